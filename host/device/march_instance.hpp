// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/device/launch.hpp"
#include "kernels/march.hpp"

namespace ra2d {

#if defined(RA2D_WARPS)
template <Form form, TeamShape shape>
void march_listed(const Space& space, const ScenesToMarch& l) {
  using Lanes = LanesOf<Space>::type<shape.width>;
  March<Space, Lanes, form, shape.packs>{
      l.tables, l.states,  l.scenes,
      l.count,  l.targets, static_cast<std::uint64_t>(l.most_seconds / l.tick),
      l.tick,   l.seconds}
      .launch(space, l.multiprocessors);
}
/// Compiles the march of one form for the i-th shape.
#define RA2D_MARCH(form, i) \
  template void march_listed<form, Shapes<form>::at(i)>(const Space&, const ScenesToMarch&)
#else
template <Form form, TeamShape shape>
void march_one(const SceneTables& tables, SceneState& state, std::int64_t target) {
  march_scene<HostLanes, form, shape.packs>(HostLanes(tables.modes.count), tables, state, target);
}
/// Compiles the march of one form for the i-th shape.
#define RA2D_MARCH(form, i) \
  template void march_one<form, Shapes<form>::at(i)>(const SceneTables&, SceneState&, std::int64_t)
#endif

/// Compile it for few and for many modes, and for teams that share a warp: each a file.
#define RA2D_MARCH_FEW(form) \
  RA2D_MARCH(form, 0);       \
  RA2D_MARCH(form, 1)
#if defined(RA2D_ONE_MARCH)
#define RA2D_MARCH_MANY(form) RA2D_MARCH(form, 0)
#else
#define RA2D_MARCH_MANY(form) \
  RA2D_MARCH(form, 2);        \
  RA2D_MARCH(form, 3)
#endif
#define RA2D_MARCH_SHARED(form) RA2D_MARCH(form, 4)

}  // namespace ra2d
