// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/series.hpp"
#include "kernels/displacement.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The modal forces of the moving forces as power series in time, like the modes' own
/// (kernels/adaptive/series.hpp). A force stands on the resonator, not on its nodes: on a patch a
/// mode's shape is a polynomial of the place, so where the force moves it is one of the time.
template <class Lanes, int packs>
class MovingForceSeries {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  /// `terms`: (order, lane), SeriesBuffers::forces.
  RA2D_FUNCTION MovingForceSeries(const Lanes& lanes, const SliderMotion& motion,
                                  const PatchTables& patches, const MovingForces& forces,
                                  const SeriesTables& adaptive, double* terms)
      : lanes_{lanes},
        motion_{motion},
        patches_{patches},
        forces_{forces},
        adaptive_{adaptive},
        terms_{terms} {}

  /// The series from a tick on, in units of `scale` [s]. Returns the ticks for which they hold:
  /// until a force enters or leaves the beam or a patch of it.
  RA2D_FUNCTION std::int64_t expand(std::int64_t tick, double scale) const {
    const Real zero(0.0);
    for (int j = 0; j <= adaptive_.order; ++j)
      for (int p = 0; p < filled<packs>(lanes_); ++p) lanes_.store(term(j, p), zero);
    double least = 4e18;  // ticks
    for (int i = 0; i < forces_.count; ++i) {
      const MovingForceTable& f = forces_.list[i];
      const double x = Kokkos::fma(static_cast<double>(tick), f.advance, f.position);  // m
      const bool on = x >= 0.0 && x <= forces_.resonator_length;
      const int patch = on ? static_cast<int>(x / motion_.spacing) / patches_.nodes : 0;
      const double ticks = ticks_to_edge(f, x, on, patch);
      if (ticks < least) least = ticks;
      if (on) add(i, x, patch, scale);
    }
    return static_cast<std::int64_t>(least);
  }

  /// Work of the moving forces from the beginning of the step to x [J].
  RA2D_FUNCTION double work(const ModalSeries<Lanes, packs>& series, double x) const {
    if (forces_.count == 0) return 0.0;
    Real sum(0.0);
    for (int g = 0; g < gauss_points; ++g) {
      const double at = x * adaptive_.gauss[g];
      Real v[packs];
      series.velocity(at, v);
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        Real force = lanes_.load(term(adaptive_.order, p));
        for (int j = adaptive_.order - 1; j >= 0; --j)
          force = multiply_add(force, Real(at), lanes_.load(term(j, p)));
        sum = multiply_add(Real(adaptive_.gauss[gauss_row + g]) * force, v[p], sum);
      }
    }
    return x * series.scale() * lanes_.sum(sum);
  }

 private:
  Lanes lanes_;
  const SliderMotion& motion_;
  const PatchTables& patches_;
  const MovingForces& forces_;
  const SeriesTables& adaptive_;
  double* terms_;

  KOKKOS_FORCEINLINE_FUNCTION double* term(int j, int p) const {
    return terms_ + (j * packs + p) * width;
  }

  /// Ticks until a force at x [m] comes to an end of the beam, or of the patch that it is on;
  /// without end where it comes to none.
  RA2D_FUNCTION double ticks_to_edge(const MovingForceTable& f, double x, bool on,
                                     int patch) const {
    const double width_of_patch = patches_.nodes * motion_.spacing;
    double edge = -1.0;  // that it comes to next
    if (on && f.advance > 0.0)
      edge = Kokkos::min((patch + 1) * width_of_patch, forces_.resonator_length);
    else if (on)
      edge = patch * width_of_patch;
    else if (x < 0.0)
      edge = 0.0;
    else
      edge = forces_.resonator_length;
    const double ahead = (edge - x) / f.advance;  // not a number, or infinite, at rest
    if (!(f.advance != 0.0 && ahead >= 0.0)) return 1e300;
    // a little farther, so that roundings of the place cannot keep it before the edge
    const double rounding = 4 * 0x1p-52 * (Kokkos::abs(x) + Kokkos::abs(edge));
    return Kokkos::floor(ahead + rounding / Kokkos::abs(f.advance)) + 1.0;
  }

  /// Adds the series of a force at x [m], on that patch.
  RA2D_FUNCTION void add(int force, double x, int patch, double scale) const {
    const MovingForceTable& f = forces_.list[force];
    const Real eta((x / motion_.spacing - (patch + 0.5) * patches_.nodes) *
                   patches_.inverse_radius);
    const double eta_per_x =
        f.advance * (scale / motion_.time_step) * patches_.inverse_radius / motion_.spacing;
    const double* rows =
        patches_.derivatives + static_cast<std::int64_t>(patch) * 4 * packs * width;
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real c[most_terms];
      full_series<Lanes, packs>(lanes_, patches_, patches_.terms, rows, p, c);
      Real power(f.force);
      if (forces_.across != nullptr) [[unlikely]]
        power = power * lanes_.load(forces_.across + (force * packs + p) * width);
      for (int m = 0; m < patches_.terms && m <= adaptive_.order;
           ++m) {  // repeated synthetic division
        for (int j = patches_.terms - 2; j >= m; --j) c[j] = multiply_add(eta, c[j + 1], c[j]);
        lanes_.store(term(m, p), multiply_add(power, c[m], lanes_.load(term(m, p))));
        power = power * eta_per_x;
      }
    }
  }
};

}  // namespace ra2d
