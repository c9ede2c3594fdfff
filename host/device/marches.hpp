// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// The marches, compiled for a few numbers of packs of modes in files of their own
/// (host/CMakeLists.txt makes them).
namespace ra2d {

/// The smallest number of packs of modes compiled for at least `needed`; 0 if there is none.
int compiled_packs(int needed);

/// Marches one scene to `target`, on the thread that calls.
using MarchScene = void (*)(const SceneTables&, SceneState&, std::int64_t target);
/// Throws std::logic_error in a build for a GPU, which has none for the host.
MarchScene march_of(Form form, int packs);

}  // namespace ra2d
