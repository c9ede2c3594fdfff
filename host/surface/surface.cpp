// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/base/errors.hpp"
#include "host/surface/prepared_face.hpp"
#include "host/surface/profile_file.hpp"
#include "host/surface/random_profile.hpp"

namespace ra2d {
namespace {

using std::numbers::pi;

/// Heights above the flat face the peaks stand on: that face, not their mean, is their mean line.
std::vector<double> peak_heights(const std::vector<Peak>& peaks, int nodes, double spacing) {
  std::vector<double> heights(static_cast<std::size_t>(nodes), 0.0);
  for (const Peak& peak : peaks) {
    // a node more on each side than roundings could leave out
    const auto node_at = [&](double x) {
      return static_cast<int>(std::clamp(x / spacing, -1.0, static_cast<double>(nodes)));
    };
    const int first = std::max(0, node_at(peak.at - peak.half_width) - 1);
    const int last = std::min(nodes - 1, node_at(peak.at + peak.half_width) + 2);
    for (int n = first; n <= last; ++n) {
      const double away = n * spacing - peak.at;
      if (std::abs(away) <= peak.half_width)
        heights[static_cast<std::size_t>(n)] +=
            peak.height / 2 * (1 + std::cos(pi * away / peak.half_width));
    }
  }
  return heights;
}

}  // namespace

int node_count(double length, double spacing) {
  const double spacings = length / spacing;
  // 1e-9 as promised, and the roundings of the two lengths and of their quotient.
  const double slack = 1e-9 + 2 * std::numeric_limits<double>::epsilon() * spacings;
  if (!(spacings >= 0 && spacings < std::numeric_limits<int>::max() - 1))
    throw RequestError(
        fmt::format("a beam of {:.10g} m cannot have nodes every {:.10g} m", length, spacing));
  return static_cast<int>(std::floor(spacings + slack)) + 1;
}

std::vector<double> make_surface(const SurfaceSpec& spec, double length, double spacing,
                                 const std::filesystem::path& scene_file, double thickness,
                                 std::vector<std::string>* doubts) {
  const int nodes = node_count(length, spacing);
  switch (spec.kind) {
    case SurfaceKind::flat:
      break;
    case SurfaceKind::peaks:
      return peak_heights(spec.peaks, nodes, spacing);
    case SurfaceKind::file:
      if (needs_preparation(spec, scene_file.parent_path() / spec.path))
        return prepared_face(spec, scene_file.parent_path() / spec.path, nodes, length, spacing,
                             thickness, doubts);
      return read_profile(scene_file.parent_path() / spec.path, nodes, length, spacing, thickness,
                          doubts);
    case SurfaceKind::gaussian:
      return random_heights(spec, length, nodes, spacing, doubts);
  }
  return std::vector<double>(static_cast<std::size_t>(nodes), 0.0);
}

}  // namespace ra2d
