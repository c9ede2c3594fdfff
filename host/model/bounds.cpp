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

// In a stretch h long a function exceeds the higher of its ends by no more than h^2/8 times its
// largest second derivative, which is 4 rate^2 size^2 of psi^2 at the most.
std::array<double, 2> largest_square_sums(const Body& body,
                                          const std::array<std::vector<double>, 2>& weights,
                                          double width) {
  constexpr double stretches_per_rate = 4.0;
  double rate_along = 0, rate_across = 0;
  for (const BodyMode& mode : body.modes) {
    rate_along = std::max(rate_along, mode.shape->change_rate());
    rate_across = std::max(rate_across, mode.shape->across_rate());
  }
  const auto stretches = [](double length, double rate) {
    return std::max(1, static_cast<int>(std::ceil(stretches_per_rate * length * rate)));
  };
  const int along = stretches(body.length, rate_along),
            across = width > 0 ? stretches(width, rate_across) : 0;
  const double step_along = body.length / along, step_across = across > 0 ? width / across : 0.0;
  const auto squared = [](double value) { return value * value; };
  const std::size_t row = along + 1;
  std::array<std::vector<double>, 2> sums;  // (across, along)
  std::array<double, 2> all{}, between{};
  for (std::vector<double>& sum : sums) sum.assign((across + 1) * row, 0.0);
  std::vector<double> square(row);
  for (std::size_t k = 0; k < body.modes.size(); ++k) {
    const ModeShape& shape = *body.modes[k].shape;
    double psi;
    for (int i = 0; i <= along; ++i) {
      shape.evaluate(i * step_along, 1, &psi);
      square[i] = squared(psi);
    }
    for (int j = 0; j <= across; ++j) {
      shape.evaluate_across(j * step_across, 1, &psi);
      for (int w = 0; w < 2; ++w) {
        const double weight = weights[w][k] * squared(psi);
        double* const sum = sums[w].data() + j * row;
        for (int i = 0; i <= along; ++i) sum[i] += weight * square[i];
      }
    }
    for (int w = 0; w < 2; ++w) {
      const double largest = weights[w][k] * squared(shape.size());
      all[w] += largest;
      between[w] +=
          0.5 * largest *
          (squared(step_along * shape.change_rate()) + squared(step_across * shape.across_rate()));
    }
  }
  std::array<double, 2> most;
  for (int w = 0; w < 2; ++w) {
    const double highest = *std::max_element(sums[w].begin(), sums[w].end());
    most[w] = std::min(all[w], (1.0 + 1e-12) * (highest + between[w]));
  }
  return most;
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
