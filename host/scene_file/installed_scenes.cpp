// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/installed_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/system/input_file.hpp"
#include "host/system/process.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t read_at_most = 1 << 16;  // bytes: the first comment and the first keys

/// Beside the installed program, or in the source.
std::vector<fs::path> folders_of_scenes() {
  return {(program_folder() / RA2D_SCENES_FROM_PROGRAM).lexically_normal(), RA2D_SCENES_SOURCE};
}

InstalledScene describe(const fs::path& file) {
  const std::string text = InputFile(file, "the scene").beginning(read_at_most);
  InstalledScene scene{file.stem().string(), file, {}, text.find("\n[vary]") != text.npos};
  if (text.starts_with('#'))
    scene.about = trimmed(std::string_view(text).substr(1, text.find('\n') - 1));
  return scene;
}

/// A word that no file here has.
bool is_free_word(const fs::path& given) {
  std::error_code none;
  return !given.empty() && given == given.filename() &&
         !fs::exists(fs::symlink_status(given, none));
}

/// Refuses the file name of an installed scene, such as dang2012.toml, where no file has it.
void require_no_ending(const fs::path& given) {
  std::error_code none;
  for (const fs::path& folder : folders_of_scenes())
    if (fs::exists(folder / given, none))
      throw FileError(fmt::format(
          "cannot read the scene '{}': there is no such file. '{}', without an ending, is the one "
          "that comes with ra2d",
          given.string(), given.stem().string()));
}

}  // namespace

std::vector<InstalledScene> installed_scenes() {
  const std::vector<fs::path> folders = folders_of_scenes();
  std::error_code none;
  const auto folder = std::find_if(folders.begin(), folders.end(), [&](const fs::path& one) {
    return fs::is_directory(one, none);
  });
  if (folder == folders.end())
    throw FileError(fmt::format("the scenes are neither at '{}' nor at '{}': install ra2d again",
                                folders[0].string(), folders[1].string()));
  std::vector<InstalledScene> scenes;
  for (const fs::directory_entry& entry : fs::directory_iterator(*folder))
    if (entry.path().extension() == ".toml" && entry.is_regular_file())
      scenes.push_back(describe(entry.path()));
  std::sort(scenes.begin(), scenes.end(),
            [](const InstalledScene& a, const InstalledScene& b) { return a.name < b.name; });
  return scenes;
}

fs::path scene_file_of(const fs::path& given) {
  if (!is_free_word(given)) return given;
  if (given.has_extension()) {
    require_no_ending(given);
    return given;
  }
  std::vector<std::string> names;
  for (const InstalledScene& scene : installed_scenes()) {
    if (scene.name == given) return scene.file;
    names.push_back(scene.name);
  }
  const auto near = nearest(given.string(), names);
  throw FileError(fmt::format(
      "cannot read the scene '{}': there is no such file, and no scene of "
      "this name comes with ra2d{}. 'ra2d scenes' lists them",
      shortened(given.string()), near ? fmt::format(" (did you mean '{}'?)", *near) : ""));
}

}  // namespace ra2d
