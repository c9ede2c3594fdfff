// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

/// Pictures, drawn by Python scripts.
namespace ra2d {

/// Runs a script of ours (host/chart/*.py, installed under share/ra2d) with the first python3 that
/// has matplotlib: the one on the PATH, or the system's. Throws FileError, which says what to
/// install, when there is none or when the script fails.
void draw(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace ra2d
