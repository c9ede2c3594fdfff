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
double compare(Trial& trial, const Ensemble& base, const Ensemble& runs, double asked) {
  trial.verdict = Verdict::kept;
  double wanted = 0;
  for (std::size_t q = 0; q < trial.moved.size(); ++q) {
    trial.moved[q] = movement(base.answers(), runs.answers(), quantities_of_answer[q]);
    const Verdict verdict = judge(trial.moved[q], asked);
    if (verdict == Verdict::open) wanted = std::max(wanted, pairs_needed(trial.moved[q], asked));
    if (verdict == Verdict::moved || trial.verdict == Verdict::kept) trial.verdict = verdict;
  }
  return wanted;
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
  Runs runs;
  const auto time_of = [&](double pairs) {
    const double own = runs && runs->runs() > 0
                           ? runs->seconds_per_run()
                           : std::max(expected_cost * search.out.duration / backend_threads(),
                                      expected_cost > 0 ? 0.0 : base->seconds_per_run());
    return std::max(0.0, pairs - (runs ? runs->runs() : 0)) * own +
           std::max(0.0, pairs - base->runs()) * base->seconds_per_run();
  };
  const double room = std::max(0.0, search.left(std::max(begin_by, end)));
  if (time_of(first_pairs) > room + 0.02 * search.options.budget) {
    trial.why = fmt::format("not run: {} pairs would take {}", first_pairs,
                            seconds_text(time_of(first_pairs)));
    return trial;
  }
  try {
    if (trial.key != "as written") require_possible(trial.scene);
    runs = std::make_shared<Ensemble>(search.for_runs(trial.scene));
    const bool alone = search.out.runs == 1;
    for (int pairs = alone ? 1 : first_pairs;;) {
      base->extend(pairs);
      runs->extend(pairs);
      if (const std::string failure = runs->failure();
          !failure.empty() && base->failure() != failure) {
        trial.verdict = Verdict::moved;
        trial.why = failure;
        break;
      }
      const double wanted = compare(trial, *base, *runs, search.options.accuracy);
      if (trial.verdict != Verdict::open || alone) break;
      const double longer = time_of(wanted);
      if (pairs >= sure_pairs && (longer > 1.5 * search.left(end) || search.left(end) <= 0)) {
        trial.why = std::isfinite(longer) && longer < 1e7
                        ? fmt::format("open: to tell takes some {:.2g} pairs, {} more", wanted,
                                      seconds_text(longer))
                        : "open: it moves about as far as is allowed";
        break;
      }
      const double more = std::clamp(std::ceil(1.1 * wanted), pairs + 1.0, 2.0 * pairs);
      if (time_of(more) > std::max(search.left(end), 0.0)) {
        trial.why = "open: the time was up";
        break;
      }
      pairs = static_cast<int>(more);
    }
    trial.cheaper = base->cost() / runs->cost();
    trial.first = movement(base->answers(), runs->answers(), &Answer::first_duration);
    for (const Answer& a : runs->answers()) trial.closure += a.closure / runs->runs();
  } catch (const RequestError& fault) {
    trial.verdict = Verdict::moved;
    trial.why = "cannot be run: " + first_sentence(fault.what());
  }
  search.last = runs;
  return trial;
}

}  // namespace ra2d
