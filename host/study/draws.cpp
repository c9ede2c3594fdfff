// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/draws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/scene_file/shared_stretch.hpp"
#include "host/study/law.hpp"
#include "host/study/study_points.hpp"

namespace ra2d {
namespace {

/// The bodies whose faces the values of an axis choose. None where its first key, whose numbers
/// they are, is another: faces tied to it are part of what it changes.
struct ChosenFaces {
  bool resonator = false, slider = false;
  bool operator==(const ChosenFaces&) const = default;
};

ChosenFaces chosen_faces(const StudyAxis& axis) {
  ChosenFaces chosen;
  std::string_view rest = axis.keys;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(", "), rest.size());
    const std::string_view key = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 2, rest.size()));
    if (key == "scene.start" || key == "scene.side") chosen.resonator = true;
    for (const char* of_face : {".surface.seed", ".surface.path", ".surface.row", ".surface.column",
                                ".surface.offset_x", ".surface.offset_y"})
      if (key.ends_with(of_face))
        (key.starts_with("slider.") ? chosen.slider : chosen.resonator) = true;
    if (chosen == ChosenFaces{}) break;
  }
  return chosen;
}

/// Whether any two runs that differ in their seeds alone have other answers: where no surface has a
/// seed they are one run.
bool seeds_differ(const StudyAnswers& answers, const std::vector<double>& amplitude) {
  const std::size_t seeds = answers.axes.back().size();
  double first = quiet_nan;
  for (std::size_t i = 0; i < amplitude.size(); ++i) {
    const double value = amplitude[i];
    if (i % seeds == 0) first = quiet_nan;
    if (!(value > 0 && std::isfinite(value))) continue;
    if (std::isnan(first)) first = value;
    if (std::abs(value - first) > 1e-9 * first) return true;
  }
  return false;
}

constexpr const char* place_keys[] = {"scene.start", "scene.side", ".surface.offset_x",
                                      ".surface.offset_y"};

bool has_key(const StudyAxis& axis, std::string_view key) {
  return axis.keys.find(key) != std::string::npos;
}

/// The study that a table is of. Throws RequestError where its text is not understood.
StudyPoints points_of(const StudyAnswers& answers) {
  std::vector<std::string> given;
  std::istringstream lines(answers.given);
  for (std::string line; std::getline(lines, line);) given.push_back(line);
  Study study = parse_study(answers.study, "study.toml", given);
  study.base_text = answers.base;
  StudyPoints points(std::move(study));
  std::vector<std::size_t> shape;
  for (const StudyAxis& axis : answers.axes) shape.push_back(axis.size());
  if (points.shape() != shape) throw RequestError("another study than that of the table");
  return points;
}

/// The scenes of the values of an axis, with the first values of all others.
std::vector<Scene> scenes_along(const StudyPoints& points, std::size_t axis) {
  const std::vector<std::size_t> shape = points.shape();
  std::size_t stride = 1;
  for (std::size_t a = axis + 1; a < shape.size(); ++a) stride *= shape[a];
  std::vector<Scene> scenes;
  for (std::size_t i = 0; i < shape[axis]; ++i) scenes.push_back(points.scene(i * stride));
  return scenes;
}

bool is_place(const StudyAxis& axis) {
  return std::any_of(std::begin(place_keys), std::end(place_keys),
                     [&](const char* key) { return has_key(axis, key); });
}

/// Says which of the axes has two values at which runs touch a part of the same faces; empty where
/// none has. Each is taken to be as long as the longest of any run.
std::string shared_stretch(const StudyPoints& points, const std::vector<StudyAxis>& axes,
                           const std::vector<std::size_t>& places) {
  Scene longest = points.scene(0);
  const auto see = [&](const Scene& scene) {
    longest.slider.length = std::max(longest.slider.length, scene.slider.length);
    longest.speed = std::max(longest.speed, scene.speed);
    longest.duration = std::max(longest.duration, scene.duration);
  };
  for (std::size_t a = 0; a + 1 < axes.size(); ++a)
    for (const char* key : {"slider.length", "scene.speed", "scene.duration"})
      if (has_key(axes[a], key)) std::ranges::for_each(scenes_along(points, a), see);
  for (const std::size_t a : places) {
    std::vector<Scene> scenes = scenes_along(points, a);
    for (Scene& scene : scenes) {
      scene.slider.length = longest.slider.length;
      scene.speed = longest.speed;
      scene.duration = longest.duration;
    }
    if (two_on_one_stretch(scenes))
      return fmt::format(
          "values of {} lie so close that runs touch a part of the same faces: each takes up to "
          "{:.4g} m along x, the slider's length and what it slides. Take values further apart, or "
          "several `seeds`",
          axes[a].name, touched_length(longest));
  }
  return {};
}

/// As above, of a table; empty where no axis says where the faces are touched.
std::string shared_stretch(const StudyAnswers& answers, const std::vector<std::size_t>& drawn) {
  std::vector<std::size_t> places;
  for (const std::size_t a : drawn)
    if (is_place(answers.axes[a])) places.push_back(a);
  if (places.empty()) return {};
  try {
    return shared_stretch(points_of(answers), answers.axes, places);
  } catch (const RequestError&) {  // of another version of ra2d
    return {};
  }
}

}  // namespace

bool chooses_faces(const StudyAxis& axis) { return chosen_faces(axis) != ChosenFaces{}; }

bool changes_along(const StudyAnswers& answers, const std::vector<double>& amplitude,
                   std::size_t axis) {
  std::size_t block = 1;  // runs that a value of the axis has in a row
  for (std::size_t a = axis + 1; a < answers.axes.size(); ++a) block *= answers.axes[a].size();
  const std::size_t whole = block * answers.axes[axis].size();
  bool compared = false;
  for (std::size_t run = 0; run + block < amplitude.size(); ++run) {
    const double here = amplitude[run], next = amplitude[run + block];
    if (run % whole + block >= whole || !(here > 0) || !(next > 0)) continue;
    compared = true;
    if (here != next) return true;
  }
  return !compared;
}

Draws draws_of(const StudyAnswers& answers, const std::vector<double>& amplitude) {
  const std::vector<StudyAxis>& axes = answers.axes;
  std::vector<std::size_t> drawn;
  Draws draws;
  if (seeds_differ(answers, amplitude)) {
    drawn.push_back(axes.size() - 1);
  } else {
    for (std::size_t a = 0; a + 1 < axes.size(); ++a)
      if (axes[a].size() > 1 && chooses_faces(axes[a]) && changes_along(answers, amplitude, a))
        drawn.push_back(a);
  }
  for (const std::size_t a : drawn) draws.axes.push_back(axes[a].name);
  const auto same_bodies = [&](std::size_t a) {
    return chosen_faces(axes[a]) == chosen_faces(axes[drawn.front()]);
  };
  if (!std::all_of(drawn.begin(), drawn.end(), same_bodies))
    draws.dependent = fmt::format(
        "{} choose faces of different bodies, so that each run shares a face with others. Take "
        "several `seeds` instead",
        fmt::join(draws.axes, " and "));
  else
    draws.dependent = shared_stretch(answers, drawn);
  draws.of_run.assign(amplitude.size(), 0);
  if (!draws.dependent.empty()) return draws;
  for (const std::size_t a : drawn) draws.count *= axes[a].size();
  for (std::size_t run = 0; run < amplitude.size(); ++run) {
    const std::vector<std::size_t> place = place_of_run(axes, run);
    for (const std::size_t a : drawn)
      draws.of_run[run] = draws.of_run[run] * axes[a].size() + place[a];
  }
  return draws;
}

}  // namespace ra2d
