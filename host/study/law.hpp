// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "host/analysis/means.hpp"
#include "host/study/study_table.hpp"

/// The law of a study's runs: an amplitude as a product of powers of the varied numbers.
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

/// An amplitude that laws are fitted to. Its level is 20 log10(amplitude/reference).
struct LawQuantity {
  const char *name, *symbol,
      *reference_text;                        // of the table's column; of the level: "Lv", "1 nm/s"
  double reference;                           // SI units; of a power's amplitude W^(1/2)
  std::vector<double> StudyAnswers::*levels;  // none: the amplitude is v_rms
};
inline constexpr LawQuantity vibration{"v_rms", "Lv", "1 nm/s", 1e-9, nullptr};
/// Those of sound. Their exponents are those of a pressure, and of the square root of a power.
inline constexpr LawQuantity sounds[] = {
    {"lp", "Lp", "20 uPa", 20e-6, &StudyAnswers::lp},
    {"lpa", "LpA", "20 uPa, A-weighted", 20e-6, &StudyAnswers::lp_a},
    {"lw", "Lw", "1 pW", 1e-6, &StudyAnswers::lw},
    {"lwa", "LwA", "1 pW, A-weighted", 1e-6, &StudyAnswers::lw_a},
};
/// A run counts for the law if it has this: "a v_rms above 0".
std::string needed_for(const LawQuantity& of);

/// Says of runs that are missing what runs them; nothing of none.
std::string missing_text(std::size_t runs);
/// Those of sound that the table has.
std::vector<LawQuantity> sounds_of(const StudyAnswers& answers);

/// v_rms = factor x_1^e_1 x_2^e_2 ..., so that
///   Lv = 20 e_1 log10 x_1 + 20 e_2 log10 x_2 + ... + constant,
/// by least squares of log10 v_rms over all runs; other amplitudes likewise. Runs of one draw share
/// their surfaces and deviate alike: the intervals are by clusters of draws (draws_of,
/// clustered_errors). With one draw each run's deviation is taken for chance of its own.
struct StudyLaw {
  std::vector<Exponent> exponents;    // of the dimensions that are positive scales and vary
  std::vector<std::string> pooled;    // dimensions that are not: all of their values in one
  double factor = 0;                  // in the quantity's SI units
  double constant = 0;                // dB, of its level
  double deviation = 0;               // dB, of the runs from the law
  double explained = 0;               // R^2: the share of the variance of the logarithm
  std::size_t runs = 0;               // that it is fitted to
  std::size_t left_out = 0;           // missing, failed, or of amplitude 0
  std::size_t missing = 0;            // of these, runs that have not run yet
  std::size_t seeds = 1;              // draws that the intervals are of; 1: of runs
  std::vector<std::string> drawn_by;  // dimensions whose values are the draws: mostly "seed"
  std::string dependent;              // Draws::dependent: then there are no intervals
  StraightLine line;
  LawQuantity of = vibration;
};

/// Throws RequestError where nothing can be fitted, and says why.
StudyLaw fit_law(const StudyAnswers& answers, const LawQuantity& of = vibration);

/// Of one combination: means over its seeds.
struct CombinationMean {
  std::vector<std::size_t> place;  // values of the dimensions, the seeds left out
  std::size_t runs = 0;            // that have numbers
  MeanOfRuns v_rms, level;         // m/s, dB
  MeanOfRuns shock_rate;           // 1/s; of none where the table has no rates
  std::vector<MeanOfRuns> sound;   // dB, of each of sounds_of()
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
