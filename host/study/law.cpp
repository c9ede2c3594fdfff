// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/law.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "host/analysis/distributions.hpp"
#include "host/base/decompositions.hpp"
#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/result/level.hpp"
#include "host/study/clusters.hpp"
#include "host/study/draws.hpp"
#include "host/study/straight_line.hpp"

namespace ra2d {
namespace {

/// Whether 0 is but one of its values, so that a power of it means nothing. That is asked of its
/// first key, whose numbers they are.
bool is_offset(const StudyAxis& axis) {
  const std::string key = axis.keys.substr(0, axis.keys.find(','));
  const auto ends_key = [&](const char* name) { return key.ends_with(name); };
  return std::ranges::any_of(std::array{".gap", ".temperature", ".skewness", ".start", ".at", ".y"},
                             ends_key);
}

bool can_be_fitted(const StudyAxis& axis) {
  return axis.size() > 1 && axis.texts.empty() && !chooses_faces(axis) && !is_offset(axis) &&
         std::all_of(axis.numbers.begin(), axis.numbers.end(),
                     [](double x) { return x > 0 && std::isfinite(x); });
}

/// The amplitude of each run, NaN where there is none.
std::vector<double> amplitudes(const StudyAnswers& answers, const LawQuantity& of) {
  if (of.levels == nullptr) return answers.v_rms;
  std::vector<double> found;
  for (const double level : answers.*of.levels)
    found.push_back(of.reference * std::pow(10.0, level / 20));
  return found;
}

/// Of deviations that are chance of their own, of this variance.
std::vector<CoefficientError> independent_errors(const Eigen::MatrixXd& x, double variance) {
  const Eigen::MatrixXd inverse = solve_symmetric(
      x.transpose() * x, Eigen::MatrixXd(Eigen::MatrixXd::Identity(x.cols(), x.cols())));
  std::vector<CoefficientError> errors;
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    errors.push_back(
        {std::sqrt(variance * inverse(k, k)), static_cast<double>(x.rows() - x.cols())});
  return errors;
}

}  // namespace

std::vector<std::size_t> place_of_run(const std::vector<StudyAxis>& axes, std::size_t run) {
  std::vector<std::size_t> place(axes.size());
  for (std::size_t axis = axes.size(); axis-- > 0; run /= axes[axis].size())
    place[axis] = run % axes[axis].size();
  return place;
}

double law_level(const StudyLaw& law, const std::vector<StudyAxis>& axes,
                 const std::vector<std::size_t>& place) {
  double sum = law.constant;
  for (const Exponent& e : law.exponents)
    for (std::size_t a = 0; a < place.size(); ++a)
      if (axes[a].name == e.name) sum += 20 * e.value * std::log10(axes[a].numbers[place[a]]);
  return sum;
}

namespace {

/// The equations log10(amplitude) = constant + sum of exponent * log10(value), a row for each run.
struct LawEquations {
  Eigen::MatrixXd x;  // the values less their means, for which far more digits are left
  Eigen::VectorXd y;
  Eigen::RowVectorXd centre;  // the means
};

LawEquations law_equations(const StudyAnswers& answers, const std::vector<double>& amplitude,
                           const std::vector<std::size_t>& fitted,
                           const std::vector<std::size_t>& runs) {
  const auto rows = static_cast<Eigen::Index>(runs.size()),
             terms = static_cast<Eigen::Index>(fitted.size()) + 1;
  LawEquations e{Eigen::MatrixXd(rows, terms), Eigen::VectorXd(rows),
                 Eigen::RowVectorXd::Zero(terms - 1)};
  for (Eigen::Index row = 0; row < rows; ++row) {
    const std::size_t run = runs[static_cast<std::size_t>(row)];
    const std::vector<std::size_t> place = place_of_run(answers.axes, run);
    e.x(row, 0) = 1;
    for (std::size_t k = 0; k < fitted.size(); ++k)
      e.x(row, static_cast<Eigen::Index>(k) + 1) =
          std::log10(answers.axes[fitted[k]].numbers[place[fitted[k]]]);
    e.y(row) = std::log10(amplitude[run]);
  }
  if (rows > 0) e.centre = e.x.rightCols(terms - 1).colwise().mean();
  e.x.rightCols(terms - 1).rowwise() -= e.centre;
  return e;
}

/// The axes that the law has an exponent for; the names of the others go to `law.pooled`.
std::vector<std::size_t> fitted_axes(const StudyAnswers& answers,
                                     const std::vector<double>& amplitude, StudyLaw& law) {
  std::vector<std::size_t> fitted;
  for (std::size_t a = 0; a + 1 < answers.axes.size(); ++a) {
    if (can_be_fitted(answers.axes[a]) && changes_along(answers, amplitude, a)) {
      fitted.push_back(a);
      law.exponents.push_back({answers.axes[a].name, quiet_nan, quiet_nan, quiet_nan});
    } else if (answers.axes[a].size() > 1) {
      law.pooled.push_back(answers.axes[a].name);
    }
  }
  if (answers.axes.size() <= 1) throw RequestError("no law: no key is varied");
  if (fitted.empty())
    throw RequestError(
        "no law: no key that the study varies can have an exponent. Such a key has two or more "
        "positive numbers and changes the answers. It neither chooses a face nor is an offset, "
        "like scene.start");
  return fitted;
}

/// The intervals of the exponents. `draws`: of all runs, of which the law is fitted to `runs`.
void set_intervals(StudyLaw& law, const Draws& draws, const std::vector<std::size_t>& runs,
                   const LawEquations& equations, const Eigen::VectorXd& deviations,
                   double variance) {
  std::map<std::size_t, std::size_t> numbers;  // of the draws that these runs have
  std::vector<std::size_t> clusters;
  for (const std::size_t run : runs)
    clusters.push_back(numbers.try_emplace(draws.of_run[run], numbers.size()).first->second);
  law.seeds = numbers.size();
  if (!draws.dependent.empty()) return;
  const std::vector<CoefficientError> errors =
      law.seeds == 1 ? independent_errors(equations.x, variance)
                     : clustered_errors(equations.x, deviations, clusters);
  for (std::size_t k = 0; k < law.exponents.size(); ++k) {
    const CoefficientError& e = errors[k + 1];
    if (!(e.degrees_of_freedom > 0)) continue;
    const double half =
        e.error * student_quantile((1 + confidence_of_means) / 2, e.degrees_of_freedom);
    law.exponents[k].low = law.exponents[k].value - half;
    law.exponents[k].high = law.exponents[k].value + half;
  }
}

}  // namespace

std::string needed_for(const LawQuantity& of) {
  return of.levels == nullptr ? fmt::format("a {} above 0", of.name)
                              : fmt::format("a finite {}", of.name);
}

std::string missing_text(std::size_t runs) {
  if (runs == 0) return {};
  return fmt::format(
      "{} of the runs {} not run yet: the same 'ra2d study' command continues, or those of other "
      "shards",
      runs, runs == 1 ? "has" : "have");
}

std::vector<LawQuantity> sounds_of(const StudyAnswers& answers) {
  std::vector<LawQuantity> found;
  for (const LawQuantity& sound : sounds)
    if (!(answers.*sound.levels).empty()) found.push_back(sound);
  return found;
}

StudyLaw fit_law(const StudyAnswers& answers, const LawQuantity& of) {
  StudyLaw law;
  law.of = of;
  const std::vector<double> amplitude = amplitudes(answers, of);
  const std::vector<std::size_t> fitted = fitted_axes(answers, amplitude, law);
  if (amplitude.empty())
    throw RequestError(fmt::format("no law: the table holds no {}, for keep lacks \"{}\"", of.name,
                                   of.levels == nullptr ? "level" : "sound"));
  std::vector<std::size_t> runs;
  for (std::size_t i = 0; i < amplitude.size(); ++i)
    if (amplitude[i] > 0 && std::isfinite(amplitude[i])) runs.push_back(i);
  law.runs = runs.size();
  law.left_out = amplitude.size() - runs.size();
  law.missing = static_cast<std::size_t>(std::count(answers.status.begin(), answers.status.end(),
                                                    static_cast<double>(RunStatus::missing)));

  const LawEquations equations = law_equations(answers, amplitude, fitted, runs);
  const auto& [x, y, centre] = equations;
  const Eigen::Index rows = x.rows(), terms = x.cols();
  const LeastSquares decomposed(x);
  if (rows < terms || decomposed.rank() < terms) {
    const std::string missing = missing_text(law.missing);
    throw RequestError(fmt::format(
        "no law yet: the {} runs with {} do not vary all of the dimensions by themselves{}{}",
        runs.size(), needed_for(of), missing.empty() ? "" : ". ", missing));
  }
  const Eigen::VectorXd solution = decomposed.solve(y);
  const Eigen::VectorXd deviations = y - x * solution;
  const double residual = deviations.squaredNorm();
  const double total = (y.array() - y.mean()).matrix().squaredNorm();
  law.explained = total > 0 ? 1 - residual / total : 1;
  law.factor = std::pow(10.0, solution(0) - centre.dot(solution.tail(terms - 1)));
  law.constant = 20 * std::log10(law.factor / of.reference);
  for (std::size_t k = 0; k < fitted.size(); ++k)
    law.exponents[k].value = solution(static_cast<Eigen::Index>(k) + 1);
  law.deviation = quiet_nan;
  law.line.why_not_tested = "it takes two seeds or more that differ";
  const auto free = static_cast<double>(rows - terms);
  if (!(free > 0)) return law;
  law.deviation = 20 * std::sqrt(residual / free);
  const Draws draws = draws_of(answers, amplitude);
  law.drawn_by = draws.axes;
  law.dependent = draws.dependent;
  set_intervals(law, draws, runs, equations, deviations, residual / free);
  if (law.seeds > 1) law.line = test_straight_line(answers, amplitude, fitted, draws);
  return law;
}

std::vector<CombinationMean> combination_means(const StudyAnswers& answers) {
  std::vector<CombinationMean> means;
  const std::size_t seeds = answers.axes.back().size();
  const std::vector<LawQuantity> sounds_there = sounds_of(answers);
  if (answers.v_rms.empty() && sounds_there.empty()) return means;
  for (std::size_t first = 0; first < answers.status.size(); first += seeds) {
    std::vector<double> values, levels, rates;
    for (std::size_t i = first; i < first + seeds; ++i) {
      const double v_rms = answers.v_rms.empty() ? quiet_nan : answers.v_rms[i];
      values.push_back(v_rms);
      levels.push_back(v_rms > 0 ? level(v_rms) : quiet_nan);
      if (!answers.shock_rate.empty()) rates.push_back(answers.shock_rate[i]);
    }
    std::vector<std::size_t> place = place_of_run(answers.axes, first);
    place.pop_back();
    means.push_back({std::move(place),
                     0,
                     mean_of_runs(values, Values::positive),
                     mean_of_runs(levels),
                     mean_of_runs(rates, Values::positive),
                     {}});
    means.back().runs = means.back().v_rms.count;
    for (const LawQuantity& sound : sounds_there) {
      levels.clear();
      for (std::size_t i = first; i < first + seeds; ++i) {
        const double its = (answers.*sound.levels)[i];
        levels.push_back(std::isfinite(its) ? its : quiet_nan);
      }
      means.back().sound.push_back(mean_of_runs(levels));
      means.back().runs = std::max(means.back().runs, means.back().sound.back().count);
    }
  }
  return means;
}

}  // namespace ra2d
