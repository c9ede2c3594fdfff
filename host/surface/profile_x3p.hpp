// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "host/surface/height_map.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/profile.hpp"

namespace ra2d {

/// A profile of an X3P file (ISO 25178-72, ISO 5436-2): one profile, or an areal file of which the
/// query names a line. All in metres. The checksums of main.xml and of the data are verified. No
/// more is held than main.xml, the profile and what is being read, whatever the file claims. Throws
/// RequestError, with the file and what is wrong; FileError where it cannot be read.
Profile read_profile_x3p(const std::filesystem::path& file, const ProfileQuery& query);

/// All points of such a file with even steps, row after row. Missing ones are NaN.
HeightMap read_map_x3p(const std::filesystem::path& file, const MapQuery& query);

}  // namespace ra2d
