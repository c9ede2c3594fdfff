// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/savings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "host/savings/cheaper_numerics.hpp"
#include "host/savings/combination.hpp"
#include "host/savings/face_search.hpp"
#include "host/savings/savings_reference.hpp"
#include "host/savings/smaller_models.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

// The end of each part, as a share of the budget. First come the trials that the answer depends on
// most: whether the scene's own faces, modes and nodes are enough. Then come faces and their
// spacing, which save most. Schemes and steps come last: most are cheap to try and differ little in
// cost.
constexpr double base_end = 0.35, written_end = 0.42, beyond_end = 0.52, faces_end = 0.68,
                 modes_end = 0.8, slider_end = 0.83, numerics_end = 0.88, combination_end = 0.97;

/// Alternates the two, so that background load slows both equally.
void measure_costs(SavingsSearch& search) {
  search.say("what it costs");
  constexpr int repetitions = 3;
  const double share = 1.0 / (2 * repetitions);
  const double wall = std::clamp(share * search.left(1), 0.001 * search.options.budget,
                                 0.006 * search.options.budget);
  std::vector<double> written, chosen;
  for (int i = 0; i < repetitions && (i == 0 || search.left(1) > 0); ++i) {
    written.push_back(measure_cost(search.out.written, wall));
    chosen.push_back(measure_cost(search.out.chosen, wall));
  }
  std::sort(written.begin(), written.end());
  std::sort(chosen.begin(), chosen.end());
  search.out.cost_written = written[written.size() / 2];
  search.out.cost_chosen = chosen[chosen.size() / 2];
}

/// Keeps the scene as written where the plan is dearer than it, unless its faces are too far off.
void keep_no_dearer(SavingsSearch& search) {
  Savings& out = search.out;
  if (!(out.cost_chosen > out.cost_written)) return;
  if (const Trial* own = faces_as_written(out); own != nullptr && own->verdict == Verdict::moved) {
    out.notes.push_back(fmt::format(
        "the scene's faces are not accurate enough; those that are take {:.3g} times as "
        "long",
        out.cost_chosen / out.cost_written));
    return;
  }
  if (echo(out.chosen) == echo(out.written)) {  // timed twice
    out.cost_chosen = out.cost_written;
    return;
  }
  out.notes.push_back(fmt::format(
      "what is accurate enough takes {:.3g} times as long as the scene as written, which is kept",
      out.cost_chosen / out.cost_written));
  out.chosen = out.written;
  out.cost_chosen = out.cost_written;
  for (std::vector<Trial>* trials : {&out.trials, &out.combinations})
    for (Trial& trial : *trials) trial.taken = false;
}

}  // namespace

Savings find_savings(const Scene& scene, const SavingsOptions& options) {
  SavingsSearch search(scene, options);
  set_reference(search);
  find_base(search, base_end);
  check_faces(search, written_end);
  compare_with_larger_models(search, beyond_end);
  find_faces(search, faces_end);
  find_modes(search, &Scene::resonator, modes_end);
  find_modes(search, &Scene::slider, slider_end);
  find_numerics(search, numerics_end);
  combine_savings(search, combination_end);
  measure_costs(search);
  keep_no_dearer(search);
  take_answer(search);
  search.out.seconds = search.spent() * options.budget;
  return search.out;
}

}  // namespace ra2d
