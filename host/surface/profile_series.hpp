// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/surface/measure.hpp"
#include "host/surface/profile.hpp"

namespace ra2d {

struct ProfileSeriesOptions {
  ProfileQuery query;
  MeasureOptions measure;
  bool usual_filter = true;  // of the usual cut-off; none where the profile is too short for it
};

/// A measured profile as JSON, for its picture (host/python/ra2d/profile_plot.py): the profile, its
/// roughness, its parameters, the distribution of its heights. `doubts` takes warnings of what
/// looks odd but may be meant. Throws as read_measured_profile() and measure_profile() do.
std::string profile_series(const std::filesystem::path& file, const ProfileSeriesOptions& options,
                           std::vector<std::string>* doubts = nullptr);

}  // namespace ra2d
