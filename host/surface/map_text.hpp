// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "host/surface/map_file.hpp"

namespace ra2d {

/// A matrix in text: a row of constant y in each line, all rows equally long, the numbers parted as
/// those of a profile (docs/surfaces.md). The header may give the unit of the heights in brackets,
/// "z [um]", and spacings, "spacing = 8e-06 m" and "spacing_y = 8e-06 m". Throws RequestError that
/// names up to ten faults by their lines; FileError where the file cannot be read.
BareMap read_map_text(const std::filesystem::path& file, DecimalMark decimal);

}  // namespace ra2d
