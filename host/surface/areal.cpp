// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/areal.hpp"

#include <fmt/format.h>

#include "host/base/errors.hpp"

namespace ra2d {
namespace {

/// Of axis x or z.
void check_unit(const std::string& name, const char* format, const char* axis,
                const std::optional<LengthUnit>& unit) {
  if (unit && unit->metres != 1)
    throw RequestError(
        fmt::format("{}: {} is in m, as in every {} file, and in {} by --{}-unit: drop the option",
                    name, axis, format, unit->name, axis));
}

void check_query(const std::string& name, const char* format, const ProfileQuery& query) {
  check_unit(name, format, "x", query.x_unit);
  check_unit(name, format, "z", query.z_unit);
  if (query.spacing)
    throw RequestError(
        fmt::format("{}: --spacing is of texts without x: {} tells its own", name, format));
  if (query.decimal == DecimalMark::comma)
    throw RequestError(
        fmt::format("{}: --decimal is of texts: {} knows no decimal comma", name, format));
}

}  // namespace

GridLine choose_line(const std::filesystem::path& file, const char* format, const Grid& grid,
                     const ProfileQuery& query) {
  const std::string name = file.string();
  check_query(name, format, query);
  if (grid.points == 0 || grid.profiles == 0 || grid.points > most_grid_points ||
      grid.profiles > most_grid_points / grid.points)
    throw RequestError(fmt::format("{}: {} by {} points: expected from 1 to {} of them", name,
                                   grid.points, grid.profiles, most_grid_points));
  if (query.row && query.column)
    throw RequestError(fmt::format("{}: --row and --column: expected one of them", name));
  const auto wrong = [&](const char* option, int value, std::uint64_t most, const char* what) {
    return RequestError(
        fmt::format("{}: --{} {}: the file has the {} 1 to {}", name, option, value, what, most));
  };
  if (grid.profiles == 1 && query.column)
    throw RequestError(fmt::format("{}: --column {}: the file is one profile: drop the option",
                                   name, *query.column));
  if (grid.profiles > 1 && !query.row && !query.column)
    throw RequestError(
        fmt::format("{}: an areal file: say with --row (1 to {}, along x) or --column (1 to {}, "
                    "along y) which profile of it is meant ('ra2d surface map' takes all of it)",
                    name, grid.profiles, grid.points));
  if (query.column) {
    const int column = *query.column;
    if (column < 1 || static_cast<std::uint64_t>(column) > grid.points)
      throw wrong("column", column, grid.points, "columns");
    return {static_cast<std::uint64_t>(column) - 1, grid.points, grid.profiles, grid.dy, true};
  }
  const int row = query.row.value_or(1);
  if (row < 1 || static_cast<std::uint64_t>(row) > grid.profiles)
    throw wrong("row", row, grid.profiles, "rows");
  return {(static_cast<std::uint64_t>(row) - 1) * grid.points, 1, grid.points, grid.dx, false};
}

GridLine whole_grid(const std::filesystem::path& file, const char* format, const Grid& grid,
                    const MapQuery& query, HeightMap& map) {
  const std::string name = file.string();
  check_unit(name, format, "z", query.z_unit);
  if (query.spacing || query.spacing_y)
    throw RequestError(fmt::format("{}: --spacing{} is of files without spacings: {} tells its own",
                                   name, query.spacing ? "" : "-y", format));
  if (query.decimal == DecimalMark::comma)
    throw RequestError(
        fmt::format("{}: --decimal is of texts: {} knows no decimal comma", name, format));
  require_map_size(name, static_cast<double>(grid.points), static_cast<double>(grid.profiles));
  map.nx = grid.points;
  map.ny = grid.profiles;
  map.spacing = grid.dx;
  map.spacing_y = grid.dy;
  return {0, 1, grid.points * grid.profiles, grid.dx, false};
}

void require_heights(const std::filesystem::path& file, const Profile& profile) {
  const std::size_t count = profile.heights.size();
  if (count < 2)
    throw RequestError(fmt::format("{}: a profile of 1 point, expected at least 2", file.string()));
  if (profile.missing() == count)
    throw RequestError(fmt::format("{}: every height is missing", file.string()));
}

}  // namespace ra2d
