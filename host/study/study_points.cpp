// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>
#include <utility>

#include "host/beam/beam.hpp"
#include "host/errors.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_told = 3;  // scenes that are wrong

/// Of run k: both surfaces' seeds + 1000 k, within the numbers that TOML knows.
void shift_seeds(Scene& scene, std::int64_t k) {
  constexpr auto most = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  for (BodySpec* body : {&scene.resonator, &scene.slider})
    if (body->surface.kind == SurfaceKind::gaussian)
      body->surface.seed = (body->surface.seed + 1000 * static_cast<std::uint64_t>(k)) & most;
}

bool has_seed(const Scene& scene) {
  return scene.resonator.surface.kind == SurfaceKind::gaussian ||
         scene.slider.surface.kind == SurfaceKind::gaussian;
}

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

}  // namespace

StudyPoints::StudyPoints(Study study) : study_{std::move(study)} {
  for (const StudyDimension& dimension : study_.dimensions) combinations_ *= dimension.size();
}

std::vector<std::size_t> StudyPoints::shape() const {
  std::vector<std::size_t> shape;
  for (const StudyDimension& dimension : study_.dimensions) shape.push_back(dimension.size());
  shape.push_back(study_.seeds.size());
  return shape;
}

std::vector<std::size_t> StudyPoints::place(std::size_t point) const {
  const std::vector<std::size_t> lengths = shape();
  std::vector<std::size_t> place(lengths.size());
  for (std::size_t axis = lengths.size(); axis-- > 0; point /= lengths[axis])
    place[axis] = point % lengths[axis];
  return place;
}

std::string StudyPoints::name(std::size_t point) const {
  const std::vector<std::size_t> at = place(point);
  std::string name;
  for (std::size_t d = 0; d < study_.dimensions.size(); ++d)
    name += fmt::format("{} = {}, ", study_.dimensions[d].name, study_.dimensions[d].shown(at[d]));
  return name + fmt::format("seed {}", study_.seeds[at.back()]);
}

std::vector<std::string> StudyPoints::overrides(const std::vector<std::size_t>& place) const {
  std::vector<std::string> texts = study_.set;
  texts.insert(texts.end(), study_.given.begin(), study_.given.end());
  for (std::size_t d = 0; d < study_.dimensions.size(); ++d) {
    const StudyDimension& dimension = study_.dimensions[d];
    for (std::size_t k = 0; k < dimension.keys.size(); ++k)
      texts.push_back(dimension.keys[k] + "=" + dimension.values[place[d]][k]);
  }
  return texts;
}

Scene StudyPoints::combination(std::size_t point) const {
  return parse_scene(study_.base_text, study_.base, overrides(place(point)));
}

Scene StudyPoints::scene(std::size_t point) const {
  Scene scene = combination(point);
  shift_seeds(scene, study_.seeds[point % study_.seeds.size()]);
  return scene;
}

std::string StudyPoints::in_words_of_the_study(std::string fault, std::size_t point) const {
  const std::string base = study_.base.filename().string();
  replace_all(fault, study_.base.string(), base);
  const std::string one = base + ": 1 fault\n";
  if (fault.starts_with(one)) fault.erase(0, one.size());
  for (const std::string& change : overrides(place(point)))
    if (std::find(study_.given.begin(), study_.given.end(), change) == study_.given.end())
      replace_all(fault, "--set " + change, "the study's " + change);
  return fault;
}

PointCensus::PointCensus(const StudyPoints& points) {
  const std::size_t seeds = points.study().seeds.size();
  FileHashes files;
  std::string faults;
  std::size_t wrong = 0;
  keys.reserve(points.size());
  costs.reserve(points.size());
  has_seeds = false;
  for (std::size_t c = 0; c < points.combinations(); ++c) {
    try {
      const Scene scene = points.combination(c * seeds);
      has_seeds = has_seeds || has_seed(scene);
      const auto cost = static_cast<float>(scene_cost(scene));
      for (const std::int64_t k : points.study().seeds) {
        // scenes without a seed are one run for all
        if (k != points.study().seeds.front() && !has_seed(scene)) {
          keys.push_back(keys.back());
        } else {
          Scene shifted = scene;
          shift_seeds(shifted, k);
          keys.push_back(scene_key(shifted, files));
        }
        costs.push_back(cost);
      }
    } catch (const RequestError& fault) {
      if (++wrong <= most_told) {
        const std::string name = points.name(c * seeds);
        const std::size_t end = name.rfind(", seed ");
        faults +=
            fmt::format("\n{}:\n{}", end == name.npos ? "every run" : "with " + name.substr(0, end),
                        points.in_words_of_the_study(fault.what(), c * seeds));
      }
    }
  }
  profiles = files.names();
  if (wrong > 0)
    throw RequestError(
        fmt::format("{}: {} of {} scenes {} wrong{}{}", points.study().file.string(), wrong,
                    points.combinations(), wrong == 1 ? "is" : "are", faults,
                    wrong > most_told ? fmt::format("\nand {} more", wrong - most_told) : ""));
}

std::vector<std::size_t> PointCensus::different() const {
  std::vector<std::size_t> points;
  std::unordered_set<Key128> seen;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (seen.insert(keys[i]).second) points.push_back(i);
  return points;
}

double scene_cost(const Scene& scene) {
  // As of 'ra2d plan', whose figures need the beams and faces (host/plan/plan.cpp): the mean, in ratio, of
  // no contact and of a node in contact all the time.
  constexpr double setup = 5e-3;                    // s: surfaces, tables
  constexpr double flight = 5e-9, contact = 45e-9;  // s: a fixed step
  constexpr double leap = 600e-9, drive = 2e-6;     // s: an adaptive one
  constexpr int most_counted = 2000;                // modes
  const int elastic = mode_count(scene.resonator, most_counted);
  const int modes = elastic + mode_count(scene.slider, most_counted);
  const double wide = std::max(1.0, modes / 24.0);
  if (!is_adaptive(scene)) {
    const double steps = scene.duration / scene.time.step;
    const int stages = scheme_table(scene.time.scheme).stages;
    const double each =
        scene.time.nodes == Nodes::all ? 1e-9 * (scene.slider.length / scene.spacing) : 0.0;
    return setup + steps * (wide * std::sqrt(flight * contact * stages) + stages * each);
  }
  const double crossings = scene.speed / scene.spacing;  // a second
  const double highest =
      elastic > 0 && scene.resonator.support != Support::rigid
          ? elastic_frequency(scene.resonator, std::max(0, std::min(elastic, most_counted) - 1))
          : 0.0;
  const double free = crossings * leap, pressed = (crossings + 2 * M_PI * highest) * drive;
  return setup + scene.duration * wide * std::sqrt(std::max(free, 1e-3) * std::max(pressed, 1e-3));
}

}  // namespace ra2d
