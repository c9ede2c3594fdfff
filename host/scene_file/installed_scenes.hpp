// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

/// The scenes and studies that come with the program: beside the installed one, or in the source
/// that it was built from.
namespace ra2d {

struct InstalledScene {
  std::string name;  // of the file, without .toml
  std::filesystem::path file;
  std::string about;  // its first line, a comment
  bool is_study = false;
};

/// All of them by name. Throws FileError where their folder is missing.
std::vector<InstalledScene> installed_scenes();

/// The file that a user means: `given`, or the installed scene of that name. A name is one word
/// without an ending, and no file or folder here has it. Throws FileError for an unknown name, and
/// for an installed scene's name with its ending.
std::filesystem::path scene_file_of(const std::filesystem::path& given);

}  // namespace ra2d
