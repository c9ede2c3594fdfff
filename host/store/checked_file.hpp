// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ra2d {

/// What a look at every byte of a file has found.
struct CheckedFile {
  std::vector<std::string> faults;  // a sentence each; none: it is whole
  std::string what;  // of a result: "a complete result", "a result that was cut short: interrupted"
  std::size_t datasets = 0;
  double bytes = 0;  // of their numbers
};

/// Reads every dataset of a file and compares it with its hash. Faults are found, not thrown, by both.
CheckedFile check_hashes(const std::filesystem::path& path);

/// The same of a result or a segment; and what must be there with what is.
CheckedFile check_result(const std::filesystem::path& path);

}  // namespace ra2d
