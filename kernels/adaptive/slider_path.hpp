// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidate_groups.hpp"
#include "kernels/function.hpp"
#include "kernels/place.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Where the slider stands at a tick, and when it comes to a place. Its theta is right to its own
/// rounding, that of Place only to the rounding of the position: as a function of this theta an
/// overlap is a polynomial in time.
class SliderPath {
 public:
  RA2D_FUNCTION explicit SliderPath(const SliderMotion& motion) : motion_{motion} {}

  RA2D_FUNCTION Place at(std::int64_t tick) const {
    Place place(motion_, tick);
    place.theta = distance_at(tick, motion_.position - place.base);
    place.offset = place.theta - place.middle;
    return place;
  }
  /// The place at another tick, seen from the same window; within that window it has the bits of
  /// at().
  KOKKOS_FORCEINLINE_FUNCTION Place moved(const Place& place, std::int64_t tick) const {
    Place there = place;
    there.position = Kokkos::fma(static_cast<double>(tick), motion_.advance, motion_.position);
    there.theta = distance_at(tick, motion_.position - place.base);
    there.offset = there.theta - place.middle;
    return there;
  }

  /// Ticks until all nodes have passed those of the resonator.
  RA2D_FUNCTION std::int64_t ticks_to_next_node(const Place& place) const {
    return ticks_to(place, 1.0);
  }
  /// Ticks until the window ends.
  RA2D_FUNCTION std::int64_t ticks_to_next_window(const Place& place) const {
    return ticks_to(place, (place.part + 1) * motion_.window_width);
  }

 private:
  const SliderMotion& motion_;

  /// from + tick advance, rounded once at the end: a tick has more digits than a double, and the
  /// two parts may cancel.
  KOKKOS_FORCEINLINE_FUNCTION double distance_at(std::int64_t tick, double from) const {
    const std::int64_t low = tick & 2047;
    return Kokkos::fma(static_cast<double>(low), motion_.advance,
                       Kokkos::fma(static_cast<double>(tick - low), motion_.advance, from));
  }

  /// Ticks until all nodes are `edge` chi behind the resonator's.
  RA2D_FUNCTION std::int64_t ticks_to(const Place& place, double edge) const {
    constexpr double forever = 4e18;
    if (motion_.advance == 0.0) return static_cast<std::int64_t>(forever);
    // a little farther, so that roundings of the position cannot keep it before the edge
    const double left = Kokkos::max(edge - place.theta, 0.0) + 2.0 * position_rounding(place);
    const double ticks = Kokkos::ceil(left / motion_.advance);
    return ticks < forever ? static_cast<std::int64_t>(ticks) + 1
                           : static_cast<std::int64_t>(forever);
  }
};

}  // namespace ra2d
