// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/cheaper_numerics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/plan/plan.hpp"
#include "host/savings/trials.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

// The most that one scheme and step may take of the budget.
constexpr double numerics_share = 0.06;

/// A scheme with its step or tolerance, and what it costs.
struct Numerics {
  TimeSettings time;
  double cost = 0;  // as of Ensemble, expected
};

/// 1, 2 and 5 times powers of ten, downwards from at most `largest`.
std::vector<double> ladder(double largest, double smallest) {
  std::vector<double> steps;
  for (int power = static_cast<int>(std::floor(std::log10(largest))); power > -15; --power)
    for (const int digit : {5, 2, 1}) {
      // read as it will be written, 2e-07 and not twice what 1e-07 is rounded to
      const double step = std::stod(fmt::format("{}e{}", digit, power));
      if (step > largest * (1 + 1e-9)) continue;
      if (step < smallest * (1 - 1e-9)) return steps;
      steps.push_back(step);
    }
  return steps;
}

/// The tolerances that are tried: the scene's own is among them.
std::vector<double> tolerances_of(const Scene& scene) {
  std::vector<double> list{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8};
  const double own = scene.time.tolerance.value_or(usual_tolerance);
  if (is_adaptive(scene) && std::find(list.begin(), list.end(), own) == list.end())
    list.push_back(own);
  std::sort(list.begin(), list.end(), std::greater<>());
  return list;
}

/// All schemes and steps that cost less than the reference, by what they cost; those whose cost is
/// known by `until`.
std::vector<Numerics> cheaper_than_reference(const SavingsSearch& search, double until) {
  std::vector<Numerics> list;
  if (search.left(until) <= 0) return list;
  const bool spring = search.whole.contact.law == ContactLaw::penalty;
  const double probe = 0.002 * search.options.budget;
  Scene reference = search.out.reference;
  reference.time.nodes = Nodes::candidates;
  double most = std::max(measure_cost(search.for_runs(reference), probe), search.cost_whole);
  if (spring)
    for (const double tolerance : tolerances_of(search.whole)) {
      if (search.left(until) <= 0) break;
      Numerics n{search.adaptive(tolerance)};
      n.cost = measure_cost(search.for_runs(search.marched(n.time)), probe);
      most = std::max(most, n.cost);
      list.push_back(n);
    }
  const Model model = make_model(search.out.reference);
  const JoinedModes place = most_compliant(model);
  for (const TimeSettings& choice : choices_under(search.whole.contact.law)) {
    if (search.left(until) <= 0) break;
    // what an impact gives back is the scheme's under multipliers: two let it rest alike
    if (!spring && choice.scheme != search.whole.time.scheme &&
        !(is_semi_implicit(choice.scheme) && is_semi_implicit(search.whole.time.scheme)))
      continue;
    // a shock in fewer than two steps is none
    double largest = std::min({step_limits(model, choice, place).holds(),
                               1 / search.whole.output.rate, search.out.duration});
    if (spring) largest = std::min(largest, M_PI / contact_frequency(model, place) / 2);
    if (!(largest > 0)) continue;
    double per_step = 0;
    for (const double step : ladder(largest, spring ? 1e-11 : search.whole.time.step)) {
      Numerics n{search.plain};
      n.time.scheme = choice.scheme;
      if (spring && choice.scheme == SchemeKind::backward_euler)
        n.time.contact_force = choice.contact_force;
      n.time.step = step;
      if (per_step == 0) {
        try {
          per_step = measure_cost(search.for_runs(search.marched(n.time)), probe) * step;
        } catch (const RequestError&) {
          break;
        }
      }
      n.cost = per_step / step;
      if (spring && n.cost > most) break;
      list.push_back(n);
    }
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Numerics& a, const Numerics& b) { return a.cost < b.cost; });
  return list;
}

/// How much shorter a step must be before it is worth another run: across impacts no scheme gains
/// more than the square of that.
double shortening(const Trial& trial, double accuracy) {
  double most = accuracy;
  for (const Movement& m : trial.moved) most = std::max(most, std::abs(m.relative) - m.margin());
  if (trial.verdict == Verdict::open) most = std::max(most, trial.energy_closure);
  // of what is far off altogether no more is known than that
  return std::min(0.6, std::sqrt(accuracy / std::min(most, std::max(0.3, accuracy))));
}

Trial attempt(SavingsSearch& search, const Numerics& n, double end) {
  const auto change = [time = n.time](Scene& s) { s.time = time; };
  Trial trial =
      try_out(search, changed("time", text_of(search.marched(n.time)), change, search.whole),
              search.reference, end, n.cost);
  trial.by_balance = trial.verdict == Verdict::open && trial.first.pairs > 0 &&
                     trial.energy_closure <= search.options.accuracy &&
                     judge(trial.first, search.options.accuracy) == Verdict::kept;
  return trial;
}

bool does(const Trial& trial) { return trial.verdict == Verdict::kept || trial.by_balance; }

/// Whether a setting is the one that the scene has.
bool is_own(const SavingsSearch& search, const TimeSettings& time) {
  TimeSettings own = search.plain;
  own.nodes = time.nodes;
  return own == time;
}

/// A saving is cheaper than the scene as written by more than timings scatter.
bool saves(const SavingsSearch& search, const Numerics& n) {
  const double measured = search.last ? search.last->cost() : n.cost;
  return (std::isnan(measured) ? n.cost : measured) < 0.98 * search.cost_whole;
}

}  // namespace

void find_base(SavingsSearch& search, double end) {
  search.say("what the scene as written costs");
  const double probe = 0.004 * search.options.budget;
  search.cost_whole = measure_cost(search.for_runs(search.whole), probe);
  search.base = search.reference;
  const bool spring = search.whole.contact.law == ContactLaw::penalty;
  Numerics safe{is_adaptive(search.whole) ? search.plain
                : spring                  ? search.adaptive(usual_tolerance)
                                          : search.plain};
  safe.cost = measure_cost(search.for_runs(search.marched(safe.time)), probe);
  Trial trial = attempt(search, safe, end);
  if (does(trial)) {
    search.base = search.last;
    trial.taken = is_own(search, safe.time) || saves(search, safe);
    if (trial.taken) trial.change(search.out.chosen);
  }
  search.out.trials.push_back(std::move(trial));
}

void find_numerics(SavingsSearch& search, double until) {
  search.say("what the schemes cost");
  const std::vector<Numerics> list = cheaper_than_reference(search, until);
  double cheapest = search.cost_whole;  // of what does
  for (const Trial& trial : search.out.trials)
    if (trial.key == "time" && trial.taken) cheapest = std::fmin(cheapest, search.base->cost());

  std::map<std::string, double> longest;  // worth trying, by scheme
  std::size_t left_out = 0;
  std::optional<std::size_t> found;
  for (const Numerics& n : list) {
    if (n.cost >= cheapest || found) break;  // by cost the first that does is the cheapest
    const std::string what = text_of(search.marched(n.time));
    if (std::any_of(search.out.trials.begin(), search.out.trials.end(),
                    [&](const Trial& t) { return t.key == "time" && t.what == what; }))
      continue;
    const std::string name = fmt::format("{} {}", static_cast<int>(n.time.scheme),
                                         static_cast<int>(n.time.contact_force));
    if (longest.contains(name) && n.time.step > longest[name] * (1 + 1e-9)) continue;
    Trial trial;
    if (search.spent() < until)
      trial = attempt(search, n, std::min(until, search.spent() + numerics_share));
    if (trial.moved[0].pairs == 0 && trial.verdict == Verdict::open) {
      ++left_out;
      continue;
    }
    if (!is_adaptive(n.time))
      longest[name] = n.time.step * shortening(trial, search.options.accuracy);
    if (does(trial) && saves(search, n)) found = search.out.trials.size();
    search.out.trials.push_back(std::move(trial));
  }
  if (left_out > 0)
    search.out.notes.push_back(fmt::format(
        "{} more schemes and steps that may be cheaper were not tried for want of time (--budget)",
        left_out));
  if (found) {
    for (Trial& trial : search.out.trials)
      if (trial.key == "time") trial.taken = false;
    Trial& best = search.out.trials[*found];
    best.taken = true;
    best.change(search.out.chosen);
  } else if (std::none_of(search.out.trials.begin(), search.out.trials.end(),
                          [](const Trial& trial) { return trial.key == "time" && trial.taken; })) {
    search.out.notes.push_back(
        "no cheaper scheme or step could be shown to do: the scene keeps its own (see --budget)");
  }
}

}  // namespace ra2d
