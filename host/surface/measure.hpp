// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/surface/form.hpp"
#include "host/surface/profile.hpp"
#include "host/surface/roughness.hpp"

namespace ra2d {

constexpr double usual_cutoff = 2.5e-3;            // m
constexpr std::size_t usual_sampling_lengths = 5;  // where as many fit

enum class ProfileFilter {
  gaussian,  // of the cutoff
  done,      // by the instrument: a roughness profile already
  none       // the primary profile
};

struct MeasureOptions {
  ProfileForm form;
  ProfileFilter filter = ProfileFilter::gaussian;
  std::optional<double> cutoff;    // m; without a filter here the sampling length alone
  std::optional<double> cutoff_s;  // m, of the filter against short waves
  std::optional<std::size_t> sampling_lengths;  // 0: as many as fit
  double fill = 0;                              // m, the widest gap
  RoughnessStandard standard = RoughnessStandard::iso21920;
  std::optional<double> level;  // m from the mean line, of Rmr
};

struct Measurement {
  std::size_t nodes, missing;  // of the whole profile
  double spacing, length;      // m
  std::optional<double> cutoff;
  std::size_t sampling_lengths, fitting;  // evaluated, and as many as would fit
  double sampling_length;                 // m
  Roughness parameters;
  double material_ratio;            // at the level; NaN where options.level is empty
  std::vector<double> heights;      // that were evaluated, from their mean line
  std::size_t dropped;              // points before them
  std::vector<std::string> doubts;  // values that look wrong but may be intended
};

/// Number of sampling lengths of `points` points (which need not be whole) that fit into `left`
/// points.
/// They may be short of it by less than 0.1 %, and half a sampling length: an instrument that cuts
/// its profile into whole points drops the rest of a point at each sampling length.
std::size_t fitting_lengths(std::size_t left, double points);

/// Number of sampling lengths that fit into a profile of `nodes` points once the filter has taken
/// half a cutoff off each end.
std::size_t fitting_filtered(std::size_t nodes, double spacing, double cutoff);

/// Takes the form off, then what is shorter than `cutoff_s` and what is longer than `cutoff` [m];
/// leaves out half a cutoff at each end, which the filter does not see whole. Where that is
/// everything, no height is left.
void shape_profile(Profile& profile, ProfileForm form, std::optional<double> cutoff_s,
                   std::optional<double> cutoff);

/// Says where most of the height of a face is tilt, which no form and no filter takes off.
void doubt_tilt(const std::filesystem::path& file, const std::vector<double>& heights,
                std::vector<std::string>* doubts);

/// Fills gaps, takes the form off, filters (and then drops half a cutoff at each end) and measures
/// the first sampling lengths of what is left. `name` is the profile's in messages. Throws
/// RequestError where the options do not fit the profile.
Measurement measure_profile(Profile profile, const MeasureOptions& given, const std::string& name);

}  // namespace ra2d
