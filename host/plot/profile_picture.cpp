// SPDX-License-Identifier: BSD-3-Clause
#include "host/plot/profile_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "host/plot/envelope.hpp"
#include "host/surface/measure.hpp"
#include "host/surface/profile_filter.hpp"
#include "host/text.hpp"

namespace ra2d {
namespace {

using Json = nlohmann::ordered_json;  // writes null for what is not finite

constexpr std::size_t most_groups =
    1500;  // of a profile, about as many as a picture has dots across
constexpr std::size_t height_bins = 60;

/// Heights over their places, as a picture can hold them.
Json drawn(std::span<const double> heights, double first, double spacing) {
  std::vector<double> at(heights.size());
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = first + static_cast<double>(i) * spacing;
  return envelope(at, heights, even_groups(heights.size(), most_groups));
}

double mean_of(std::span<const double> values) {
  double sum = 0;
  std::size_t numbers = 0;
  for (const double value : values)
    if (!std::isnan(value)) {
      sum += value;
      ++numbers;
    }
  return sum / static_cast<double>(numbers);
}

/// Share of the points in each of equal bins from the lowest height to the highest.
Json distribution(std::span<const double> heights) {
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  if (!(*high > *low)) return {{"empty", "all heights are the same"}};
  std::vector<double> edges, shares(height_bins);
  for (std::size_t i = 0; i <= height_bins; ++i)
    edges.push_back(*low + (*high - *low) * static_cast<double>(i) / height_bins);
  for (const double z : heights) {
    const double bin = (z - *low) / (*high - *low) * height_bins;
    shares[static_cast<std::size_t>(std::min(bin, height_bins - 1.0))] +=
        1 / static_cast<double>(heights.size());
  }
  return {{"edges", edges}, {"shares", shares}};
}

Json parameters_of(const Roughness& r) {
  return {{"Ra", r.ra}, {"Rq", r.rq},   {"Rz", r.rz},   {"Rt", r.rt},   {"Rp", r.rp},
          {"Rv", r.rv}, {"Rsk", r.rsk}, {"Rku", r.rku}, {"RSm", r.rsm}, {"Rdq", r.rdq},
          {"Rk", r.rk}, {"Rpk", r.rpk}, {"Rvk", r.rvk}};
}

/// What was measured: the heights from their mean line, over the evaluation length.
void add_roughness(const Profile& profile, const ProfilePictureOptions& asked,
                   const std::string& name, Json& json) {
  MeasureOptions options;
  options.cutoff = asked.cutoff;
  options.filter = asked.cutoff || profile.length() >= 2 * usual_cutoff;
  const Measurement m = measure_profile(profile, options, name);
  std::vector<double> z = profile.heights;
  std::size_t dropped = 0;
  if (options.filter) {
    const std::vector<double> line = gaussian_mean_line(z, profile.spacing, *m.cutoff);
    for (std::size_t i = 0; i < z.size(); ++i) z[i] -= line[i];
    dropped = static_cast<std::size_t>(std::round(0.5 * *m.cutoff / profile.spacing));
    json["mean_line"] = drawn(line, 0, profile.spacing);
    json["cutoff"] = *m.cutoff;
  }
  const auto count = static_cast<std::size_t>(
      std::round(m.sampling_length * static_cast<double>(m.sampling_lengths) / profile.spacing));
  std::vector<double> part(
      z.begin() + static_cast<std::ptrdiff_t>(dropped),
      z.begin() + static_cast<std::ptrdiff_t>(std::min(dropped + count, z.size() - dropped)));
  if (!options.filter)
    for (const double mean = mean_of(part); double& height : part) height -= mean;
  json["roughness"] = drawn(part, static_cast<double>(dropped) * profile.spacing, profile.spacing);
  json["heights"] = distribution(part);
  json["parameters"] = parameters_of(m.parameters);
  json["sampling_lengths"] = m.sampling_lengths;
  json["sampling_length"] = m.sampling_length;
}

}  // namespace

std::string profile_picture(const std::filesystem::path& file,
                            const ProfilePictureOptions& options) {
  Profile profile = read_measured_profile(file, options.query);
  Json json{{"file", printable(file.filename().string())},
            {"nodes", profile.heights.size()},
            {"spacing", profile.spacing},
            {"length", profile.length()},
            {"missing", profile.missing()}};
  const double mean = mean_of(profile.heights);
  for (double& height : profile.heights) height -= mean;
  json["profile"] = drawn(profile.heights, 0, profile.spacing);
  if (profile.missing() == 0) add_roughness(profile, options, file.string(), json);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace ra2d
