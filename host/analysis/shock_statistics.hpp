// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "host/result/record.hpp"

/// Statistics of the shocks of a stretch.
namespace ra2d {

/// Quantiles and mean of values; NaN where there are none.
struct Spread {
  double median = 0, p10 = 0, p90 = 0, mean = 0;
};
Spread spread_of(std::vector<double> values);

/// The value that a share of all values does not exceed, straight between the two nearest ranks (as
/// numpy.quantile); NaN without values. `sorted` in ascending order.
double quantile(std::span<const double> sorted, double share);

/// Counts in ten bins of equal ratio to a decade.
struct LogBins {
  std::vector<double> edges;        // one more than there are counts; none without positive values
  std::vector<std::size_t> counts;  // of edges[i] <= value < edges[i + 1]
  std::size_t not_positive = 0;     // values that fall into no bin
};
LogBins log_bins(std::span<const double> values);

struct ShockStatistics {
  std::size_t count = 0;
  double rate = 0;                                 // 1/s
  Spread duration, peak_force, impulse, interval;  // s, N, N s, s from start to start
  double at_once_mean = 0;                         // over the time
  std::size_t at_once_most = 0;
  LogBins durations, peak_forces, impulses, intervals;
};

/// Of the shocks that begin in a stretch from `begin` to `end` [s]. Those at once are all that go
/// on in it, whenever they began. `shocks` in order of start.
ShockStatistics shock_statistics(const std::vector<Shock>& shocks, double begin, double end);

}  // namespace ra2d
