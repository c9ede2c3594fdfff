// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/compared_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "host/base/format.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

/// The expected wall time of a run of a setting to a time [s]: what its first stretch took outside
/// the march (large maps: most of it), and the march.
double expected_seconds(const Measured& row, double time) {
  constexpr double least_outside = 0.02;  // s
  const double rate = row.slowed * row.wall.front();
  return std::max(least_outside, row.took - rate * row.stretch) + rate * time;
}

/// A state that could be compared, and its expected wall time [s].
struct StateJob {
  std::size_t point, instant;
  double seconds;
};

/// Which of the states fit into the time of their part: the cheap ones first, so that most do.
class StatePlan {
 public:
  StatePlan(const Survey& survey, const std::vector<ChartPoint>& points)
      : chosen_(points.size(), std::vector<bool>(survey.chart.instants.size(), false)) {
    std::vector<StateJob> jobs;
    for (std::size_t p = 0; p < points.size(); ++p)
      for (std::size_t i = 0; i < survey.chart.instants.size(); ++i)
        jobs.push_back(
            {p, i,
             expected_seconds(survey.chart.points[points[p].row], survey.chart.instants[i].time)});
    std::stable_sort(jobs.begin(), jobs.end(),
                     [](const StateJob& a, const StateJob& b) { return a.seconds < b.seconds; });
    // what own references take is of the same time
    double left = 0.7 * survey.left(state_end);
    for (const StateJob& job : jobs) {
      left -= job.seconds;
      if (left < 0) break;
      dearest_ = job.seconds;
      chosen_[job.point][job.instant] = true;
    }
  }
  bool has(std::size_t point, std::size_t instant) const { return chosen_[point][instant]; }
  /// The most that one of them is expected to take [s].
  double dearest() const { return dearest_; }

 private:
  std::vector<std::vector<bool>> chosen_;
  double dearest_ = 0;
};

/// A march that takes much longer than expected is cut off, at the end of this part's time at the
/// latest.
RunLimits limits_for(const Survey& survey, double expected) {
  return {.wall = std::min(2 * expected, std::max(survey.left(state_end), expected))};
}

StateReference own_reference(Survey& survey, const Method& method, const StatePlan& plan) {
  StateReference own{survey.finest(method), {}, {}};
  // the finest whose rate is known, where one four times finer would take too long
  const Measured* finest_measured = nullptr;
  for (const double step : survey.options.steps)
    if (const Measured* point = survey.measured(sized(method, step))) finest_measured = point;
  if (finest_measured == nullptr) return own;
  const auto expected = [&](const Instant& instant) {
    return expected_seconds(*finest_measured, finest_measured->setting.time.step /
                                                  own.setting.time.step * instant.time);
  };
  for (const Instant& instant : survey.chart.instants)
    if (expected(instant) > 2 * plan.dearest()) own.setting = finest_measured->setting;
  own.text = fmt::format("its own finest, {}", size_text(own.setting));
  for (const Instant& instant : survey.chart.instants) {
    std::optional<State> state;
    if (survey.fits(expected(instant), state_end)) {
      const TimedRun run = survey.march(ending_at(survey.scene, own.setting, instant.time),
                                        limits_for(survey, expected(instant)));
      if (run.status == Status::done) state = run.state;
    }
    own.states.push_back(state);
  }
  return own;
}

/// The state of a point at one of the instants.
StateError compare(Survey& survey, const ChartPoint& point, const StateReference& reference,
                   std::size_t instant, bool chosen) {
  const Measured& row = survey.chart.points[point.row];
  const double time = survey.chart.instants[instant].time;
  const double expected = expected_seconds(row, time);
  StateError state;
  if (row.setting.time.step >= 2 * time)
    state.note = "the step is longer than the time";
  else if (row.setting == reference.setting)
    state.note = "it is the reference";
  else if (reference.states.size() <= instant || !reference.states[instant])
    state.note = "no reference";
  else if (std::isnan(survey.chart.reference_error[instant]))
    state.note = "nothing has moved by then";
  else if (!chosen || !survey.fits(expected, state_end))
    state.note = fmt::format("not run: would take {} (--budget)", seconds_text(expected));
  if (!state.note.empty()) return state;
  const Scene scene = ending_at(survey.scene, row.setting, time);
  const TimedRun run = survey.march(scene, limits_for(survey, expected));
  if (run.status == Status::done) {
    state.error = state_error(point.model, run.state, *reference.states[instant]);
    state.step = is_adaptive(scene) ? 0.0 : scene.time.step;
  } else {
    state.note = has_failed(run) ? status_text(run.status) : "took too long";
  }
  return state;
}

}  // namespace

void compare_states(Survey& survey, const std::vector<ChartPoint>& points,
                    const StateReference& reference) {
  const StatePlan plan(survey, points);
  for (const Method& method : survey.methods) {
    survey.say(fmt::format("states, {}", text(method)));
    // multipliers are another model of an impact, by every scheme its own
    const bool shared = method.law == reference.setting.law && method.law == ContactLaw::penalty;
    const StateReference& against = shared ? reference : own_reference(survey, method, plan);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const ChartPoint& point = points[p];
      Measured& row = survey.chart.points[point.row];
      if (row.name.text != text(method)) continue;
      row.against = against.text;
      for (std::size_t i = 0; i < survey.chart.instants.size(); ++i)
        row.states.push_back(compare(survey, point, against, i, plan.has(p, i)));
    }
  }
}

}  // namespace ra2d
