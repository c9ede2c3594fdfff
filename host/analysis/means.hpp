// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/analysis/analysis.hpp"

/// Means of several results.
namespace ra2d {

/// Which intervals fit what is averaged.
enum class Values {
  any,       // of either sign, or levels in dB
  positive,  // rates, velocities, durations: skewed to the right, the more the wider they spread
  share      // from 0 to 1
};

/// The mean of independent runs that differ by chance alone, e.g. by their seeds, and its interval
/// of 95 % confidence, by Student's t; of positive values by Student's t of the
/// mean's logarithm, mean exp(+-t deviation / (sqrt(count) mean)), and of shares of its logit.
/// bench/coverage.py measures how often they hold the truth. NaN where there are too few, or all
/// are equal.
struct MeanOfRuns {
  std::size_t count = 0;  // of values that are there
  double mean = 0, deviation = 0, low = 0, high = 0;
};
inline constexpr double confidence_of_means = 0.95;
MeanOfRuns mean_of_runs(const std::vector<double>& values, Values kind = Values::any);

/// The figures that means are taken of.
struct FigureOfRuns {
  std::string name, unit;  // as in the JSON, dots between its levels
  MeanOfRuns value;
};
std::vector<FigureOfRuns> means_of(const std::vector<Analysis>& analyses);

/// Where the results are no independent runs of one scene: a run that is there twice, runs that
/// touch a part of the same faces, and scenes that differ in more than their faces. One text for
/// each of these.
std::vector<std::string> doubts_of_means(const std::vector<Analysis>& analyses);

}  // namespace ra2d
