// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/commands.hpp"

namespace ra2d {

void add_surface(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* surface = app.add_subcommand("surface", "rough profiles and height maps");
  surface->require_subcommand(1);
  add_surface_generate(*surface, chosen);
  add_surface_measure(*surface, chosen);
  add_surface_map(*surface, chosen);
}

}  // namespace ra2d
