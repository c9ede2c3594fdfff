// SPDX-License-Identifier: BSD-3-Clause
// The marches of a build for a GPU, of RA2D_TEST_PACKS packs as wide as a warp, on a thread of the
// host: a library of its own, since its Kokkos is another than that of the build for a GPU.
#include "tests/pack.hpp"
//
#include "kernels/march.hpp"

using namespace ra2d;
using test::PackLanes;

/// Marches a scene to `target`, or to what ends it before. False for forms that are not compiled.
extern "C" __attribute__((visibility("default"))) bool ra2d_march_on_pack(const SceneTables& tables,
                                                                          SceneState& state,
                                                                          std::int64_t target) {
  switch (tables.scheme.form) {
    case Form::adaptive:
      march_scene<PackLanes, Form::adaptive, RA2D_TEST_PACKS>(PackLanes(), tables, state, target);
      return true;
    case Form::semi_implicit:
      march_scene<PackLanes, Form::semi_implicit, RA2D_TEST_PACKS>(PackLanes(), tables, state,
                                                                   target);
      return true;
    default:
      return false;
  }
}
