// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "host/surface/map_file.hpp"

namespace ra2d {

/// Whether a file that begins so is an array of NumPy.
bool begins_as_npy(std::string_view bytes);

/// An array of NumPy (format versions 1.0 to 3.0), of two dimensions: (rows, x), float32 or float64
/// of either byte order, in C's or Fortran's order of elements. NaN is a missing point. Nothing is
/// held for what the header claims until the file is seen to have it. Throws RequestError, with the
/// file and what is wrong; FileError where it cannot be read.
BareMap read_map_npy(const std::filesystem::path& file);

/// The header of a float64 array of shape (rows, columns) in C's order, lowest byte first.
std::string npy_header(std::size_t rows, std::size_t columns);

}  // namespace ra2d
