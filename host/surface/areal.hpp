// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "host/surface/height_map.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/profile.hpp"

/// Grids of heights, of which a profile is one line, and a map all: common to the readers of SDF
/// and of X3P.
namespace ra2d {

constexpr std::uint64_t most_grid_points = 50'000'000;

/// Heights in rows along x, row after row as the file has them.
struct Grid {
  std::uint64_t points, profiles;  // along x, and rows
  double dx, dy;                   // m; not of an axis that lists its places
};

/// Which heights of a grid are the profile: first, first + stride, ...
struct GridLine {
  std::uint64_t first, stride, count;
  double spacing;  // m
  bool along_y;    // a column
};

/// The line that the query names, or the only one. Throws RequestError where there is no such line,
/// and for options that such a file has no use for: units, spacing, decimal marks.
GridLine choose_line(const std::filesystem::path& file, const char* format, const Grid& grid,
                     const ProfileQuery& query);

/// All points, as one line; `map` gets the sizes and the spacings. Throws RequestError where they
/// are those of no map, and for options that such a file has no use for.
GridLine whole_grid(const std::filesystem::path& file, const char* format, const Grid& grid,
                    const MapQuery& query, HeightMap& map);

/// Throws RequestError for a profile without heights.
void require_heights(const std::filesystem::path& file, const Profile& profile);

}  // namespace ra2d
