// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <limits>

/// What a warp's reductions give, over the values of its lanes in their order.
namespace ra2d::test {

inline constexpr int warp_width = 32;
using WarpValues = std::array<double, warp_width>;

/// Lane i with lane i + half, as Kokkos adds over a vector of threads, and as HostLanes does.
inline double tree_sum(WarpValues part) {
  for (int half = warp_width / 2; half > 0; half /= 2)
    for (int lane = 0; lane < half; ++lane) part[lane] += part[lane + half];
  return part[0];
}
inline double smallest(const WarpValues& values) {
  double least = std::numeric_limits<double>::infinity();
  for (const double value : values) least = value < least ? value : least;
  return least;
}
inline std::uint32_t lanes_at_least(const WarpValues& values, double level) {
  std::uint32_t word = 0;
  for (int lane = 0; lane < warp_width; ++lane)
    if (level <= values[lane]) word |= 1u << lane;
  return word;
}

}  // namespace ra2d::test
