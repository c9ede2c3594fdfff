// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/result/level.hpp"
#include "host/scene_file/key_facts.hpp"
#include "host/study/law.hpp"
#include "host/study/study_warnings.hpp"

namespace ra2d {
namespace {

std::optional<StudyLaw> law_if_any(const StudyAnswers& answers, const LawQuantity& of,
                                   std::string& why) {
  try {
    return fit_law(answers, of);
  } catch (const RequestError& fault) {
    why = fault.what();
    return std::nullopt;
  }
}

std::size_t count_of(const StudyAnswers& answers, RunStatus status) {
  return static_cast<std::size_t>(
      std::count(answers.status.begin(), answers.status.end(), static_cast<double>(status)));
}

/// Says which runs the intervals take for independent.
std::string intervals_text(const StudyLaw& law) {
  if (!law.dependent.empty()) return "no intervals: " + law.dependent;
  if (law.seeds == 1) return "intervals by the runs, each taken for chance of its own";
  if (law.drawn_by == std::vector<std::string>{"seed"})
    return fmt::format("intervals by the {} seeds: runs of one seed share their surfaces",
                       law.seeds);
  return fmt::format("intervals by the {} values of {}: runs of one value share a face", law.seeds,
                     fmt::join(law.drawn_by, " and "));
}

std::string law_text(const StudyLaw& law) {
  std::string formula = fmt::format("{} =", law.of.symbol);
  for (const Exponent& e : law.exponents)
    formula += fmt::format(" 20 x {:.3f} log10({}) +", e.value, e.name);
  formula += fmt::format(" {:.2f} dB", law.constant);
  if (law.of.levels != nullptr) formula += fmt::format(" re {}", law.of.reference_text);
  formula += ", of values in SI units";
  std::string text = fmt::format("  {:<17}{}\n", "law", formula);
  for (const Exponent& e : law.exponents)
    text += std::isnan(e.low) ? fmt::format("    {:<15}{:.3f} ({})\n", e.name, e.value,
                                            law.dependent.empty() ? "too few runs for an interval"
                                                                  : "no interval")
                              : fmt::format("    {:<15}{:.3f}, 95 % from {:.3f} to {:.3f}\n",
                                            e.name, e.value, e.low, e.high);
  text += fmt::format("    {} runs, R^2 = {:.4f}", law.runs, law.explained);
  if (!std::isnan(law.deviation))
    text += fmt::format(", {:.2f} dB from the law to a run", law.deviation);
  if (const std::size_t ended = law.left_out - law.missing; ended > 0)
    text += fmt::format("; {} without {} left out", ended, needed_for(law.of));
  text += '\n';
  if (law.missing > 0) text += fmt::format("    {}\n", missing_text(law.missing));
  text += fmt::format("    {}\n", intervals_text(law));
  text += fmt::format("    {}\n", describe(law.line));
  for (const LocalExponent& change : law.line.changes)
    text += fmt::format("      {}\n", describe(change));
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

nlohmann::ordered_json json_line(const StraightLine& line) {
  nlohmann::ordered_json json;
  const bool tested = line.why_not_tested.empty();
  json["fits"] = tested ? nlohmann::ordered_json(!line.bends()) : nlohmann::ordered_json();
  json["p"] = tested ? json_number(line.p) : nlohmann::ordered_json();
  json["f"] = tested ? json_number(line.f) : nlohmann::ordered_json();
  json["degrees_of_freedom"] =
      tested ? nlohmann::ordered_json({line.above, line.below}) : nlohmann::ordered_json();
  json["says"] = describe(line);
  nlohmann::ordered_json changes = nlohmann::ordered_json::array();
  for (const LocalExponent& c : line.changes)
    changes.push_back({{"of", c.of},
                       {"along", c.along},
                       {"from", c.from},
                       {"to", c.to},
                       {"exponent_from", json_number(c.exponent_from)},
                       {"exponent_to", json_number(c.exponent_to)},
                       {"p", json_number(c.p)}});
  json["changes"] = std::move(changes);
  return json;
}

nlohmann::ordered_json json_law(const StudyLaw& law) {
  nlohmann::ordered_json exponents = nlohmann::ordered_json::object();
  for (const Exponent& e : law.exponents)
    exponents[e.name] = {{"value", json_number(e.value)},
                         {"low", json_number(e.low)},
                         {"high", json_number(e.high)}};
  return {{"of", law.of.name},
          {"exponents", std::move(exponents)},
          {"factor", json_number(law.factor)},
          {"constant_db", json_number(law.constant)},
          {"deviation_db", json_number(law.deviation)},
          {"r_squared", json_number(law.explained)},
          {"runs", law.runs},
          {"seeds", law.seeds},
          {"drawn_by", law.drawn_by},
          {"intervals", intervals_text(law)},
          {"straight_line", json_line(law.line)},
          {"left_out", law.left_out},
          {"pooled", law.pooled}};
}

/// Of shocks a second, in four digits or so.
std::string rate_number(double rate) {
  return rate < 1e4 ? fmt::format("{:.4g}", rate) : fmt::format("{:.0f}", rate);
}

/// Its name and unit.
std::string head_of(const StudyAxis& axis) {
  const std::string unit = unit_of_udunits(axis.units);
  return unit.empty() ? axis.name : fmt::format("{} [{}]", axis.name, unit);
}

/// A line for each combination: its level and its rate of shocks with their 95 % intervals.
std::string means_text(const StudyAnswers& answers, std::size_t most_rows) {
  const bool rates = !answers.shock_rate.empty();
  std::string text = "  ";
  for (std::size_t a = 0; a + 1 < answers.axes.size(); ++a)
    text += fmt::format("{:<12} ", head_of(answers.axes[a]));
  text += fmt::format("{:>5} {:>13} {:>10}  {:<18}{}\n", "runs", "v_rms [m/s]", "Lv [dB]", "95 %",
                      rates ? "  shocks [1/s]  95 %" : "");
  const auto interval = [](const MeanOfRuns& mean, const std::string& both) {
    return std::isfinite(mean.low) ? both : mean.count == 1 ? "one run: none" : "";
  };
  const std::vector<CombinationMean> means = combination_means(answers);
  for (std::size_t i = 0; i < std::min(means.size(), most_rows); ++i) {
    const CombinationMean& mean = means[i];
    std::string row = "  ";
    for (std::size_t a = 0; a < mean.place.size(); ++a)
      row += fmt::format("{:<12} ", shortened(value_text(answers.axes[a], mean.place[a])));
    row += fmt::format("{:>5}", mean.runs);
    if (mean.v_rms.count > 0)
      row += fmt::format(
          " {:>13.3e} {:>10.2f}  {:<18}", mean.v_rms.mean,
          mean.level.count > 0 ? mean.level.mean : level(0),
          interval(mean.level, fmt::format("{:.2f} to {:.2f}", mean.level.low, mean.level.high)));
    if (mean.shock_rate.count > 0)
      row += fmt::format("  {:>12}  {}", rate_number(mean.shock_rate.mean),
                         interval(mean.shock_rate, rate_number(mean.shock_rate.low) + " to " +
                                                       rate_number(mean.shock_rate.high)));
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + '\n';
  }
  if (means.size() > most_rows)
    text += fmt::format("  and {} more: 'ra2d analyze' has them all\n", means.size() - most_rows);
  return text;
}

/// A line for each combination: the levels of its sound with half of their 95 % intervals.
std::string sound_text(const StudyAnswers& answers, std::size_t most_rows) {
  const std::vector<LawQuantity> sound = sounds_of(answers);
  if (sound.empty()) return {};
  std::string head = "  ";
  for (std::size_t a = 0; a + 1 < answers.axes.size(); ++a)
    head += fmt::format("{:<12} ", head_of(answers.axes[a]));
  for (const LawQuantity& one : sound)
    head += fmt::format("{:<17}", fmt::format("{} [dB]  95 %", one.symbol));
  std::string text = head.substr(0, head.find_last_not_of(' ') + 1) + '\n';
  const std::vector<CombinationMean> means = combination_means(answers);
  for (std::size_t i = 0; i < std::min(means.size(), most_rows); ++i) {
    std::string row = "  ";
    for (std::size_t a = 0; a < means[i].place.size(); ++a)
      row += fmt::format("{:<12} ", shortened(value_text(answers.axes[a], means[i].place[a])));
    for (const MeanOfRuns& its : means[i].sound) {
      std::string level = its.count > 0 ? fmt::format("{:.2f}", its.mean) : "none";
      if (std::isfinite(its.high)) level += fmt::format(" +- {:.2f}", its.high - its.mean);
      row += fmt::format("{:<17}", level);
    }
    text += row.substr(0, row.find_last_not_of(' ') + 1) + '\n';
  }
  return text;
}

}  // namespace

std::string value_text(const StudyAxis& axis, std::size_t value) {
  return axis.texts.empty() ? fmt::format("{:g}", axis.numbers[value])
                            : printable(axis.texts[value]);
}

std::string describe_study(const StudyAnswers& answers, const std::string& name,
                           std::size_t most_rows) {
  const std::size_t missing = count_of(answers, RunStatus::missing),
                    done = count_of(answers, RunStatus::done);
  std::string text =
      fmt::format("{}: {} runs, {} done, {} failed, {} missing\n", printable(name),
                  answers.status.size(), done, answers.status.size() - done - missing, missing);
  if (!answers.v_rms.empty()) text += means_text(answers, most_rows);
  text += sound_text(answers, most_rows);
  text += warnings_text(answers);
  std::string why;
  const auto law = law_if_any(answers, vibration, why);
  text += law ? law_text(*law) : fmt::format("  {}\n", why);
  for (const LawQuantity& sound : sounds_of(answers)) {
    const auto its = law_if_any(answers, sound, why);
    text += its ? law_text(*its) : fmt::format("  {}: {}\n", sound.symbol, why);
  }
  return text;
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
    point["runs"] = mean.runs;
    point["v_rms"] = json_mean(mean.v_rms);
    point["lv"] = json_mean(mean.level);
    if (!answers.shock_rate.empty()) point["shock_rate"] = json_mean(mean.shock_rate);
    for (std::size_t i = 0; i < mean.sound.size(); ++i)
      point[sounds_of(answers)[i].name] = json_mean(mean.sound[i]);
    points.push_back(std::move(point));
  }
  json["points"] = std::move(points);
  json["warnings"] = nlohmann::ordered_json::array();
  for (const SharedWarning& warning : shared_warnings(answers))
    json["warnings"].push_back(
        {{"text", warning.text}, {"runs", warning.runs}, {"first", warning.first}});
  std::string why;
  if (const auto law = law_if_any(answers, vibration, why)) {
    json["law"] = json_law(*law);
  } else {
    json["law"] = nullptr;
    json["why_no_law"] = why;
  }
  for (const LawQuantity& sound : sounds_of(answers)) {
    const auto law = law_if_any(answers, sound, why);
    json["sound_laws"][sound.name] =
        law ? json_law(*law) : nlohmann::ordered_json{{"of", sound.name}, {"why_none", why}};
  }
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace ra2d
