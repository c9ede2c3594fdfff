// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene/scene.hpp"

#include <fmt/format.h>

#include "host/errors.hpp"

namespace ra2d {

std::string place_of(const Scene& scene, std::string key) {
  while (scene.places) {
    if (const auto found = scene.places->find(key); found != scene.places->end())
      return found->second;
    if (key.empty()) break;
    key.resize(key.find('.') == std::string::npos ? 0 : key.rfind('.'));
  }
  return scene.file.string();
}

RequestError refusal(const Scene& scene, const std::string& key, const std::string& what) {
  return RequestError(
      fmt::format("{}: 1 fault\n{}: {}: {}", scene.file.string(), place_of(scene, key), key, what));
}

bool has_equilibrium(const Scene& scene) {
  if (scene.resonator.support == Support::free) return false;
  return scene.slider.support != Support::free || scene.slider.load_is_weight ||
         scene.slider.load > 0;
}

std::vector<std::string> warnings(const Scene& scene) {
  std::vector<std::string> out;
  const auto moves_off = [&](const char* body, const char* load) {
    out.push_back(
        fmt::format("nothing holds the free {} against {}: it moves off as a whole. The level "
                    "counts its elastic "
                    "motion alone",
                    body, load));
  };
  const bool pressed = scene.slider.load_is_weight || scene.slider.load > 0;
  if (scene.slider.support == Support::free && scene.slider.load < 0)
    moves_off("slider", "its load, which pulls it off the resonator (slider.load < 0)");
  if (scene.resonator.support != Support::free) return out;
  if (scene.slider.support == Support::free && pressed) moves_off("resonator", "the slider's load");
  for (const MovingForce& force : scene.resonator.moving_forces)
    if (force.force != 0) {
      moves_off("resonator", "its moving force");
      break;
    }
  return out;
}

std::vector<std::filesystem::path> files_of(const Scene& scene) {
  std::vector<std::filesystem::path> files{scene.file};
  for (const BodySpec* body : {&scene.resonator, &scene.slider})
    if (body->surface.kind == SurfaceKind::file)
      files.push_back(scene.file.parent_path() / body->surface.path);
  return files;
}

std::string title(const Scene& scene) {
  return scene.name.empty() ? scene.file.filename().string() : scene.name;
}

}  // namespace ra2d
