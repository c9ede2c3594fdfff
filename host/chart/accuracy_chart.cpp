// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/accuracy_chart.hpp"

#include <fmt/format.h>

#include "host/chart/chart_points.hpp"
#include "host/chart/chart_reference.hpp"
#include "host/chart/compared_states.hpp"
#include "host/chart/long_runs.hpp"
#include "host/chart/peer_answers.hpp"
#include "host/chart/timed_stretches.hpp"
#include "host/result/statistics.hpp"

namespace ra2d {

double Measured::wall_median() const { return median(wall); }

AccuracyChart measure_accuracy(const Scene& scene, const AccuracyOptions& options) {
  Survey survey(scene, options);
  std::vector<ChartPoint> points = list_points(survey);
  const StateReference reference = find_reference(survey);
  points = first_stretches(survey, std::move(points));
  compare_states(survey, points, reference);
  PeerAnswers peers(survey, points, reference);
  for (int i = 1; i < options.repetitions; ++i) {
    survey.say(fmt::format("repetition {} of {}", i + 1, options.repetitions));
    // in turns; each round has its part of the time
    const double end = peer_end + (repeat_end - peer_end) * i / (options.repetitions - 1);
    repeat_stretches(survey, points, end);
    peers.repeat(end);
  }
  run_long(survey);
  survey.chart.seconds = survey.elapsed();
  return survey.chart;
}

}  // namespace ra2d
