// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/quiet_nan.hpp"
#include "host/savings/savings.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

using Json = nlohmann::ordered_json;  // writes null for what is not finite

constexpr std::array<const char*, 3> names{"v_rms", "shock_rate", "shock_duration_median"};

Json movement_json(const Movement& movement) {
  return {
      {"relative", movement.relative}, {"margin", movement.margin()}, {"pairs", movement.pairs}};
}

Json trial_json(const Trial& trial) {
  const bool was_run = trial.why.empty() || trial.moved[0].pairs > 0;
  Json json{{"key", trial.key.empty() ? Json() : Json(trial.key)},
            {"value", trial.what},
            {"verdict", trial.verdict == Verdict::kept    ? "kept"
                        : trial.verdict == Verdict::moved ? "moved"
                                                          : "open"},
            {"why", trial.why.empty() ? Json() : Json(trial.why)},
            {"taken", trial.taken},
            {"taken_because_energy_closes", trial.by_balance},
            {"is_check", trial.checked},
            {"times_cheaper", trial.cheaper},
            {"energy_closure", was_run ? Json(trial.energy_closure) : Json()}};
  for (std::size_t q = 0; q < names.size(); ++q)
    json["moved"][names[q]] = was_run ? movement_json(trial.moved[q]) : Json();
  return json;
}

Json trials_json(const std::vector<Trial>& trials) {
  Json list = Json::array();
  for (const Trial& trial : trials) list.push_back(trial_json(trial));
  return list;
}

}  // namespace

std::string savings_json(const Savings& s, const std::filesystem::path& output) {
  Json spread;
  for (std::size_t q = 0; q < names.size(); ++q)
    spread[names[q]] = s.runs > 1 ? Json(s.spread[q]) : Json();
  const Json json{{"file", s.written.file.string()},
                  {"accuracy", s.accuracy},
                  {"duration", s.duration},
                  {"runs", s.runs},
                  {"lv", s.mean.v_rms > 0 ? 20 * std::log10(s.mean.v_rms / 1e-9) : quiet_nan},
                  {"v_rms", s.mean.v_rms},
                  {"shock_rate", s.mean.shock_rate},
                  {"shock_duration_median", s.mean.shock_duration_median},
                  {"spread_of_a_run", spread},
                  {"energy_closure", s.energy_closure},
                  {"trials", trials_json(s.trials)},
                  {"combinations", trials_json(s.combinations)},
                  {"scene", echo(s.chosen)},
                  {"set", set_words(s)},
                  {"output", output.string()},
                  {"cost_as_written", s.cost_written},
                  {"cost", s.cost_chosen},
                  {"notes", s.notes},
                  {"wall_seconds", s.seconds}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace ra2d
