// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <string_view>

namespace ra2d {

/// TOML whose absolute file names have lost their folders: "/home/ann/ground.csv" is "ground.csv".
/// A page is sent to others, whose disks are other ones. Texts in quotes that begin with a slash
/// are taken for such names.
std::string without_folders(std::string_view toml);

}  // namespace ra2d
