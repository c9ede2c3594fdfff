// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/system/machine_memory.hpp"

/// Faces of areal bodies: heights on a grid.
namespace ra2d {

/// Heights in rows of constant y: that of point i of row j is heights[j * nx + i]. x runs along the
/// sliding direction.
struct HeightMap {
  std::size_t nx = 0, ny = 0;         // points of a row, and rows
  double spacing = 0, spacing_y = 0;  // m, from point to point and from row to row
  std::vector<double> heights;        // m, NaN where a point is missing
  std::string doubt{};                // a sentence where something looks wrong in the file

  double at(std::size_t i, std::size_t j) const { return heights[j * nx + i]; }
  std::size_t missing() const;
};

/// More points than that are no map: 800 MB of heights.
constexpr double most_map_points = 1e8;

/// Throws RequestError where a map of so many points is none (fewer than two in a row, one row,
/// more than most_map_points) or takes more than 0.4 of the memory [bytes]. To be asked before
/// memory is taken. `name` begins the message: a file, or an option.
void require_map_size(const std::string& name, double nx, double ny,
                      std::int64_t most_memory = machine_memory());

/// Moves the heights to mean zero; returns what the mean was [m]. None of them may be missing.
double subtract_map_mean(HeightMap& map);

/// Fills missing points. A point gets the height of the straight line through its gap along x or
/// along y, whichever is narrower, and at most `width` [m] wide: each missing point is a spacing.
/// Lines begin and end at measured points. Throws RequestError, with the first such point, where
/// neither gap is narrow enough or both reach the map's edge; with a width of 0 for any.
void fill_map_gaps(HeightMap& map, double width, const std::string& name);

/// The shape that a map loses: by least squares, a polynomial in x and y of a total degree. 0 is
/// the mean, 1 a plane.
struct MapForm {
  static constexpr int none = -1, highest = 10;
  int degree = none;
};

/// Of `none`, `mean`, `plane` or `poly:N`; nothing for anything else.
std::optional<MapForm> understand_map_form(std::string_view text);

/// Takes the form off. Exact to roundings for a polynomial of its degree. No point may be missing.
void remove_map_form(HeightMap& map, MapForm form);

/// How a map goes on beyond its edges.
enum class MapExtension {
  repeat,  // copies one after another, faded into one another as a repeated profile is
  mirror   // each copy is the mirror image of the one before it: nothing jumps or fades
};

/// The map on `nx` by `ny` points of the same spacings, from its first point on. Less than it has
/// is a part of it. Throws RequestError as require_map_size does. No point may be missing.
HeightMap extended_map(const HeightMap& map, MapExtension how, std::size_t nx, std::size_t ny,
                       const std::string& name);

}  // namespace ra2d
