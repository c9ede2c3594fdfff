// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/scene_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>

#include "host/base/errors.hpp"
#include "host/scene/hertz.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/checks.hpp"
#include "host/scene_file/key_table.hpp"
#include "host/scene_file/reader.hpp"
#include "host/scene_file/unit_doubts.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t largest_file = 16u << 20;  // bytes
const std::string linear_faces = "scene.faces=linear";

template <class Part>
Reader read_section(Document& document, const std::string& name, const keys::Keys<Part>& keys,
                    Part& part) {
  Reader in = document.section(name);
  keys::read(keys, in, part);
  return in;
}

/// The values that follow from those of other keys; `first` has those of the scene itself.
void complete(Scene& scene, const Reader& first) {
  if (scene.kind == SceneKind::areal) make_areal(scene);
  if (scene.contact.is_hertz) scene.contact.stiffness = hertz_stiffness(scene);
  if (keys::takes_hertz(scene.contact))
    for (BodySpec* body : {&scene.resonator, &scene.slider})
      if (body->young != 0) body->poisson = body->poisson.value_or(usual_poisson);
  if (is_adaptive(scene)) scene.time.tolerance = scene.time.tolerance.value_or(usual_tolerance);
  if (!first.has("faces"))  // on maps linear ones cost least (docs/accuracy.md)
    scene.faces = scene.kind == SceneKind::areal ? Faces::linear : Faces::smooth;
  if (!first.has("initial"))
    scene.initial = has_equilibrium(scene) ? Initial::statics : Initial::rest;
}

Scene read(Document& document, const std::filesystem::path& file) {
  Scene scene;
  scene.file = file;
  const Reader first = read_section(document, "scene", keys::of_scene(), scene);
  const bool has_kind =
      std::any_of(scene_kinds.words.begin(), scene_kinds.words.end(),
                  [&](const auto& word) { return first.says("kind", word.first); });
  // all other keys depend on it
  if (first.has("kind") && !has_kind) document.require_none();
  if (scene.kind == SceneKind::areal) {  // which of their keys are required depends on it
    scene.resonator.kind = BodyKind::plate;
    scene.slider.kind = BodyKind::block;
  }
  read_section(document, "resonator", keys::of_resonator(), scene.resonator);
  read_section(document, "slider", keys::of_slider(), scene.slider);
  read_section(document, "contact", keys::of_contact(), scene.contact);
  read_section(document, "time", keys::of_time(), scene.time);
  read_section(document, "output", keys::of_output(), scene.output);
  read_section(document, "air", keys::of_air(), scene.air);
  complete(scene, first);
  return scene;
}

void require_size(std::size_t bytes, const std::filesystem::path& file) {
  if (bytes > largest_file)
    throw RequestError(
        fmt::format("{}: 1 fault\n{}: more than 16 MiB: expected a scene, a short "
                    "text (is it another file?)",
                    file.string(), file.string()));
}

}  // namespace

Scene parse_scene(const ParsedText& text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides) {
  Document document{text, file, overrides};
  Scene scene = read(document, file);
  check(scene, document);
  document.finish({});
  return scene;
}

Scene parse_scene(const std::string& text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides) {
  require_size(text.size(), file);
  Document document{text, file, overrides};
  Scene scene = read(document, file);
  check(scene, document);
  const char* const any_spacing =
      "a seed means the same profile at every scene.spacing: drop the key";
  const char* const study = "this is a study: run it with 'ra2d study'";
  const std::map<std::string, std::string> hints = {
      {"base", study},
      {"vary", study},
      {"resonator.surface.seed_spacing", any_spacing},
      {"slider.surface.seed_spacing", any_spacing},
      {"resonator.load",
       "only the slider takes a load (slider.load, or [[resonator.moving_force]])"},
      {"slider.moving_force",
       "only the resonator takes a moving force (slider.load loads the slider)"}};
  try {
    document.finish(hints);
  } catch (const RequestError& fault) {  // what looks odd may be why
    std::string text = fault.what();
    for (const std::string& odd : unit_doubts(scene)) text += "\nlooks odd: " + odd;
    throw RequestError(text);
  }
  scene.places = std::make_shared<const std::map<std::string, std::string>>(document.places());
  return scene;
}

Scene parse_echo(const std::string& text, const std::filesystem::path& file) {
  const bool says_faces = text.find("\nfaces = ") != text.npos;
  return parse_scene(text, file,
                     says_faces ? std::vector<std::string>{} : std::vector{linear_faces});
}

Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return parse_scene(InputFile(file, "the scene").beginning(largest_file + 1), file, overrides);
}

}  // namespace ra2d
