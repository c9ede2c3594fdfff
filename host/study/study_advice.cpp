// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_advice.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/errors.hpp"
#include "host/model/doubts.hpp"

namespace ra2d {

void require_other_seeds(const StudyPoints& points, const PointCensus& census) {
  const std::size_t seeds = points.study().seeds.size();
  if (seeds < 2) return;
  for (std::size_t first = 0; first < points.size(); first += seeds) {
    if (census.keys[first] != census.keys[first + 1]) continue;
    std::string name = points.name(first);
    name.resize(name.rfind("seed "));
    throw RequestError(fmt::format(
        "{}: seeds: {} runs of each combination, and a seed changes nothing of the scene{}: "
        "neither "
        "face is random, so they would be one run. Expected seeds = 1. Other runs are those of "
        "other "
        "faces: vary slider.surface.path or resonator.surface.path (or row and column of an areal "
        "file), or scene.start by more than slider.length, which takes other stretches of the "
        "resonator's face",
        points.study().file.string(), seeds,
        name.empty() ? "" : fmt::format(" with {}", name.substr(0, name.rfind(", ")))));
  }
}

namespace {

/// Of dimensions of which no value makes another scene.
void doubt_dimensions(const StudyPoints& points, const PointCensus& census,
                      std::vector<std::string>& doubts) {
  std::size_t block = points.size();  // points that a value of the dimension has in a row
  for (const StudyDimension& dimension : points.study().dimensions) {
    const std::size_t values = dimension.size(), whole = block;
    block /= values;
    if (values < 2) continue;
    const auto key = [&](std::size_t point) { return census.keys[point]; };
    bool changes = false;
    for (std::size_t point = 0; point < points.size() && !changes; ++point)
      changes = point % whole + block < whole && key(point) != key(point + block);
    if (changes) continue;
    doubts.push_back(
        fmt::format("vary.{}: {} changes nothing of these scenes, and all its values are one run "
                    "('ra2d plan SCENE' says what a scene does not use)",
                    dimension.name, fmt::join(dimension.keys, ", ")));
  }
}

}  // namespace

std::vector<std::string> study_doubts(const StudyPoints& points, const PointCensus& census) {
  constexpr std::size_t most_scenes = 300;
  std::vector<std::size_t> chosen{0};
  const std::vector<std::size_t> shape = points.shape();
  std::size_t stride = points.size();
  for (std::size_t axis = 0; axis + 1 < shape.size(); ++axis) {
    stride /= shape[axis];
    for (std::size_t i = 1; i < shape[axis] && chosen.size() < most_scenes; ++i)
      chosen.push_back(i * stride);
  }
  std::vector<std::string> doubts;
  doubt_dimensions(points, census, doubts);
  for (const std::size_t point : chosen)
    for (std::string& doubt : scene_doubts(points.scene(point)))
      if (std::find(doubts.begin(), doubts.end(), doubt) == doubts.end())
        doubts.push_back(std::move(doubt));
  if (doubts.size() > most_doubts) {
    const std::size_t more = doubts.size() - most_doubts;
    doubts.resize(most_doubts);
    doubts.push_back(fmt::format("and {} more of this kind", more));
  }
  return doubts;
}

}  // namespace ra2d
