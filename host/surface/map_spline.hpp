// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

#include "host/surface/height_map.hpp"

/// Heights between the points of a map.
namespace ra2d {

/// Places along a line of points: the k-th stands at first + k step. The first point stands at 0,
/// and the distance of two points is 1.
struct PlacesOnLine {
  double first = 0, step = 1;
  std::size_t count = 0;

  double operator[](std::size_t k) const { return first + step * static_cast<double>(k); }
  double last() const { return (*this)[count - 1]; }
};

/// Points further away than that move a spline by less than a rounding: their weight falls by 3.7
/// from point to point.
constexpr std::size_t spline_neighbours = 40;

/// The map's bicubic spline at each place along x in each place along y, as a map of that many
/// points: cubic splines along x (spline_curvatures), and along y through what these give. On a
/// point of the map it has the map's bits. Beyond the outermost points it goes on straight for half
/// a distance, to where the strips around them end, and then level. No point may be missing.
HeightMap map_on_spline(const HeightMap& map, const PlacesOnLine& x, const PlacesOnLine& y);

/// Rows of the map that this takes: it needs memory for as many of x.count points.
double rows_on_spline(const HeightMap& map, const PlacesOnLine& y);

/// Root mean square of what splines along rows and columns through every other point miss the
/// points between by [m]: some sixteen times what the map's own spline is off by, where the map is
/// smooth from point to point.
double map_spline_miss(const HeightMap& map);

}  // namespace ra2d
