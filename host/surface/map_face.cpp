// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_face.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "host/base/errors.hpp"
#include "host/scene/names.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/map_spline.hpp"
#include "host/surface/prepared_face.hpp"
#include "host/surface/profile.hpp"
#include "host/surface/random_map.hpp"
#include "host/surface/random_profile.hpp"
#include "host/surface/sum.hpp"
#include "host/surface/usual_faces.hpp"

namespace ra2d {
namespace {

constexpr double drift = 1e-3;           // of a spacing, over a whole map: its points are the nodes
constexpr double unknown_between = 0.1;  // of Sq, that a spline through every other point misses

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

/// A map and the nodes along one direction.
struct MapAxis {
  const char* offset_key;
  double points;       // that the map has
  double own;          // m, its spacing
  double spacing;      // m, of the nodes
  double offset;       // m, from the nodes' beginning to the map's
  double within;       // of a spacing: where in its strip a point or a node stands
  double first, last;  // nodes that need a height

  /// Whether each node from the map's beginning on stands on a point.
  bool is_on_points() const {
    const double nodes = offset / spacing;
    return std::abs(own - spacing) * points <= drift * spacing &&
           std::abs(nodes - std::round(nodes)) <= drift;
  }
  /// The nodes 0 ... last among the map's points.
  PlacesOnLine places() const {
    const auto count = static_cast<std::size_t>(last) + 1;
    if (is_on_points()) return {-std::round(offset / spacing), 1, count};
    return {(within * spacing - offset) / own - within, spacing / own, count};
  }
};

/// Where the nodes stand among the map's points. The map may begin up to half a spacing behind
/// them.
PlacesOnLine places_on_map(const std::filesystem::path& file, const MapAxis& axis) {
  const PlacesOnLine places = axis.places();
  const double before = -0.5 - places[static_cast<std::size_t>(axis.first)];
  if (before > drift)
    refuse_measured_map(
        file, fmt::format("{}: it begins {:.10g} m behind the first node that is touched: expected "
                          "at least that much less",
                          axis.offset_key,
                          (axis.is_on_points() ? std::ceil(before) : before) * axis.own));
  return places;
}

/// Part of a grid, from place to place along x and along y. A point is 1 from the next.
struct GridPart {
  double left, right, low, high;
};

/// Root mean square slope along x or y of a part of heights in rows of `nx`. A step that lies half
/// in the part counts by half.
double slope_of(const std::vector<double>& heights, std::size_t nx, const GridPart& part,
                bool along_y, double spacing) {
  const auto whole = [](double place) { return static_cast<std::size_t>(place); };
  const std::size_t left = whole(part.left), low = whole(part.low);
  const std::size_t right = whole(std::ceil(part.right)) + (along_y ? 1 : 0),
                    high = whole(std::ceil(part.high)) + (along_y ? 0 : 1);
  const std::size_t step = along_y ? nx : 1;
  const double from = along_y ? part.low : part.left, to = along_y ? part.high : part.right;
  double squares = 0, steps = 0;
  for (std::size_t j = low; j < high; ++j)
    for (std::size_t i = left; i < right; ++i) {
      const double rise = heights[j * nx + i + step] - heights[j * nx + i];
      const auto begin = static_cast<double>(along_y ? j : i);
      const double share = std::min(begin + 1, to) - std::max(begin, from);
      squares += share * rise * rise;
      steps += share;
    }
  return steps > 0 ? std::sqrt(squares / steps) / spacing : 0;
}

/// The map with the points that the nodes need: `touched` along x and along y, `wanted` where it
/// goes on.
HeightMap wide_enough(HeightMap map, const SurfaceSpec& spec, const std::filesystem::path& file,
                      std::pair<double, double> touched, std::pair<double, double> wanted,
                      std::vector<std::string>* doubts) {
  const bool is_short =
      touched.first > static_cast<double>(map.nx) || touched.second > static_cast<double>(map.ny);
  const bool repeats = spec.prepared.when_short == ShortProfile::repeat;
  if (spec.prepared.when_short == ShortProfile::refuse) {
    if (!is_short) return map;
    refuse_measured_map(
        file, fmt::format("it has {} by {} points, and up to {:.0f} by {:.0f} are touched: give a "
                          "larger map, or say short = \"repeat\" or \"mirror\"",
                          map.nx, map.ny, touched.first, touched.second));
  }
  if (doubts != nullptr && is_short)
    doubts->push_back(fmt::format("{}: {} by {} points, fewer than are touched: {}", file.string(),
                                  map.nx, map.ny, repeats ? "repeated" : "mirrored"));
  const double nx = std::max(wanted.first, static_cast<double>(map.nx)),
               ny = std::max(wanted.second, static_cast<double>(map.ny));
  require_map_size(file.string(), nx, ny);
  return extended_map(map, repeats ? MapExtension::repeat : MapExtension::mirror,
                      static_cast<std::size_t>(nx), static_cast<std::size_t>(ny), file.string());
}

/// How many of the nodes that are welcome behind the last of these a map has: as far as its points
/// go, or all where it goes on.
std::size_t nodes_beyond(const HeightMap& map, const FilePreparation& how, const PlacesOnLine& x,
                         std::size_t welcome) {
  if (how.when_short != ShortProfile::refuse) return welcome;
  const double free = (static_cast<double>(map.nx - 1) - x.last()) / x.step;
  return static_cast<std::size_t>(std::clamp(std::floor(free), 0.0, static_cast<double>(welcome)));
}

/// The heights of the points on which the nodes stand; before the first one it is level.
std::vector<double> points_at(const HeightMap& map, const PlacesOnLine& x, const PlacesOnLine& y) {
  std::vector<double> heights;
  heights.reserve(x.count * y.count);
  for (std::size_t j = 0; j < y.count; ++j)
    for (std::size_t i = 0; i < x.count; ++i)
      heights.push_back(
          map.at(static_cast<std::size_t>(std::max(0.0, x[i])), static_cast<std::size_t>(y[j])));
  return heights;
}

/// The nodes that stand on the map.
GridPart part_on_face(const MapRows& rows) {
  return {static_cast<double>(rows.first), static_cast<double>(rows.nx - 1), 0,
          static_cast<double>(rows.heights.size() / rows.nx - 1)};
}

/// Doubts where the nodes stand between the points: waves that the nodes are too far apart for, and
/// heights that the map does not know.
void doubt_between(const std::filesystem::path& file, const HeightMap& map, const PlacesOnLine& x,
                   const PlacesOnLine& y, const MapRows& rows, const MapAxis& along,
                   const MapAxis& across, std::vector<std::string>& doubts) {
  const auto on_map = [](double place, std::size_t points) {
    return std::clamp(place, 0.0, static_cast<double>(points - 1));
  };
  const GridPart of_points{on_map(x[rows.first], map.nx), on_map(x.last(), map.nx),
                           on_map(y.first, map.ny), on_map(y.last(), map.ny)};
  for (const bool along_y : {false, true}) {
    const MapAxis& axis = along_y ? across : along;
    if (!(axis.own < axis.spacing)) continue;
    const double own = slope_of(map.heights, map.nx, of_points, along_y, axis.own),
                 slope = slope_of(rows.heights, rows.nx, part_on_face(rows), along_y, axis.spacing);
    if (!(slope < (1 - most_slope_lost) * own)) continue;
    doubts.push_back(fmt::format(
        "{}: nodes {:.4g} m apart along {} show a root mean square slope of {:.3g}, {:.0f} % less "
        "than the points, {:.4g} m apart: shorter waves are cut. A scene.{} nearer to the points "
        "shows them",
        file.string(), axis.spacing, along_y ? 'y' : 'x', slope, 100 * (1 - slope / own), axis.own,
        along_y ? "spacing_y" : "spacing"));
  }
  for (const auto& [axis, which, key] :
       {std::tuple{&along, "points along x", "spacing"}, std::tuple{&across, "rows", "spacing_y"}})
    if (axis->own > usual_faces::coarse_nodes * axis->spacing)
      doubts.push_back(
          fmt::format("{}: its {} are {:.6g} m apart, {:.0f} nodes of the scene: is "
                      "its {} in metres?",
                      file.string(), which, axis->own, axis->own / axis->spacing, key));
  if (along.own <= along.spacing && across.own <= across.spacing) return;
  const double miss = map_spline_miss(map),
               rms = std::sqrt(
                   compensated_sum(map.heights.size(),
                                   [&](std::size_t i) { return map.heights[i] * map.heights[i]; }) /
                   static_cast<double>(map.heights.size()));
  if (miss > unknown_between * rms)
    doubts.push_back(fmt::format(
        "{}: a spline through every other point misses those between by {:.2g} m, root mean "
        "square, {:.0f} % of Sq: between its points this face is little known. A finer map is "
        "needed, or a scene.spacing no finer than the map's",
        file.string(), miss, 100 * miss / rms));
}

MapRows measured_map(const SurfaceSpec& spec, const MapNodes& nodes,
                     const std::filesystem::path& file, std::vector<std::string>* doubts) {
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
  const MapAxis along{"offset_x",
                      static_cast<double>(map.nx),
                      map.spacing,
                      nodes.spacing,
                      how.offset_x.value_or(0),
                      0,
                      static_cast<double>(nodes.first),
                      static_cast<double>(nodes.nx - 1)};
  const MapAxis across{"offset_y",
                       static_cast<double>(map.ny),
                       map.spacing_y,
                       nodes.spacing_y,
                       how.offset_y.value_or(nodes.side) - nodes.side,
                       0.5,
                       0,
                       static_cast<double>(nodes.rows - 1)};
  PlacesOnLine x = places_on_map(file, along);
  const PlacesOnLine y = places_on_map(file, across);
  const auto points = [](const PlacesOnLine& places) {
    return std::ceil(places.last() + 0.5 - drift);
  };
  const std::pair touched{points(x), points(y)};
  x.count += nodes_beyond(map, how, x, nodes.beyond);
  const bool on_points = along.is_on_points() && across.is_on_points();
  // where the map goes on, a spline feels neither the run's end nor the slider's side
  const double felt = on_points ? 0 : spline_neighbours;
  map = wide_enough(std::move(map), spec, file, touched, {points(x) + felt, points(y) + felt},
                    doubts);
  if (!on_points)
    require_map_size(file.string(), static_cast<double>(x.count), rows_on_spline(map, y));
  MapRows rows;
  rows.nx = x.count;
  rows.first = static_cast<std::size_t>(
      std::clamp(std::ceil(-x.first / x.step), 0.0, static_cast<double>(nodes.first)));
  rows.heights = on_points ? points_at(map, x, y) : map_on_spline(map, x, y).heights;
  if (!on_points && doubts != nullptr) doubt_between(file, map, x, y, rows, along, across, *doubts);
  const auto [low, high] = std::minmax_element(rows.heights.begin(), rows.heights.end());
  const auto slope_along = [&](bool along_y, double spacing) {
    return slope_of(rows.heights, rows.nx, part_on_face(rows), along_y, spacing);
  };
  const double slope =
      std::max(slope_along(false, nodes.spacing), slope_along(true, nodes.spacing_y));
  check_proportion(file, {*high - *low, slope}, {"body", nodes.length, nodes.thickness}, doubts);
  return rows;
}

}  // namespace

MapRows map_face(const SurfaceSpec& spec, const MapNodes& nodes,
                 const std::filesystem::path& scene_file, std::vector<std::string>* doubts) {
  require_map_size("the map", static_cast<double>(nodes.nx), static_cast<double>(nodes.rows));
  MapRows rows;
  rows.nx = nodes.nx + nodes.beyond;
  switch (spec.kind) {
    case SurfaceKind::gaussian: {
      const double rsm = resolve_random(spec, nodes.length).rsm;
      rows.heights =
          random_map({spec.rq, rsm, spec.rsm_y.value_or(rsm), spec.exact == Exactly::rq, spec.seed},
                     nodes.length, nodes.width, nodes.spacing, nodes.spacing_y, doubts, rows.nx)
              .heights;
      return rows;
    }
    case SurfaceKind::file:
      return measured_map(spec, nodes, scene_file.parent_path() / spec.path, doubts);
    case SurfaceKind::peaks:
      throw RequestError("an areal scene has no peaks; expected a map");
    case SurfaceKind::flat:
      break;
  }
  rows.heights.assign(rows.nx * nodes.rows, 0.0);
  return rows;
}

}  // namespace ra2d
