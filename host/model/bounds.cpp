// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/bounds.hpp"

#include <algorithm>
#include <cmath>

namespace ra2d {

double fastest_rate(const Mode& mode) {
  return mode.omega * (mode.zeta + std::sqrt(1.0 + mode.zeta * mode.zeta));
}

double fastest_rate(const Model& model) {
  double square = 0, spring = 0;
  for (const Body* body : {&model.resonator, &model.slider})
    for (const BodyMode& mode : body->modes) {
      const double rate = fastest_rate(mode);
      square = std::max(square, rate * rate);
      spring += model.node_stiffness * std::pow(mode.shape->largest(), 2) / mode.mass;
    }
  return std::sqrt(square + spring);
}

double fourth_derivative(const Mode& mode, double largest_shape, double passing_rate) {
  const double rate = fastest_rate(mode), b = passing_rate;
  return largest_shape * (rate * rate * (rate + 4.0 * b) + b * b * (6.0 * rate + 4.0 * b) +
                          b * b * b * b / mode.omega);
}

double steepest_rise(const double* height, int count) {
  double steepest = 0;
  for (int n = 0; n + 1 < count; ++n)
    steepest = std::max(steepest, std::abs(height[n + 1] - height[n]));
  return steepest;
}

void fill_highest(const double* height, int count, int ahead, double* highest) {
  for (int n = 0; n < count; ++n) {
    highest[n] = height[n];
    for (int m = n + 1; m <= n + ahead && m < count; ++m)
      highest[n] = std::max(highest[n], height[m]);
  }
}

double steepest_rise(const double* height, const double* curvature, int count) {
  double steepest = 0;
  for (int n = 0; n + 1 < count; ++n)
    steepest =
        std::max(steepest, std::abs(height[n + 1] - height[n]) +
                               0.5 * std::max(std::abs(curvature[n]), std::abs(curvature[n + 1])));
  return steepest;
}

void fill_sag(const double* curvature, int count, int before, int ahead, double* sag) {
  for (int n = 0; n < count; ++n) {
    double most = -curvature[n];
    for (int m = std::max(0, n - before); m <= n + ahead && m < count; ++m)
      most = std::max(most, -curvature[m]);
    sag[n] = 0.125 * most;
  }
}

void fill_raised(const double* height, const double* curvature, int count, double* raised) {
  fill_sag(curvature, count, 1, 1, raised);
  for (int n = 0; n < count; ++n) raised[n] = height[n] + std::max(0.0, 8.0 / 6.0 * raised[n]);
}

double largest_face_curvature(const double* curvature, int count) {
  double sharpest = 0;
  for (int n = 0; n < count; ++n) sharpest = std::max(sharpest, std::abs(curvature[n]));
  return sharpest;
}

double face_rounding(double scale, bool smooth) { return (smooth ? 64 : 16) * 0x1p-52 * scale; }

}  // namespace ra2d
