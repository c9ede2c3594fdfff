// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/near_groups.hpp"
#include "kernels/place.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Where the slider stands at a tick, and when it comes to a place. As Place, but with a theta that
/// is right to its own rounding and not only to that of the position: on it an overlap is a
/// polynomial in time.
class SliderWay {
 public:
  KOKKOS_FUNCTION explicit SliderWay(const SceneTables& tables) : t_{tables} {}

  KOKKOS_FUNCTION Place stand(std::int64_t step) const {
    Place place(t_, step);
    place.theta = way_to(step, t_.position - place.base);
    place.offset = place.theta - (place.part + 0.5) * t_.window_width;
    return place;
  }
  /// The place at another tick, seen from the same window; within it to the bit what stand() says.
  KOKKOS_FORCEINLINE_FUNCTION Place moved(const Place& place, std::int64_t step) const {
    Place there = place;
    there.position = Kokkos::fma(static_cast<double>(step), t_.advance, t_.position);
    there.theta = way_to(step, t_.position - place.base);
    there.offset = there.theta - (place.part + 0.5) * t_.window_width;
    return there;
  }

  /// Ticks until all nodes have passed those of the resonator, ...
  KOKKOS_FUNCTION std::int64_t ticks_to_next_node(const Place& place) const {
    return ticks_to(place, 1.0);
  }
  /// ... and until the window ends.
  KOKKOS_FUNCTION std::int64_t ticks_to_next_window(const Place& place) const {
    return ticks_to(place, (place.part + 1) * t_.window_width);
  }

 private:
  const SceneTables& t_;

  /// from + step advance, rounded once at the end: a step has more digits than a double, and the
  /// two parts may cancel.
  KOKKOS_FORCEINLINE_FUNCTION double way_to(std::int64_t step, double from) const {
    const std::int64_t low = step & 2047;
    return Kokkos::fma(static_cast<double>(low), t_.advance,
                       Kokkos::fma(static_cast<double>(step - low), t_.advance, from));
  }

  /// Ticks until all nodes are `edge` chi behind the resonator's.
  KOKKOS_FUNCTION std::int64_t ticks_to(const Place& place, double edge) const {
    constexpr double forever = 4e18;
    if (t_.advance == 0.0) return static_cast<std::int64_t>(forever);
    // on to where the roundings of the position cannot hold it back
    const double way = Kokkos::max(edge - place.theta, 0.0) + 2.0 * position_rounding(place);
    const double ticks = Kokkos::ceil(way / t_.advance);
    return ticks < forever ? static_cast<std::int64_t>(ticks) + 1
                           : static_cast<std::int64_t>(forever);
  }
};

}  // namespace ra2d
