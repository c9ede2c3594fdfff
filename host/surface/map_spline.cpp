// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_spline.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/surface/spline.hpp"
#include "host/system/blocks.hpp"

namespace ra2d {
namespace {

constexpr std::size_t a_block = 64;  // rows or columns

/// A place on the spline through heights z with the curvatures c: z[i] of_z[0] + z[i + 1] of_z[1] +
/// c[i] of_c[0] + c[i + 1] of_c[1].
struct SplinePlace {
  std::size_t i;
  double of_z[2], of_c[2];

  SplinePlace(double place, std::size_t points) {
    const auto last = static_cast<double>(points - 1);
    place = std::clamp(place, -0.5, last + 0.5);
    i = static_cast<std::size_t>(std::clamp(std::floor(place), 0.0, last - 1));
    const double t = place - static_cast<double>(i);
    of_z[0] = 1 - t, of_z[1] = t;
    if (t < 0) {
      of_c[0] = -t / 3, of_c[1] = -t / 6;
    } else if (t > 1) {
      of_c[0] = (t - 1) / 6, of_c[1] = (t - 1) / 3;
    } else {
      const double sixth = -t * (1 - t) / 6;
      of_c[0] = sixth * (2 - t), of_c[1] = sixth * (1 + t);
    }
  }
  double of(const std::vector<double>& z, const std::vector<double>& c) const {
    return of_z[0] * z[i] + of_z[1] * z[i + 1] + of_c[0] * c[i] + of_c[1] * c[i + 1];
  }
};

std::vector<SplinePlace> all_places(const PlacesOnLine& places, std::size_t points) {
  std::vector<SplinePlace> all;
  all.reserve(places.count);
  for (std::size_t k = 0; k < places.count; ++k) all.emplace_back(places[k], points);
  return all;
}

/// Splines along the rows `first` to `first + ny` - 1.
HeightMap along_rows(const HeightMap& map, std::size_t first, std::size_t ny,
                     const PlacesOnLine& x) {
  const std::vector<SplinePlace> places = all_places(x, map.nx);
  HeightMap made{x.count, ny, x.step * map.spacing, map.spacing_y, {}};
  made.heights.resize(x.count * ny);
  in_blocks(ny, a_block, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      const double* const row = &map.heights[(first + j) * map.nx];
      const std::vector<double> z(row, row + map.nx), c = spline_curvatures(z);
      for (std::size_t k = 0; k < x.count; ++k) made.heights[j * x.count + k] = places[k].of(z, c);
    }
  });
  return made;
}

HeightMap along_columns(const HeightMap& map, const PlacesOnLine& y) {
  const std::vector<SplinePlace> places = all_places(y, map.ny);
  HeightMap made{map.nx, y.count, map.spacing, y.step * map.spacing_y, {}};
  made.heights.resize(map.nx * y.count);
  in_blocks(map.nx, a_block, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<double> z(map.ny);
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = 0; j < map.ny; ++j) z[j] = map.at(i, j);
      const std::vector<double> c = spline_curvatures(z);
      for (std::size_t k = 0; k < y.count; ++k) made.heights[k * map.nx + i] = places[k].of(z, c);
    }
  });
  return made;
}

/// The rows that the splines along y need at some places.
struct Rows {
  std::size_t first, end;

  Rows(const HeightMap& map, const PlacesOnLine& y) {
    const auto row = [&](double place) {
      return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(map.ny - 1)));
    };
    const std::size_t low = row(std::floor(y.first)), high = row(std::ceil(y.last()));
    first = low > spline_neighbours ? low - spline_neighbours : 0;
    end = std::min(map.ny, high + spline_neighbours + 1);
  }
};

}  // namespace

HeightMap map_on_spline(const HeightMap& map, const PlacesOnLine& x, const PlacesOnLine& y) {
  const Rows rows(map, y);
  PlacesOnLine in_part = y;
  in_part.first -= static_cast<double>(rows.first);
  return along_columns(along_rows(map, rows.first, rows.end - rows.first, x), in_part);
}

double rows_on_spline(const HeightMap& map, const PlacesOnLine& y) {
  const Rows rows(map, y);
  return static_cast<double>(rows.end - rows.first);
}

double map_spline_miss(const HeightMap& map) {
  double squares = 0;
  std::size_t count = 0;
  const auto add = [&](const std::vector<double>& line) {
    for (const double miss : spline_misses(line)) squares += miss * miss, ++count;
  };
  for (std::size_t j = 0; j < map.ny; ++j) {
    const double* const row = &map.heights[j * map.nx];
    add(std::vector<double>(row, row + map.nx));
  }
  for (std::size_t i = 0; i < map.nx; ++i) {
    std::vector<double> column(map.ny);
    for (std::size_t j = 0; j < map.ny; ++j) column[j] = map.at(i, j);
    add(column);
  }
  return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0;
}

}  // namespace ra2d
