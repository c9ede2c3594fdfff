// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/key_table.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {

std::string surface_text(const SurfaceSpec& surface, const std::filesystem::path& folder) {
  Scene scene;
  scene.file = folder / "scene.toml";
  return keys::inline_table(keys::of_surface(), surface, scene);
}

std::string echo(const Scene& scene) {
  std::string text = "[scene]\n" + keys::written(keys::of_scene(), scene, scene);
  text += "\n[resonator]\n" + keys::written(keys::of_resonator(), scene.resonator, scene);
  const bool is_rigid = scene.resonator.support == Support::rigid;
  for (const MovingForce& force : scene.resonator.moving_forces)
    text += fmt::format("\n[[resonator.moving_force]]{}\n{}",
                        is_rigid ? "  # not used: the body is rigid" : "",
                        keys::written(keys::of_moving_force(), force, scene));
  text += "\n[slider]\n" + keys::written(keys::of_slider(), scene.slider, scene);
  text += "\n[contact]\n" + keys::written(keys::of_contact(), scene.contact, scene);
  text += "\n[time]\n" + keys::written(keys::of_time(), scene.time, scene);
  text += "\n[output]\n" + keys::written(keys::of_output(), scene.output, scene);
  if (const std::string air = keys::written(keys::of_air(), scene.air, scene); !air.empty())
    text += "\n[air]\n" + air;
  return text;
}

}  // namespace ra2d
