// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/surface/height_map.hpp"

namespace ra2d {

/// A Gaussian random map. Its heights have the correlation exp(-(x/l)^2 - (y/l_y)^2), with
/// l = rsm/(sqrt(2) pi) and l_y = rsm_y/(sqrt(2) pi): lines along x and along y cross their mean
/// upwards every rsm and rsm_y on average (Rice 1945).
struct RandomMap {
  double rq = 0;      // m, root mean square height
  double rsm = 0;     // m, mean spacing of the profile elements along x
  double rsm_y = 0;   // m, along y. Infinite: every row is the random profile of the seed
  bool exact = true;  // rq holds over the area, not only in expectation
  std::uint64_t seed = 0;
};

/// Rows of a map of `width` [m] at steps of `spacing_y` [m].
double map_rows(double width, double spacing_y);

/// The map on an area of `length` by `width` [m]: point i of row j stands at x = i spacing,
/// y = (j + 1/2) spacing_y, so that rows are the middles of strips. A smooth function of x and y
/// that the seed and the four lengths fix, its mean over the area 0: other grids see other points
/// of the same one. The same bits on every platform, whatever the threads; a point's bits are those
/// of its x and y, whatever the grid. `doubts` takes a sentence where points are too far apart to
/// show the slope. `nx` points of a row are made, also behind the length, or as many as it has room
/// for. Throws RequestError for waves of fewer than four points, for a map that is bent
/// rather than rough, and as require_map_size does.
HeightMap random_map(const RandomMap& map, double length, double width, double spacing,
                     double spacing_y, std::vector<std::string>* doubts = nullptr,
                     std::optional<std::size_t> nx = {});

}  // namespace ra2d
