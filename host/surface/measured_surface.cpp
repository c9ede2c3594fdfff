// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/measured_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/errors.hpp"
#include "host/surface/measure.hpp"
#include "host/surface/profile_lines.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

constexpr double largest_share = 0.5;  // of the beam's thickness, from the lowest to the highest

}  // namespace

std::vector<double> measured_heights(const std::filesystem::path& file, const ProfileSpec& spec,
                                     int nodes, double length, double spacing, double thickness) {
  const auto refuse_with = [&](const std::string& why) {
    throw RequestError(fmt::format("{}: {}", file.string(), why));
  };
  ProfileQuery query;
  if (spec.x_unit) query.x_unit = to_unit(*spec.x_unit);
  if (spec.z_unit) query.z_unit = to_unit(*spec.z_unit);
  query.column = spec.column;
  Profile profile = read_measured_profile(file, query);
  if (profile.missing() > 0)
    throw RequestError(fmt::format("{}: a height is missing, the first of {}: complete the profile",
                                   profile.first_missing, profile.missing()));
  const double measured = profile.length();
  shape_profile(profile, to_form(spec.form.value_or("none")), spec.cutoff_s, spec.cutoff);
  const std::vector<double>& z = profile.heights;
  const double needed = (nodes - 1) * spacing;
  if (z.size() < 2 || profile.length() < needed - evenness * spacing)
    refuse_with(fmt::format(
        "the profile is {:.10g} m long{} and the beam {:.10g} m; give a longer "
        "profile or a shorter beam",
        measured,
        spec.cutoff ? fmt::format(", of which a cut-off of {:g} m is left out", *spec.cutoff) : "",
        length));
  // The same spacing, as far as the digits tell: the nodes are the points.
  const bool same =
      std::abs(profile.spacing - spacing) * static_cast<double>(z.size() - 1) <= evenness * spacing;
  const double stride = same ? 1 : spacing / profile.spacing;
  std::vector<double> heights(static_cast<std::size_t>(nodes));
  for (std::size_t n = 0; n < heights.size(); ++n) {
    const double at = static_cast<double>(n) * stride;
    const std::size_t i = std::min(static_cast<std::size_t>(at), z.size() - 2);
    heights[n] = std::lerp(z[i], z[i + 1], at - static_cast<double>(i));
  }
  subtract_mean(heights);
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  const double depth = thickness > 0 ? thickness : 2 * length;
  if (*high - *low > largest_share * depth)
    refuse_with(fmt::format("the heights span {:.6g} m on a beam {:.6g} m {}: is z_unit right?",
                            *high - *low, thickness > 0 ? thickness : length,
                            thickness > 0 ? "thick" : "long"));
  return heights;
}

}  // namespace ra2d
