// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <vector>

#include "host/scene/scene.hpp"

namespace ra2d {

/// Heights [m] at n spacing of a measured profile with anything said about how it is read or what is
/// taken off it: as `ra2d surface measure` reads and filters it, then linear between its points, mean
/// zero over the nodes. Lengths in m. Throws RequestError, FileError as read_measured_profile.
std::vector<double> measured_heights(const std::filesystem::path& file, const ProfileSpec& spec,
                                     int nodes, double length, double spacing, double thickness);

}  // namespace ra2d
