// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "tests/pack.hpp"
// before the kernels
#include "host/device/launch.hpp"
#include "kernels/march.hpp"

namespace ra2d::test {

static_assert(pack_width == LanesOf<Space>::width);

/// Compiled beside one another: a few packs, so that sums go over several.
inline constexpr int plain_packs = Packs::at(1);

/// The march of production on lanes that are nothing but doubles.
template <Form form>
void plain_march(const SceneTables& tables, SceneState& state, std::int64_t target) {
  march_scene<PackLanes, form, plain_packs>(PackLanes(), tables, state, target);
}

// one form each, in files of their own
extern template void plain_march<Form::semi_implicit>(const SceneTables&, SceneState&,
                                                      std::int64_t);
extern template void plain_march<Form::staged>(const SceneTables&, SceneState&, std::int64_t);
extern template void plain_march<Form::implicit>(const SceneTables&, SceneState&, std::int64_t);
extern template void plain_march<Form::adaptive>(const SceneTables&, SceneState&, std::int64_t);

}  // namespace ra2d::test
