// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdlib>
#include <filesystem>
#include <string>

namespace ra2d::bench {

/// A file of scenes/ by its name without .toml: this source tree's, or that of the folder which
/// RA2D_SOURCE_DIR names, as in a bundle.
inline std::filesystem::path scene_file(const std::string& name) {
  const char* named = std::getenv("RA2D_SOURCE_DIR");
  return std::filesystem::path(named ? named : RA2D_BENCH_SOURCE_DIR) / "scenes" / (name + ".toml");
}

}  // namespace ra2d::bench
