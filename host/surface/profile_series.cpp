// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <vector>

#include "host/base/text.hpp"
#include "host/surface/envelope.hpp"
#include "host/surface/form.hpp"
#include "host/surface/profile_filter.hpp"

namespace ra2d {
namespace {

using Json = nlohmann::ordered_json;  // writes null for what is not finite

constexpr std::size_t most_drawn_points =
    1500;  // of a profile, about as many as a picture has dots across
constexpr std::size_t height_bins = 60;

/// Heights over their places, as a picture can hold them.
Json drawn(std::span<const double> heights, double first, double spacing) {
  std::vector<double> at(heights.size());
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = first + static_cast<double>(i) * spacing;
  return envelope(at, heights, even_groups(heights.size(), most_drawn_points));
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
  const double squares = std::inner_product(heights.begin(), heights.end(), heights.begin(), 0.0);
  // of all heights at once, which Rq need not be (ISO 4287)
  const double rms = std::sqrt(squares / static_cast<double>(heights.size()));
  return {{"edges", edges}, {"shares", shares}, {"rms", rms}};
}

Json parameters_of(const Roughness& r) {
  return {{"Ra", r.ra}, {"Rq", r.rq},   {"Rz", r.rz},   {"Rt", r.rt},   {"Rp", r.rp},
          {"Rv", r.rv}, {"Rsk", r.rsk}, {"Rku", r.rku}, {"RSm", r.rsm}, {"Rdq", r.rdq},
          {"Rk", r.rk}, {"Rpk", r.rpk}, {"Rvk", r.rvk}, {"Mr1", r.mr1}, {"Mr2", r.mr2}};
}

/// The line that the evaluated heights are counted from, in the heights of the whole profile: the
/// form, and what is left of it the mean line of the filter.
std::vector<double> reference_line(const Profile& filled, const MeasureOptions& options,
                                   std::optional<double> cutoff) {
  std::vector<double> formless = filled.heights;
  remove_form(formless, options.form);
  std::vector<double> line(formless.size(), 0.0);
  if (options.filter == ProfileFilter::gaussian)
    line = gaussian_mean_line(options.cutoff_s
                                  ? gaussian_mean_line(formless, filled.spacing, *options.cutoff_s)
                                  : formless,
                              filled.spacing, *cutoff);
  for (std::size_t i = 0; i < line.size(); ++i) line[i] += filled.heights[i] - formless[i];
  return line;
}

/// Adds the heights from their mean line, over the evaluation length.
void add_roughness(const Profile& profile, const ProfileSeriesOptions& options,
                   const std::string& name, Json& json, std::vector<std::string>* doubts) {
  MeasureOptions measure = options.measure;
  if (options.usual_filter &&
      fitting_filtered(profile.heights.size(), profile.spacing, usual_cutoff) == 0)
    measure.filter = ProfileFilter::none;
  const Measurement m = measure_profile(profile, measure, name);
  Profile filled = profile;
  fill_gaps(filled, measure.fill);
  const bool has_form = measure.form.degree != ProfileForm::none;
  const bool filters = measure.filter == ProfileFilter::gaussian;
  if (filters || has_form) {
    json["line"] = drawn(reference_line(filled, measure, m.cutoff), 0, profile.spacing);
    json["line_is"] = !filters   ? "form"
                      : has_form ? "form, and mean line of the filter"
                                 : "mean line of the filter";
  }
  json["filtered"] = measure.filter != ProfileFilter::none;
  json["filtered_before"] = measure.filter == ProfileFilter::done;
  json["standard"] = name_of(measure.standard);
  if (m.cutoff) json["cutoff"] = *m.cutoff;
  json["roughness"] =
      drawn(m.heights, static_cast<double>(m.dropped) * profile.spacing, profile.spacing);
  json["heights"] = distribution(m.heights);
  json["parameters"] = parameters_of(m.parameters);
  json["sampling_lengths"] = m.sampling_lengths;
  json["sampling_length"] = m.sampling_length;
  if (doubts != nullptr) *doubts = m.doubts;
}

}  // namespace

std::string profile_series(const std::filesystem::path& file, const ProfileSeriesOptions& options,
                           std::vector<std::string>* doubts) {
  Profile profile = read_measured_profile(file, options.query);
  Json json{{"file", printable(file.filename().string())},
            {"nodes", profile.heights.size()},
            {"spacing", profile.spacing},
            {"length", profile.length()},
            {"missing", profile.missing()}};
  const double mean = mean_of(profile.heights);
  for (double& height : profile.heights) height -= mean;
  json["profile"] = drawn(profile.heights, 0, profile.spacing);
  if (profile.missing() == 0 || options.measure.fill > 0)
    add_roughness(profile, options, file.string(), json, doubts);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace ra2d
