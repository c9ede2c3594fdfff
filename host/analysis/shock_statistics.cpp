// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/shock_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

constexpr int bins_per_decade = 10;

/// The lower edge of a bin; whole decades are exact.
double edge(int bin) {
  const int decade = static_cast<int>(std::floor(static_cast<double>(bin) / bins_per_decade));
  return std::pow(10.0, decade) *
         std::pow(10.0, static_cast<double>(bin - bins_per_decade * decade) / bins_per_decade);
}

/// The bin that a positive value is in.
int bin_of(double value) {
  int bin = static_cast<int>(std::floor(bins_per_decade * std::log10(value)));
  while (edge(bin) > value) --bin;  // the logarithm was rounded
  while (edge(bin + 1) <= value) ++bin;
  return bin;
}

/// How many shocks there are at once in a stretch: a walk over their starts and ends.
void count_at_once(const std::vector<Shock>& shocks, double begin, double end,
                   ShockStatistics& statistics) {
  std::vector<double> starts, ends;
  double in_contact = 0;  // s, of all
  for (const Shock& shock : shocks) {
    const double from = std::max(begin, shock.start);
    const double to = std::min(end, shock.start + shock.duration);
    if (!(to > from)) continue;
    starts.push_back(from);
    ends.push_back(to);
    in_contact += to - from;
  }
  statistics.at_once_mean = end > begin ? in_contact / (end - begin) : quiet_nan;
  std::sort(starts.begin(), starts.end());
  std::sort(ends.begin(), ends.end());
  for (std::size_t begun = 0, ended = 0; begun < starts.size(); ++begun) {
    while (ends[ended] <= starts[begun]) ++ended;
    statistics.at_once_most = std::max(statistics.at_once_most, begun + 1 - ended);
  }
}

}  // namespace

double quantile(std::span<const double> sorted, double share) {
  if (sorted.empty()) return quiet_nan;
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), sorted.size() - 1);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

Spread spread_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double sum = 0;
  for (const double value : values) sum += value;
  return {quantile(values, 0.5), quantile(values, 0.1), quantile(values, 0.9),
          values.empty() ? quiet_nan : sum / static_cast<double>(values.size())};
}

LogBins log_bins(std::span<const double> values) {
  LogBins bins;
  int low = std::numeric_limits<int>::max(), high = std::numeric_limits<int>::min();
  std::vector<int> places;
  for (const double value : values) {
    if (!(value > 0 && std::isfinite(value))) {
      ++bins.not_positive;
      continue;
    }
    places.push_back(bin_of(value));
    low = std::min(low, places.back());
    high = std::max(high, places.back());
  }
  if (places.empty()) return bins;
  for (int bin = low; bin <= high + 1; ++bin) bins.edges.push_back(edge(bin));
  bins.counts.resize(bins.edges.size() - 1);
  for (const int place : places) ++bins.counts[static_cast<std::size_t>(place - low)];
  return bins;
}

ShockStatistics shock_statistics(const std::vector<Shock>& shocks, double begin, double end) {
  std::vector<double> durations, forces, impulses, intervals;
  double last = quiet_nan;
  for (const Shock& shock : shocks) {
    if (shock.start < begin || shock.start > end) continue;
    durations.push_back(shock.duration);
    forces.push_back(shock.peak_force);
    impulses.push_back(shock.impulse);
    if (durations.size() > 1) intervals.push_back(shock.start - last);
    last = shock.start;
  }
  ShockStatistics statistics;
  statistics.count = durations.size();
  statistics.rate = end > begin ? static_cast<double>(statistics.count) / (end - begin) : quiet_nan;
  count_at_once(shocks, begin, end, statistics);
  statistics.durations = log_bins(durations);
  statistics.peak_forces = log_bins(forces);
  statistics.impulses = log_bins(impulses);
  statistics.intervals = log_bins(intervals);
  statistics.duration = spread_of(std::move(durations));
  statistics.peak_force = spread_of(std::move(forces));
  statistics.impulse = spread_of(std::move(impulses));
  statistics.interval = spread_of(std::move(intervals));
  return statistics;
}

}  // namespace ra2d
