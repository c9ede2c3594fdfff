// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "host/surface/profile.hpp"

namespace ra2d {

struct ProfilePictureOptions {
  ProfileQuery query;
  std::optional<double>
      cutoff;  // m; else the usual one, or no filter where the profile is too short
};

/// What the picture of a measured profile shows, as JSON for host/plot/plot_profile.py: the profile, its
/// roughness, its parameters, how its heights are distributed. Throws as read_measured_profile() and
/// measure_profile() do.
std::string profile_picture(const std::filesystem::path& file,
                            const ProfilePictureOptions& options);

}  // namespace ra2d
