// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/law.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/analysis/distributions.hpp"
#include "host/errors.hpp"
#include "host/result/level.hpp"
#include "host/text.hpp"

namespace ra2d {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::size_t> place_of_run(const std::vector<StudyAxis>& axes, std::size_t run) {
  std::vector<std::size_t> place(axes.size());
  for (std::size_t axis = axes.size(); axis-- > 0; run /= axes[axis].size())
    place[axis] = run % axes[axis].size();
  return place;
}

bool can_be_fitted(const StudyAxis& axis) {
  return axis.size() > 1 && axis.texts.empty() &&
         std::all_of(axis.numbers.begin(), axis.numbers.end(),
                     [](double x) { return x > 0 && std::isfinite(x); });
}

std::optional<StudyLaw> law_if_any(const StudyAnswers& answers, std::string& why) {
  try {
    return fit_law(answers);
  } catch (const RequestError& fault) {
    why = fault.what();
    return std::nullopt;
  }
}

std::size_t count_of(const StudyAnswers& answers, RunStatus status) {
  return static_cast<std::size_t>(
      std::count(answers.status.begin(), answers.status.end(), static_cast<double>(status)));
}

std::string law_text(const StudyLaw& law) {
  std::string formula = "Lv =";
  for (const Exponent& e : law.exponents)
    formula += fmt::format(" 20 x {:.3f} log10({}) +", e.value, e.name);
  formula += fmt::format(" {:.2f} dB", level(law.factor));
  std::string text = fmt::format("  {:<17}{}\n", "law", formula);
  for (const Exponent& e : law.exponents)
    text += std::isnan(e.low)
                ? fmt::format("    {:<15}{:.3f} (too few runs for an interval)\n", e.name, e.value)
                : fmt::format("    {:<15}{:.3f}, 95 % from {:.3f} to {:.3f}\n", e.name, e.value,
                              e.low, e.high);
  text += fmt::format("    {} runs, R^2 = {:.4f}", law.runs, law.explained);
  if (!std::isnan(law.deviation))
    text += fmt::format(", {:.2f} dB from the law to a run", law.deviation);
  if (law.left_out > 0) text += fmt::format("; {} without a v_rms left out", law.left_out);
  text += '\n';
  if (!law.pooled.empty())
    text += fmt::format("    taken together: all values of {}\n", fmt::join(law.pooled, ", "));
  return text;
}

nlohmann::ordered_json json_number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

nlohmann::ordered_json json_mean(const MeanOfRuns& mean) {
  return {{"mean", json_number(mean.mean)},
          {"deviation", json_number(mean.deviation)},
          {"low", json_number(mean.low)},
          {"high", json_number(mean.high)}};
}

}  // namespace

std::string value_text(const StudyAxis& axis, std::size_t value) {
  return axis.texts.empty() ? fmt::format("{:g}", axis.numbers[value]) : axis.texts[value];
}

double law_level(const StudyLaw& law, const std::vector<StudyAxis>& axes,
                 const std::vector<std::size_t>& place) {
  double sum = level(law.factor);
  for (const Exponent& e : law.exponents)
    for (std::size_t a = 0; a < place.size(); ++a)
      if (axes[a].name == e.name) sum += 20 * e.value * std::log10(axes[a].numbers[place[a]]);
  return sum;
}

StudyLaw fit_law(const StudyAnswers& answers) {
  StudyLaw law;
  std::vector<std::size_t> fitted;
  for (std::size_t a = 0; a + 1 < answers.axes.size(); ++a) {
    if (can_be_fitted(answers.axes[a])) {
      fitted.push_back(a);
      law.exponents.push_back({answers.axes[a].name, nan, nan, nan});
    } else if (answers.axes[a].size() > 1) {
      law.pooled.push_back(answers.axes[a].name);
    }
  }
  if (fitted.empty())
    throw RequestError("no law: no dimension of this study is of two positive numbers or more");
  if (answers.v_rms.empty())
    throw RequestError("no law: the table holds no v_rms (keep = [\"level\"])");
  std::vector<std::size_t> runs;
  for (std::size_t i = 0; i < answers.v_rms.size(); ++i)
    if (answers.v_rms[i] > 0 && std::isfinite(answers.v_rms[i])) runs.push_back(i);
  law.runs = runs.size();
  law.left_out = answers.v_rms.size() - runs.size();

  const auto rows = static_cast<Eigen::Index>(runs.size()),
             terms = static_cast<Eigen::Index>(fitted.size()) + 1;
  Eigen::MatrixXd x(rows, terms);
  Eigen::VectorXd y(rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const std::size_t run = runs[static_cast<std::size_t>(row)];
    const std::vector<std::size_t> place = place_of_run(answers.axes, run);
    x(row, 0) = 1;
    for (std::size_t k = 0; k < fitted.size(); ++k)
      x(row, static_cast<Eigen::Index>(k) + 1) =
          std::log10(answers.axes[fitted[k]].numbers[place[fitted[k]]]);
    y(row) = std::log10(answers.v_rms[run]);
  }
  // about their means, for which far more digits are left
  const Eigen::RowVectorXd centre =
      rows > 0 ? Eigen::RowVectorXd(x.rightCols(terms - 1).colwise().mean())
               : Eigen::RowVectorXd::Zero(terms - 1);
  x.rightCols(terms - 1).rowwise() -= centre;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> decomposed(x);
  if (rows < terms || decomposed.rank() < terms)
    throw RequestError(fmt::format(
        "no law yet: the {} runs with a v_rms do not vary all of the dimensions by themselves",
        runs.size()));
  const Eigen::VectorXd solution = decomposed.solve(y);
  const double residual = (y - x * solution).squaredNorm();
  const double total = (y.array() - y.mean()).matrix().squaredNorm();
  law.explained = total > 0 ? 1 - residual / total : 1;
  const double constant = solution(0) - centre.dot(solution.tail(terms - 1));
  law.factor = std::pow(10.0, constant);
  for (std::size_t k = 0; k < fitted.size(); ++k)
    law.exponents[k].value = solution(static_cast<Eigen::Index>(k) + 1);
  law.deviation = nan;
  const auto free = static_cast<double>(rows - terms);
  if (!(free > 0)) return law;
  const double variance = residual / free;
  law.deviation = 20 * std::sqrt(variance);
  const Eigen::MatrixXd inverse =
      (x.transpose() * x).ldlt().solve(Eigen::MatrixXd::Identity(terms, terms));
  const double t = student_quantile((1 + confidence_of_means) / 2, free);
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k) + 1;
    const double half = t * std::sqrt(variance * inverse(at, at));
    law.exponents[k].low = law.exponents[k].value - half;
    law.exponents[k].high = law.exponents[k].value + half;
  }
  return law;
}

std::vector<CombinationMean> combination_means(const StudyAnswers& answers) {
  std::vector<CombinationMean> means;
  const std::size_t seeds = answers.axes.back().size();
  for (std::size_t first = 0; first < answers.v_rms.size(); first += seeds) {
    std::vector<double> values, levels;
    for (std::size_t i = first; i < first + seeds; ++i) {
      values.push_back(answers.v_rms[i]);
      levels.push_back(answers.v_rms[i] > 0 ? level(answers.v_rms[i]) : nan);
    }
    std::vector<std::size_t> place = place_of_run(answers.axes, first);
    place.pop_back();
    means.push_back({std::move(place), mean_of_runs(values), mean_of_runs(levels)});
  }
  return means;
}

std::string describe_study(const StudyAnswers& answers, const std::string& name) {
  const std::size_t missing = count_of(answers, RunStatus::missing),
                    done = count_of(answers, RunStatus::done);
  std::string text =
      fmt::format("{}: {} runs, {} done, {} failed, {} missing\n", printable(name),
                  answers.status.size(), done, answers.status.size() - done - missing, missing);
  if (!answers.v_rms.empty()) {
    text += "  ";
    for (std::size_t a = 0; a + 1 < answers.axes.size(); ++a)
      text += fmt::format("{:<12} ", answers.axes[a].name);
    text += fmt::format("{:>5} {:>13} {:>10}  {}\n", "runs", "v_rms [m/s]", "Lv [dB]", "95 %");
    for (const CombinationMean& mean : combination_means(answers)) {
      text += "  ";
      for (std::size_t a = 0; a < mean.place.size(); ++a)
        text += fmt::format("{:<12} ", shortened(value_text(answers.axes[a], mean.place[a])));
      text += fmt::format("{:>5}", mean.v_rms.count);
      if (mean.v_rms.count > 0) text += fmt::format(" {:>13.3e}", mean.v_rms.mean);
      if (mean.level.count > 0) text += fmt::format(" {:>10.2f}", mean.level.mean);
      if (mean.level.count > 1)
        text += fmt::format("  {:.2f} to {:.2f}", mean.level.low, mean.level.high);
      text += '\n';
    }
  }
  std::string why;
  const auto law = law_if_any(answers, why);
  return text + (law ? law_text(*law) : fmt::format("  {}\n", why));
}

std::string study_json(const StudyAnswers& answers, const std::string& title) {
  nlohmann::ordered_json json;
  if (!title.empty()) json["title"] = title;
  json["runs"] = answers.status.size();
  json["done"] = count_of(answers, RunStatus::done);
  json["missing"] = count_of(answers, RunStatus::missing);
  json["failed"] = answers.status.size() - count_of(answers, RunStatus::done) -
                   count_of(answers, RunStatus::missing);
  nlohmann::ordered_json axes = nlohmann::ordered_json::object(),
                         units = nlohmann::ordered_json::object();
  for (const StudyAxis& axis : answers.axes) {
    units[axis.name] = axis.units;
    if (axis.texts.empty())
      axes[axis.name] = axis.numbers;
    else
      axes[axis.name] = axis.texts;
  }
  json["dimensions"] = std::move(axes);
  json["units"] = std::move(units);
  nlohmann::ordered_json points = nlohmann::ordered_json::array();
  for (const CombinationMean& mean : combination_means(answers)) {
    nlohmann::ordered_json point = nlohmann::ordered_json::object();
    for (std::size_t a = 0; a < mean.place.size(); ++a) {
      const StudyAxis& axis = answers.axes[a];
      if (axis.texts.empty())
        point[axis.name] = axis.numbers[mean.place[a]];
      else
        point[axis.name] = axis.texts[mean.place[a]];
    }
    point["runs"] = mean.v_rms.count;
    point["v_rms"] = json_mean(mean.v_rms);
    point["lv"] = json_mean(mean.level);
    points.push_back(std::move(point));
  }
  json["points"] = std::move(points);
  std::string why;
  if (const auto law = law_if_any(answers, why)) {
    nlohmann::ordered_json exponents = nlohmann::ordered_json::object();
    for (const Exponent& e : law->exponents)
      exponents[e.name] = {{"value", json_number(e.value)},
                           {"low", json_number(e.low)},
                           {"high", json_number(e.high)}};
    json["law"] = {{"of", "v_rms"},
                   {"exponents", std::move(exponents)},
                   {"factor", json_number(law->factor)},
                   {"constant_db", json_number(level(law->factor))},
                   {"deviation_db", json_number(law->deviation)},
                   {"r_squared", json_number(law->explained)},
                   {"runs", law->runs},
                   {"left_out", law->left_out},
                   {"pooled", law->pooled}};
  } else {
    json["law"] = nullptr;
    json["why_no_law"] = why;
  }
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace ra2d
