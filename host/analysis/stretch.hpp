// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>

#include "host/scene/scene.hpp"
#include "host/store/result_reader.hpp"

namespace ra2d {

/// The part of a run that is analysed or played.
struct Stretch {
  double from = 0, to = 0;           // s
  bool whole = true;                 // all that the file's own summary counts
  std::size_t first = 0, count = 0;  // its samples
};

/// From `from` to `to` [s]; without them from output.from of the scene to the end of the run, or
/// its output.window. Throws RequestError where the run has nothing there. `file` is named in that.
Stretch choose_stretch(const ResultContents& contents, const std::optional<Scene>& scene,
                       const std::filesystem::path& file, std::optional<double> from,
                       std::optional<double> to);

/// The scene that a result carries; none where this program does not understand it.
std::optional<Scene> scene_of(const ResultContents& contents, const std::filesystem::path& file);

}  // namespace ra2d
