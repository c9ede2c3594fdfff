// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/face_choices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/errors.hpp"
#include "host/plan/expected_work.hpp"
#include "host/scene/names.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/surface/spline.hpp"
#include "host/surface/surface.hpp"

namespace ra2d {
namespace {

/// Errors of linear faces are about these times (spacing/width of a contact)^2, and no larger than
/// the second number. Where nodes pass faster than a shock lasts, their kinks average out in
/// proportion. Fitted to runs of the paper's scene at 4e12 to 1e17 Pa/m and 1 to 32 um
/// (bench/smooth_faces_convergence.csv, to which tests/host/test_face_choices.cpp holds them).
constexpr double linear_level = 0.05, most_level = 0.1, linear_rate = 8, most_rate = 1,
                 linear_duration = 2, most_duration = 0.8;
/// Errors of smooth faces, over what their splines are off by. On a fractal profile rates moved by
/// some 5 % and 10 % where it was 0.09 and 0.2, durations by less, levels by 0.2 dB. On faces
/// without corners these are bounds: on the paper's, neither rates nor durations moved by more than
/// chance (5 %) at 192 um.
constexpr double smooth_level = 0.25, smooth_shocks = 1;
/// Spacings of either kind that are looked at, and nodes of both bodies together.
constexpr int most_finer = 3, most_wider = 4;
constexpr double most_nodes_looked_at = 4e6;
/// Costs that differ by less are alike.
constexpr double alike = 1.05;

constexpr double infinity = std::numeric_limits<double>::infinity();

bool holds(const FaceChoice& choice) { return choice.errors.most() <= face_accuracy; }

/// The scene's choices, one by one.
class Chooser {
 public:
  Chooser(const Model& model, const UsualContact& contact) : model_{model}, contact_{contact} {}

  /// Adds a choice and returns whether it holds; nothing where the scene cannot have it.
  std::optional<bool> add(Faces faces, double spacing) {
    FaceChoice choice{faces, spacing};
    Scene scene = model_.scene;
    choice.is_own = faces == scene.faces && spacing == scene.spacing;
    scene.faces = faces;
    scene.spacing = spacing;
    try {
      if (!choice.is_own && !can_be(scene)) return std::nullopt;
      choice.errors = faces == Faces::smooth
                          ? smooth_errors(spline_errors(scene))
                          : linear_errors(spacing, contact_.width, scene.speed * contact_.duration);
    } catch (const RequestError&) {  // of a measured face, too wide a spacing
      return std::nullopt;
    }
    choice.seconds = expected_work(scene, contact_).seconds();
    found_.push_back(choice);
    return holds(choice);
  }

  /// Adds the scene's spacing; finer ones until one holds, or wider ones while they hold.
  void add_all(Faces faces) {
    const double own = model_.scene.spacing;
    const std::optional<bool> first = add(faces, own);
    if (!first) return;
    if (*first)
      for (int k = 1; k <= most_wider && add(faces, own * std::exp2(k)).value_or(false);) ++k;
    // under multipliers finer linear ones do not help
    else if (faces == Faces::smooth || contact_.width > 0)
      for (int k = 1; k <= most_finer && !add(faces, own * std::exp2(-k)).value_or(true);) ++k;
  }

  std::vector<FaceChoice> found() const { return found_; }

 private:
  bool can_be(const Scene& scene) const {
    if ((scene.resonator.length + scene.slider.length) / scene.spacing > most_nodes_looked_at)
      return false;
    parse_scene(echo(scene), scene.file);
    return true;
  }

  /// Of both faces together.
  double spline_errors(const Scene& scene) const {
    if (scene.spacing == model_.scene.spacing)
      return std::max(spline_error(model_.resonator_height), spline_error(model_.slider_height));
    double most = 0;
    for (const BodySpec* body : {&scene.resonator, &scene.slider})
      most = std::max(most, spline_error(make_surface(body->surface, body->length, scene.spacing,
                                                      scene.file, body->thickness)));
    return most;
  }

  const Model& model_;
  UsualContact contact_;
  std::vector<FaceChoice> found_;
};

}  // namespace

double FaceErrors::most() const { return std::max({level, rate, duration}); }

FaceErrors linear_errors(double spacing, double width, double sliding_distance) {
  // under multipliers a contact is one node, whatever the spacing: shocks go with it
  if (width == 0) return {infinity, infinity, infinity};
  const double square = std::pow(spacing / width, 2);
  const double felt = sliding_distance > 0 ? std::min(1.0, spacing / sliding_distance) : 1.0;
  return {.level = std::min(most_level, linear_level * square),
          .rate = std::min(most_rate, linear_rate * square * felt),
          .duration = std::min(most_duration, linear_duration * square * felt)};
}

FaceErrors smooth_errors(double off) {
  return {.level = std::min(most_level, smooth_level * off),
          .rate = std::min(most_rate, smooth_shocks * off),
          .duration = std::min(most_duration, smooth_shocks * off)};
}

FaceChoices choose_faces(const Model& model, const Asperities& asperities) {
  const bool springs = model.scene.contact.law == ContactLaw::penalty;
  FaceChoices found;
  if (asperities.radius == 0 || (springs && !(asperities.width > 0))) return found;
  Chooser chooser(model, {asperities.width, asperities.springs.duration});
  chooser.add_all(Faces::linear);
  chooser.add_all(Faces::smooth);
  found.list = chooser.found();
  double least = infinity;
  for (const FaceChoice& choice : found.list)
    if (holds(choice)) least = std::min(least, choice.seconds);
  for (const FaceChoice& choice : found.list)
    if (holds(choice) && choice.seconds <= alike * least &&
        (!found.best || choice.errors.most() < found.best->errors.most()))
      found.best = choice;
  return found;
}

std::string set_words(const FaceChoice& choice) {
  return fmt::format("--set scene.faces={} --set scene.spacing={}", face_choices.name(choice.faces),
                     choice.spacing);
}

std::string faces_text(Faces faces, double spacing) {
  return fmt::format("{}, {:g} um", face_choices.name(faces), spacing * 1e6);
}

}  // namespace ra2d
