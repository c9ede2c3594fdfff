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
  for (const Beam* beam : {&model.resonator, &model.slider})
    for (const ModeShape& shape : beam->modes) {
      const double rate = fastest_rate(Mode{shape.omega, beam->zeta, beam->mass_per_length});
      square = std::max(square, rate * rate);
      spring += model.node_stiffness * std::pow(shape.largest, 2) / beam->mass_per_length;
    }
  return std::sqrt(square + spring);
}

double highest_beta(const Beam& beam) {
  double beta = 0;
  for (const ModeShape& mode : beam.modes) beta = std::max(beta, mode.beta);
  return beta;
}

double largest_shape(const ModeShape& shape, double length) {
  const double wave =
      std::hypot(shape.sine, shape.cosine) + std::abs(shape.left) + std::abs(shape.right);
  const double rigid =
      std::max(std::abs(shape.constant), std::abs(shape.constant + shape.slope * length));
  return wave + rigid;
}

double largest_wave(const ModeShape& shape, double beyond) {
  return std::hypot(shape.sine, shape.cosine) + std::abs(shape.left) +
         std::abs(shape.right) * std::exp(shape.beta * beyond);
}

CubicRemainder cubic_remainder(const ModeShape& shape, double radius) {
  const double wave = largest_wave(shape, 2 * radius);
  return {wave * std::pow(shape.beta * radius, 4) / 24,
          wave * shape.beta * std::pow(shape.beta * radius, 3) / 6};
}

double passing_rate(const ModeShape& shape, double length, double speed) {
  return std::max(shape.beta, std::abs(shape.slope) / largest_shape(shape, length)) * speed;
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

double face_rounding(double scale) { return 16 * 0x1p-52 * scale; }

}  // namespace ra2d
