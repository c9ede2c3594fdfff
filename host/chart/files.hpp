// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

/// What a chart leaves behind: texts, and pictures drawn by a Python script.
namespace ra2d {

/// Writes a text under its final name once it is complete (host/output_file.hpp says what that may
/// replace). Throws FileError.
void write_text(const std::filesystem::path& path, const std::string& text);

/// Runs a script of ours (host/chart/*.py, installed under share/ra2d) with the first python3 that
/// has matplotlib: the one on the PATH, or the system's. Throws FileError, which says what to
/// install, when there is none or when the script fails.
void draw(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace ra2d
