// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/prepared_face.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "host/base/errors.hpp"
#include "host/scene/names.hpp"
#include "host/surface/form.hpp"
#include "host/surface/measure.hpp"
#include "host/surface/profile.hpp"
#include "host/surface/profile_lines.hpp"
#include "host/surface/profile_text.hpp"
#include "host/surface/repeated_place.hpp"
#include "host/surface/sum.hpp"
#include "host/surface/usual_faces.hpp"

namespace ra2d {
namespace {

constexpr double steps_to_cutoff = 5;  // of the profile, at the least
constexpr double most_copies = 100;    // along a beam
constexpr double much_change = 0.1;    // of Rq, where a profile is repeated

ProfileQuery query_of(const FilePreparation& how) {
  ProfileQuery query;
  if (how.x_unit) query.x_unit = to_unit(file_units.name(*how.x_unit));
  if (how.z_unit) query.z_unit = to_unit(file_units.name(*how.z_unit));
  query.spacing = how.spacing;
  if (how.decimal)
    query.decimal = *how.decimal == FileDecimal::comma ? DecimalMark::comma : DecimalMark::point;
  query.row = how.row;
  query.column = how.column;
  return query;
}

[[noreturn]] void refuse_face(const std::filesystem::path& file, const std::string& why) {
  throw RequestError(fmt::format("{}: {}", file.string(), why));
}

/// Throws RequestError where the profile is too short or too coarse for the filter.
void check_cutoff(const std::filesystem::path& file, const Profile& profile, double cutoff) {
  if (cutoff < steps_to_cutoff * profile.spacing)
    refuse_face(file, fmt::format("cutoff = {:g}: at least {:g} steps of the profile are needed, "
                                  "{:.6g} m",
                                  cutoff, steps_to_cutoff, steps_to_cutoff * profile.spacing));
  const double half = std::round(0.5 * cutoff / profile.spacing);
  if (2 * half + 2 > static_cast<double>(profile.heights.size()))
    refuse_face(file, fmt::format("cutoff = {:g}: half of it is dropped at each end, and the "
                                  "profile is {:.6g} m long",
                                  cutoff, profile.length()));
}

Profile prepare(const FilePreparation& how, const std::filesystem::path& file) {
  Profile profile;
  try {
    profile = read_measured_profile(file, query_of(how));
    fill_gaps(profile, how.fill.empty() ? 0 : to_fill_width(how.fill).value_or(0));
  } catch (const RequestError& fault) {
    throw RequestError(in_keys(fault.what()));
  }
  if (how.cutoff_s && *how.cutoff_s > 0.5 * profile.length())
    refuse_face(file, fmt::format("cutoff_s = {:g}: the profile is {:.6g} m long", *how.cutoff_s,
                                  profile.length()));
  std::optional<double> cutoff;
  if (how.filter == FaceFilter::gaussian) {
    cutoff = how.cutoff.value_or(usual_cutoff);
    check_cutoff(file, profile, *cutoff);
  }
  shape_profile(profile, how.form.empty() ? ProfileForm{} : to_form(how.form), how.cutoff_s,
                cutoff);
  subtract_mean(profile.heights);
  return profile;
}

/// Heights at the nodes, straight between points; `height` gives that of a point.
template <class Height>
std::vector<double> at_nodes(std::size_t nodes, double stride, std::size_t last,
                             const Height& height) {
  std::vector<double> heights(nodes);
  for (std::size_t n = 0; n < nodes; ++n) {
    const double at = static_cast<double>(n) * stride;
    const std::size_t i = std::min(static_cast<std::size_t>(at), last - 1);
    heights[n] = std::lerp(height(i), height(i + 1), at - static_cast<double>(i));
  }
  return heights;
}

struct FaceShape {
  double rq, slope;  // m; root mean square
};

FaceShape face_shape(std::span<const double> z, double spacing) {
  const auto count = static_cast<double>(z.size());
  const double mean = compensated_sum(z.size(), [&](std::size_t i) { return z[i]; }) / count;
  const double squares =
      compensated_sum(z.size(), [&](std::size_t i) { return (z[i] - mean) * (z[i] - mean); });
  const double rises = compensated_sum(
      z.size() - 1, [&](std::size_t i) { return (z[i + 1] - z[i]) * (z[i + 1] - z[i]); });
  return {std::sqrt(squares / count), std::sqrt(rises / (count - 1)) / spacing};
}

void check_profile(const std::filesystem::path& file, const std::vector<double>& z, double length,
                   double spacing, double thickness, std::vector<std::string>* doubts) {
  const auto [low, high] = std::minmax_element(z.begin(), z.end());
  check_proportion(file, {*high - *low, face_shape(z, spacing).slope}, {"beam", length, thickness},
                   doubts);
}

}  // namespace

void check_proportion(const std::filesystem::path& file, const FaceExtent& face,
                      const CarryingBody& body, std::vector<std::string>* doubts) {
  const double depth = body.thickness > 0 ? body.thickness : body.length;
  const char* const what = body.thickness > 0 ? "thick" : "long";
  // SDF and X3P have units of their own
  const bool has_units = format_of(file) != ProfileFormat::text;
  if (face.height > depth * (body.thickness > 0 ? usual_faces::largest_share : 1))
    refuse_face(file, fmt::format("the heights span {:.6g} m on a {} {:.6g} m {}: {}, or take a "
                                  "form off",
                                  face.height, body.name, depth, what,
                                  has_units ? "mend its scale of z, which is in metres"
                                            : "say with z_unit what they are in, or mend the unit "
                                              "in its header"));
  if (face.slope > usual_faces::steepest)
    refuse_face(
        file, fmt::format("the slopes have a root mean square of {:.3g}, steeper than any face: {}",
                          face.slope,
                          has_units ? "mend its scales of x and z, which are in metres"
                          : body.name == std::string("beam")
                              ? "say with x_unit and z_unit what x and z are in, or mend the units "
                                "in its header"
                              : "is z_unit what the heights are in, and are `spacing` and "
                                "`spacing_y` in metres?"));
  if (doubts == nullptr) return;
  if (face.height > usual_faces::large_share * depth)
    doubts->push_back(fmt::format("{}: the heights span {:.3g} m on a {} {:.3g} m {}",
                                  file.string(), face.height, body.name, depth, what));
  else if (face.slope > usual_faces::steep)
    doubts->push_back(
        fmt::format("{}: the slopes have a root mean square of {:.2g}, and few faces "
                    "are so steep",
                    file.string(), face.slope));
  else if (face.slope < usual_faces::smooth)
    doubts->push_back(
        fmt::format("{}: the slopes have a root mean square of {:.2g}, smoother than faces are: "
                    "are the heights in the unit in which they are read?",
                    file.string(), face.slope));
}

std::string in_keys(std::string text) {
  constexpr std::pair<std::string_view, std::string_view> words[] = {
      {"--decimal point", "decimal = \"point\""},
      {"--decimal comma", "decimal = \"comma\""},
      {"--decimal", "decimal"},
      {"--spacing-y", "spacing_y"},
      {"--spacing", "spacing"},
      {"--x-unit m", "x_unit = \"m\""},
      {"--x-unit", "x_unit"},
      {"--z-unit m", "z_unit = \"m\""},
      {"--z-unit", "z_unit"},
      {"--column", "column"},
      {"--row", "row"},
      {"--fill", "fill"},
      {"--form plane", "form = \"plane\""},
      {"drop the option", "drop the key"}};
  for (const auto& [option, key] : words)
    for (std::size_t at = text.find(option); at != text.npos; at = text.find(option, at))
      text.replace(at, option.size(), key);
  return text;
}

RepeatedProfile::RepeatedProfile(const std::vector<double>& heights)
    : heights_{heights}, seam_{RepeatedPlace::seam(heights.size())} {}

double RepeatedProfile::at(std::size_t point) const {
  const RepeatedPlace place(heights_.size(), point);
  if (place.other_share == 0) return heights_[place.point];
  return place.share * heights_[place.point] + place.other_share * heights_[place.other];
}

bool needs_preparation(const SurfaceSpec& spec, const std::filesystem::path& file) {
  return spec.prepared != FilePreparation{} || format_of(file) != ProfileFormat::text ||
         !is_plain_text(file);
}

std::vector<double> prepared_face(const SurfaceSpec& spec, const std::filesystem::path& file,
                                  int nodes, double length, double spacing, double thickness,
                                  std::vector<std::string>* doubts) {
  const FilePreparation& how = spec.prepared;
  const Profile profile = prepare(how, file);
  const std::vector<double>& z = profile.heights;
  if (doubts != nullptr && !profile.doubt.empty()) doubts->push_back(profile.doubt);
  const bool keeps_tilt = how.form.empty() || to_form(how.form).degree < 1;
  if (keeps_tilt && how.filter != FaceFilter::gaussian) doubt_tilt(file, z, doubts);
  if (doubts != nullptr && how.cutoff_s && *how.cutoff_s < profile.spacing)
    doubts->push_back(
        fmt::format("{}: cutoff_s = {:g} is less than a step of the profile and changes nothing",
                    file.string(), *how.cutoff_s));
  const std::size_t last = z.size() - 1;
  const auto count = static_cast<std::size_t>(nodes);
  const double needed = static_cast<double>(count - 1) * spacing, there = profile.length();
  // equal spacings, but for roundings: the nodes are the points
  const bool same =
      std::abs(profile.spacing - spacing) * static_cast<double>(last) <= evenness * spacing;
  const double stride = same ? 1 : spacing / profile.spacing;
  const bool is_short = there < needed - evenness * spacing;
  if (is_short && how.when_short == ShortProfile::refuse)
    refuse_face(file, fmt::format("the profile is {:.10g} m long and the beam {:.10g} m; give a "
                                  "longer profile, or say short = \"repeat\"",
                                  there, length));
  if (is_short && needed > most_copies * there)
    refuse_face(file,
                fmt::format("the profile is {:.6g} m long and the beam {:.6g} m: repeated more "
                            "than {:g} times it would be heard as a tone alone",
                            there, length, most_copies));
  const RepeatedProfile repeated(z);
  std::vector<double> heights =
      is_short ? at_nodes(count, stride, static_cast<std::size_t>(-1) / 2,
                          [&](std::size_t i) { return repeated.at(i); })
               : at_nodes(count, stride, last, [&](std::size_t i) { return z[i]; });
  check_profile(file, heights, length, spacing, thickness, doubts);
  const std::size_t own = std::min(count, static_cast<std::size_t>(there / spacing) + 1);
  if (doubts != nullptr && own > 1) {
    const auto intervals = static_cast<double>(own - 1) * stride;
    const std::size_t points = std::min(z.size(), static_cast<std::size_t>(intervals) + 2);
    doubt_lost_slope(file, face_shape(std::span(z).first(points), profile.spacing).slope,
                     profile.spacing, face_shape(std::span(heights).first(own), spacing).slope,
                     spacing, doubts);
  }
  if (doubts != nullptr && profile.spacing > usual_faces::coarse_nodes * spacing)
    doubts->push_back(
        fmt::format("{}: x steps by {:.6g} m, {:.0f} nodes of the scene, between which the face is "
                    "straight",
                    file.string(), profile.spacing, profile.spacing / spacing));
  if (doubts != nullptr && is_short) {
    const FaceShape before =
        face_shape(std::span(heights).first(std::max<std::size_t>(own, 2)), spacing);
    const FaceShape after = face_shape(heights, spacing);
    std::string doubt =
        fmt::format("{}: {:.4g} m long, less than the beam: repeated every {:.4g} m", file.string(),
                    there, static_cast<double>(last + repeated.seam()) * profile.spacing);
    if (std::abs(after.rq - before.rq) > much_change * before.rq)
      doubt += fmt::format(", which changes Rq from {:.3g} to {:.3g} m", before.rq, after.rq);
    doubts->push_back(std::move(doubt));
  }
  subtract_mean(heights);
  return heights;
}

}  // namespace ra2d
