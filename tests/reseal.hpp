// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <fstream>
#include <string>

#include "host/store/seal.hpp"
#include "tests/child.hpp"

namespace ra2d::test {

/// Gives a file that was changed a seal that fits, as a forger would.
inline void reseal(const std::filesystem::path& path) {
  std::string bytes = read_file(path);
  if (bytes.size() >= seal_size && bytes.compare(bytes.size() - seal_size, 10, "ra2d seal ") == 0)
    bytes.resize(bytes.size() - seal_size);
  std::ofstream(path, std::ios::binary) << bytes << seal_of(bytes);
}

}  // namespace ra2d::test
