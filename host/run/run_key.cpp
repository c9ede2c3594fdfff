// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run_key.hpp"

#include <fmt/format.h>

#include "host/device/backend.hpp"
#include "host/hash.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {

std::string run_key(const Model& model) {
  Scene scene = without_origins(model.scene);
  for (BodySpec* body : {&scene.resonator, &scene.slider})
    body->surface.path.clear();  // its heights tell more
  const std::string text =
      fmt::format("numerics {}\n{}\n{}", numerics_version, arithmetic(), echo(scene));
  Hash hash;
  hash.add(text);
  for (const std::vector<double>* height : {&model.resonator_height, &model.slider_height}) {
    hash.add(fmt::format("\n{} heights\n", height->size()));
    hash.add(height->data(), height->size());
  }
  return hash.text();
}

}  // namespace ra2d
