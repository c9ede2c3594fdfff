// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/savings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "host/savings/cheaper_numerics.hpp"
#include "host/savings/savings_reference.hpp"
#include "host/savings/smaller_models.hpp"
#include "host/savings/together.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

// Until when each part may go on, as shares of the budget. First what the answer hangs on most,
// whether the scene's own modes and nodes are enough; then what saves most, a coarser spacing;
// schemes and steps, of which most are cheap to try and save little beside one another, come last.
constexpr double base_end = 0.35, beyond_end = 0.52, spacing_end = 0.68, modes_end = 0.8,
                 slider_end = 0.83, numerics_end = 0.88, together_end = 0.97;

/// In turns, so that what else the machine does meets both alike.
void measure_costs(SavingsSearch& search) {
  search.say("what it costs");
  const double wall = 0.006 * search.options.budget;
  std::vector<double> written, chosen;
  for (int i = 0; i < 3; ++i) {
    written.push_back(measure_cost(search.written, wall));
    chosen.push_back(measure_cost(search.out.chosen, wall));
  }
  std::sort(written.begin(), written.end());
  std::sort(chosen.begin(), chosen.end());
  search.out.cost_written = written[1];
  search.out.cost_chosen = chosen[1];
}

/// A plan that is dearer than the scene is none.
void keep_no_dearer(SavingsSearch& search) {
  Savings& out = search.out;
  if (!(out.cost_chosen > out.cost_written)) return;
  if (echo(out.chosen) == echo(out.written)) {  // timed twice
    out.cost_chosen = out.cost_written;
    return;
  }
  out.notes.push_back(
      fmt::format("what would do takes {:.3g} times as long as the scene as written, which is kept",
                  out.cost_chosen / out.cost_written));
  out.chosen = out.written;
  out.cost_chosen = out.cost_written;
  for (std::vector<Trial>* trials : {&out.trials, &out.together})
    for (Trial& trial : *trials) trial.taken = false;
}

}  // namespace

Savings find_savings(const Scene& scene, const SavingsOptions& options) {
  SavingsSearch search(scene, options);
  set_reference(search);
  find_base(search, base_end);
  look_beyond(search, beyond_end);
  find_spacing(search, spacing_end);
  find_modes(search, &Scene::resonator, modes_end);
  find_modes(search, &Scene::slider, slider_end);
  find_numerics(search, numerics_end);
  take_together(search, together_end);
  measure_costs(search);
  keep_no_dearer(search);
  take_answer(search);
  search.out.seconds = search.spent() * options.budget;
  return search.out;
}

}  // namespace ra2d
