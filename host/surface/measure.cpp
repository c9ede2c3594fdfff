// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/measure.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "host/errors.hpp"
#include "host/surface/profile_filter.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double fewest_steps = 5;  // to a sampling length
constexpr double whole = 1e-9;      // of a sampling length: as many as fit
constexpr double much_tilt = 0.5;   // of the mean square height

void check_lengths(const MeasureOptions& options, const Profile& profile, const std::string& name) {
  const auto refuse_with = [&](const std::string& why) { throw RequestError(name + ": " + why); };
  if (options.cutoff && *options.cutoff < fewest_steps * profile.spacing)
    refuse_with(
        fmt::format("--cutoff {:g}: at least {:g} steps of the profile are needed, {:.6g} m",
                    *options.cutoff, fewest_steps, fewest_steps * profile.spacing));
  if (options.cutoff_s && options.cutoff && options.filter && *options.cutoff_s >= *options.cutoff)
    refuse_with(fmt::format("--cutoff-s {:g} must be smaller than the cut-off, {:g} m",
                            *options.cutoff_s, *options.cutoff));
  if (options.cutoff_s && *options.cutoff_s > 0.5 * profile.length())
    refuse_with(fmt::format("--cutoff-s {:g}: the profile is {:.6g} m long", *options.cutoff_s,
                            profile.length()));
}

bool is_tilted(const std::vector<double>& heights) {
  const auto square = [](const std::vector<double>& z) {
    return compensated_sum(z.size(), [&](std::size_t i) { return z[i] * z[i]; });
  };
  std::vector<double> flat = heights, level = heights;
  remove_form(flat, {0});
  remove_form(level, {1});
  return square(level) < (1 - much_tilt) * square(flat);
}

}  // namespace

void shape_profile(Profile& profile, ProfileForm form, std::optional<double> cutoff_s,
                   std::optional<double> cutoff) {
  std::vector<double>& z = profile.heights;
  remove_form(z, form);
  if (cutoff_s) z = gaussian_mean_line(z, profile.spacing, *cutoff_s);
  if (!cutoff) return;
  const double half = std::round(0.5 * *cutoff / profile.spacing);
  if (2 * half >= static_cast<double>(z.size())) return z.clear();
  const std::vector<double> line = gaussian_mean_line(z, profile.spacing, *cutoff);
  for (std::size_t i = 0; i < z.size(); ++i) z[i] -= line[i];
  const auto dropped = static_cast<std::ptrdiff_t>(half);
  z.erase(z.end() - dropped, z.end());
  z.erase(z.begin(), z.begin() + dropped);
}

Measurement measure_profile(Profile profile, const MeasureOptions& asked, const std::string& name) {
  MeasureOptions options = asked;
  if (options.filter && !options.cutoff) options.cutoff = usual_cutoff;
  check_lengths(options, profile, name);
  Measurement found{};
  found.nodes = profile.heights.size();
  found.spacing = profile.spacing;
  found.length = profile.length();
  found.missing = profile.missing();
  found.cutoff = options.cutoff;
  fill_gaps(profile, options.fill);

  if (options.cutoff_s && *options.cutoff_s < profile.spacing)
    found.doubts.push_back(
        fmt::format("{}: --cutoff-s {:g} is less than a step of the profile and changes nothing",
                    name, *options.cutoff_s));
  shape_profile(profile, options.form, options.cutoff_s,
                options.filter ? options.cutoff : std::nullopt);
  std::vector<double>& z = profile.heights;
  found.dropped = (found.nodes - z.size()) / 2;
  const auto left = static_cast<double>(z.size());
  const double points =  // of a sampling length
      options.cutoff ? *options.cutoff / profile.spacing : static_cast<double>(z.size());
  found.fitting = static_cast<std::size_t>(left / points + whole);
  if (found.fitting == 0)
    throw RequestError(fmt::format(
        "{}: the profile is {:.6g} m long, and a cut-off of {:g} m needs {:g} m{}: give a smaller "
        "--cutoff, or --filter none",
        name, found.length, *options.cutoff, *options.cutoff * (options.filter ? 2 : 1),
        options.filter ? ", half of it being dropped at each end" : ""));
  found.sampling_lengths = std::min(found.fitting, usual_sampling_lengths);
  if (options.sampling_lengths)
    found.sampling_lengths =
        *options.sampling_lengths > 0 ? *options.sampling_lengths : found.fitting;
  if (found.sampling_lengths > found.fitting)
    throw RequestError(fmt::format("{}: --sampling-lengths {}: {} of {:g} m fit", name,
                                   found.sampling_lengths, found.fitting,
                                   points * profile.spacing));
  found.sampling_length = points * profile.spacing;

  const auto count = static_cast<std::size_t>(
      std::min(left, std::round(points * static_cast<double>(found.sampling_lengths))));
  z.resize(count);
  if (!options.filter) {
    if (options.form.degree < 1 && is_tilted(z))
      found.doubts.push_back(fmt::format(
          "{}: most of the height is tilt, which no filter takes off: try --form line", name));
    subtract_mean(z);
  }
  found.parameters = roughness(z, profile.spacing, found.sampling_lengths, options.rule);
  found.material_ratio = options.level ? material_ratio(z, *options.level) : nan;
  found.heights = std::move(z);
  return found;
}

}  // namespace ra2d
