// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <utility>
#include <vector>

/// Where timings come from.
namespace ra2d {

/// The compiler of the program, with its version.
std::string compiler_name();

/// The program and the machine of a file of timings: names and values.
std::vector<std::pair<std::string, std::string>> timing_context();

}  // namespace ra2d
