// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/long_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "host/base/errors.hpp"
#include "host/ensemble/ensemble.hpp"
#include "host/plan/plan.hpp"
#include "host/result/level.hpp"
#include "host/run/v_rms.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

/// The settings that are run for long, of those whose rate is known. `reference`: the one that the
/// others are compared with.
std::vector<Method> long_settings(const Survey& survey, Method& reference) {
  const auto is_measured = [&](const Method& setting) {
    return survey.measured(setting) != nullptr;
  };
  const auto step_near = [&](double wanted) {
    return *std::min_element(
        survey.options.steps.begin(), survey.options.steps.end(), [&](double a, double b) {
          return std::abs(std::log(a / wanted)) < std::abs(std::log(b / wanted));
        });
  };
  const double step = step_near(survey.scene.time.step);
  const ContactLaw law = survey.methods.front().law;
  const Method midpoint{{SchemeKind::midpoint}, law},
      own{choice_of(survey.scene), survey.scene.contact.law},
      euler{{SchemeKind::backward_euler}, ContactLaw::penalty},
      inelastic{{SchemeKind::backward_euler}, ContactLaw::multiplier};
  std::vector<Method> settings;
  const auto add = [&](const Method& setting) {
    if (is_measured(setting) &&
        std::find(settings.begin(), settings.end(), setting) == settings.end())
      settings.push_back(setting);
  };
  for (const Method& method : survey.methods)
    if (is_adaptive(method.time))
      for (const double tolerance : {1e-8, 1e-6, 1e-4})
        if (std::find(survey.options.tolerances.begin(), survey.options.tolerances.end(),
                      tolerance) != survey.options.tolerances.end())
          add(sized(method, tolerance));
  if (settings.empty()) add(sized(midpoint, step_near(step / 3)));
  if (settings.empty()) add(sized(midpoint, step));
  if (!settings.empty()) reference = settings.front();
  add(sized(own, is_adaptive(survey.scene) ? survey.scene.time.tolerance.value_or(0) : step));
  add(sized(euler, step));
  add(sized(midpoint, step));
  for (const double coarse : {step_near(10 * step), step_near(3 * step)})
    if (is_measured(sized(midpoint, coarse))) {
      add(sized(midpoint, coarse));
      break;
    }
  add(sized(inelastic, step));
  return settings;
}

/// Surfaces from which every law finds its start, and that of each on each of them.
struct Surfaces {
  std::vector<int> seeds;
  std::vector<Model> made;  // one a seed, under any setting: the faces are made once
  std::map<ContactLaw, std::vector<ModalStart>> starts;
};

Surfaces to_start_from(const Survey& survey, const std::vector<Method>& settings) {
  Surfaces surfaces;
  const double half = 0.5 * survey.left(long_end);  // s: the other half is for the march
  for (int seed = 0; seed < (has_seeds(survey.scene) ? survey.options.seeds : 1); ++seed) {
    if (seed > 0 && survey.left(long_end) < half) break;
    std::map<ContactLaw, ModalStart> found;
    std::optional<Model> made;
    try {
      for (const Method& setting : settings) {
        if (found.contains(setting.law)) continue;
        const Scene scene = variant(with(survey.scene, setting), seed);
        made = made ? with_settings(*made, scene) : make_model(scene);
        found[setting.law] = make_start(*made);
      }
    } catch (const RequestError&) {
      continue;
    }
    surfaces.seeds.push_back(seed);
    surfaces.made.push_back(*std::move(made));
    for (auto& [law, start] : found) surfaces.starts[law].push_back(std::move(start));
  }
  return surfaces;
}

using Quantities = std::array<double, quantities>;

Quantities quantities_of(const Model& model, const TimedRun& run) {
  const Answer answer = answer_of(mean_squares(model), run, model.scene.output.from);
  return {level(answer.v_rms), answer.shock_rate, answer.shock_duration_median};
}

/// Mean and standard error of values; `apart` are their differences from the reference's.
Statistic statistic(const std::vector<double>& values, const std::vector<double>& apart) {
  const auto mean_of = [](const std::vector<double>& x, double& mean, double& error) {
    const double count = static_cast<double>(x.size());
    double sum = 0, square = 0;
    for (const double value : x) sum += value;
    mean = sum / count;
    for (const double value : x) square += (value - mean) * (value - mean);
    error = x.size() > 1 ? std::sqrt(square / (count - 1) / count) : quiet_nan;
  };
  Statistic s;
  mean_of(values, s.mean, s.error);
  if (!apart.empty()) mean_of(apart, s.difference, s.difference_error);
  return s;
}

std::array<Statistic, quantities> statistics_of(const std::vector<Quantities>& found,
                                                const std::vector<Quantities>& reference) {
  std::array<Statistic, quantities> statistics;
  for (std::size_t q = 0; q < quantities; ++q) {
    std::vector<double> values, apart;
    for (std::size_t i = 0; i < found.size(); ++i) {
      values.push_back(found[i][q]);
      if (!reference.empty()) apart.push_back(found[i][q] - reference[i][q]);
    }
    statistics[q] = statistic(values, apart);
  }
  return statistics;
}

/// s of wall time of a setting for a simulated second.
double rate_of(const Survey& survey, const Method& setting) {
  const Measured& row = *survey.measured(setting);
  return row.slowed * row.wall_median();
}

/// How long [s] every run can be; 0 where the time is up. `making`: s, of all models of one law.
double time_of_each(const Survey& survey, const std::vector<Method>& settings, double making) {
  double rates = 0;
  for (const Method& setting : settings) rates += rate_of(survey, setting);
  const double marching =
      0.9 * survey.left(long_end) - making * static_cast<double>(settings.size());
  return std::max(0.0, std::min(survey.scene.duration, marching / rates / survey.chart.seeds));
}

/// The long runs of one setting. `of_reference`: the reference's quantities on each surface, which
/// its own row sets. `waiting`: settings that are not run yet, this one included.
LongRun long_run(Survey& survey, const Method& setting, bool is_reference, const Surfaces& surfaces,
                 std::size_t waiting, std::vector<Quantities>& of_reference) {
  const AccuracyChart& chart = survey.chart;
  LongRun row{.name = name_of(setting), .setting = setting, .reference = is_reference};
  survey.say(fmt::format("long runs, {}, {}", row.name.text, size_text(setting)));
  const double each = rate_of(survey, setting) * chart.long_time;  // s
  if (!survey.fits(each * chart.seeds, 1.05 * long_end)) {
    row.note = "not run: the time was up (--budget)";
    return row;
  }
  std::vector<Model> models;
  for (std::size_t i = 0; i < surfaces.seeds.size(); ++i)
    models.push_back(
        with_settings(surfaces.made[i], variant(with(survey.scene, setting), surfaces.seeds[i])));
  // s of one run: twice what is expected, or its share of the time that is left
  const double left = std::max(0.0, survey.left(1.05 * long_end)) / chart.seeds;
  const double longest = std::min(left, std::max(2 * each, left / static_cast<double>(waiting)));
  const std::vector<TimedRun> runs = timed_runs(models, surfaces.starts.at(setting.law),
                                                {.time = chart.long_time, .wall = longest});
  std::vector<Quantities> found;
  double marched = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (has_failed(runs[i]))
      row.note = status_text(runs[i].status);
    else if (runs[i].time < 0.99 * chart.long_time)
      row.note = "cut off: it took much longer than its first stretch promised";
    marched += runs[i].time;
    found.push_back(quantities_of(models[i], runs[i]));
  }
  row.wall = runs.front().seconds / marched;
  if (!row.note.empty()) return row;
  row.statistics = statistics_of(found, of_reference);  // still empty for the reference itself
  if (is_reference) of_reference = found;
  return row;
}

}  // namespace

void run_long(Survey& survey) {
  AccuracyChart& chart = survey.chart;
  Method reference;
  const std::vector<Method> settings = long_settings(survey, reference);
  if (settings.empty()) {
    chart.long_notes = "no long run: nothing of the right kind could be measured";
    return;
  }
  const double begun = survey.elapsed();
  const Surfaces surfaces = to_start_from(survey, settings);
  chart.seeds = static_cast<int>(surfaces.seeds.size());
  if (!has_seeds(survey.scene)) chart.long_notes = "one run of each: the surfaces have no seeds";
  if (surfaces.seeds.empty()) {
    chart.long_notes = "no long run: no surfaces were found to start from";
    return;
  }
  chart.long_time = time_of_each(survey, settings, survey.elapsed() - begun);
  if (!(chart.long_time > 0)) {
    chart.long_notes = "no long run: the time was up (--budget)";
    return;
  }
  std::vector<Quantities> of_reference;
  for (const Method& setting : settings)
    chart.long_runs.push_back(long_run(survey, setting, setting == reference, surfaces,
                                       settings.size() - chart.long_runs.size(), of_reference));
}

}  // namespace ra2d
