// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace ra2d {

/// The findings after every byte of a checkpoint and of its segments was read.
struct CheckedCheckpoint {
  std::vector<std::string> faults;  // a sentence each; none: it is whole
  std::string what;                 // "a checkpoint of ra2d 0.1 ..., 31415 steps into its run; ..."
};

/// Faults are found, not thrown, but where the file cannot be read (FileError).
CheckedCheckpoint check_checkpoint(const std::filesystem::path& file);

}  // namespace ra2d
