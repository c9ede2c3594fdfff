// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <vector>

namespace ra2d {

/// Sum of f(x) over the values, compensated (Neumaier): exact to a rounding or two for any length.
template <class Function>
double compensated_sum(const std::vector<double>& values, Function f) {
  double sum = 0, lost = 0;
  for (const double value : values) {
    const double term = f(value), next = sum + term;
    lost += std::abs(sum) >= std::abs(term) ? (sum - next) + term : (term - next) + sum;
    sum = next;
  }
  return sum + lost;
}

/// Moves the values to mean zero: gaps are measured between mean lines. Returns what the mean was.
inline double subtract_mean(std::vector<double>& values) {
  const double mean =
      compensated_sum(values, [](double v) { return v; }) / static_cast<double>(values.size());
  for (double& value : values) value -= mean;
  return mean;
}

}  // namespace ra2d
