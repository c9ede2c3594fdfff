// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace ra2d {

/// Heights [m] at n spacing, n = 0 ... nodes - 1, of a measured profile: two columns, x and z in
/// metres, the first point at n = 0, linear between points, mean zero over the nodes. `length` and
/// `thickness` [m] are the beam's (0: not known); `doubts` takes a sentence for each value that
/// looks wrong but may be intended. Throws RequestError that names up to ten faults by file and
/// line, also where lengths or heights are out of all proportion to the beam, FileError if it
/// cannot be read.
std::vector<double> read_profile(const std::filesystem::path& file, int nodes, double length,
                                 double spacing, double thickness = 0,
                                 std::vector<std::string>* doubts = nullptr);

}  // namespace ra2d
