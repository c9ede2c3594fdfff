// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string_view>

#include "host/surface/height_map.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/profile.hpp"

namespace ra2d {

/// Whether a file that begins so is SDF, in whatever version.
bool begins_as_sdf(std::string_view bytes);

/// A profile of a surface data file (ISO 25178-71): text or binary, version BCR-1.0 or ISO-1.0, one
/// profile or an areal file of which the query names a line. All in metres. No more is held than
/// the profile and what is being read, whatever the header says. Throws RequestError, with the file
/// and what is wrong; FileError where it cannot be read.
Profile read_profile_sdf(const std::filesystem::path& file, const ProfileQuery& query);

/// All points of such a file, row after row. Missing ones are NaN.
HeightMap read_map_sdf(const std::filesystem::path& file, const MapQuery& query);

}  // namespace ra2d
