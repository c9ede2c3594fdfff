// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/device/launch.hpp"
#include "kernels/march.hpp"

namespace ra2d {

#if defined(KOKKOS_ENABLE_CUDA)
template <Form form, int K>
void march_listed(const Space& space, const ScenesToMarch& l) {
  March<Space, form, K>{l.tables, l.states,  l.scenes,
                        l.count,  l.targets, static_cast<std::uint64_t>(1e9 * l.most_seconds),
                        l.seconds}
      .launch(space, l.multiprocessors);
}
/// Compiles the march of one form for the i-th number of packs.
#define RA2D_MARCH(form, i) \
  template void march_listed<form, Packs::at(i)>(const Space&, const ScenesToMarch&)
#else
template <Form form, int K>
void march_one(const SceneTables& tables, SceneState& state, std::int64_t target) {
  march_scene<HostLanes, form, K>(HostLanes(tables.modes.count), tables, state, target);
}
/// Compiles the march of one form for the i-th number of packs.
#define RA2D_MARCH(form, i) \
  template void march_one<form, Packs::at(i)>(const SceneTables&, SceneState&, std::int64_t)
#endif

/// Compile it for the lower and the upper half of these numbers: half a form a file.
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

}  // namespace ra2d
