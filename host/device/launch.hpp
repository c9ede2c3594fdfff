// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <array>
#include <cstdint>
#include <type_traits>

#include "host/device/arena.hpp"
#include "kernels/lanes.hpp"
#include "kernels/limits.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// The march is compiled for a few numbers of packs of modes, in files of their own
/// (host/device/march_*.cpp).
namespace ra2d {

using TablesView = Kokkos::View<SceneTables*, Space>;
using StatesView = Kokkos::View<SceneState*, Space>;
using TargetsView = Kokkos::View<std::int64_t*, Space>;
using ScenesView = Kokkos::View<int*, Space>;

/// The smallest number of packs of modes compiled for at least `needed`; 0 if there is none.
int compiled_packs(int needed);

/// On a CPU: marches one scene to `target`, on the thread that calls.
using MarchScene = void (*)(const SceneTables&, SceneState&, std::int64_t target);
MarchScene march_of(Form form, int packs);

/// On a GPU: marches the listed scenes, all of one form and one number of packs, each to its target.
void launch_march(const Space& space, Form form, int packs, const TablesView& tables,
                  const StatesView& states, const ScenesView& scenes, const TargetsView& targets);

template <Form form, int K>
void march_one(const SceneTables& tables, SceneState& state, std::int64_t target);
template <Form form, int K>
void march_listed(const Space& space, const TablesView& tables, const StatesView& states,
                  const ScenesView& scenes, const TargetsView& targets);

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
