// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "tests/warp/scene_on_lanes.hpp"

namespace ra2d::test {

/// Marches a scene on a thread, with packs as wide as its team (march_program.hpp) and the
/// functions that both share (portable_functions.hpp).
void march_on_pack(SceneOnLanes& scene, std::int64_t target);

// one form each, in files of their own
template <Form form>
void march_form(SceneOnLanes& scene, std::int64_t target);

}  // namespace ra2d::test
