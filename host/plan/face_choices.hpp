// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/plan/asperities.hpp"

/// Faces and spacings that a scene could have: how far off each makes the answer, and what it
/// costs. Estimates; `plan --accuracy` measures them by runs.
namespace ra2d {

/// Each error is relative and about the most: of the level as a velocity, of the rate of shocks and
/// of their median duration.
struct FaceErrors {
  double level = 0, rate = 0, duration = 0;
  double most() const;
};

struct FaceChoice {
  Faces faces = Faces::linear;
  double spacing = 0;  // m
  FaceErrors errors;
  double seconds = 0;  // of one core, a whole run
  bool is_own = false;
};

struct FaceChoices {
  std::vector<FaceChoice> list;    // empty where nothing is known of the contacts
  std::optional<FaceChoice> best;  // the cheapest that holds `face_accuracy`
};

/// The accuracy that the recommended choice holds.
inline constexpr double face_accuracy = 0.02;

/// Linear faces of the scene's spacing and finer ones, smooth faces of its spacing and wider ones,
/// as far as they may hold. Of choices whose costs differ by less than a twentieth the most
/// accurate one is best.
FaceChoices choose_faces(const Model& model, const Asperities& asperities);

/// Linear faces of nodes so far apart, where a contact is `width` [m] wide (0: under multipliers)
/// and the slider moves on by `sliding_distance` [m] while a shock lasts.
FaceErrors linear_errors(double spacing, double width, double sliding_distance);

/// Smooth faces whose splines are off by `off` of the root mean square height.
FaceErrors smooth_errors(double off);

/// The words that make the choice: "--set scene.faces=smooth --set scene.spacing=3.2e-05".
std::string set_words(const FaceChoice& choice);

/// For tables, e.g. "smooth, 32 um".
std::string faces_text(Faces faces, double spacing);

}  // namespace ra2d
