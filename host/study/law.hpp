// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/analysis/several.hpp"
#include "host/study/study_table.hpp"

/// What the runs of a study say together.
namespace ra2d {

/// An exponent, and where the true one lies in 95 of 100 studies (Student's t); NaN where there are no
/// more runs than exponents.
struct Exponent {
  std::string name;
  double value = 0, low = 0, high = 0;
};

/// v_rms = factor x_1^e_1 x_2^e_2 ..., so that
///   Lv = 20 e_1 log10 x_1 + 20 e_2 log10 x_2 + ... + constant,
/// by least squares of log10 v_rms over all runs. The runs' deviations from it are taken for chance, one
/// independent of the other; runs of one seed share their surfaces, and are so only about.
struct StudyLaw {
  std::vector<Exponent> exponents;  // of the dimensions that are positive numbers and vary
  std::vector<std::string> pooled;  // dimensions that are not: all of their values in one
  double factor = 0;                // in SI units
  double deviation = 0;             // dB, of the runs from the law
  double explained = 0;             // R^2: the share of the variance of log10 v_rms
  std::size_t runs = 0;             // that it is fitted to
  std::size_t left_out = 0;         // missing, failed, or of v_rms = 0
};

/// Throws RequestError where nothing can be fitted, and says why.
StudyLaw fit_law(const StudyAnswers& answers);

/// Of one combination: means over its seeds.
struct CombinationMean {
  std::vector<std::size_t> place;  // values of the dimensions, the seeds left out
  MeanOfRuns v_rms, level;         // m/s, dB
};
std::vector<CombinationMean> combination_means(const StudyAnswers& answers);

/// Level of one place by the law [dB].
double law_level(const StudyLaw& law, const std::vector<StudyAxis>& axes,
                 const std::vector<std::size_t>& place);

/// A value as people read it.
std::string value_text(const StudyAxis& axis, std::size_t value);

/// For people, and as JSON. `name` of the table.
std::string describe_study(const StudyAnswers& answers, const std::string& name);
/// `title`: of a picture; none if empty.
std::string study_json(const StudyAnswers& answers, const std::string& title = {});

}  // namespace ra2d
