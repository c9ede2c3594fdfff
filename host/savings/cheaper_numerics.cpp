// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/cheaper_numerics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "host/errors.hpp"
#include "host/format.hpp"
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

/// All schemes and steps that cost less than the reference, by what they cost.
std::vector<Numerics> cheaper_than_reference(const SavingsSearch& search) {
  std::vector<Numerics> list;
  const bool spring = search.written.contact.law == ContactLaw::penalty;
  const double probe = 0.002 * search.options.budget;
  Scene reference = search.out.reference;
  reference.time.nodes = Nodes::candidates;
  double most = measure_cost(search.for_runs(reference), probe);
  if (spring)
    for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
      Numerics n{search.adaptive(tolerance)};
      n.cost = measure_cost(search.for_runs(search.marched(n.time)), probe);
      most = std::max(most, n.cost);
      list.push_back(n);
    }
  const Model model = make_model(search.out.reference);
  const JoinedModes place = most_yielding(model);
  for (const TimeSettings& choice : choices_under(search.written.contact.law)) {
    // what an impact gives back is the scheme's under multipliers: two let it rest alike
    if (!spring && choice.scheme != search.written.time.scheme &&
        !(is_semi_implicit(choice.scheme) && is_semi_implicit(search.written.time.scheme)))
      continue;
    // a shock in fewer than two steps is none
    double largest = std::min({step_limits(model, choice, place).holds(),
                               1 / search.written.output.rate, search.out.duration});
    if (spring) largest = std::min(largest, M_PI / contact_frequency(model, place) / 2);
    if (!(largest > 0)) continue;
    double per_step = 0;
    for (const double step : ladder(largest, spring ? 1e-11 : search.written.time.step)) {
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
double shortening(const Trial& trial, double asked) {
  double most = asked;
  for (const Movement& m : trial.moved) most = std::max(most, std::abs(m.relative) - m.margin());
  if (trial.verdict == Verdict::open) most = std::max(most, trial.closure);
  // of what is far off altogether no more is known than that
  return std::min(0.6, std::sqrt(asked / std::min(most, std::max(0.3, asked))));
}

}  // namespace

void find_numerics(SavingsSearch& search, double until) {
  search.say("what the schemes cost");
  std::vector<Numerics> list = cheaper_than_reference(search);
  std::optional<Trial> found;
  const auto attempt = [&](const Numerics& n, double end) {
    const auto change = [time = n.time](Scene& s) { s.time = time; };
    Trial trial =
        try_out(search, changed("time", text_of(search.marched(n.time)), change, search.written),
                search.reference, end, n.cost);
    trial.by_balance = trial.verdict == Verdict::open && trial.first.pairs > 0 &&
                       trial.closure <= search.options.accuracy &&
                       judge(trial.first, search.options.accuracy) == Verdict::kept;
    const bool enough = trial.verdict == Verdict::kept || trial.by_balance;
    if (enough && !(found && found->cheaper >= trial.cheaper)) {
      found = trial;
      search.base = search.last;
    }
    return trial;
  };

  // first what will do if anything does, so that there is time for it
  Numerics safe{search.written.contact.law == ContactLaw::penalty ? search.adaptive(usual_tolerance)
                                                                  : search.plain};
  safe.cost =
      measure_cost(search.for_runs(search.marched(safe.time)), 0.004 * search.options.budget);
  search.out.trials.push_back(attempt(safe, search.spent() + 2 * numerics_share));

  std::map<std::string, double> longest;  // worth trying, by scheme
  std::size_t left_out = 0;
  for (const Numerics& n : list) {
    if (n.cost >= safe.cost && found) break;
    if (n.time == safe.time) continue;
    if (found && found->what != search.out.trials.front().what)
      break;  // by cost the first that does is the cheapest
    const std::string name = fmt::format("{} {}", static_cast<int>(n.time.scheme),
                                         static_cast<int>(n.time.contact_force));
    if (longest.contains(name) && n.time.step > longest[name] * (1 + 1e-9)) continue;
    Trial trial;
    if (search.spent() < until)
      trial = attempt(n, std::min(until, search.spent() + numerics_share));
    if (trial.moved[0].pairs == 0 && trial.verdict == Verdict::open) {
      ++left_out;
      continue;
    }
    if (!is_adaptive(n.time))
      longest[name] = n.time.step * shortening(trial, search.options.accuracy);
    search.out.trials.push_back(std::move(trial));
  }
  if (left_out > 0)
    search.out.notes.push_back(fmt::format(
        "{} more schemes and steps that may be cheaper were not tried for want of time (--budget)",
        left_out));
  if (!found) {
    search.base = search.reference;
    search.out.notes.push_back(
        "no cheaper scheme or step could be shown to do: the scene keeps its own (see --budget)");
    return;
  }
  found->change(search.out.chosen);
  for (Trial& trial : search.out.trials) trial.taken = trial.what == found->what;
}

}  // namespace ra2d
