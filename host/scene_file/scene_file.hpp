// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

/// Scenes as TOML, in and out.
namespace ra2d {

class ParsedText;  // host/scene_file/reader.hpp

/// Reads and checks a scene (docs/scene.md). `overrides` are "section.key=value" texts of
/// --set. Throws RequestError that names every fault at once, FileError when the file cannot be
/// read.
Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// Reads and checks the text of a scene. `file` is used in messages and to resolve relative paths.
Scene parse_scene(const std::string& text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides = {});

/// Reads one of many scenes that differ in their overrides alone. Its faults have no lines, nor has
/// Scene::places: for a message read its text.
Scene parse_scene(const ParsedText& text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides);

/// The scene as TOML, complete (defaults included): reading it again gives the same scene, from any
/// folder, since it names profiles by absolute path.
/// Keys that the scene's choices do not use carry a comment "# not used: why".
std::string echo(const Scene& scene);

/// Reads the echo that a result keeps. Those of programs whose faces were linear by default have no
/// key `faces` where they are. Throws as parse_scene.
Scene parse_echo(const std::string& text, const std::filesystem::path& file);

/// A surface as the inline table of a scene in `folder`.
std::string surface_text(const SurfaceSpec& surface, const std::filesystem::path& folder);

}  // namespace ra2d
