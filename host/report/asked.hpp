// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "host/scene/scene.hpp"

namespace ra2d {

/// Names and values, as markup.
using FactTable = std::vector<std::pair<std::string, std::string>>;

/// The settings of a scene, as rows of a table.
FactTable asked_facts(const Scene& scene);

}  // namespace ra2d
