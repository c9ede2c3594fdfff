// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/level_history.hpp"

#include <algorithm>
#include <cmath>

namespace ra2d {
namespace {

constexpr std::size_t independent_parts = 10;

double mean_square(const ResultReader& reader, std::size_t first, std::size_t count) {
  const std::vector<double>& weights = reader.contents().mean_square;
  const auto columns = reader.columns("resonator/velocity", first, count, 0, weights.size());
  double sum = 0;
  for (std::size_t k = 0; k < weights.size(); ++k)
    if (weights[k] > 0)
      for (const double v : columns[k]) sum += weights[k] * v * v;
  return sum / static_cast<double>(count);
}

}  // namespace

LevelHistory level_history(const ResultReader& reader, const Stretch& stretch, std::size_t parts) {
  LevelHistory history;
  parts = std::min(parts, stretch.count / 2);
  if (parts == 0) return history;
  const std::size_t rows = stretch.count / parts;
  const double rate = reader.contents().rate;
  history.from = static_cast<double>(stretch.first) / rate;
  history.part_seconds = static_cast<double>(rows) / rate;
  history.shocks.resize(parts);
  for (std::size_t i = 0; i < parts; ++i)
    history.mean_square.push_back(mean_square(reader, stretch.first + i * rows, rows));
  for (const Shock& shock : reader.contents().shocks) {
    const double part = std::floor((shock.start - history.from) / history.part_seconds);
    if (part >= 0 && part < static_cast<double>(parts))
      history.shocks[static_cast<std::size_t>(part)] += 1 / history.part_seconds;
  }
  return history;
}

MeanOfRuns mean_of_parts(const std::vector<double>& values) {
  const std::size_t each = values.size() / independent_parts;
  if (each == 0) return mean_of_runs({});
  std::vector<double> means(independent_parts);
  for (std::size_t i = 0; i < independent_parts * each; ++i)
    means[i / each] += values[i] / static_cast<double>(each);
  return mean_of_runs(means);
}

}  // namespace ra2d
