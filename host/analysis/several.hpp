// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/analysis/analysis.hpp"

/// Means of several results.
namespace ra2d {

/// Of independent runs that differ by chance alone, e.g. by their seeds: the mean and where the true one
/// lies with this confidence, by Student's t. NaN where there are too few.
struct MeanOfRuns {
  std::size_t count = 0;  // of values that are there
  double mean = 0, deviation = 0, low = 0, high = 0;
};
inline constexpr double confidence_of_means = 0.95;
MeanOfRuns mean_of_runs(const std::vector<double>& values, double level = confidence_of_means);

/// The figures that means are taken of.
struct FigureOfRuns {
  std::string name, unit;  // as in the JSON, dots between its levels
  MeanOfRuns value;
};
std::vector<FigureOfRuns> means_of(const std::vector<Analysis>& analyses);

}  // namespace ra2d
