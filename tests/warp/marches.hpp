// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "host/device/layout.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"
#include "tests/warp/warp.hpp"

/// The marches of production, on 32 lanes.
namespace ra2d::test {

/// Packs of 32 modes that are compiled.
inline constexpr int most_packs = 2;
/// With `adaptive` also so many, for nodes in contact in clusters.
inline constexpr int clustered_packs = 4;

/// Marches a scene of `packs` packs on a thread whose packs are as wide as a warp.
void march_on_pack(int packs, const SceneTables& tables, SceneState& state, std::int64_t target);
/// Marches it on 32 lanes.
void march_on_warp(Warp& warp, int packs, const SceneTables& tables, SceneState& state,
                   std::int64_t target);

// one form each, in files of their own
template <Form form>
void march_form_on_pack(int packs, const SceneTables& tables, SceneState& state,
                        std::int64_t target);
template <Form form>
void march_form_on_warp(Warp& warp, int packs, const SceneTables& tables, SceneState& state,
                        std::int64_t target);

}  // namespace ra2d::test
