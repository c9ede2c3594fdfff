// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/compared_states.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/format.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

/// s of march that one comparison of states may take.
double state_limit(const Survey& survey) { return 0.05 * state_share * survey.budget; }

StateReference own_reference(Survey& survey, const Method& method) {
  StateReference own{survey.finest(method), {}, {}};
  // the finest whose rate is known, where one four times finer would take too long
  const Measured* known = nullptr;
  for (const double step : survey.options.steps)
    if (const Measured* point = survey.measured(sized(method, step))) known = point;
  if (known == nullptr) return own;
  for (const Instant& instant : survey.chart.instants) {
    const double expected =
        known->wall.front() * known->setting.time.step / own.setting.time.step * instant.time;
    if (expected > 2 * state_limit(survey)) own.setting = known->setting;
  }
  own.text = fmt::format("its own finest, {}", size_text(own.setting));
  for (const Instant& instant : survey.chart.instants) {
    const TimedRun run = survey.march(ending_at(survey.scene, own.setting, instant.time),
                                      {.wall = 4 * state_limit(survey)});
    own.states.push_back(run.status == Status::done ? std::optional(run.state) : std::nullopt);
  }
  return own;
}

/// The state of a point at one of the instants.
StateError compare(Survey& survey, const ChartPoint& point, const StateReference& reference,
                   std::size_t instant) {
  const Measured& row = survey.chart.points[point.row];
  const double time = survey.chart.instants[instant].time, limit = state_limit(survey);
  StateError state;
  if (row.setting.time.step >= 2 * time)
    state.note = "the step is longer than the time";
  else if (row.setting == reference.setting)
    state.note = "it is the reference";
  else if (reference.states.size() <= instant || !reference.states[instant])
    state.note = "no reference";
  else if (std::isnan(survey.chart.reference_error[instant]))
    state.note = "nothing has moved by then";
  else if (const double expected = row.wall.front() * time; expected > limit)
    state.note = fmt::format("would take {}", seconds_text(expected));
  if (!state.note.empty()) return state;
  const Scene scene = ending_at(survey.scene, row.setting, time);
  const TimedRun run = survey.march(scene, {.wall = 4 * limit});
  if (run.status == Status::done) {
    state.error = state_error(point.model, run.state, *reference.states[instant]);
    state.step = is_adaptive(scene) ? 0.0 : scene.time.step;
  } else {
    state.note = failed(run) ? status_text(run.status) : "took too long";
  }
  return state;
}

}  // namespace

void compare_states(Survey& survey, const std::vector<ChartPoint>& points,
                    const StateReference& reference) {
  for (const Method& method : survey.methods) {
    survey.say(fmt::format("states, {}", text(method)));
    // multipliers are another model of an impact, by every scheme its own
    const bool shared = method.law == reference.setting.law && method.law == ContactLaw::penalty;
    const StateReference& against = shared ? reference : own_reference(survey, method);
    for (const ChartPoint& point : points) {
      Measured& row = survey.chart.points[point.row];
      if (row.name.text != text(method)) continue;
      row.against = against.text;
      for (std::size_t i = 0; i < survey.chart.instants.size(); ++i)
        row.states.push_back(compare(survey, point, against, i));
    }
  }
}

}  // namespace ra2d
