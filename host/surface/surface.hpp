// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

/// The rough faces (docs/scene.md).
namespace ra2d {

/// Number of nodes of a beam: n chi for n = 0 ... , the last one at or before its end.
/// A length within 1e-9 of a whole number of spacings counts as whole.
int node_count(double length, double spacing);

/// Heights [m] at the nodes n chi of a beam of this length, positive towards the opposite body.
/// `scene_file` anchors a relative path. Of a measured profile: `thickness` [m] of the beam, 0
/// where it has none; `doubts` as in read_profile. Throws RequestError for a profile that cannot be
/// used (with the file and the line), FileError when it cannot be read.
std::vector<double> make_surface(const SurfaceSpec& spec, double length, double spacing,
                                 const std::filesystem::path& scene_file, double thickness = 0,
                                 std::vector<std::string>* doubts = nullptr);

}  // namespace ra2d
