// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

namespace ra2d {

/// Turns standard normal heights into heights of a given skewness and kurtosis: a function that
/// grows with its argument, from the system of N. L. Johnson (Biometrika 36, 1949), as Hu and
/// Tonder used it for rough surfaces (Int. J. Mach. Tools Manufact. 32, 1992). Its values have mean
/// 0 and variance 1.
class JohnsonHeights {
 public:
  /// Leaves normal heights as they are.
  JohnsonHeights() = default;
  /// Throws RequestError for moments that no such heights have, or only ones of nearly two values.
  JohnsonHeights(double skewness, double kurtosis);

  bool is_identity() const { return family_ == Family::normal; }
  double operator()(double g) const;
  /// The normal height that becomes 0, the mean line.
  double at_mean_line() const;
  /// The correlation of two heights whose normal heights have the correlation `normal`.
  double correlation(double normal) const;
  /// Inverse of correlation(): that of the normal heights. -1 where no normal heights have it.
  double normal_correlation(double of_heights) const;

 private:
  enum class Family { normal, unbounded, bounded, lognormal };
  double raw(double g) const;
  void standardise();
  void find_series();

  Family family_ = Family::normal;
  double sign_ = 1, gamma_ = 0, delta_ = 1, mean_ = 0, spread_ = 1;
  std::vector<double> series_;  // n! a_n^2 of He_n, n = 1, 2, ...: the correlation's powers
};

}  // namespace ra2d
