// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/spline.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ra2d {

std::vector<double> spline_curvatures(const std::vector<double>& height) {
  const std::size_t n = height.size();
  std::vector<double> curvature(n, 0.0);
  if (n < 3) return curvature;
  const auto second_difference = [&](std::size_t i) {
    return (height[i + 1] - height[i]) - (height[i] - height[i - 1]);
  };
  // the condition at the ends makes the second derivative there the second difference
  curvature[1] = second_difference(1);
  curvature[n - 2] = second_difference(n - 2);
  // b[i-1] + 4 b[i] + b[i+1] = 6 second differences in between, by elimination
  std::vector<double> ratio(n, 0.0);
  for (std::size_t i = 2; i + 2 < n; ++i) {
    ratio[i] = 1.0 / (4.0 - ratio[i - 1]);
    curvature[i] = (6.0 * second_difference(i) - curvature[i - 1]) * ratio[i];
  }
  for (std::size_t i = n - 3; i >= 2 && i + 2 < n; --i) curvature[i] -= ratio[i] * curvature[i + 1];
  curvature[0] = 2.0 * curvature[1] - curvature[std::min<std::size_t>(2, n - 1)];
  curvature[n - 1] = 2.0 * curvature[n - 2] - curvature[n >= 3 ? n - 3 : 0];
  if (n == 3) curvature[0] = curvature[2] = curvature[1];
  return curvature;
}

std::vector<double> spline_misses(const std::vector<double>& height) {
  std::vector<double> coarse, misses;
  for (std::size_t i = 0; i < height.size(); i += 2) coarse.push_back(height[i]);
  const std::vector<double> curvature = spline_curvatures(coarse);
  for (std::size_t i = 0; i + 1 < coarse.size(); ++i) {
    const double between =
        0.5 * (coarse[i] + coarse[i + 1]) - 0.0625 * (curvature[i] + curvature[i + 1]);
    misses.push_back(between - height[2 * i + 1]);
  }
  return misses;
}

double spline_miss(const std::vector<double>& height) {
  double most = 0;
  for (const double miss : spline_misses(height)) most = std::max(most, std::abs(miss));
  return most;
}

double spline_off(const std::vector<double>& height) {
  const double fine = spline_miss(height);
  if (!(fine > 0)) return 0;
  std::vector<double> every_other;
  for (std::size_t i = 0; i < height.size(); i += 2) every_other.push_back(height[i]);
  return fine / std::clamp(spline_miss(every_other) / fine, 1.0, 16.0);
}

double spline_error(const std::vector<double>& height) {
  double square = 0;
  for (const double h : height) square += h * h;
  const double rms = std::sqrt(square / static_cast<double>(height.size()));
  return rms > 0 ? spline_off(height) / rms : 0.0;
}

}  // namespace ra2d
