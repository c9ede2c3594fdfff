// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

#include "host/store/hdf5.hpp"

/// The seal of a finished HDF5 file: a line of text behind HDF5's own end of the file, over all
/// bytes before it (docs/results.md). HDF5 and what is made of it take no notice of the line when
/// they read, and cut it off when they write. HDF5 itself may crash on a single flipped bit: it is
/// given no file whose seal does not fit.
namespace ra2d {

inline constexpr std::size_t seal_size = 64;  // bytes

/// "ra2d seal 1 ", the number of bytes in 18 digits, a space, their XXH3-128 in 32 digits, a line
/// end.
std::string seal_of(std::string_view bytes);

/// Appends its seal to a file that is open for reading and writing. Returns 0, or an errno.
int append_seal(int descriptor);

/// Reads every byte of an open file: whether it ends in a seal that fits. False also where it
/// cannot be read.
bool has_fitting_seal(int descriptor);

/// Why a file cannot be read, without its name: "No such file or directory", "it is no regular
/// file".
struct Unreadable : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Why a file is not given to HDF5: "it is damaged: ...".
struct Unsealed : Unreadable {
  using Unreadable::Unreadable;
};

/// Whether a file looks like HDF5, or like what is left of a sealed file. Throws Unreadable.
bool looks_like_hdf5(const std::filesystem::path& file);

/// Whether a file looks like HDF5, has no fitting seal, and is likely to be one of ours: HDF5 finds
/// its root's `attribute` or cannot open it. A child process asks. Throws FileError where it cannot
/// be read.
bool is_damaged_with(const std::filesystem::path& file, const char* attribute);

/// Whether a file may be given to HDF5. One process reads the bytes of a file for that once, as
/// long as the system says that nobody changed it. Throws Unreadable, and Unsealed where it may
/// not.
void require_seal(const std::filesystem::path& file);

/// Opens an HDF5 file for reading, after the same look at the same bytes. Throws h5::Failure, too.
/// The library is taken by the caller.
h5::File open_sealed(const std::filesystem::path& file);

}  // namespace ra2d
