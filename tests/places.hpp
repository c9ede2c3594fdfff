// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>

/// Programs and folders that tests use: this build's, or those that the environment names
/// (RA2D_PROGRAM, RA2D_SOURCE_DIR, RA2D_PYTHON, RA2D_FAULTY_DISK, RA2D_MPIRUN), as in a bundle.
namespace ra2d::test {

/// The program ra2d.
std::string program();

/// The folder that holds scenes/ and tests/.
std::filesystem::path source_folder();

/// A file of scenes/ by its name without .toml.
std::string scene_file(const std::string& name);

/// The library that makes calls to a disk fail and sets the wall clock (tests/faults); empty where
/// none can be loaded.
std::string faulty_disk();

/// The mpirun of the MPI that the program was built with; empty where there is none.
std::string mpirun();

/// A Python with h5py, netCDF4, scipy, xarray and xxhash; empty when RA2D_PYTHON says that there is
/// none.
std::string python();
#define RA2D_SKIP_WITHOUT_PYTHON()    \
  if (ra2d::test::python().empty()) { \
    GTEST_SKIP() << "no Python here"; \
  }                                   \
  static_assert(true)

}  // namespace ra2d::test
