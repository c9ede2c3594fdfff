// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/model/model.hpp"

/// Doubts: values of a scene that look wrong but may be intended. Each is a sentence that is
/// printed before a run; nothing is refused.
namespace ra2d {

/// Doubts of the scene alone: numbers that are likely to be in another unit, a contact stiffer than
/// the bodies' materials, loads that nothing holds.
std::vector<std::string> scene_doubts(const Scene& scene);

/// Appends doubts of a model's faces: heights and slopes that no face has, a gap that does not fit
/// them, and smooth faces whose cells are too wide for the modes' shapes or for their splines.
void doubt_faces(const Model& model, std::vector<std::string>& doubts);

/// Appends a doubt where microphones would hear modes at frequencies that are not theirs, since
/// they ring above half the rate of the samples.
void doubt_sound(const Model& model, std::vector<std::string>& doubts);

}  // namespace ra2d
