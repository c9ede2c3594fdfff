// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene/scene.hpp"

#include <fmt/format.h>

#include "host/base/errors.hpp"
#include "host/scene/hertz.hpp"

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

void make_areal(Scene& scene) {
  scene.kind = SceneKind::areal;
  scene.resonator.kind = BodyKind::plate;
  scene.slider.kind = BodyKind::block;
  scene.spacing_y = scene.spacing_y.value_or(scene.spacing);
  scene.side = scene.side.value_or(0.5 * (scene.resonator.width - scene.slider.width));
  if (scene.resonator.support != Support::rigid)
    scene.resonator.poisson = scene.resonator.poisson.value_or(usual_poisson);
}

void set_spacing(Scene& scene, double spacing) {
  if (scene.spacing_y) *scene.spacing_y *= spacing / scene.spacing;
  scene.spacing = spacing;
}

double mesh_tone_frequency(const Scene& scene) {
  return scene.faces == Faces::linear ? scene.speed / scene.spacing : 0.0;
}

bool has_equilibrium(const Scene& scene) {
  if (scene.resonator.support == Support::free) return false;
  return scene.slider.support != Support::free || scene.slider.load_is_weight ||
         scene.slider.load > 0;
}

std::vector<std::filesystem::path> files_of(const Scene& scene) {
  std::vector<std::filesystem::path> files{scene.file};
  for (const BodySpec* body : {&scene.resonator, &scene.slider})
    if (body->surface.kind == SurfaceKind::file)
      files.push_back(scene.file.parent_path() / body->surface.path);
  return files;
}

Scene without_origins(Scene scene) {
  scene.name.clear();
  scene.contact.is_hertz = false;
  scene.output.microphones.clear();
  scene.air = {};
  for (BodySpec* body : {&scene.resonator, &scene.slider})
    if (body->kind != BodyKind::plate) body->poisson.reset();
  return scene;
}

std::string title(const Scene& scene) {
  return scene.name.empty() ? scene.file.filename().string() : scene.name;
}

}  // namespace ra2d
