// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/series.hpp"
#include "kernels/displacement.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The modal forces of the moving forces as power series in time, like the modes' own
/// (kernels/adaptive/series.hpp). A force stands on the resonator, not on its nodes: on a patch a
/// mode's shape is a polynomial of the place, so where the force moves it is one of the time.
template <class Lanes, int K>
class Push {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION Push(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes}, t_{tables}, s_{state} {}

  /// The series from tick `step` on, in units of `scale` [s]. Returns the ticks for which they
  /// hold: until a force enters or leaves the beam or a patch of it.
  KOKKOS_FUNCTION std::int64_t expand(std::int64_t step, double scale) const {
    const Real zero(0.0);
    for (int j = 0; j <= t_.order; ++j)
      for (int p = 0; p < K; ++p) lanes_.store(term(j, p), zero);
    double room = 4e18;  // ticks
    for (int i = 0; i < t_.moving_forces; ++i) {
      const MovingForceTable& f = t_.moving_force[i];
      const double x = Kokkos::fma(static_cast<double>(step), f.advance, f.position);  // m
      const bool on = x >= 0.0 && x <= t_.resonator_length;
      const int patch = on ? static_cast<int>(x / t_.spacing) / t_.patch_nodes : 0;
      const double ticks = ticks_to_edge(f, x, on, patch);
      if (ticks < room) room = ticks;
      if (on) add(f, x, patch, scale);
    }
    return static_cast<std::int64_t>(room);
  }

  /// Work of the moving forces from the beginning of the step to x [J].
  KOKKOS_FUNCTION double work(const ModalSeries<Lanes, K>& series, double x) const {
    if (t_.moving_forces == 0) return 0.0;
    Real sum(0.0);
    for (int g = 0; g < gauss_points; ++g) {
      const double at = x * t_.gauss[g];
      Real v[K];
      series.velocity(at, v);
      for (int p = 0; p < K; ++p) {
        Real push = lanes_.load(term(t_.order, p));
        for (int j = t_.order - 1; j >= 0; --j)
          push = multiply_add(push, Real(at), lanes_.load(term(j, p)));
        sum = multiply_add(Real(t_.gauss[gauss_room + g]) * push, v[p], sum);
      }
    }
    return x * series.scale() * lanes_.sum(sum);
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;

  KOKKOS_FORCEINLINE_FUNCTION double* term(int j, int p) const {
    return s_.push_series + (j * K + p) * width;
  }

  /// Ticks until a force at x [m] comes to an end of the beam, or of the patch that it is on;
  /// without end where it comes to none.
  KOKKOS_FUNCTION double ticks_to_edge(const MovingForceTable& f, double x, bool on,
                                       int patch) const {
    const double width_of_patch = t_.patch_nodes * t_.spacing;
    double edge = -1.0;  // that it comes to next
    if (on && f.advance > 0.0)
      edge = Kokkos::min((patch + 1) * width_of_patch, t_.resonator_length);
    else if (on)
      edge = patch * width_of_patch;
    else if (x < 0.0)
      edge = 0.0;
    else
      edge = t_.resonator_length;
    const double ahead = (edge - x) / f.advance;  // not a number, or infinite, at rest
    if (!(f.advance != 0.0 && ahead >= 0.0)) return 1e300;
    // on to where the roundings of the place cannot hold it back
    const double stairs = 4 * 0x1p-52 * (Kokkos::abs(x) + Kokkos::abs(edge));
    return Kokkos::floor(ahead + stairs / Kokkos::abs(f.advance)) + 1.0;
  }

  /// Adds the series of a force at x [m], on that patch.
  KOKKOS_FUNCTION void add(const MovingForceTable& f, double x, int patch, double scale) const {
    const Real eta((x / t_.spacing - (patch + 0.5) * t_.patch_nodes) * t_.inverse_radius);
    const double step = f.advance * (scale / t_.step) * t_.inverse_radius / t_.spacing;
    const double* rows = t_.patch + static_cast<std::int64_t>(patch) * 4 * K * width;
    for (int p = 0; p < K; ++p) {
      Real c[most_terms];
      full_series<Lanes, K>(lanes_, t_, rows, p, c);
      double power = f.force;
      for (int m = 0; m < t_.terms && m <= t_.order; ++m) {  // repeated synthetic division
        for (int j = t_.terms - 2; j >= m; --j) c[j] = multiply_add(eta, c[j + 1], c[j]);
        lanes_.store(term(m, p), multiply_add(power, c[m], lanes_.load(term(m, p))));
        power *= step;
      }
    }
  }
};

}  // namespace ra2d
