// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/smaller_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/plan/plan.hpp"
#include "host/savings/trials.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

int elastic_modes(const Body& body) {
  return static_cast<int>(std::count_if(body.modes.begin(), body.modes.end(),
                                        [](const Mode& mode) { return mode.omega > 0; }));
}

std::string modes_text(const BodySpec& body, int modes) {
  return modes == 0 ? std::string("no elastic mode")
                    : fmt::format("{} elastic, up to {:.4g} kHz", modes,
                                  1e-3 * elastic_frequency(body, modes - 1));
}

std::function<void(Scene&)> with_modes(BodySpec Scene::*body, int modes) {
  return [body, modes](Scene& s) {
    (s.*body).modes = modes;
    (s.*body).max_frequency.reset();
  };
}

std::string spacing_text(double spacing) { return fmt::format("{:g} um", spacing * 1e6); }

}  // namespace

void find_modes(SavingsSearch& search, BodySpec Scene::*body, double end) {
  const bool of_resonator = body == &Scene::resonator;
  const std::string key = of_resonator ? "resonator.modes" : "slider.modes";
  const Model model = make_model(search.whole);
  const int kept = elastic_modes(of_resonator ? model.resonator : model.slider);
  if ((search.whole.*body).support == Support::rigid || kept == 0) return;
  int least = kept, too_few = -1;
  std::optional<std::size_t> best;
  for (int tests = 1 + static_cast<int>(std::log2(kept + 1)); least - too_few > 1; --tests) {
    const int modes = (least + too_few) / 2;
    Trial trial = try_out(search,
                          changed(key, modes_text(search.whole.*body, modes),
                                  with_modes(body, modes), search.base->scene()),
                          search.base, search.next_end(end, std::max(1, tests)), 0, end);
    const bool enough = trial.verdict == Verdict::kept;
    (enough ? least : too_few) = modes;
    if (enough) best = search.out.trials.size();
    const bool over = was_not_run(trial);  // the others take as long
    search.out.trials.push_back(std::move(trial));
    if (over) break;
  }
  if (best) search.out.trials[*best].taken = true;
}

void compare_with_larger_models(SavingsSearch& search, double until) {
  std::vector<Trial> list;
  const Scene& from = search.base->scene();
  const double spacing = search.whole.spacing / 2;
  list.push_back(changed(
      "scene.spacing", spacing_text(spacing), [spacing](Scene& s) { set_spacing(s, spacing); },
      from));
  const auto more = [&](const char* key, BodySpec Scene::*body, int modes) {
    list.push_back(
        changed(key, modes_text(search.whole.*body, modes), with_modes(body, modes), from));
  };
  const Model model = make_model(search.whole);
  if (search.whole.resonator.support != Support::rigid) {
    const int kept = elastic_modes(model.resonator);
    int modes = kept + 1;
    while (kept > 0 && elastic_frequency(search.whole.resonator, modes) <=
                           2 * elastic_frequency(search.whole.resonator, kept - 1))
      ++modes;
    more("resonator.modes", &Scene::resonator, modes);
  }
  if (search.whole.slider.support != Support::rigid && search.whole.slider.kind != BodyKind::block)
    more("slider.modes", &Scene::slider, elastic_modes(model.slider) + 2);
  if (!is_adaptive(search.whole))
    list.push_back(changed(
        "as written", text_of(search.whole), [](Scene&) {}, search.whole));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double end = search.next_end(until, static_cast<double>(list.size() - i));
    const bool own = list[i].key == "as written";
    // numerics are compared with the reference, models under the same numerics
    Trial trial = try_out(search, list[i], own ? search.reference : search.base, end,
                          own ? search.cost_whole
                          : list[i].key == "scene.spacing" && search.base->cost() > 0
                              ? 2 * search.base->cost()  // twice as many nodes pass nodes
                              : 0.0,
                          until);
    trial.checked = true;
    search.out.trials.push_back(std::move(trial));
  }
}

}  // namespace ra2d
