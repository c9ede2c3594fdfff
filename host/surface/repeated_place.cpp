// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/repeated_place.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ra2d {
namespace {

constexpr double seam_share = 0.1;  // of the line

}  // namespace

std::size_t RepeatedPlace::seam(std::size_t points) {
  return std::max<std::size_t>(
      1, static_cast<std::size_t>(seam_share * static_cast<double>(points - 1)));
}

RepeatedPlace::RepeatedPlace(std::size_t points, std::size_t place) {
  const std::size_t last = points - 1, steps = seam(points);
  point = place % (last + steps);
  if (point <= last) return;
  const std::size_t into = point - last;  // from 1 to steps - 1
  const double turn = std::numbers::pi / 2 * static_cast<double>(into) / static_cast<double>(steps);
  point = last - into;
  other = steps - into;
  share = std::cos(turn);
  other_share = std::sin(turn);
}

}  // namespace ra2d
