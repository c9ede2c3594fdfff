// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/combination.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "host/savings/trials.hpp"

namespace ra2d {
namespace {

/// Drops the least valuable saving, of equals the last. The next smaller one of that kind replaces
/// it if it is accurate enough alone.
void give_up_least(std::vector<Trial>& trials, std::vector<Trial*>& taken) {
  const auto gain = [](const Trial* t) { return std::isnan(t->cheaper) ? 1.0 : t->cheaper; };
  auto least = taken.begin();
  for (auto it = taken.begin(); it != taken.end(); ++it)
    if (gain(*it) <= gain(*least)) least = it;
  Trial* given_up = *least;
  given_up->taken = false;
  given_up->why = "dropped: combined with the others the error is too large, or undecided";
  Trial* before = nullptr;
  for (Trial& other : trials) {
    if (&other == given_up) break;
    if (other.key == given_up->key && other.verdict == Verdict::kept) before = &other;
  }
  if (before) {
    before->taken = true;
    *least = before;
  } else {
    taken.erase(least);
  }
}

/// Cost of the base with the largest of the savings alone: all of them together cost no more. 0
/// where it is not known.
double expected_cost(const SavingsSearch& search, const std::vector<Trial*>& taken) {
  double most = 1;
  for (const Trial* trial : taken) most = std::fmax(most, trial->cheaper);
  const double cost = search.base->cost() / most;
  return std::isfinite(cost) ? cost : 0.0;
}

}  // namespace

void combine_savings(SavingsSearch& search, double end) {
  std::vector<Trial*> taken;
  for (Trial& trial : search.out.trials)
    if (trial.taken && trial.key != "time") taken.push_back(&trial);
  const Scene numerics = search.out.chosen;
  while (!taken.empty()) {
    Scene all = numerics;
    std::vector<std::string> names;
    for (const Trial* trial : taken) {
      trial->change(all);
      names.push_back(trial->key);
    }
    const auto change = [all](Scene& s) { s = all; };
    Trial trial = try_out(
        search,
        changed("together", fmt::format("time, {}", fmt::join(names, ", ")), change, search.whole),
        search.reference, search.next_end(end, 2), expected_cost(search, taken));
    // a scheme that was chosen by its energy is open to chance here, too
    trial.taken = trial.verdict == Verdict::kept;
    const bool enough = trial.taken;
    search.out.combinations.push_back(std::move(trial));
    if (enough) {
      search.out.chosen = all;
      return;
    }
    give_up_least(search.out.trials, taken);
  }
}

}  // namespace ra2d
