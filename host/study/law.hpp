// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "host/analysis/several.hpp"
#include "host/study/study_table.hpp"

/// The law of a study's runs: v_rms as a product of powers of the varied numbers.
namespace ra2d {

/// An exponent, and where the true one lies in 95 of 100 studies (Student's t); NaN where there are
/// no more runs than exponents.
struct Exponent {
  std::string name;
  double value = 0, low = 0, high = 0;
};

/// The exponent of one dimension at both ends of another, or of itself, the others in the middle of
/// their logarithms: slopes of the parabola that each seed has.
struct LocalExponent {
  std::string of, along;
  double from = 0, to = 0;  // values of the dimension `along`
  double exponent_from = 0, exponent_to = 0;
  double p = 0;  // that chance alone makes the two differ as much
};

/// Whether a straight line is the right shape, by the lack-of-fit test (clusters.hpp).
struct StraightLine {
  std::string why_not_tested;  // empty where it was
  double p = 0, f = 0, above = 0, below = 0;
  /// Where it does not fit: the exponents that change, those that chance hardly explains first.
  std::vector<LocalExponent> changes;
  bool bends() const;
};

/// v_rms = factor x_1^e_1 x_2^e_2 ..., so that
///   Lv = 20 e_1 log10 x_1 + 20 e_2 log10 x_2 + ... + constant,
/// by least squares of log10 v_rms over all runs. Runs of one seed share their surfaces and deviate
/// alike: the intervals are by clusters of seeds (clustered_errors). With one seed, or where seeds
/// change nothing, each run's deviation is taken for chance of its own.
struct StudyLaw {
  std::vector<Exponent> exponents;  // of the dimensions that are positive numbers and vary
  std::vector<std::string> pooled;  // dimensions that are not: all of their values in one
  double factor = 0;                // in SI units
  double deviation = 0;             // dB, of the runs from the law
  double explained = 0;             // R^2: the share of the variance of log10 v_rms
  std::size_t runs = 0;             // that it is fitted to
  std::size_t left_out = 0;         // missing, failed, or of v_rms = 0
  std::size_t seeds = 1;            // clusters that the intervals are of; 1: of runs
  StraightLine line;
};

/// Throws RequestError where nothing can be fitted, and says why.
StudyLaw fit_law(const StudyAnswers& answers);

/// Of one combination: means over its seeds.
struct CombinationMean {
  std::vector<std::size_t> place;  // values of the dimensions, the seeds left out
  MeanOfRuns v_rms, level;         // m/s, dB
  MeanOfRuns shock_rate;           // 1/s; of none where the table has no rates
};
std::vector<CombinationMean> combination_means(const StudyAnswers& answers);

/// Which value of each dimension a run of the table takes, its seed's last.
std::vector<std::size_t> place_of_run(const std::vector<StudyAxis>& axes, std::size_t run);

/// Level of one place by the law [dB].
double law_level(const StudyLaw& law, const std::vector<StudyAxis>& axes,
                 const std::vector<std::size_t>& place);

/// A value as people read it.
std::string value_text(const StudyAxis& axis, std::size_t value);

/// The shape of the law in a sentence, and each change in one that follows.
std::string describe(const StraightLine& line);
std::string describe(const LocalExponent& change);

/// For people, and as JSON. `name` of the table; of more than `most_rows`
/// combinations the first are shown.
std::string describe_study(const StudyAnswers& answers, const std::string& name,
                           std::size_t most_rows = std::numeric_limits<std::size_t>::max());
/// `title`: of a picture; none if empty.
std::string study_json(const StudyAnswers& answers, const std::string& title = {});

}  // namespace ra2d
