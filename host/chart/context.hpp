// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <utility>
#include <vector>

/// Where timings come from.
namespace ra2d {

/// The compiler of the program, with its version.
std::string compiler_name();

/// What a file of timings says of the program and the machine: what, and which.
std::vector<std::pair<std::string, std::string>> timing_context();

}  // namespace ra2d
