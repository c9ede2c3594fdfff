// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

namespace ra2d {

/// Sum of term(0) ... term(count - 1), compensated (Neumaier): exact to a rounding or two for any
/// number of terms.
template <class Term>
double compensated_sum(std::size_t count, const Term& term) {
  double sum = 0, lost = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double next_term = term(i), next = sum + next_term;
    lost +=
        std::abs(sum) >= std::abs(next_term) ? (sum - next) + next_term : (next_term - next) + sum;
    sum = next;
  }
  return sum + lost;
}

/// Moves the values to mean zero: gaps are measured between mean lines. Returns what the mean was.
inline double subtract_mean(std::vector<double>& values) {
  const double mean = compensated_sum(values.size(), [&](std::size_t i) { return values[i]; }) /
                      static_cast<double>(values.size());
  for (double& value : values) value -= mean;
  return mean;
}

}  // namespace ra2d
