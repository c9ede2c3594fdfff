// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/survey.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {

Survey::Survey(const Scene& base, const AccuracyOptions& requested)
    : scene{base}, options{requested} {
  scene.time.nodes = Nodes::candidates;
  scene.time.force = false;
  scene.output.from = 0;  // the stretches are short: all of them counts
  if (!(scene.time.step > 0)) scene.time.step = 1e-8;  // of a scene that leaves it to its scheme
  methods = methods_of(scene);
  std::vector<double>& steps = options.steps;
  if (std::none_of(steps.begin(), steps.end(),
                   [&](double step) { return std::abs(step / scene.time.step - 1) < 0.01; }))
    steps.push_back(scene.time.step);
  std::sort(steps.begin(), steps.end(), std::greater<>());
  std::sort(options.tolerances.begin(), options.tolerances.end(), std::greater<>());
}

void Survey::say(const std::string& text) const {
  if (options.progress) options.progress(text);
}

double Survey::elapsed() const { return seconds_since(begun_); }

double Survey::left(double end) const {
  constexpr double peers = peer_end - state_end;
  if (options.peers.empty())
    end = (end > state_end ? std::max(state_end, end - peers) : end) / (1 - peers);
  return options.budget * end - elapsed();
}

const ModalStart& Survey::start_of(ContactLaw law, const Model& model) {
  const auto found = starts_.find(law);
  return found != starts_.end() ? found->second
                                : starts_.emplace(law, make_start(model)).first->second;
}

Model Survey::model_of(const Scene& of) {
  if (!made_) made_ = make_model(with(scene, methods.front()));
  return with_settings(*made_, of);
}

TimedRun Survey::march(const Scene& marched, const RunLimits& limits) {
  const Model model = model_of(marched);
  return timed_run(model, start_of(marched.contact.law, model), limits);
}

Method Survey::finest(const Method& method) const {
  return is_adaptive(method.time) ? sized(method, 0.1 * options.tolerances.back())
                                  : sized(method, 0.25 * options.steps.back());
}

const Measured* Survey::measured(const Method& setting) const {
  for (const Measured& point : chart.points)
    if (point.setting == setting && point.name.program == "ra2d" && !point.wall.empty())
      return &point;
  return nullptr;
}

Name name_of(const Method& setting) {
  const auto& [time, law] = setting;
  // under multipliers the force is that of the end of the step
  const bool at_end = law == ContactLaw::multiplier || time.contact_force == ForceTime::new_time;
  return {.scheme = schemes.name(time.scheme),
          .law = contact_laws.name(law),
          .contact_force = is_adaptive(time) ? continuous_force
                                             : force_times.name(at_end ? ForceTime::new_time
                                                                       : ForceTime::old_time),
          .nodes = node_choices.name(Nodes::candidates),
          .text = text(setting)};
}

bool has_failed(const TimedRun& run) {
  return run.status != Status::running && run.status != Status::done;
}

}  // namespace ra2d
