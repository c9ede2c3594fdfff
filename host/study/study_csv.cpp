// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_csv.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/base/csv.hpp"
#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

/// One column of a line; empty where there is no number.
std::string column(double value) { return std::isfinite(value) ? fmt::format(",{}", value) : ","; }

void add(const MeanOfRuns& mean, std::string& text) {
  for (const double value : {mean.mean, mean.deviation, mean.low, mean.high}) text += column(value);
}

/// Its lines of the table. Those of another amplitude than v_rms begin with its name.
std::string law_rows(const StudyLaw& law) {
  const std::string of = law.of.levels == nullptr ? "" : fmt::format("{}_", law.of.name);
  std::string text;
  for (const Exponent& e : law.exponents)
    text += csv_field(of + "exponent_" + e.name) + column(e.value) + column(e.low) +
            column(e.high) + '\n';
  for (const auto& [name, value] :
       {std::pair{"factor", law.factor},
        {"constant_dB", law.constant},
        {"deviation_dB", law.deviation},
        {"r_squared", law.explained},
        {"straight_line_p", law.line.why_not_tested.empty() ? law.line.p : quiet_nan},
        {"seeds", static_cast<double>(law.seeds)},
        {"runs", static_cast<double>(law.runs)},
        {"left_out", static_cast<double>(law.left_out)}})
    text += of + name + column(value) + ",,\n";
  return text;
}

}  // namespace

std::string means_csv(const StudyAnswers& answers) {
  const std::size_t dimensions = answers.axes.size() - 1;  // the last are the seeds
  std::string text;
  for (std::size_t a = 0; a < dimensions; ++a) text += csv_field(answers.axes[a].name) + ',';
  text += "runs";
  for (const auto& [name, unit] :
       {std::pair{"v_rms", "m/s"}, {"level", "dB"}, {"shock_rate", "1/s"}})
    for (const char* figure : {"mean", "deviation", "low", "high"})
      text += fmt::format(",{}_{}_{}", name, figure, unit);
  for (const LawQuantity& sound : sounds_of(answers))
    for (const char* figure : {"mean", "deviation", "low", "high"})
      text += fmt::format(",{}_{}_dB", sound.name, figure);
  text += '\n';
  for (const CombinationMean& mean : combination_means(answers)) {
    for (std::size_t a = 0; a < dimensions; ++a) {
      const StudyAxis& axis = answers.axes[a];
      text += axis.texts.empty() ? fmt::format("{},", axis.numbers[mean.place[a]])
                                 : csv_field(axis.texts[mean.place[a]]) + ',';
    }
    text += fmt::format("{}", mean.runs);
    add(mean.v_rms, text);
    add(mean.level, text);
    add(mean.shock_rate, text);
    for (const MeanOfRuns& sound : mean.sound) add(sound, text);
    text += '\n';
  }
  return text;
}

std::string law_csv(const std::vector<StudyLaw>& laws) {
  std::string text = "quantity,value,low,high\n";
  for (const StudyLaw& law : laws) text += law_rows(law);
  return text;
}

}  // namespace ra2d
