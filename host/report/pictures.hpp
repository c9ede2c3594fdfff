// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/analysis/analysis.hpp"
#include "host/analysis/level_history.hpp"

namespace ra2d {

/// A chart, and the words below it. Both are markup.
struct Picture {
  std::string svg, caption;
};

/// Of one result; what there is nothing of is left out.
std::vector<Picture> pictures_of(const Analysis& analysis, const LevelHistory& history);

}  // namespace ra2d
