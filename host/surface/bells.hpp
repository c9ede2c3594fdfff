// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace ra2d {

/// The smooth function sum_i c_i exp(-(x - i)^2/8): a bell about each of a row of places, at
/// distances of 1. Waves of four places or longer show nothing of the places: what of such a wave
/// in the coefficients appears as another is less than exp(-4 pi^2) of it.
class Bells {
 public:
  /// Beyond this many places a bell is below the roundings of the sum.
  static constexpr int half_width = 18;

  /// `coefficients` are those of the places -half_width, 1 - half_width, ...
  explicit Bells(std::vector<double> coefficients);

  /// Replaces every x by the function there; x from 0 to the number of coefficients - 2 half_width
  /// - 1. The bits are the same on every platform and compiler, and do not depend on the other
  /// places.
  void evaluate(std::vector<double>& x) const;

  /// Amplitude of the wave that coefficients exp(i n turn) give, turn [rad] from one place to the
  /// next, |turn| <= pi/2.
  static double gain(double turn);

 private:
  /// Places computed side by side: the operations of one exp wait for each other, those of sixteen
  /// do not. Each place goes through the same operations in the same order as it would alone, so
  /// its bits do not depend on its neighbours.
  static constexpr std::size_t side_by_side = 16;
  using Group = std::array<double, side_by_side>;

  void sum(Group& x) const;
  static void small_exp(Group& x, Group& y);

  std::vector<double> coefficients_;
  std::array<double, half_width + 1> bell_{};
};

/// Mean and root mean square over (0, length), the latter about the former, of a function that
/// shows nothing finer than waves of two (its square: of one): Gauss's rule of five points between
/// places, which is off by 1e-11 for a square of bells. `evaluate` replaces places by values.
struct Moments {
  double mean, rms;
};
Moments moments(const std::function<void(std::vector<double>&)>& evaluate, double length);

}  // namespace ra2d
