// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/level_history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "host/analysis/means.hpp"
#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_parts = 200, independent_parts = 10;

/// Factor by which to widen the standard error found from ten parts of a process whose correlation
/// falls as exp(-t / forgotten). With the variance of a mean over T of such a process, v(T) = 2 a
/// (1 - a (1 - exp(-1/a))), a = forgotten / T, the parts' scatter is v(T/10) - v(T) on average.
double widening(double part, double forgotten) {
  const auto variance = [&](double seconds) {
    const double a = forgotten / seconds;
    return a > 0 ? 2 * a * (1 + a * std::expm1(-1 / a)) : 0.0;
  };
  const auto n = static_cast<double>(independent_parts);
  const double whole = variance(n * part), scatter = (variance(part) - whole) / (n - 1);
  return forgotten > 0 ? std::sqrt(whole / scatter) : 1.0;
}

/// Half the width of the interval of a mean's logarithm.
double half_width(const std::vector<double>& parts, double ringing, double part_seconds) {
  const std::size_t each = parts.size() / independent_parts;
  std::vector<double> means(independent_parts);
  for (std::size_t i = 0; i < independent_parts * each; ++i)
    means[i / each] += parts[i] / static_cast<double>(each);
  const MeanOfRuns mean = mean_of_runs(means, Values::positive);
  return std::log(mean.high / mean.mean) *
         widening(part_seconds * static_cast<double>(each), ringing);
}

}  // namespace

LevelParts::LevelParts(std::size_t first, std::size_t count, double rate, std::size_t modes)
    : first_{first}, modes_{modes}, rate_{rate} {
  parts_ = std::min(most_parts, count / 2);
  if (parts_ > 0) rows_ = count / parts_;
  sums_.squares.resize(parts_ * modes_);
  sums_.shocks.resize(parts_);
}

void LevelParts::add_rows(std::size_t at, std::span<const double> rows) {
  if (modes_ == 0) return;
  const std::size_t count = rows.size() / modes_;
  for (std::size_t i = at < first_ ? first_ - at : 0; i < count; ++i) {
    const std::size_t row = at + i - first_;
    if (row >= parts_ * rows_) break;
    double* const squares = sums_.squares.data() + row / rows_ * modes_;
    const double* const v = rows.data() + i * modes_;
    for (std::size_t k = 0; k < modes_; ++k) squares[k] += v[k] * v[k];
    sums_.filled = row + 1;
  }
}

void LevelParts::add_column(std::size_t mode, std::span<const double> column) {
  sums_.filled = std::min(column.size(), parts_ * rows_);
  for (std::size_t row = 0; row < sums_.filled; ++row)
    sums_.squares[row / rows_ * modes_ + mode] += column[row] * column[row];
}

void LevelParts::add_shock(double start) {
  if (parts_ == 0) return;
  const double part =
      std::floor((start * rate_ - static_cast<double>(first_)) / static_cast<double>(rows_));
  if (part >= 0 && part < static_cast<double>(parts_))
    ++sums_.shocks[static_cast<std::size_t>(part)];
}

LevelHistory LevelParts::history(const std::vector<double>& weights) const {
  LevelHistory history;
  if (parts_ == 0) return history;
  history.from = static_cast<double>(first_) / rate_;
  history.part_seconds = static_cast<double>(rows_) / rate_;
  for (std::size_t part = 0; part < sums_.filled / rows_; ++part) {
    double sum = 0;
    for (std::size_t k = 0; k < modes_; ++k) sum += weights[k] * sums_.squares[part * modes_ + k];
    history.mean_square.push_back(sum / static_cast<double>(rows_));
    history.shocks.push_back(sums_.shocks[part] / history.part_seconds);
  }
  return history;
}

void LevelParts::go_on(Sums sums) {
  if (sums.filled > parts_ * rows_ || sums.squares.size() != sums_.squares.size() ||
      sums.shocks.size() != sums_.shocks.size())
    throw std::invalid_argument("the history of its level is of another stretch");
  sums_ = std::move(sums);
}

std::string why_no_interval(double level, std::size_t parts, double seconds, double ringing) {
  const double least = static_cast<double>(independent_parts) * ringing;
  if (!std::isfinite(level)) return "there is no level";
  if (parts < independent_parts) return "too few samples";
  if (std::isinf(ringing)) return "without damping the motion never forgets";
  if (std::isnan(least)) return "the scene is not known";
  if (seconds < least)
    return fmt::format(
        "the run is too short, its slowest mode rings on: {:.2g} s or more are needed", least);
  return {};
}

IntervalsOfRun intervals_of_run(const LevelHistory& history, double level, double shock_rate,
                                double ringing) {
  const std::size_t parts = history.mean_square.size();
  IntervalsOfRun found{
      {quiet_nan, quiet_nan},
      {quiet_nan, quiet_nan},
      why_no_interval(level, parts, history.part_seconds * static_cast<double>(parts), ringing)};
  if (!found.why_none.empty()) return found;
  const double of_level =
      10 * std::numbers::log10e * half_width(history.mean_square, ringing, history.part_seconds);
  const double of_rate = std::exp(half_width(history.shocks, ringing, history.part_seconds));
  found.level = {level - of_level, level + of_level};
  found.shock_rate = {shock_rate / of_rate, shock_rate * of_rate};
  return found;
}

double ringing_of(const std::vector<double>& frequencies, double damping) {
  double slowest = std::numeric_limits<double>::infinity();
  for (const double f : frequencies)
    if (f > 0) slowest = std::min(slowest, f);
  return std::isinf(slowest) ? 0.0 : 1 / (4 * std::numbers::pi * damping * slowest);
}

}  // namespace ra2d
