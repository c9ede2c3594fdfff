// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace ra2d {

/// A sound within a page.
struct Clip {
  std::string caption;       // markup
  std::string data_address;  // "data:audio/wav;base64,..."
};

/// The sounds of a result; none, and why, where it has none.
struct Clips {
  std::vector<Clip> clips;
  std::string why_none;  // markup
};

/// The first probe's noise of each result, as it is and slowed down, all to one scale, so that what
/// sounds louder is louder. Long ones are shortened; of many results the first ones alone have
/// sounds.
std::vector<Clips> clips_of(const std::vector<std::filesystem::path>& results);

}  // namespace ra2d
