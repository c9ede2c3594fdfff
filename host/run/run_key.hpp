// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/model/model.hpp"

/// What tells one run from another: two runs of one key give the same bits.
namespace ra2d {

/// Raised by whoever changes the bits of an answer on purpose (CONTRIBUTING.md).
inline constexpr int numerics_version = 1;

/// XXH3-128, as 32 hexadecimal digits, of the scene with all its keys, of both bodies' heights, of the
/// version of the numerics and of the build's arithmetic. Neither the scene's name nor the place of its
/// files is in it, nor the number of threads.
std::string run_key(const Model& model);

}  // namespace ra2d
