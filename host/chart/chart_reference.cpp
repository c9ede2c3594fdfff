// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/chart_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

constexpr std::size_t compared_shocks[] = {5, 20};

/// The time with the fewest digits in the last tenth of what lies between two times.
double round_time_before(double time, double after) {
  const double least = time - 0.1 * (time - after);
  const int first = -static_cast<int>(std::floor(std::log10(time)));
  for (int digits = first; digits < first + 15; ++digits) {
    const double scale = std::pow(10.0, digits), rounded = std::floor(time * scale) / scale;
    if (rounded > least && rounded < time) return rounded;
  }
  return least;
}

/// Sets the instants: before the 5th and before the 20th shock. Where there are fewer shocks, the
/// end of the search.
void find_instants(Survey& survey, const TimedRun& search) {
  const bool whole = search.status == Status::done;
  const auto end = [&](std::size_t shocks) {
    const double time = whole ? survey.scene.duration : round_time_before(search.time, 0.0);
    return Instant{"state-end",
                   fmt::format("the state at {} ({} shock{}{})", seconds_text(time), shocks,
                               shocks == 1 ? "" : "s", whole ? ", the end" : ""),
                   time};
  };
  for (const std::size_t number : compared_shocks) {
    // a shock that has begun at t = 0 has no time before it
    std::size_t i = number - 1;
    while (i < search.shocks.size() && search.shocks[i].start == 0) ++i;
    if (i >= search.shocks.size()) {
      survey.chart.instants.push_back(end(search.shocks.size()));
      break;
    }
    double after = 0;
    for (const Shock& shock : search.shocks)
      if (shock.start < search.shocks[i].start) after = std::max(after, shock.start);
    const double time = round_time_before(search.shocks[i].start, after);
    survey.chart.instants.push_back(
        {fmt::format("state-{}", number),
         fmt::format("the state before the {}th shock (t = {} s)", number, time), time});
  }
}

}  // namespace

StateReference find_reference(Survey& survey) {
  survey.say("the reference");
  StateReference reference;
  // the one that chooses its own steps, or the one of the highest order
  const Method best = *std::max_element(
      survey.methods.begin(), survey.methods.end(), [](const Method& a, const Method& b) {
        const auto rank = [](const Method& method) {
          const SchemeKind scheme = method.time.scheme;
          const int order = is_adaptive(method.time) ? 100 : scheme_table(scheme).order;
          return method.law == ContactLaw::penalty ? order
                 : scheme == SchemeKind::midpoint  ? 0
                                                   : -order;
        };
        return rank(a) < rank(b);
      });
  reference.setting = survey.finest(best);
  survey.chart.reference = reference.text =
      fmt::format("{}, {}", text(best), size_text(reference.setting));
  Scene searched = with(survey.scene, reference.setting);
  searched.output.rate = std::min(searched.output.rate, 1000.0);
  // at the two instants it is run again, and once more to a coarser tolerance
  const double begun = survey.elapsed();
  const TimedRun search = survey.march(
      searched,
      {.wall = std::max(0.0, survey.left(reference_end)) / 4, .shocks = compared_shocks[1]});
  const double took = survey.elapsed() - begun;
  if (has_failed(search))
    throw SimulationError(fmt::format("the reference, {}, ended at t = {:g} s: {}",
                                      survey.chart.reference, search.time,
                                      status_text(search.status)));
  find_instants(survey, search);

  Method coarser = reference.setting;
  coarser.time.step *= 2;
  if (coarser.time.tolerance) *coarser.time.tolerance *= 10;
  survey.chart.reference_check = size_text(coarser);
  for (const Instant& instant : survey.chart.instants) {
    const double expected = took * instant.time / std::max(search.time, instant.time);
    if (!survey.fits(2 * expected, stretch_end)) {  // not even with the time of the next part
      reference.states.push_back(std::nullopt);
      survey.chart.reference_error.push_back(quiet_nan);
      continue;
    }
    const Scene scene = ending_at(survey.scene, reference.setting, instant.time);
    const auto march = [&](const Scene& marched) {
      return survey.march(marched, {.wall = std::max(0.0, survey.left(stretch_end))});
    };
    const TimedRun run = march(scene);
    const TimedRun check = march(ending_at(survey.scene, coarser, instant.time));
    const bool is_whole = run.status == Status::done && check.status == Status::done;
    reference.states.push_back(is_whole ? std::optional(run.state) : std::nullopt);
    survey.chart.reference_error.push_back(
        is_whole ? state_error(survey.model_of(scene), check.state, run.state) : quiet_nan);
  }
  return reference;
}

}  // namespace ra2d
