// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

#include "host/store/seal.hpp"
#include "tests/child.hpp"

namespace ra2d::test {

/// The bytes that HDF5 wrote.
inline std::string without_seal(std::string bytes) {
  constexpr std::size_t digits_at = 12, digits = 18;
  const std::size_t line = bytes.size() - std::min(bytes.size(), seal_line_size);
  if (bytes.compare(line, 10, "ra2d seal ") == 0)
    bytes.resize(std::stoul(bytes.substr(line + digits_at, digits)));
  return bytes;
}

/// Gives a file that was changed a seal that fits, as a forger would.
inline void reseal(const std::filesystem::path& path) {
  const std::string bytes = without_seal(read_file(path));
  std::ofstream(path, std::ios::binary) << bytes << seal_of(bytes);
}

}  // namespace ra2d::test
