// SPDX-License-Identifier: BSD-3-Clause
#include "tests/places.hpp"

#include <cstdlib>

namespace ra2d::test {
namespace {

std::string named(const char* variable, const char* otherwise) {
  const char* value = std::getenv(variable);
  return value ? value : otherwise;
}

}  // namespace

std::string program() { return named("RA2D_PROGRAM", RA2D_TEST_PROGRAM); }

std::filesystem::path source_folder() { return named("RA2D_SOURCE_DIR", RA2D_TEST_SOURCE_DIR); }

std::string scene_file(const std::string& name) {
  return source_folder() / "scenes" / (name + ".toml");
}

std::string faulty_disk() { return named("RA2D_FAULTY_DISK", RA2D_TEST_FAULTY_DISK); }

std::string mpirun() { return named("RA2D_MPIRUN", RA2D_TEST_MPIRUN); }

std::string python() { return named("RA2D_PYTHON", RA2D_TEST_PYTHON); }

}  // namespace ra2d::test
