// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/scene/scene.hpp"
#include "host/scene_file/reader.hpp"

namespace ra2d {

/// Names what is wrong between the values of a scene, each fine by itself. Values that were at
/// fault already are NaN, and every check is written so that NaN passes it.
void check(const Scene& scene, Document& document);

}  // namespace ra2d
