// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/surface.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "host/errors.hpp"
#include "host/surface/gaussian.hpp"
#include "host/surface/measured_surface.hpp"
#include "host/surface/profile_file.hpp"

namespace ra2d {
namespace {

constexpr double pi = std::numbers::pi;

/// Heights above the flat face the peaks stand on: that face, not their mean, is their mean line.
std::vector<double> peak_heights(const std::vector<Peak>& peaks, int nodes, double spacing) {
  std::vector<double> heights(static_cast<std::size_t>(nodes), 0.0);
  for (const Peak& peak : peaks)
    for (int n = 0; n < nodes; ++n) {
      const double away = n * spacing - peak.at;
      if (std::abs(away) <= peak.half_width)
        heights[static_cast<std::size_t>(n)] +=
            peak.height / 2 * (1 + std::cos(pi * away / peak.half_width));
    }
  return heights;
}

/// A Gaussian process crosses its mean line upwards every 2 pi sqrt(C(0)/-C''(0)) on average
/// (Rice): sqrt(2) pi l for C(x) = rq^2 exp(-(x/l)^2).
double correlation_length(const SurfaceSpec& spec) {
  const double length = spec.correlation_length ? *spec.correlation_length
                        : spec.rsm              ? *spec.rsm / (std::sqrt(2.0) * pi)
                                                : 0;
  if (!(length > 0) || !std::isfinite(length))
    throw RequestError("a gaussian surface needs a positive rsm or correlation_length in metres");
  return length;
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
      if (spec.profile != ProfileSpec{})
        return measured_heights(scene_file.parent_path() / spec.path, spec.profile, nodes, length,
                                spacing, thickness);
      return read_profile(scene_file.parent_path() / spec.path, nodes, length, spacing, thickness,
                          doubts);
    case SurfaceKind::gaussian:
      return gaussian_heights(spec.rq, correlation_length(spec), spec.seed, length, nodes, spacing);
  }
  return std::vector<double>(static_cast<std::size_t>(nodes), 0.0);
}

}  // namespace ra2d
