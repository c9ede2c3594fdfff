// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/savings_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/device/backend.hpp"
#include "host/plan/plan.hpp"
#include "host/savings/trials.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

constexpr double reference_tolerance = 1e-10;
constexpr double reference_share = 0.25;  // of the budget, for its first runs

/// The scene as written with the finest numerics. Throws RequestError where it cannot be run.
Scene reference_of(const SavingsSearch& search) {
  Scene reference = search.whole;
  if (search.whole.contact.law == ContactLaw::penalty) {
    reference.time = search.adaptive(reference_tolerance);
  } else {
    reference.time.step = search.whole.time.step / 10;
    reference.time.force = false;
  }
  try {
    require_possible(reference);
  } catch (const RequestError& fault) {
    // only of fixed steps, for a scene that was read
    const StepLimits limits = step_limits(make_model(reference), choice_of(reference));
    throw refusal(
        search.whole, "time.scheme",
        fmt::format("the reference would be the scene's own scheme at a tenth of its step, and {}. "
                    "{}",
                    fault.what(), step_cure(reference, limits.holds())));
  }
  if (const std::string overlap = overlap_at_start(make_model(reference)); !overlap.empty())
    throw refusal(search.whole, "scene.gap", overlap);
  return reference;
}

/// How long the runs are: the scene's own duration, or as much of it as the budget allows.
void set_duration(SavingsSearch& search) {
  const Scene& written = search.out.written;
  const Scene& reference = search.out.reference;
  double& duration = search.out.duration = written.duration;
  const double wall = reference_share * search.options.budget;
  const double cost = measure_wall_cost(search.for_runs(reference), 0.1 * wall);
  const double longest = wall * backend_threads() / (2 * sure_pairs * cost);
  if (!(longest < duration)) return;
  // whole milliseconds where there are any, for people
  duration = longest > 1e-2 ? std::floor(longest * 1e3) * 1e-3 : longest;
  if (!is_adaptive(reference))  // a whole number of steps
    duration = std::max(1.0, std::floor(duration / reference.time.step)) * reference.time.step;
  const double from = written.output.from;
  if (from > 0 && duration - from < 0.1 * (written.duration - from))  // too little is counted
    throw refusal(
        written, "output.from",
        fmt::format("{} s are not counted, and in the time given a run of the reference comes to "
                    "{} only: expected a larger --budget, or an earlier time",
                    from, seconds_text(longest)));
  search.out.notes.push_back(fmt::format(
      "the runs were cut short at {} of the scene's {}: a run of the reference takes {} (--budget "
      "allows more)",
      seconds_text(duration), seconds_text(written.duration),
      seconds_text(cost * written.duration)));
}

}  // namespace

void set_reference(SavingsSearch& search) {
  const Scene& reference = search.out.reference = reference_of(search);
  search.say("the reference");
  set_duration(search);
  search.reference = std::make_shared<Ensemble>(search.for_runs(reference));
  search.out.runs = varied(search.whole).empty() ? 1 : first_pairs;
  search.reference->extend(search.out.runs, search.left(runs_end));
  if (search.reference->runs() == 0)
    throw RequestError(
        fmt::format("--budget {}: not one run of the reference, {}, came to its end "
                    "in this time: expected a larger one",
                    search.options.budget, text_of(reference)));
  const std::vector<Answer>& answers = search.reference->answers();
  if (std::all_of(answers.begin(), answers.end(),
                  [](const Answer& a) { return !a.failure.empty(); }))
    throw SimulationError(fmt::format("the reference, {}, did not reach its end: {}",
                                      text_of(reference), search.reference->failure()));
}

void take_answer(SavingsSearch& search) {
  const std::vector<Answer>& answers = search.reference->answers();
  search.out.runs = search.reference->runs();
  for (std::size_t q = 0; q < quantities_of_answer.size(); ++q) {
    const auto quantity = quantities_of_answer[q];
    double sum = 0, square = 0;
    int count = 0;
    for (const Answer& a : answers) {
      if (!a.failure.empty() || std::isnan(a.*quantity)) continue;
      sum += a.*quantity;
      square += std::pow(a.*quantity, 2);
      ++count;
    }
    const double mean = count > 0 ? sum / count : quiet_nan;
    search.out.mean.*quantity = mean;
    search.out.spread[q] =
        count > 1 && mean > 0
            ? std::sqrt(std::max(0.0, square / count - mean * mean) * count / (count - 1)) / mean
            : 0.0;
  }
  for (const Answer& a : answers)
    search.out.energy_closure += a.energy_closure / static_cast<double>(answers.size());
}

}  // namespace ra2d
