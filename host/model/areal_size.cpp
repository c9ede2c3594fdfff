// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/areal_size.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/base/format.hpp"
#include "host/body/body.hpp"
#include "host/surface/random_map.hpp"

namespace ra2d {

double nodes_along(const Scene& scene) {
  return std::round(scene.slider.length / scene.spacing) + 1;
}

double last_node(const Scene& scene) {
  return std::ceil((scene.start + scene.speed * scene.duration) / scene.spacing - 1e-9) +
         nodes_along(scene) - 1;
}

double areal_memory(const Scene& scene) {
  // of a node of the slider: lists of groups, with four lanes; its place among the expanded nodes
  constexpr double lists = 24;  // bytes
  const double rows = map_rows(scene.slider.width, scene.spacing_y.value_or(scene.spacing));
  const double along = nodes_along(scene), beyond = last_node(scene) + 1;
  const double behind = std::floor(scene.start / scene.spacing);
  double maps = along + beyond, tables = along + (beyond - behind) + along, shapes = 0;
  if (scene.faces == Faces::smooth) {
    // curvatures, and what they let cells exceed their ends by; modes along a row of cells
    tables += 2 * (along + beyond - behind);
    maps = 2 * maps + spline_reach;
    constexpr int most_counted = 2000;
    shapes =
        4 * along * (mode_count(scene.resonator, most_counted) + rigid_mode_count(scene.slider));
  }
  return program_memory + rows * (sizeof(double) * (maps + tables) + lists * along) +
         sizeof(double) * shapes;
}

void require_areal_memory(const Scene& scene, double available) {
  const double needed = areal_memory(scene);
  if (needed <= available) return;
  std::string cure = "a smaller slider, or a shorter distance of sliding";
  if (available > 1.5 * program_memory) {
    const double coarser =
        scene.spacing * std::sqrt((needed - program_memory) / (available - program_memory));
    cure = fmt::format(
        "scene.spacing = {:.2g} or more, a smaller slider, or a shorter distance of sliding",
        coarser * 1.05);
  }
  const RequestError fault =
      refusal(scene, "scene.spacing",
              fmt::format("{:g} m: the maps and their tables take {:.3g} GB of memory, and {:.3g} "
                          "GB are free: expected {}",
                          scene.spacing, needed * 1e-9, available * 1e-9, cure));
  throw MemoryShortage(fault.what(), needed);
}

}  // namespace ra2d
