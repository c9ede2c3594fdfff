// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/device/backend.hpp"

namespace ra2d {
namespace {

/// The first sentence of a message, without what counts its faults.
std::string first_sentence(std::string text) {
  const auto line = text.find('\n');
  if (line != std::string::npos && text.find(" fault") < line) text = text.substr(line + 1);
  return text.substr(0, std::min(text.find('\n'), text.find(". ")));
}

/// Judges all that is compared; returns how many pairs it takes where that stays open.
double compare(Trial& trial, const Ensemble& base, const Ensemble& runs, double accuracy) {
  trial.verdict = Verdict::kept;
  double wanted = 0;
  for (std::size_t q = 0; q < trial.moved.size(); ++q) {
    trial.moved[q] = movement(base.answers(), runs.answers(), quantities_of_answer[q]);
    const Verdict verdict = judge(trial.moved[q], accuracy);
    if (verdict == Verdict::open) wanted = std::max(wanted, pairs_needed(trial.moved[q], accuracy));
    if (verdict == Verdict::moved || trial.verdict == Verdict::kept) trial.verdict = verdict;
  }
  return wanted;
}

/// Wall time [s] until there are so many pairs. `runs` may be null: then by `expected_cost`, or by
/// the base where that is 0.
double seconds_for(double pairs, const SavingsSearch& search, const Ensemble& base,
                   const Ensemble* runs, double expected_cost) {
  const int count = runs != nullptr ? runs->runs() : 0;
  const double own = count > 0 ? runs->seconds_per_run()
                               : std::max(expected_cost * search.out.duration / backend_threads(),
                                          expected_cost > 0 ? 0.0 : base.seconds_per_run());
  return std::max(0.0, pairs - count) * own +
         std::max(0.0, pairs - base.runs()) * base.seconds_per_run();
}

/// Runs pairs until the trial is judged, `end` (a share of the budget) is near or it would take too
/// long; runs that are not over by `cut_off` are given up.
void run_pairs(const SavingsSearch& search, Trial& trial, Ensemble& base, Ensemble& runs,
               double end, double cut_off) {
  const bool alone = search.out.runs == 1;
  const auto time_of = [&](double pairs) { return seconds_for(pairs, search, base, &runs, 0); };
  for (int pairs = alone ? 1 : first_pairs;;) {
    base.extend(pairs, search.left(cut_off));
    runs.extend(pairs, search.left(cut_off));
    if (std::min(base.runs(), runs.runs()) < pairs) {
      trial.why = "open: the time was up";
      return;
    }
    if (const std::string failure = runs.failure(); !failure.empty() && base.failure() != failure) {
      trial.verdict = Verdict::moved;
      trial.why = failure;
      return;
    }
    const double wanted = compare(trial, base, runs, search.options.accuracy);
    if (trial.verdict != Verdict::open || alone) return;
    const double longer = time_of(wanted);
    if (pairs >= sure_pairs && (longer > 1.5 * search.left(end) || search.left(end) <= 0)) {
      trial.why = std::isfinite(longer) && longer < 1e7
                      ? fmt::format("open: to tell takes some {:.2g} pairs, {} more", wanted,
                                    seconds_text(longer))
                      : "open: it moves about as far as is allowed";
      return;
    }
    const double more = std::clamp(std::ceil(1.1 * wanted), pairs + 1.0, 2.0 * pairs);
    if (time_of(more) > std::max(search.left(end), 0.0)) {
      trial.why = "open: the time was up";
      return;
    }
    pairs = static_cast<int>(more);
  }
}

}  // namespace

Trial changed(const std::string& key, const std::string& what, std::function<void(Scene&)> change,
              const Scene& from) {
  Trial trial;
  trial.key = key;
  trial.what = what;
  trial.scene = from;
  change(trial.scene);
  trial.change = std::move(change);
  return trial;
}

bool was_not_run(const Trial& trial) {
  return trial.verdict == Verdict::open && trial.moved[0].pairs == 0;
}

Trial try_out(SavingsSearch& search, Trial trial, const Runs& base, double end,
              double expected_cost, double begin_by) {
  search.say(fmt::format("{}: {}", trial.key, trial.what));
  const double latest = std::max(begin_by, end);
  const double expected = seconds_for(first_pairs, search, *base, nullptr, expected_cost);
  if (expected > std::max(0.0, search.left(latest)) + 0.02 * search.options.budget) {
    trial.why = fmt::format("not run: {} pairs would take {}", first_pairs, seconds_text(expected));
    return trial;
  }
  Runs runs;
  try {
    if (trial.key != "as written") require_possible(trial.scene);
    runs = std::make_shared<Ensemble>(search.for_runs(trial.scene));
    run_pairs(search, trial, *base, *runs, end, std::min(runs_end, latest + 0.05));
    if (was_not_run(trial)) return trial;  // too few pairs to say anything of
    trial.cheaper = base->cost() / runs->cost();
    trial.first = movement(base->answers(), runs->answers(), &Answer::first_duration);
    for (const Answer& a : runs->answers()) trial.energy_closure += a.energy_closure / runs->runs();
  } catch (const RequestError& fault) {
    trial.verdict = Verdict::moved;
    trial.why = "cannot be run: " + first_sentence(fault.what());
  }
  search.last = runs;
  return trial;
}

}  // namespace ra2d
