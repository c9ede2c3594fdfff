// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/savings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "host/savings/cheaper_numerics.hpp"
#include "host/savings/savings_reference.hpp"
#include "host/savings/smaller_models.hpp"
#include "host/savings/together.hpp"

namespace ra2d {
namespace {

// Until when each part may go on, as shares of the budget.
constexpr double numerics_end = 0.45, modes_end = 0.6, slider_end = 0.65, spacing_end = 0.73,
                 together_end = 0.88;

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

}  // namespace

Savings find_savings(const Scene& scene, const SavingsOptions& options) {
  SavingsSearch search(scene, options);
  set_reference(search);
  find_numerics(search, numerics_end);
  find_modes(search, &Scene::resonator, modes_end);
  find_modes(search, &Scene::slider, slider_end);
  find_spacing(search, spacing_end);
  take_together(search, together_end);
  measure_costs(search);
  look_beyond(search);
  take_answer(search);
  search.out.seconds = search.spent() * options.budget;
  return search.out;
}

}  // namespace ra2d
