// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/scene/scene.hpp"
#include "host/scene_file/reader.hpp"

namespace ra2d {

/// Finds faults between the values of a scene, each of which is fine by itself. Values that were at
/// fault already are NaN, and every check is written so that NaN passes it.
void check(const Scene& scene, Document& document);

}  // namespace ra2d
