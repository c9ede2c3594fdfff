// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

/// Pictures, drawn by Python scripts.
namespace ra2d {

/// Runs a script of ours (host/plot/*.py, installed under share/ra2d) with the first python3 that
/// has matplotlib: the one on the PATH, or the system's. Throws FileError, which says what to
/// install, when there is none or when the script fails.
void draw(const std::string& script, const std::vector<std::string>& arguments);

/// The kind of a picture by the ending of its name: "png", "svg" or "pdf". Throws RequestError for
/// another.
std::string picture_kind(const std::filesystem::path& picture);

/// Runs a script with two more arguments, the file that is drawn into and the kind of the picture.
/// The picture appears whole or not at all.
void draw_picture(const std::string& script, std::vector<std::string> arguments,
                  const std::filesystem::path& picture);

}  // namespace ra2d
