// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/timed_stretches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/scene/schemes.hpp"

namespace ra2d {

namespace {

// s that a first stretch may always take: its batch is made, and its first launch is of some
// thousand steps.
constexpr double least_share = 2e-3;

/// Seconds of the march for a simulated second, of its thread: other programs on the machine do not
/// count.
double rate_of(const TimedRun& run) {
  return (run.processor > 0 ? std::min(run.processor, run.seconds) : run.seconds) / run.time;
}

}  // namespace

// The coarse ones first: what they leave of their share goes to the fine ones.
std::vector<ChartPoint> first_stretches(Survey& survey, std::vector<ChartPoint> points) {
  std::stable_sort(points.begin(), points.end(), [&](const ChartPoint& a, const ChartPoint& b) {
    const auto size = [&](const ChartPoint& p) {
      const TimeSettings& time = survey.chart.points[p.row].setting.time;
      return time.tolerance.value_or(time.step);
    };
    return size(a) > size(b);
  });
  std::vector<ChartPoint> going;
  for (std::size_t i = 0; i < points.size(); ++i) {
    survey.say(fmt::format("stretch {} of {}", i + 1, points.size()));
    ChartPoint& point = points[i];
    Measured& row = survey.chart.points[point.row];
    const double share = survey.left(stretch_end) / static_cast<double>(points.size() - i);
    if (!(share > 0)) {
      row.left_out = "not run: the time was up (--budget)";
      continue;
    }
    const double begun = survey.elapsed();
    const TimedRun run = timed_run(point.model, survey.start_of(row.setting.law, point.model),
                                   {.wall = std::max(least_share, 0.7 * share)});
    if (has_failed(run)) {
      row.left_out = fmt::format("ended at t = {:.3g} s: {}", run.time, status_text(run.status));
      continue;
    }
    row.stretch = run.time;
    row.took = survey.elapsed() - begun;
    row.wall.push_back(rate_of(run));
    row.slowed = std::max(1.0, run.seconds / run.time / row.wall.back());
    // before the shocks that the states are compared at, little has gone through
    if (run.time > 0.99 * survey.chart.instants.back().time && run.energy.turnover > 0)
      row.energy_closure = run.energy.closure();
    going.push_back(std::move(point));
  }
  return going;
}

void repeat_stretches(Survey& survey, const std::vector<ChartPoint>& points, double end) {
  for (const ChartPoint& point : points) {
    Measured& row = survey.chart.points[point.row];
    if (!survey.fits(row.took, end)) continue;  // the row says how many there are
    const TimedRun run = timed_run(point.model, survey.start_of(row.setting.law, point.model),
                                   {.time = row.stretch, .wall = survey.left(end)});
    if (run.time > 0.99 * row.stretch) row.wall.push_back(rate_of(run));
  }
}

}  // namespace ra2d
