// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/analysis/several.hpp"
#include "host/analysis/stretch.hpp"

namespace ra2d {

/// A stretch in equal parts: what each has, from its samples and shocks.
struct LevelHistory {
  double from = 0, part_seconds = 0;  // s
  std::vector<double> mean_square;    // (m/s)^2, of the resonator's elastic motion
  std::vector<double> shocks;         // that begin in it, a second
};
LevelHistory level_history(const ResultReader& reader, const Stretch& stretch, std::size_t parts);

/// The mean of a quantity that stands part by part, from ten parts that are taken for independent.
MeanOfRuns mean_of_parts(const std::vector<double>& values);

}  // namespace ra2d
