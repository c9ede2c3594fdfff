// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/adaptive_march.hpp"
#include "kernels/fixed/fixed_march.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"
#include "kernels/warp.hpp"

/// The launch: one team marches one scene.
namespace ra2d {

/// Copies what the host wants to know of a scene to where it reads it.
template <class Lanes, int packs>
RA2D_FUNCTION void publish(const Lanes& lanes, const CarriedState& carried, CarriedCopies& now) {
  constexpr int width = Lanes::width;
  for (int p = 0; p < filled<packs>(lanes); ++p) {
    const int row = p * width;
    lanes.store(now.u + row, lanes.load(carried.modal.u + row));
    lanes.store(now.v + row, lanes.load(carried.modal.v + row));
    lanes.store(now.square + row, lanes.load(carried.modal.square + row));
    lanes.store(now.square_part + row, lanes.load(carried.modal.square_part + row));
  }
  lanes.store(now.deflection_work_part, lanes.load(carried.sums.deflection_work_part));
  if (lanes.leader())
    for (int i = 0; i < carried.shocks.open_count; ++i) now.open[i] = carried.shocks.open[i];
}

/// Marches one scene to step `target`, its end, the end of the time, a full buffer, an interrupt or
/// a failure.
template <class Lanes, Form form, int packs>
RA2D_FUNCTION void march_scene(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                               std::int64_t target) {
  if constexpr (form == Form::adaptive)
    AdaptiveMarch<Lanes, packs>(lanes, tables, state).run(target);
  else
    FixedMarch<Lanes, form, packs>(lanes, tables, state).run(target);
  publish<Lanes, packs>(lanes, state.carried, state.out.now);
}

#if defined(RA2D_WARPS)
/// A launch on a GPU: scenes of one form, a team of `Lanes` each, to their targets. Addresses of
/// the device.
template <class Space, class Lanes, Form form, int packs>
struct March {
  /// Scenes of a block. The instructions of `adaptive` do not fit in the caches of a multiprocessor
  /// (docs/gpu.md), so its scenes keep step with one another (AdaptiveMarch::enter): as many as the
  /// multiprocessor has room for. Sixteen leave 128 registers to a thread, eight all 255. Where
  /// teams may not wait for one another, a block is a warp.
  static constexpr int most_in_block = form != Form::adaptive || !warp::teams_may_wait
                                           ? warp::size / Lanes::width
                                       : packs == 1 ? 16
                                                    : 8;
  /// Blocks that a multiprocessor has room for. Of NVIDIA's, twelve leave 168 registers to a
  /// thread: of what was measured on a card the fastest (docs/gpu.md).
  static constexpr int least_blocks =
      warp::size == 32 && form == Form::semi_implicit && packs * Lanes::width <= 32 ? 12 : 1;
  using Policy =
      Kokkos::TeamPolicy<Space, Kokkos::LaunchBounds<most_in_block * Lanes::width, least_blocks>>;
  using Member = typename Policy::member_type;

  const SceneTables* tables;
  SceneState* states;
  const int* scenes;
  int count;
  const std::int64_t* targets;
  std::uint64_t most;  // ticks of the GPU's clock: what each may take
  double tick;         // s
  double* seconds;     // out: what each took

  RA2D_FUNCTION void operator()(const Member& member) const {
    const int i = member.league_rank() * member.team_size() + member.team_rank();
    if (i >= count) return;
    const int scene = scenes[i];
    const std::uint64_t begin = warp::clock();
    const Lanes lanes(begin + most);
    march_scene<Lanes, form, packs>(lanes, tables[scene], states[scene], targets[scene]);
    const std::uint64_t end = warp::clock();
    if (lanes.leader())
      seconds[scene] = end > begin ? tick * static_cast<double>(end - begin) : 0.0;
  }
  /// Before a block has more scenes than one, the multiprocessors have all their blocks.
  void launch(const Space& space, int multiprocessors) const {
    const int blocks = multiprocessors * least_blocks, each = (count + blocks - 1) / blocks;
    const int in_block = each < most_in_block ? each : most_in_block;
    Kokkos::parallel_for("ra2d::march",
                         Policy(space, (count + in_block - 1) / in_block, in_block, Lanes::width),
                         *this);
  }
};
#endif

}  // namespace ra2d
