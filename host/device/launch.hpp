// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <array>
#include <cstdint>
#include <type_traits>

#include "host/device/device.hpp"
#include "host/device/marches.hpp"
#include "kernels/lanes.hpp"
#include "kernels/limits.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// For the files that compile the marches: their launch by Kokkos.
namespace ra2d {

using Space = Kokkos::DefaultExecutionSpace;

/// Whether a team's lanes are the threads of a warp.
inline constexpr bool marches_on_gpu = LanesOf<Space>::vector_length > 1;

/// Each to its target, a team each.
void launch_march(const Space& space, const ScenesToMarch& scenes);

template <Form form, int K>
void march_one(const SceneTables& tables, SceneState& state, std::int64_t target);
template <Form form, int K>
void march_listed(const Space& space, const ScenesToMarch& scenes);

template <int... K>
struct PackList {
  static constexpr int at(int i) { return std::array{K...}[i]; }
  static int smallest(int needed) {
    int packs = 0;
    (void)((K >= needed && (packs = K, true)) || ...);
    return packs;
  }
};
// up to most_modes with any width of the lanes
#if defined(RA2D_ONE_MARCH)
using Packs = PackList<most_modes / LanesOf<Space>::width>;
#else
using Packs = std::conditional_t<
    LanesOf<Space>::width == 32, PackList<1, 2, 4, 8>,
    std::conditional_t<LanesOf<Space>::width == 8, PackList<1, 3, 8, 32>,
                       PackList<2, 6, 16, most_modes / LanesOf<Space>::width> > >;
#endif

}  // namespace ra2d
