// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/shared_stretch.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

struct Extent {
  double first, length;  // m
};

bool overlap(const Extent& a, const Extent& b) {
  constexpr double roundings = 1e-9;  // of the lengths
  return std::max(a.first, b.first) + roundings * a.length <
         std::min(a.first + a.length, b.first + b.length);
}

/// The parts of both faces that a run touches, from where these begin.
struct Touched {
  std::size_t run;
  Extent resonator, resonator_y, slider, slider_y;
};

Touched touched(const Scene& scene, std::size_t run) {
  const FilePreparation& below = scene.resonator.surface.prepared;
  const FilePreparation& above = scene.slider.surface.prepared;
  const double side = scene.side.value_or(0);
  // a measured map without offset_y begins at the slider's side, wherever that is
  const bool is_file = scene.resonator.surface.kind == SurfaceKind::file;
  const double side_of_face = below.offset_y.value_or(is_file ? side : 0.0);
  return {run,
          {scene.start - below.offset_x.value_or(0), touched_length(scene)},
          {side - side_of_face, scene.slider.width},
          {-above.offset_x.value_or(0), scene.slider.length},
          {-above.offset_y.value_or(0), scene.slider.width}};
}

bool overlap(const Touched& a, const Touched& b) {
  return overlap(a.resonator, b.resonator) && overlap(a.resonator_y, b.resonator_y) &&
         overlap(a.slider, b.slider) && overlap(a.slider_y, b.slider_y);
}

}  // namespace

Scene without_place(Scene scene) {
  scene = without_origins(std::move(scene));
  scene.time = {};
  scene.output = {};
  scene.start = 0;
  scene.side = {};
  for (SurfaceSpec* face : {&scene.resonator.surface, &scene.slider.surface}) {
    face->prepared.offset_x.reset();
    face->prepared.offset_y.reset();
  }
  return scene;
}

double touched_length(const Scene& scene) {
  return scene.slider.length + scene.speed * scene.duration;
}

std::optional<std::pair<std::size_t, std::size_t>> two_on_one_stretch(
    const std::vector<Scene>& scenes) {
  std::map<std::string, std::vector<Touched>> by_faces;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    by_faces[echo(without_place(scenes[i]))].push_back(touched(scenes[i], i));
  for (auto& [text, runs] : by_faces) {
    std::stable_sort(runs.begin(), runs.end(), [](const Touched& a, const Touched& b) {
      return a.resonator.first < b.resonator.first;
    });
    for (std::size_t i = 0; i < runs.size(); ++i)
      for (std::size_t j = i + 1; j < runs.size() && overlap(runs[i].resonator, runs[j].resonator);
           ++j)
        if (overlap(runs[i], runs[j])) return std::minmax(runs[i].run, runs[j].run);
  }
  return {};
}

}  // namespace ra2d
