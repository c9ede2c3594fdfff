// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/together.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "host/savings/trials.hpp"

namespace ra2d {
namespace {

/// The least valuable goes back to the one before it that would do alone, or altogether; of equals
/// the last, the spacing.
void give_up_least(std::vector<Trial>& trials, std::vector<Trial*>& taken) {
  const auto gain = [](const Trial* t) { return std::isnan(t->cheaper) ? 1.0 : t->cheaper; };
  auto least = taken.begin();
  for (auto it = taken.begin(); it != taken.end(); ++it)
    if (gain(*it) <= gain(*least)) least = it;
  Trial* given_up = *least;
  given_up->taken = false;
  given_up->why = "given up: too much together with the others, or that could not be told";
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

}  // namespace

void take_together(SavingsSearch& search, double end) {
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
    Trial trial = try_out(search,
                          changed("together", fmt::format("time, {}", fmt::join(names, ", ")),
                                  change, search.written),
                          search.reference, search.next_end(end, 2));
    // alone the scheme is open to chance as well, and rests on the balance
    trial.taken = trial.verdict == Verdict::kept;
    const bool enough = trial.taken;
    search.out.together.push_back(std::move(trial));
    if (enough) {
      search.out.chosen = all;
      return;
    }
    give_up_least(search.out.trials, taken);
  }
}

}  // namespace ra2d
