// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <array>
#include <cstddef>
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

template <Form form, TeamShape shape>
void march_one(const SceneTables& tables, SceneState& state, std::int64_t target);
template <Form form, TeamShape shape>
void march_listed(const Space& space, const ScenesToMarch& scenes);

template <TeamShape... S>
struct ShapeList {
  static constexpr TeamShape at(int i) { return std::array{S...}[static_cast<std::size_t>(i)]; }
  static constexpr TeamShape smallest(int modes) {
    TeamShape least{};
    for (const TeamShape& shape : {S...})
      if (shape.modes() >= modes && (least.packs == 0 || shape.modes() < least.modes()))
        least = shape;
    return least;
  }
};

/// As wide as a GPU's warp, or a pack of a CPU.
template <int... packs>
using WholeTeams = ShapeList<TeamShape{LanesOf<Space>::width, packs}...>;
// up to most_modes with any width of the lanes
#if defined(RA2D_ONE_MARCH)
template <Form form>
using Shapes = WholeTeams<most_modes / LanesOf<Space>::width>;
#elif defined(RA2D_WARPS)
/// The steps of Form::semi_implicit are so short that much of them is work of one lane: four scenes
/// share a warp (docs/gpu.md).
template <Form form>
using Shapes = std::conditional_t<form == Form::semi_implicit,
                                  ShapeList<TeamShape{32, 1}, TeamShape{32, 2}, TeamShape{32, 4},
                                            TeamShape{32, 8}, TeamShape{8, 3}>,
                                  WholeTeams<1, 2, 4, 8> >;
#else
template <Form form>
using Shapes = std::conditional_t<LanesOf<Space>::width == 8, WholeTeams<1, 3, 8, 32>,
                                  WholeTeams<2, 6, 16, most_modes / LanesOf<Space>::width> >;
#endif

}  // namespace ra2d
