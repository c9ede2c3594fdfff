// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/surface/map_npy.hpp"
#include "host/surface/map_text.hpp"
#include "host/surface/profile_sdf.hpp"
#include "host/surface/profile_x3p.hpp"
#include "host/surface/sum.hpp"
#include "host/surface/usual_faces.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

constexpr double highest_in_metres = 1e-3;  // m, peak to valley of numbers without a unit
constexpr double much_tilt = 0.5;           // of the mean square height
constexpr double widest_spacing = 1e-3;     // m, of points that show a rough face

[[noreturn]] void refuse_map(const std::filesystem::path& file, const std::string& why) {
  throw RequestError(fmt::format("{}: {}", file.string(), why));
}

/// A spacing of the file or the user's.
double agreed_spacing(const std::filesystem::path& file, const char* option,
                      const std::optional<double>& own, const std::optional<double>& given) {
  if (own && given && *own != *given)
    refuse_map(file, fmt::format("the header has a spacing of {:g} m, and {} says {:g} m: drop the "
                                 "option",
                                 *own, option, *given));
  return own ? *own : given.value_or(0);
}

/// Throws where numbers that nobody gave a unit cannot be metres.
void require_metres(const std::filesystem::path& file, const HeightMap& map) {
  double low = quiet_nan, high = quiet_nan, squares = 0, steps = 0;
  for (std::size_t j = 0; j < map.ny; ++j)
    for (std::size_t i = 0; i < map.nx; ++i) {
      const double z = map.at(i, j);
      low = std::fmin(low, z);
      high = std::fmax(high, z);
      const double rise = i > 0 ? z - map.at(i - 1, j) : quiet_nan;
      if (!std::isnan(rise)) squares += rise * rise, ++steps;
    }
  const double slope = steps > 0 ? std::sqrt(squares / steps) / map.spacing : 0;
  if (high - low > highest_in_metres || slope > usual_faces::steepest)
    refuse_map(file, fmt::format("heights span {:.6g} with slopes of {:.3g}, without a unit: too "
                                 "much for metres. Say with --z-unit what they are in (--z-unit m, "
                                 "if they are)",
                                 high - low, slope));
}

double mean_square(const HeightMap& map) {
  return compensated_sum(map.heights.size(),
                         [&](std::size_t i) { return map.heights[i] * map.heights[i]; }) /
         static_cast<double>(map.heights.size());
}

/// Root mean square.
double map_slope(const HeightMap& map, bool along_y) {
  const std::size_t step = along_y ? map.nx : 1;
  double squares = 0;
  for (std::size_t i = step; i < map.heights.size(); ++i) {
    const double rise = map.heights[i] - map.heights[i - step];
    if (along_y || i % map.nx != 0) squares += rise * rise;
  }
  const auto rises = static_cast<double>(map.heights.size() - (along_y ? map.nx : map.ny));
  return rises > 0 ? std::sqrt(squares / rises) / (along_y ? map.spacing_y : map.spacing) : 0;
}

}  // namespace

HeightMap to_height_map(const std::filesystem::path& file, BareMap bare, const MapQuery& query) {
  if (bare.unit && query.z_unit && bare.unit->metres != query.z_unit->metres)
    refuse_map(file, fmt::format("the heights are in {} by the header, and in {} by --z-unit: mend "
                                 "the header, or drop the option",
                                 bare.unit->name, query.z_unit->name));
  HeightMap map{bare.nx, bare.ny, 0, 0, std::move(bare.numbers), std::move(bare.doubt)};
  map.spacing = agreed_spacing(file, "--spacing", bare.spacing, query.spacing);
  map.spacing_y =
      agreed_spacing(file, "--spacing-y", bare.spacing_y,
                     query.spacing_y || bare.spacing_y ? query.spacing_y : query.spacing);
  if (!(map.spacing > 0))
    refuse_map(file,
               "the file has no spacing: give that along x with --spacing, and that between rows "
               "with --spacing-y [as --spacing]");
  if (!(map.spacing_y > 0)) map.spacing_y = map.spacing;
  const bool has_unit = bare.unit || query.z_unit;
  if (!has_unit) require_metres(file, map);
  const double metres = bare.unit ? bare.unit->metres : has_unit ? query.z_unit->metres : 1;
  if (metres != 1)
    for (double& z : map.heights) z *= metres;
  return map;
}

HeightMap read_height_map(const std::filesystem::path& file, const MapQuery& query) {
  HeightMap map;
  if (begins_as_npy(InputFile(file, "the map").beginning(8))) {
    if (query.decimal != DecimalMark::of_the_file)
      refuse_map(file, "--decimal is of texts: drop the option");
    map = to_height_map(file, read_map_npy(file), query);
  } else {
    switch (format_of(file)) {
      case ProfileFormat::sdf:
        map = read_map_sdf(file, query);
        break;
      case ProfileFormat::x3p:
        map = read_map_x3p(file, query);
        break;
      case ProfileFormat::text:
        require_text(file);
        map = to_height_map(file, read_map_text(file, query.decimal), query);
        break;
    }
  }
  if (map.missing() == map.heights.size()) refuse_map(file, "every height is missing");
  require_possible_heights(file, map.heights);
  return map;
}

void prepare_map(HeightMap& map, const MapPreparation& how, const std::string& name,
                 std::vector<std::string>* doubts) {
  fill_map_gaps(map, how.fill, name);
  remove_map_form(map, how.form);
  subtract_map_mean(map);
  if (doubts == nullptr) return;
  if (!map.doubt.empty()) doubts->push_back(map.doubt);
  if (std::max(map.spacing, map.spacing_y) > widest_spacing)
    doubts->push_back(
        fmt::format("{}: its points are {:g} m apart along x, its rows {:g} m: was that meant in "
                    "metres?",
                    name, map.spacing, map.spacing_y));
  std::vector<std::string> steep;
  for (const bool along_y : {false, true})
    if (const double slope = map_slope(map, along_y); slope > usual_faces::steepest)
      steep.push_back(fmt::format("{:.3g} along {}", slope, along_y ? 'y' : 'x'));
  if (!steep.empty())
    doubts->push_back(
        fmt::format("{}: its slopes have a root mean square of {}, steeper than any face: are "
                    "heights and spacings in their units (a profile, or a list of points, is no "
                    "map)?",
                    name, fmt::join(steep, " and ")));
  if (how.form.degree >= 1) return;
  HeightMap level = map;
  remove_map_form(level, {1});
  if (mean_square(level) < (1 - much_tilt) * mean_square(map))
    doubts->push_back(name + ": most of the height is tilt: try --form plane");
}

}  // namespace ra2d
