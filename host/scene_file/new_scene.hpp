// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "host/scene/scene.hpp"
#include "host/scene_file/materials.hpp"

/// A commented scene of a user's case, from a few answers.
namespace ra2d {

/// A number as the scene will have it.
struct GivenNumber {
  double value = 0;  // SI
  std::string toml;
};

struct NewFace {
  enum class Kind { random, profile, map, flat };
  Kind kind = Kind::flat;
  GivenNumber rq, rsm;           // random
  std::filesystem::path file;    // profile or map
  std::string x_unit, z_unit;    // of them, where the file does not say them
  GivenNumber step;              // of the map's points, where the file does not say it
  double length = 0, width = 0;  // m, of the file
  double spacing = 0;            // m, the widest of nodes that shows it
};

struct NewBody {
  const Material* material = nullptr;
  GivenNumber length, width, thickness;
  NewFace face;
};

struct NewScene {
  SceneKind kind = SceneKind::plane;
  NewBody resonator, slider;
  GivenNumber speed, damping,
      duration;      // duration.value = 0: by the path
  std::string load;  // as TOML
  // of an areal scene
  double point_kappa = 1e16;  // Pa/m, as Hertz's point contacts
  double row_spacing = 0;     // m, rows of smooth faces that contacts ask for; 0: not known
};

/// A question about a new scene. Its option takes the same answers.
struct NewSceneQuestion {
  const char* option;  // "--speed"
  const char* type;    // of the option, for the help
  const char* words;
  const char* usual;  // the answer that is taken where none is given
  /// Takes an answer. Throws RequestError that explains what is wrong with it; `scene` is then as
  /// it was.
  void (*take)(NewScene& scene, const std::string& answer);
};

/// In the order in which they are asked: a later answer may need the earlier ones.
std::span<const NewSceneQuestion> new_scene_questions();

/// With the usual answers.
NewScene usual_new_scene(SceneKind kind = SceneKind::plane);

/// The scene as TOML, for a file of this name. Throws RequestError where the answers do not fit
/// together.
std::string new_scene_text(const NewScene& scene, const std::filesystem::path& file);

}  // namespace ra2d
