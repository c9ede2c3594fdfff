// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/envelope.hpp"
#include "host/base/quiet_nan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ra2d {

std::vector<std::size_t> even_groups(std::size_t values, std::size_t most) {
  const std::size_t groups = values <= 2 * most ? values : most;
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i <= groups; ++i)
    begins.push_back(groups > 0 ? i * (values / groups) + i * (values % groups) / groups : 0);
  return begins;
}

Envelope envelope(std::span<const double> at, std::span<const double> values,
                  const std::vector<std::size_t>& groups) {
  Envelope e;
  for (std::size_t g = 0; g + 1 < groups.size(); ++g) {
    double place = 0, sum = 0, low = quiet_nan, high = quiet_nan;
    std::size_t numbers = 0;
    for (std::size_t i = groups[g]; i < groups[g + 1]; ++i) {
      place += at[i];
      if (std::isnan(values[i])) continue;
      ++numbers;
      sum += values[i];
      low = std::fmin(low, values[i]);
      high = std::fmax(high, values[i]);
    }
    const std::size_t size = groups[g + 1] - groups[g];
    e.at.push_back(place / static_cast<double>(size));
    e.low.push_back(low);
    e.high.push_back(high);
    e.mean.push_back(numbers > 0 ? sum / static_cast<double>(numbers) : quiet_nan);
    e.largest_group = std::max(e.largest_group, size);
  }
  return e;
}

}  // namespace ra2d
