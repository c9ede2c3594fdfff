// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

/// Commands that the Python package answers (host/python): it draws, plays and compares.
namespace ra2d {

/// Hands a request to the package and prints its answer. `request["command"]` names the function of
/// host/python/ra2d/commands.py that answers it. Files that it makes are named in the request: they
/// are there, empty, and the caller puts them in place. Messages are the package's own, on stderr.
/// Returns the exit status. Throws FileError, which says what to install, where no python3 has what
/// the package needs.
int ask_python(const nlohmann::ordered_json& request);

/// A path as a request holds it: its bytes as the first 256 characters of Unicode, since names need
/// not be UTF-8.
std::string path_text(const std::filesystem::path& path);
std::vector<std::string> path_texts(const std::vector<std::filesystem::path>& paths);

/// The kind of a picture by the ending of its name: "png", "svg" or "pdf". Throws RequestError for
/// another.
std::string picture_kind(const std::filesystem::path& picture);

/// As ask_python(), for the command "plot": the picture appears whole or not at all.
int make_picture(nlohmann::ordered_json request, const std::filesystem::path& picture);

}  // namespace ra2d
