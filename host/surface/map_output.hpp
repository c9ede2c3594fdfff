// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>

#include "host/surface/height_map.hpp"

/// Height maps written to files.
namespace ra2d {

/// Whether a file is written as .npy: by its ending.
bool is_npy_name(const std::filesystem::path& file);

/// Writes heights in metres, as .npy (float64 of shape (rows, x)) where the name ends so, else as
/// text: a row of constant y in each line, the spacings in its header, behind `title`, with the
/// digits that bring the doubles back. Throws FileError.
void write_height_map(const std::filesystem::path& file, const HeightMap& map,
                      const std::string& title);

}  // namespace ra2d
