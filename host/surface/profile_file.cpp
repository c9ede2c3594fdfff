// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/surface/measure.hpp"
#include "host/surface/profile.hpp"
#include "host/surface/profile_lines.hpp"
#include "host/surface/sum.hpp"
#include "host/surface/text_dialect.hpp"
#include "host/surface/usual_faces.hpp"

namespace ra2d {
namespace {

// Beyond any face:
constexpr double longest_share = 900;  // a profile so many times as long as the beam
constexpr double inches = 1 / 0.0254, like_inches = 0.05;
constexpr double usual_height = 2e-5;  // m, peak to valley of a ground face
constexpr std::size_t few_points = 100;

/// Fault of a line, empty where there is none, and its point.
std::string understand(const std::vector<std::string_view>& words,
                       const std::vector<std::optional<double>>& values, ProfilePoint& point) {
  if (values.size() != 2)
    return fmt::format("{} columns, expected 2: x and z in metres", values.size());
  if (values[0] && std::isfinite(*values[0])) point.x = *values[0];
  point.z = values[1].value_or(0);
  for (std::size_t i = 0; i < 2; ++i) {
    if (i == 1 && is_missing_word(words[i]))
      return "a height is missing: fill = \"linear:WIDTH\" puts straight lines through gaps";
    if (!values[i])
      return fmt::format("{} is not a number, expected x and z in metres", quoted(words[i]));
    if (!std::isfinite(*values[i]))
      return fmt::format("{} is not a finite number in double precision", quoted(words[i]));
  }
  return {};
}

/// Reads line by line: no more than the points and one line is held.
ProfilePoints read_points(const std::filesystem::path& file) {
  ProfileLines lines(file);
  ProfilePoints profile;
  std::vector<std::string_view> words;
  std::vector<std::optional<double>> values;
  bool first = true;
  while (profile.faults.size() < most_faults && lines.next()) {
    if (lines.too_long()) {
      profile.faults.push_back(
          {lines.number(), fmt::format("a line of more than {} bytes, expected x and z "
                                       "in metres (is it another file?)",
                                       ProfileLines::longest)});
      break;
    }
    split_words(lines.text(), words);
    if (words.empty()) continue;

    values.clear();
    for (const auto word : words) values.push_back(to_number(word));
    const auto is_number = [](const auto& value) { return value.has_value(); };
    const bool names = std::none_of(values.begin(), values.end(), is_number);
    if (std::exchange(first, false) && names) continue;

    profile.has_end = lines.has_end();
    ProfilePoint point{quiet_nan, 0};
    std::string fault = understand(words, values, point);
    if (!std::isnan(point.x)) profile.digits.see(words[0]);
    profile.at_ends.see(words.back(), profile.has_end);
    profile.add(file, lines.number(), point);
    if (fault.empty()) continue;
    if (!profile.has_end) fault += " (the line has no end: was the file cut off here?)";
    profile.faults.push_back({lines.number(), std::move(fault)});
  }
  return profile;
}

struct Unit {
  const char *name, *factor;
  double metres;
};
constexpr Unit units[] = {{"mm", "1e-3", 1e-3}, {"um", "1e-6", 1e-6}, {"nm", "1e-9", 1e-9}};
constexpr Unit mils{"mils", "2.54e-5", 2.54e-5};

/// Unit in which such heights would be those of a face.
const Unit& likely_unit(double height) {
  const auto off = [&](const Unit& unit) {
    return std::abs(std::log(height * unit.metres / usual_height));
  };
  return *std::min_element(std::begin(units), std::end(units),
                           [&](const Unit& a, const Unit& b) { return off(a) < off(b); });
}

/// The smallest unit in which the profile would still reach along the beam.
const Unit& likely_unit(double length, double beam) {
  for (const Unit* unit = std::end(units); --unit != units;)
    if (length * unit->metres >= 0.9 * beam) return *unit;
  return length * mils.metres >= 0.9 * beam ? mils : units[0];
}

/// The face in numbers.
struct Relief {
  std::size_t lowest = 0, highest = 0;
  std::optional<std::size_t> slip;  // the height along the beam that is far from all others
  double height = 0;                // m, from the lowest to the highest
  double slope = 0;                 // root mean square, along the beam
  double depth = 0;  // m, of the body: its thickness, or its length where it has none
  bool has_thickness = false;

  bool odd() const {
    return height > usual_faces::large_share * depth || slope > usual_faces::steep;
  }
};

Relief measure(const ProfilePoints& profile, std::size_t used, double length, double thickness) {
  const auto& points = profile.points;
  Relief relief;
  relief.has_thickness = thickness > 0;
  relief.depth = relief.has_thickness ? thickness : length;
  double squares = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].z < points[relief.lowest].z) relief.lowest = i;
    if (points[i].z > points[relief.highest].z) relief.highest = i;
    if (i < used) squares += std::pow(points[i].z - points[i - 1].z, 2);
  }
  const auto steps = static_cast<double>(used - 1);
  relief.height = points[relief.highest].z - points[relief.lowest].z;
  relief.slope = std::sqrt(squares * steps) / (points[used - 1].x - points[0].x);
  if (!relief.odd() || points.size() < 4) return relief;
  for (const std::size_t i : {relief.lowest, relief.highest}) {
    const Span others = profile.all_but(i);
    if (!others.is_far(points[i].z)) continue;
    if (i < used)
      relief.slip = i;
    else
      relief.height = others.size();
  }
  return relief;
}

/// Fault of a profile that is out of all proportion to the beam, with its line; no text where there
/// is none.
LineFault find_disproportion(const ProfilePoints& profile, double length, const Relief& relief) {
  const auto& points = profile.points;
  const std::size_t last = points.size() - 1;
  if (!profile.has_end)
    if (std::string cut = profile.far_end("m", usual_faces::large_share * relief.depth);
        !cut.empty())
      return {profile.line_of(last), std::move(cut)};
  const double range = points[last].x - points[0].x;
  if (range >= longest_share * length) {
    const Unit& unit = likely_unit(range, length);
    return {
        profile.line_of(last),
        fmt::format("x runs over {:.6g} for a beam of {:.6g} m: is it in {}? Lengths are read "
                    "in metres: set x_unit and z_unit, or multiply x by {}, and z by what its own "
                    "unit asks for",
                    range, length, unit.name, unit.factor)};
  }
  // a rigid body's length says less about its faces than a thickness
  const bool tall =
      relief.height > relief.depth * (relief.has_thickness ? usual_faces::largest_share : 1);
  if (!tall && relief.slope <= usual_faces::steepest) return {0, {}};
  if (relief.slip) {
    const Span others = profile.all_but(*relief.slip);
    return {profile.line_of(*relief.slip),
            fmt::format("a height of {:.6g} m, and all others lie from {:.6g} to {:.6g} m: is "
                        "there a digit missing? Mend the number",
                        points[*relief.slip].z, others.low, others.high)};
  }
  const Unit& unit = likely_unit(relief.height);
  const std::string cure = fmt::format(
      "is z in {0}? Heights are read in metres: set z_unit = \"{0}\", or multiply z by {1}",
      unit.name, unit.factor);
  const std::size_t line = profile.line_of(relief.highest);
  if (tall)
    return {line, fmt::format("the heights span {:.6g} m on a beam {:.6g} m {}: {}", relief.height,
                              relief.depth, relief.has_thickness ? "thick" : "long", cure)};
  return {line, fmt::format("the slopes have a root mean square of {:.3g}, steeper than any face: "
                            "{}",
                            relief.slope, cure)};
}

/// Doubt of a profile that is rare but may be intended; no text where there is none.
LineFault find_oddity(const ProfilePoints& profile, double length, const Relief& relief) {
  const auto& points = profile.points;
  const double range = points.back().x - points.front().x;
  if (std::abs(range / length / inches - 1) < like_inches)
    return {profile.line_of(points.size() - 1),
            fmt::format("x runs over {:.6g} m for a beam of {:.6g} m, {:.3g} times as long: is it "
                        "in inches?",
                        range, length, range / length)};
  if (relief.height > usual_faces::large_share * relief.depth)
    return {profile.line_of(relief.highest),
            fmt::format("the heights span {:.3g} m, {:.0f} % of the beam's {}: are they in metres?",
                        relief.height, 100 * relief.height / relief.depth,
                        relief.has_thickness ? "thickness" : "length")};
  if (relief.slope > usual_faces::steep)
    return {profile.line_of(relief.highest),
            fmt::format("the slopes have a root mean square of {:.2g}, and few faces are so steep: "
                        "are x and z in metres?",
                        relief.slope)};
  if (relief.slope < usual_faces::smooth)
    return {profile.line_of(relief.highest),
            fmt::format("the slopes have a root mean square of {:.2g}, smoother than faces are: "
                        "are x and z in metres?",
                        relief.slope)};
  return {0, {}};
}

}  // namespace

std::vector<double> read_profile(const std::filesystem::path& file, int nodes, double length,
                                 double spacing, double thickness,
                                 std::vector<std::string>* doubts) {
  ProfilePoints profile = read_points(file);
  profile.check_steps("m");
  if (!profile.faults.empty()) refuse(file, std::move(profile.faults));
  const auto& points = profile.points;
  if (points.size() < 2)
    throw RequestError(fmt::format("{}: {} points, expected at least 2 lines of x and z in metres",
                                   file.string(), points.size()));

  const std::size_t last_line = profile.line_of(points.size() - 1);
  const double first = points.front().x, last = points.back().x, needed = (nodes - 1) * spacing;
  const double step = (last - first) / static_cast<double>(points.size() - 1);
  const double printed = profile.digits.rounding(first) + profile.digits.rounding(last);
  if (last - first < needed - evenness * spacing - std::min(printed, step / 2))
    throw RequestError(
        fmt::format("{}:{}: the profile is {:.10g} m long and the beam {:.10g} m; give a longer "
                    "profile or a shorter beam",
                    file.string(), last_line, last - first, length));

  const double wanted = std::ceil(needed / step * (1 - evenness)) + 1;  // points along the beam
  const auto used =
      static_cast<std::size_t>(std::clamp(wanted, 2.0, static_cast<double>(points.size())));
  const Relief relief = measure(profile, used, length, thickness);
  if (LineFault fault = find_disproportion(profile, length, relief); !fault.text.empty())
    refuse(file, {std::move(fault)});
  if (const LineFault odd = find_oddity(profile, length, relief);
      doubts != nullptr && !odd.text.empty())
    doubts->push_back(fmt::format("{}:{}: {}", file.string(), odd.line, odd.text));
  if (doubts != nullptr && profile.at_ends.may_be_cut())
    doubts->push_back(
        fmt::format("{}:{}: the last line has no end: if the file was cut off there, "
                    "its height of {:.6g} m is wrong",
                    file.string(), last_line, points.back().z));
  if (doubts != nullptr && step > usual_faces::coarse_nodes * spacing && points.size() > few_points)
    doubts->push_back(
        fmt::format("{}: x steps by {:.6g} m, {:.0f} nodes of the scene, between "
                    "which the face is straight: is x in metres?",
                    file.string(), step, step / spacing));

  if (doubts != nullptr) {
    std::vector<double> all;
    all.reserve(points.size());
    for (const ProfilePoint& point : points) all.push_back(point.z);
    doubt_tilt(file, all, doubts);
  }

  // equal spacings, as far as the digits show: the nodes are the points
  const bool same = std::abs(step - spacing) * static_cast<double>(points.size() - 1) <=
                    evenness * spacing + std::min(printed, spacing / 4);
  const double stride = same ? 1 : spacing / step;
  std::vector<double> heights(static_cast<std::size_t>(nodes));
  for (std::size_t n = 0; n < heights.size(); ++n) {
    const double at = static_cast<double>(n) * stride;
    const std::size_t i = std::min(static_cast<std::size_t>(at), points.size() - 2);
    heights[n] = std::lerp(points[i].z, points[i + 1].z, at - static_cast<double>(i));
  }
  double rises = 0;
  for (std::size_t n = 1; n < heights.size(); ++n)
    rises += (heights[n] - heights[n - 1]) * (heights[n] - heights[n - 1]);
  doubt_lost_slope(file, relief.slope, step,
                   std::sqrt(rises / static_cast<double>(nodes - 1)) / spacing, spacing, doubts);
  subtract_mean(heights);
  return heights;
}

}  // namespace ra2d
