// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "tests/pack.hpp"
// before the kernels
#include "kernels/march.hpp"
#include "tests/warp/marches.hpp"

namespace ra2d::test {

template <Form form>
void march_form_on_pack(int packs, const SceneTables& tables, SceneState& state,
                        std::int64_t target) {
  static_assert(most_packs == 2 && clustered_packs == 4);
  const PackLanes lanes;
  if constexpr (form == Form::adaptive)
    if (packs == clustered_packs)
      return march_scene<PackLanes, form, clustered_packs>(lanes, tables, state, target);
  packs == 1 ? march_scene<PackLanes, form, 1>(lanes, tables, state, target)
             : march_scene<PackLanes, form, 2>(lanes, tables, state, target);
}

template <Form form>
void march_form_on_warp(Warp& warp, int packs, const SceneTables& tables, SceneState& state,
                        std::int64_t target) {
  warp.run([&](int lane) {
    const FiberLanes lanes{warp, lane};
    if constexpr (form == Form::adaptive)
      if (packs == clustered_packs)
        return march_scene<FiberLanes, form, clustered_packs>(lanes, tables, state, target);
    packs == 1 ? march_scene<FiberLanes, form, 1>(lanes, tables, state, target)
               : march_scene<FiberLanes, form, 2>(lanes, tables, state, target);
  });
}

#define RA2D_WARP_MARCHES(form)                                                               \
  template void march_form_on_pack<form>(int, const SceneTables&, SceneState&, std::int64_t); \
  template void march_form_on_warp<form>(Warp&, int, const SceneTables&, SceneState&, std::int64_t)

}  // namespace ra2d::test
