// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/model/model.hpp"

/// What looks odd in a scene, but may be meant. A sentence each, said before a run; nothing is
/// refused for it.
namespace ra2d {

/// Of the scene alone: numbers that are likely to be in another unit, a contact stiffer than the
/// bodies' materials, loads that nothing holds.
std::vector<std::string> scene_doubts(const Scene& scene);

/// Of a model's faces: heights and slopes that no face has, a gap that does not go with them.
void doubt_faces(const Model& model, std::vector<std::string>& doubts);

}  // namespace ra2d
