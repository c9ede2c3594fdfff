// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <memory>

#include "host/store/hdf5.hpp"
#include "host/store/seal.hpp"
#include "host/system/crash_message.hpp"

/// HDF5 files whose bytes are known before HDF5 sees them (host/store/seal.hpp). The library is
/// taken by the caller.
namespace ra2d {

namespace h5 {
/// While it lives, a crash of HDF5 ends the program with status 4 and a message about this file: a
/// forger can give hostile bytes a seal that fits.
class CrashWatch {
 public:
  explicit CrashWatch(const std::filesystem::path& file);

 private:
  CrashMessage message_;
};
}  // namespace h5

/// Opens a sealed file for reading. HDF5 gets every byte through SealedBytes: a call of HDF5 that
/// would need a damaged one fails, and h5::check then throws Unsealed. Throws FileError,
/// Unreadable, Unsealed and h5::Failure.
h5::File open_sealed(const std::filesystem::path& file);
/// As above, through these bytes, which know afterwards what HDF5 did not need.
h5::File open_sealed(const std::filesystem::path& file, std::shared_ptr<SealedBytes> bytes);

/// Whether a file looks like HDF5, has no fitting seal, and is probably one of ours: HDF5 finds its
/// root's `attribute` or cannot open it. A child process asks. Throws FileError where it cannot be
/// read.
bool is_damaged_with(const std::filesystem::path& file, const char* attribute);

}  // namespace ra2d
