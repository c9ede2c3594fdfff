// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <vector>

namespace ra2d {

/// Heights [m] at n spacing, n = 0 ... nodes - 1, of a measured profile: two columns, x and z in
/// metres, the first point at n = 0, linear between points, mean zero over the nodes.
/// Throws RequestError that names up to ten faults by file and line, FileError if it cannot be
/// read.
std::vector<double> read_profile(const std::filesystem::path& file, int nodes, double length,
                                 double spacing);

}  // namespace ra2d
