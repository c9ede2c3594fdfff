// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

/// Reductions over lanes, computed from the values of the lanes in their order.
namespace ra2d::test {

inline constexpr int warp_width = 32;
using WarpValues = std::array<double, warp_width>;

/// Lane i with lane i + half, as Kokkos adds over a vector of threads, and as HostLanes does.
template <std::size_t width>
double tree_sum(std::array<double, width> part) {
  for (std::size_t half = width / 2; half > 0; half /= 2)
    for (std::size_t lane = 0; lane < half; ++lane) part[lane] += part[lane + half];
  return part[0];
}
template <std::size_t width>
double smallest(const std::array<double, width>& values) {
  double least = std::numeric_limits<double>::infinity();
  for (const double value : values) least = value < least ? value : least;
  return least;
}
template <std::size_t width>
std::uint32_t lanes_at_least(const std::array<double, width>& values, double level) {
  std::uint32_t word = 0;
  for (std::size_t lane = 0; lane < width; ++lane)
    if (level <= values[lane]) word |= 1u << lane;
  return word;
}

template <std::size_t width>
std::array<double, width> next_lanes(std::array<double, width> values) {
  for (std::size_t lane = 0; lane + 1 < width; ++lane) values[lane] = values[lane + 1];
  return values;
}

}  // namespace ra2d::test
