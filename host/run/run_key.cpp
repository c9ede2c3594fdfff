// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run_key.hpp"

#include <fmt/format.h>

#include <sstream>

#include "host/base/hash.hpp"
#include "host/base/text.hpp"
#include "host/device/backend.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

int version_of_motion(const Scene& scene) {
  if (!is_adaptive(scene))  // areal scenes: fine nodes share their sums over the modes
    return scene.kind == SceneKind::areal && scene.faces != Faces::smooth && !holds_forces(scene)
               ? 4
               : numerics_version;
  if (scene.faces == Faces::smooth) return 7;  // collocation, with sweeps on springs
  // shapes have the terms that a hit on a body at rest asks for; in areal scenes nodes in contact
  // are gathered in clusters, single ones have sums that serve four orders, and the order of the
  // series is chosen
  return scene.kind == SceneKind::areal ? 6 : 3;
}

bool has_map_that_goes_on(const Scene& scene) {
  const auto goes_on = [](const SurfaceSpec& face) {
    return face.kind == SurfaceKind::file && face.prepared.when_short != ShortProfile::refuse;
  };
  return scene.kind == SceneKind::areal &&
         (goes_on(scene.resonator.surface) || goes_on(scene.slider.surface));
}

}  // namespace

int numerics_version_of(const Scene& scene) {
  constexpr int of_further_points = 10;  // splines through them, behind what is touched
  return version_of_motion(scene) + (has_map_that_goes_on(scene) ? of_further_points : 0);
}

std::string run_key(const Model& model) {
  Scene scene = without_origins(model.scene);
  for (BodySpec* body : {&scene.resonator, &scene.slider})
    body->surface.path.clear();  // its heights tell more
  const std::string text =
      fmt::format("numerics {}\n{}\n{}", numerics_version_of(scene), arithmetic(), echo(scene));
  Hash hash;
  hash.add(text);
  for (const SharedNumbers* height : {&model.resonator_height, &model.slider_height}) {
    hash.add(fmt::format("\n{} heights\n", height->size()));
    hash.add(height->data(), height->size());
  }
  if (model.is_areal)
    hash.add(fmt::format("\n{} rows, {} m apart, from {} m on\n", model.rows, model.spacing_y,
                         model.side));
  return hash.text();
}

std::string run_key_with_sound(const Model& model) {
  const std::string key = run_key(model), sound = sound_settings(model.scene);
  if (sound.empty()) return key;
  Hash hash;
  hash.add(key);
  hash.add(sound);
  return hash.text();
}

std::string sound_settings(const Scene& scene) {
  if (scene.output.microphones.empty() && scene.air == AirSettings{}) return {};
  std::string text = fmt::format("\nair of {} C and {} Pa\n", scene.air.celsius, scene.air.pascal);
  for (const MicrophonePlace& at : scene.output.microphones)
    text += fmt::format("microphone at {}, {}, {} m\n", at.x, at.y, at.z);
  return text;
}

std::string first_difference(const std::string& there, const std::string& here) {
  std::istringstream a(there), b(here);
  std::string of_a, of_b;
  while (true) {
    const bool more_a = static_cast<bool>(std::getline(a, of_a));
    const bool more_b = static_cast<bool>(std::getline(b, of_b));
    if (!more_a && !more_b) return {};
    if (!more_a) of_a = "nothing";
    if (!more_b) of_b = "nothing";
    // its name and the place of its files make no other run
    if (of_a != of_b && !(of_a.starts_with("name =") && of_b.starts_with("name =")))
      return fmt::format("'{}' there, '{}' here", printable(shortened(of_a, 80)),
                         printable(shortened(of_b, 80)));
  }
}

}  // namespace ra2d
