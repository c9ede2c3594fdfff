// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/draws.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "host/base/quiet_nan.hpp"
#include "host/study/law.hpp"

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
    for (const std::size_t a : drawn)
      draws.crossed = draws.crossed || chosen_faces(axes[a]) != chosen_faces(axes[drawn.front()]);
  }
  for (const std::size_t a : drawn) draws.axes.push_back(axes[a].name);
  draws.of_run.assign(amplitude.size(), 0);
  if (draws.crossed) return draws;
  for (const std::size_t a : drawn) draws.count *= axes[a].size();
  for (std::size_t run = 0; run < amplitude.size(); ++run) {
    const std::vector<std::size_t> place = place_of_run(axes, run);
    for (const std::size_t a : drawn)
      draws.of_run[run] = draws.of_run[run] * axes[a].size() + place[a];
  }
  return draws;
}

}  // namespace ra2d
