// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_face.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/errors.hpp"
#include "host/scene/names.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/prepared_face.hpp"
#include "host/surface/random_map.hpp"
#include "host/surface/random_profile.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

constexpr double drift = 1e-3;  // of a spacing, over a whole map: its points are the nodes

[[noreturn]] void refuse_measured_map(const std::filesystem::path& file, const std::string& why) {
  throw RequestError(fmt::format("{}: {}", file.string(), why));
}

MapQuery map_query_of(const FilePreparation& how) {
  MapQuery query;
  if (how.z_unit) query.z_unit = to_unit(file_units.name(*how.z_unit));
  query.spacing = how.spacing;
  query.spacing_y = how.spacing_y;
  if (how.decimal)
    query.decimal = *how.decimal == FileDecimal::comma ? DecimalMark::comma : DecimalMark::point;
  return query;
}

/// Points of a map along one direction.
struct MapAxis {
  const char *offset_key, *spacing_key;
  double points;       // that it has
  double own;          // m, its spacing
  double spacing;      // m, of the scene
  double offset;       // m, from the nodes' beginning to the map's
  double first, last;  // nodes that it has to give a height
};

void check_map_spacing(const std::filesystem::path& file, const MapAxis& axis) {
  if (std::abs(axis.own - axis.spacing) * axis.points <= drift * axis.spacing) return;
  refuse_measured_map(
      file, fmt::format("its points are {:.10g} m apart, and the nodes {:.10g} m: maps are taken "
                        "node for node: expected {} = {:.10g}, or another map",
                        axis.own, axis.spacing, axis.spacing_key, axis.own));
}

/// Nodes from the nodes' beginning to the map's.
double nodes_to_map(const std::filesystem::path& file, const MapAxis& axis) {
  const double nodes = axis.offset / axis.spacing, whole = std::round(nodes);
  if (!(std::abs(nodes - whole) <= drift))
    refuse_measured_map(
        file, fmt::format("{}: its points fall {:.3g} of a spacing from the nodes, and maps are "
                          "taken node for node: expected {:.10g} m less, or {:.10g} m more",
                          axis.offset_key, std::abs(nodes - whole),
                          (nodes - std::floor(nodes)) * axis.spacing,
                          (std::ceil(nodes) - nodes) * axis.spacing));
  if (whole > axis.first)
    refuse_measured_map(
        file, fmt::format("{}: it begins {:.10g} m behind the first node that is touched: expected "
                          "at least that much less",
                          axis.offset_key, (whole - axis.first) * axis.spacing));
  return whole;
}

/// Height and slope along x of rows of `nx` nodes.
FaceExtent extent_of_rows(const std::vector<double>& heights, std::size_t nx, double spacing) {
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  const double rises = compensated_sum(heights.size(), [&](std::size_t i) {
    return i % nx == 0 ? 0.0 : (heights[i] - heights[i - 1]) * (heights[i] - heights[i - 1]);
  });
  const std::size_t steps = heights.size() - heights.size() / nx;
  return {*high - *low, std::sqrt(rises / static_cast<double>(steps)) / spacing};
}

/// The map with the points that the nodes need.
HeightMap wide_enough(HeightMap map, const SurfaceSpec& spec, const std::filesystem::path& file,
                      double nx, double ny, std::vector<std::string>* doubts) {
  if (nx <= static_cast<double>(map.nx) && ny <= static_cast<double>(map.ny)) return map;
  if (spec.prepared.when_short == ShortProfile::refuse)
    refuse_measured_map(
        file, fmt::format("it has {} by {} points, and up to {:.0f} by {:.0f} are touched: give a "
                          "larger map, or say short = \"repeat\" or \"mirror\"",
                          map.nx, map.ny, nx, ny));
  nx = std::max(nx, static_cast<double>(map.nx));
  ny = std::max(ny, static_cast<double>(map.ny));
  require_map_size(file.string(), nx, ny);
  if (doubts != nullptr)
    doubts->push_back(fmt::format(
        "{}: {} by {} points, fewer than are touched: {}", file.string(), map.nx, map.ny,
        spec.prepared.when_short == ShortProfile::repeat ? "repeated" : "mirrored"));
  const MapExtension how = spec.prepared.when_short == ShortProfile::repeat ? MapExtension::repeat
                                                                            : MapExtension::mirror;
  return extended_map(map, how, static_cast<std::size_t>(nx), static_cast<std::size_t>(ny),
                      file.string());
}

std::vector<double> measured_map(const SurfaceSpec& spec, const MapNodes& nodes,
                                 const std::filesystem::path& file,
                                 std::vector<std::string>* doubts) {
  const FilePreparation& how = spec.prepared;
  HeightMap map;
  std::vector<std::string> odd;
  try {
    map = read_height_map(file, map_query_of(how));
    MapPreparation preparation;
    if (!how.fill.empty()) preparation.fill = to_fill_width(how.fill).value_or(0);
    if (!how.form.empty()) preparation.form = understand_map_form(how.form).value_or(MapForm{});
    prepare_map(map, preparation, file.string(), &odd);
  } catch (const RequestError& fault) {
    throw RequestError(in_keys(fault.what()));
  }
  if (doubts != nullptr)
    for (const std::string& what : odd) doubts->push_back(in_keys(what));
  const MapAxis x{"offset_x",
                  "scene.spacing",
                  static_cast<double>(map.nx),
                  map.spacing,
                  nodes.spacing,
                  how.offset_x.value_or(0),
                  static_cast<double>(nodes.first),
                  static_cast<double>(nodes.nx - 1)};
  const MapAxis y{"offset_y",
                  "scene.spacing_y",
                  static_cast<double>(map.ny),
                  map.spacing_y,
                  nodes.spacing_y,
                  how.offset_y.value_or(nodes.side) - nodes.side,
                  0,
                  static_cast<double>(nodes.rows - 1)};
  for (const MapAxis& axis : {x, y}) check_map_spacing(file, axis);
  const double right = nodes_to_map(file, x), up = nodes_to_map(file, y);
  map = wide_enough(std::move(map), spec, file, x.last - right + 1, y.last - up + 1, doubts);
  std::vector<double> heights;
  heights.reserve(nodes.nx * nodes.rows);
  for (std::size_t j = 0; j < nodes.rows; ++j) {
    const auto row = static_cast<std::size_t>(static_cast<double>(j) - up);
    for (std::size_t i = 0; i < nodes.nx; ++i) {
      const double point = std::max(0.0, static_cast<double>(i) - right);
      heights.push_back(map.at(static_cast<std::size_t>(point), row));
    }
  }
  check_proportion(file, extent_of_rows(heights, nodes.nx, nodes.spacing),
                   {"body", nodes.length, nodes.thickness}, doubts);
  return heights;
}

}  // namespace

std::vector<double> map_face(const SurfaceSpec& spec, const MapNodes& nodes,
                             const std::filesystem::path& scene_file,
                             std::vector<std::string>* doubts) {
  require_map_size("the map", static_cast<double>(nodes.nx), static_cast<double>(nodes.rows));
  switch (spec.kind) {
    case SurfaceKind::gaussian: {
      const double rsm = resolve_random(spec, nodes.length).rsm;
      return random_map(
                 {spec.rq, rsm, spec.rsm_y.value_or(rsm), spec.exact == Exactly::rq, spec.seed},
                 nodes.length, nodes.width, nodes.spacing, nodes.spacing_y, doubts, nodes.nx)
          .heights;
    }
    case SurfaceKind::file:
      return measured_map(spec, nodes, scene_file.parent_path() / spec.path, doubts);
    case SurfaceKind::peaks:
      throw RequestError("an areal scene has no peaks; expected a map");
    case SurfaceKind::flat:
      break;
  }
  return std::vector<double>(nodes.nx * nodes.rows, 0.0);
}

}  // namespace ra2d
