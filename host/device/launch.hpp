// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <array>
#include <cstdint>
#include <type_traits>

#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// The march is compiled for a few numbers of mode packs; a scene takes the smallest that holds it.
/// Padding does not change a bit of the answer.
namespace ra2d {

using Space = Kokkos::DefaultExecutionSpace;
using TablesView = Kokkos::View<SceneTables*, Space>;
using StatesView = Kokkos::View<SceneState*, Space>;
using ScenesView = Kokkos::View<int*, Space>;

/// The smallest compiled number of packs that holds this one, in every form.
int compiled_packs(int needed);

/// One launch: every running scene of those listed, all of one form, goes on to step `target`.
void launch_march(Form form, int packs, const TablesView& tables, const StatesView& states,
                  const ScenesView& scenes, std::int64_t target);

/// One compiled march; each is compiled in one of the files march_*.cpp.
template <Form form, int K>
void march(const TablesView& tables, const StatesView& states, const ScenesView& scenes,
           std::int64_t target);

template <int... K>
struct PackList {
  static constexpr int at(int i) { return std::array{K...}[i]; }
  static int smallest(int needed) {
    int packs = 0;
    (void)((K >= needed && (packs = K, true)) || ...);
    return packs;
  }
};
// up to 256 modes with any width of the lanes
#if defined(RA2D_ONE_MARCH)
using Packs = PackList<256 / LanesOf<Space>::width>;
#else
using Packs =
    std::conditional_t<LanesOf<Space>::width == 32, PackList<1, 2, 4, 8>,
                       std::conditional_t<LanesOf<Space>::width == 8, PackList<1, 3, 8, 32>,
                                          PackList<2, 6, 16, 256 / LanesOf<Space>::width> > >;
#endif

}  // namespace ra2d
