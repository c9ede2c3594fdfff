// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "host/surface/profile.hpp"

namespace ra2d {

/// Reads a profile of columns of numbers; docs/surfaces.md says which texts are understood.
/// Units that neither the file nor the user tells are metres, and the numbers must look like it.
Profile read_profile_text(const std::filesystem::path& file, const ProfileQuery& query);

/// Whether a text looks like two columns in metres under no more than one line of names, from its
/// first lines.
bool is_plain_text(const std::filesystem::path& file);

}  // namespace ra2d
