// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/measure.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/surface/profile_filter.hpp"
#include "host/surface/sum.hpp"
#include "host/surface/usual_faces.hpp"

namespace ra2d {
namespace {

constexpr double fewest_steps = 5;    // to a sampling length
constexpr double short_share = 1e-3;  // that sampling lengths may be short of
constexpr double largest_part = 0.5;  // of one sampling length, however many there are
constexpr double much_tilt = 0.5;     // of the mean square height
constexpr double much_offset = 0.1;   // of the root mean square height

void check_lengths(const MeasureOptions& options, const Profile& profile, const std::string& name) {
  const auto refuse_with = [&](const std::string& why) { throw RequestError(name + ": " + why); };
  if (options.cutoff && *options.cutoff < fewest_steps * profile.spacing)
    refuse_with(
        fmt::format("--cutoff {:g}: at least {:g} steps of the profile are needed, {:.6g} m",
                    *options.cutoff, fewest_steps, fewest_steps * profile.spacing));
  if (options.cutoff_s && options.cutoff && options.filter != ProfileFilter::none &&
      *options.cutoff_s >= *options.cutoff)
    refuse_with(fmt::format("--cutoff-s {:g} must be smaller than the cut-off, {:g} m",
                            *options.cutoff_s, *options.cutoff));
  if (options.cutoff_s && *options.cutoff_s > 0.5 * profile.length())
    refuse_with(fmt::format("--cutoff-s {:g}: the profile is {:.6g} m long", *options.cutoff_s,
                            profile.length()));
}

double mean_square(const std::vector<double>& z) {
  return compensated_sum(z.size(), [&](std::size_t i) { return z[i] * z[i]; }) /
         static_cast<double>(z.size());
}

bool is_tilted(const std::vector<double>& heights) {
  std::vector<double> flat = heights, level = heights;
  remove_form(flat, {0});
  remove_form(level, {1});
  return mean_square(level) < (1 - much_tilt) * mean_square(flat);
}

/// Doubt of a profile that is said to be filtered: of heights that no filter leaves.
std::string doubt_of_filtered(const std::vector<double>& z) {
  if (is_tilted(z))
    return "most of the height is tilt, which no filter leaves: without --filter done it is "
           "filtered "
           "here";
  std::vector<double> level = z;
  const double mean = subtract_mean(level), square = mean_square(level);
  if (mean * mean <= much_offset * much_offset * square) return {};
  return fmt::format(
      "the mean of the heights is {:.3g} m, and their Rq from there {:.3g} m. A filter leaves a "
      "mean "
      "near 0, and heights are counted from 0: try --form mean",
      mean, std::sqrt(square));
}

void take_off(std::vector<double>& z, const std::vector<double>& line) {
  for (std::size_t i = 0; i < z.size(); ++i) z[i] -= line[i];
}

/// Drops `half` points at each end, where the filter reaches beyond the profile; or everything.
void drop_ends(std::vector<double>& z, double half) {
  if (2 * half >= static_cast<double>(z.size())) return z.clear();
  const auto dropped = static_cast<std::ptrdiff_t>(half);
  z.erase(z.end() - dropped, z.end());
  z.erase(z.begin(), z.begin() + dropped);
}

double half_of(double cutoff, double spacing) { return std::round(0.5 * cutoff / spacing); }

/// Sampling lengths: as many as fit, and as many as are evaluated.
void choose_lengths(const MeasureOptions& options, const Profile& profile, double points,
                    const std::string& name, Measurement& found) {
  found.fitting = fitting_lengths(profile.heights.size(), points);
  if (found.fitting == 0) {
    const bool filters = options.filter == ProfileFilter::gaussian;
    throw RequestError(fmt::format(
        "{}: the profile is {:.6g} m long, and a cut-off of {:g} m needs {:g} m{}: give a smaller "
        "--cutoff, or --filter none",
        name, found.length, *options.cutoff, *options.cutoff * (filters ? 2 : 1),
        filters ? ", half of it being dropped at each end" : ""));
  }
  found.sampling_lengths = std::min(found.fitting, usual_sampling_lengths);
  if (options.sampling_lengths)
    found.sampling_lengths =
        *options.sampling_lengths > 0 ? *options.sampling_lengths : found.fitting;
  if (found.sampling_lengths > found.fitting)
    throw RequestError(fmt::format("{}: --sampling-lengths {}: {} of {:g} m fit", name,
                                   found.sampling_lengths, found.fitting,
                                   points * profile.spacing));
  found.sampling_length = points * profile.spacing;
}

}  // namespace

std::size_t fitting_lengths(std::size_t left, double points) {
  const double lengths = static_cast<double>(left) / points, next = std::floor(lengths) + 1;
  const bool is_nearly_next = next - lengths < std::min(short_share * next, largest_part);
  return static_cast<std::size_t>(is_nearly_next ? next : next - 1);
}

std::size_t fitting_filtered(std::size_t nodes, double spacing, double cutoff) {
  const double left = static_cast<double>(nodes) - 2 * half_of(cutoff, spacing);
  return left > 0 ? fitting_lengths(static_cast<std::size_t>(left), cutoff / spacing) : 0;
}

void shape_profile(Profile& profile, ProfileForm form, std::optional<double> cutoff_s,
                   std::optional<double> cutoff) {
  std::vector<double>& z = profile.heights;
  remove_form(z, form);
  if (cutoff_s) z = gaussian_mean_line(z, profile.spacing, *cutoff_s);
  if (!cutoff) return;
  const double half = half_of(*cutoff, profile.spacing);
  if (2 * half >= static_cast<double>(z.size())) return z.clear();
  take_off(z, gaussian_mean_line(z, profile.spacing, *cutoff));
  drop_ends(z, half);
}

void doubt_tilt(const std::filesystem::path& file, const std::vector<double>& heights,
                std::vector<std::string>* doubts) {
  if (doubts != nullptr && is_tilted(heights))
    doubts->push_back(
        fmt::format("{}: most of the height is tilt: try form = \"line\"", file.string()));
}

Measurement measure_profile(Profile profile, const MeasureOptions& given, const std::string& name) {
  MeasureOptions options = given;
  const bool filters = options.filter == ProfileFilter::gaussian;
  if (options.filter != ProfileFilter::none && !options.cutoff) options.cutoff = usual_cutoff;
  check_lengths(options, profile, name);
  Measurement found{};
  found.nodes = profile.heights.size();
  found.spacing = profile.spacing;
  found.length = profile.length();
  found.missing = profile.missing();
  found.cutoff = options.cutoff;
  fill_gaps(profile, options.fill);

  const auto doubt = [&](const std::string& what) {
    if (!what.empty()) found.doubts.push_back(name + ": " + what);
  };
  if (!profile.doubt.empty()) found.doubts.push_back(profile.doubt);
  if (options.cutoff_s && *options.cutoff_s < profile.spacing)
    doubt(fmt::format("--cutoff-s {:g} is less than a step of the profile and changes nothing",
                      *options.cutoff_s));
  if (const double slope = rms_slope(profile.heights, profile.spacing);
      slope > usual_faces::steepest)
    doubt(
        fmt::format("its slopes have a root mean square of {:.3g}, steeper than any face: are x "
                    "and z in the units that the file or the options say, and is every height a "
                    "height?",
                    slope));
  shape_profile(profile, options.form, options.cutoff_s, std::nullopt);
  std::vector<double>& z = profile.heights;
  std::vector<double> stratified;  // the profile of Rk, where that is another one
  if (filters && options.standard == RoughnessStandard::iso4287) {
    stratified = z;
    take_off(stratified, mean_line_above_valleys(z, profile.spacing, *options.cutoff));
    drop_ends(stratified, half_of(*options.cutoff, profile.spacing));
  }
  if (filters) shape_profile(profile, {}, std::nullopt, options.cutoff);
  found.dropped = (found.nodes - z.size()) / 2;
  const double points =  // of a sampling length
      options.cutoff ? *options.cutoff / profile.spacing : static_cast<double>(z.size());
  choose_lengths(options, profile, points, name, found);

  const auto count = static_cast<std::size_t>(
      std::min(static_cast<double>(z.size()),
               std::round(points * static_cast<double>(found.sampling_lengths))));
  z.resize(count);
  if (options.filter == ProfileFilter::none) {
    if (options.form.degree < 1 && is_tilted(z))
      doubt("most of the height is tilt, which no filter takes off: try --form line");
    subtract_mean(z);
  } else if (options.filter == ProfileFilter::done) {
    doubt(doubt_of_filtered(z));
  }
  found.parameters = roughness(z, profile.spacing, found.sampling_lengths, options.standard);
  if (!stratified.empty()) {
    stratified.resize(count);
    set_core(found.parameters, core(stratified));
  }
  found.material_ratio = options.level ? material_ratio(z, *options.level) : quiet_nan;
  found.heights = std::move(z);
  return found;
}

}  // namespace ra2d
