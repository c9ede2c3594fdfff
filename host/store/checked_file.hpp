// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ra2d {

/// The findings after every byte of a file was read.
struct CheckedFile {
  std::vector<std::string> faults;  // a sentence each; none: it is whole
  std::string what;  // of a result: "a complete result", "a result that was cut short: interrupted"
  std::size_t datasets = 0;
  double bytes = 0;                     // of their numbers
  std::vector<std::string> not_finite;  // datasets with a number that is none, where they may
};

/// Compares a file with its seal, then reads its attributes and datasets and compares them with
/// their hashes. HDF5 runs in a child process, which it may crash. Faults are returned, not thrown,
/// also by check_result().
CheckedFile check_hashes(const std::filesystem::path& path);

/// Checks a result or a segment: also whether all datasets are there, and whether a run can have
/// come to these numbers.
CheckedFile check_result(const std::filesystem::path& path);

}  // namespace ra2d
