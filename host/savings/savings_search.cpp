// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/savings_search.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/plan/plan.hpp"
#include "host/savings/face_search.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {

SavingsSearch::SavingsSearch(const Scene& scene, const SavingsOptions& requested)
    : whole{with_faces_of_reference(scene)},
      options{requested},
      plain{scene.time},
      begun_{Clock::now()} {
  out.accuracy = options.accuracy;
  out.written = out.chosen = scene;
  plain.force = false;
  plain.nodes = Nodes::candidates;  // the answer is the same
}

double SavingsSearch::spent() const { return seconds_since(begun_) / options.budget; }

double SavingsSearch::next_end(double end, double parts) const {
  return spent() + std::max(0.0, end - spent()) / parts;
}

void SavingsSearch::say(const std::string& text) const {
  if (options.progress) options.progress(text);
}

Scene SavingsSearch::for_runs(Scene scene) const {
  constexpr double samples_per_run = 100;  // for the energy; what a file would hold costs time
  scene.duration = out.duration;
  scene.output.rate = std::min(scene.output.rate, samples_per_run / scene.duration);
  scene.output.probes.clear();
  return scene;
}

Scene SavingsSearch::marched(const TimeSettings& time) const {
  Scene scene = whole;
  scene.time = time;
  return scene;
}

TimeSettings SavingsSearch::adaptive(double tolerance) const {
  TimeSettings time = plain;
  time.scheme = SchemeKind::adaptive;
  time.tolerance = tolerance;
  return time;
}

std::string text_of(const Scene& scene) {
  return fmt::format("{}, {}", short_text(choice_of(scene)),
                     is_adaptive(scene)
                         ? fmt::format("{:g}", scene.time.tolerance.value_or(usual_tolerance))
                         : seconds_text(scene.time.step));
}

void require_possible(const Scene& scene) {
  const Scene read = parse_scene(echo(scene), scene.file);
  if (is_adaptive(read)) return;
  const Model model = make_model(read);
  const std::string beyond = beyond_limit(model, step_limits(model, choice_of(read)));
  if (!beyond.empty()) throw RequestError(beyond);
}

}  // namespace ra2d
