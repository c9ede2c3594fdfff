// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/displacement.hpp"
#include "kernels/group_sweep.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// sum over the modes of weight_k |x_k|
template <class Lanes, int K>
KOKKOS_FORCEINLINE_FUNCTION double weighted_sum(const Lanes& lanes, const double* weight,
                                                const typename Lanes::Real* x) {
  typename Lanes::Real part = lanes.load(weight) * Kokkos::abs(x[0]);
  for (int p = 1; p < K; ++p)
    part = multiply_add(lanes.load(weight + p * Lanes::width), Kokkos::abs(x[p]), part);
  return lanes.sum(part);
}

/// Roundings of two positions, in chi: below one of these the slider moves in stairs, not along a
/// line. Twice what they reach, for what is computed of them.
KOKKOS_FORCEINLINE_FUNCTION double position_rounding(const Place& place) {
  return 2 * 0x1p-52 * (place.position + 1.0);
}

/// The groups of nodes that can touch while no node passes another and sum_k max|psi_k| |U_k -
/// U_k^near| <= reach: all that a look at the gap has to evaluate.
///
/// Found in two passes. The first takes the highest that the resonator's face has to offer to each
/// node over the next `width` spacings of the slider's way, and holds for as long; the second
/// evaluates those of its groups that the modes can have brought near since, and holds until a node
/// passes another. Neither leaves out a node that could touch, so what they hold sets the cost,
/// never the answer.
template <class Lanes, int K>
class NearGroups {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION NearGroups(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes}, t_{tables}, s_{state} {}

  KOKKOS_FORCEINLINE_FUNCTION int count() const { return count_; }
  KOKKOS_FORCEINLINE_FUNCTION int operator[](int e) const { return s_.near[e]; }
  /// How far the modes may still go.
  KOKKOS_FORCEINLINE_FUNCTION double room(const Real* u) const {
    return reach_ - moved(s_.near_u, u);
  }
  /// Whether the list holds for all states within `travel` of this one.
  KOKKOS_FUNCTION bool holds(const Real* u, const Place& place, double travel) const {
    return place.base == base_ && moved(s_.near_u, u) + travel <= reach_;
  }
  /// Finds them anew about u. `rounding` bounds that of a displacement; `back` [chi] is how far the
  /// list must reach back on the slider's way.
  KOKKOS_FUNCTION void find(const Real* u, const Place& place, double reach, double rounding,
                            double back) {
    base_ = place.base;
    reach_ = reach < 1e300 ? reach : 1e300;  // not a number, too: then everything is near
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.near_u + p * width, u[p]);
      lanes_.store(s_.lanes + p * width, u[p]);
    }
    lanes_.sync();
    const double to_end = place.base + 1 - place.position;  // the way that is left, chi
    const double way = Kokkos::max(to_end, back);
    const double slope = weighted_sum<Lanes, K>(lanes_, t_.largest_slope, u);
    const double error = t_.slack + rounding +
                         weighted_sum<Lanes, K>(lanes_, t_.cubic_remainder, u) +
                         way * t_.spacing * slope + position_rounding(place) * t_.steepest;
    const double below = reach_ + error;
    // of what has moved the roundings, too: they were those of another displacement
    double far_below = (1.0 + 0x1p-43) * moved(s_.far_u, u) + below + error;
    if (!(place.base >= far_base_ && place.base < far_base_ + width && far_below <= far_below_)) {
      find_far(u, place, 4.0 * below, slope);
      far_below = below + error;
    }
    GroupSweep<Lanes, K> sweep(lanes_, t_, place, s_.lanes, u);
    int count = 0, evaluated = 0;
    for (int e = 0; e < far_count_; ++e) {
      if (s_.far_top[e] < -far_below) continue;
      ++evaluated;
      const int group = s_.far[e];
      const auto now = sweep.overlap(group);
      const Real most = now.overlap + Kokkos::max(Kokkos::max(Real(to_end) * now.rise, Real(0.0)),
                                                  Real(-back) * now.rise);
      if (lanes_.at_least(most, -below) == 0) continue;
      RA2D_CHECK(count < t_.groups);
      if (lanes_.leader()) s_.near[count] = group;
      ++count;
    }
    count_ = count;
    if (lanes_.leader()) s_.evaluated += static_cast<std::int64_t>(evaluated) * width;
    lanes_.sync();
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  int count_ = 0, base_ = -1;
  double reach_ = -1.0;
  // the first pass
  int far_count_ = 0, far_base_ = -2 * width;
  double far_below_ = -1.0;

  KOKKOS_FORCEINLINE_FUNCTION const double* rows(int patch) const {
    return t_.patch + static_cast<std::int64_t>(patch) * 4 * K * width;
  }
  /// Distance that a list's reference has been left behind by.
  KOKKOS_FORCEINLINE_FUNCTION double moved(const double* from, const Real* u) const {
    Real away[K];
    for (int p = 0; p < K; ++p) away[p] = u[p] - lanes_.load(from + p * width);
    return weighted_sum<Lanes, K>(lanes_, t_.largest_shape, away);
  }

  /// The groups that come within `below` of contact somewhere on the next `width` spacings of the
  /// way.
  KOKKOS_FUNCTION void find_far(const Real* u, const Place& place, double below, double slope) {
    far_base_ = place.base;
    far_below_ = below;
    for (int p = 0; p < K; ++p) lanes_.store(s_.far_u + p * width, u[p]);
    // bound on what the bent beam rises from a patch's centre to wherever a group gets
    const double bend = (t_.spacing / t_.inverse_radius + width * t_.spacing) * slope;
    int patch = -1, count = 0;
    double highest = 0.0;
    for (int group = 0; group < t_.groups; ++group) {
      const GroupPlace<Lanes> at(t_, place, group);
      if (at.patch != patch) {
        patch = at.patch;
        Real centre = lanes_.load(rows(patch)) * u[0];
        for (int p = 1; p < K; ++p)
          centre = multiply_add(lanes_.load(rows(patch) + p * width), u[p], centre);
        highest = lanes_.sum(centre) + bend;
      }
      const Real face = lanes_.load(t_.height1 + group * width) +
                        lanes_.load(t_.highest2 + place.base + group * width);
      const Real top = add_slider_displacement(lanes_, t_, s_.lanes, group, face) + Real(highest);
      if (lanes_.at_least(top, -far_below_) == 0) continue;
      const double most = lanes_.max(top);
      if (lanes_.leader()) {
        RA2D_CHECK(count < t_.groups);
        s_.far[count] = group;
        s_.far_top[count] = most;
      }
      ++count;
    }
    far_count_ = count;
    lanes_.sync();
  }
};

}  // namespace ra2d
