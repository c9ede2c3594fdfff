// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/adaptive_march.hpp"
#include "kernels/fixed/fixed_march.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// The launch: one team marches one scene.
namespace ra2d {

/// Marches one scene to step `target`, its end, a full buffer, an interrupt or a failure.
template <class Lanes, Form form, int K>
KOKKOS_FUNCTION void march_scene(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                                 std::int64_t target) {
  if constexpr (form == Form::adaptive)
    AdaptiveMarcher<Lanes, K>(lanes, tables, state).run(target);
  else
    FixedMarch<Lanes, form, K>(lanes, tables, state).run(target);
}

/// A launch on a GPU: scenes of one form, a team each, to their targets.
template <class Space, Form form, int K>
struct March {
  using Policy = Kokkos::TeamPolicy<Space>;
  using Member = typename Policy::member_type;
  using Lanes = typename LanesOf<Space>::template type<Member>;

  Kokkos::View<const SceneTables*, Space> tables;
  Kokkos::View<SceneState*, Space> states;
  Kokkos::View<const int*, Space> scenes;
  Kokkos::View<const std::int64_t*, Space> targets;

  KOKKOS_FUNCTION void operator()(const Member& member) const {
    const int scene = scenes(member.league_rank());
    march_scene<Lanes, form, K>(Lanes(member), tables(scene), states(scene), targets(scene));
  }
  void launch(const Space& space) const {
    Kokkos::parallel_for("ra2d::march",
                         Policy(space, scenes.extent_int(0), 1, LanesOf<Space>::vector_length),
                         *this);
  }
};

}  // namespace ra2d
