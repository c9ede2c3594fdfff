// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// Shocks: connected pieces of contact in space and time. A slider node in contact belongs to the
/// same shock as its neighbours, at this step and at the one before. These functions run on one
/// lane.
namespace ra2d {

/// Room left in the buffer of ended shocks for whatever a single step can end.
KOKKOS_INLINE_FUNCTION bool has_room_for_shocks(const SceneState& s) {
  return s.shock_capacity - s.shock_count > s.run_capacity;
}

/// Whether the launch is to end, wherever it is (SceneTables::interrupted).
KOKKOS_INLINE_FUNCTION bool is_interrupted(const SceneTables& t) {
  return t.interrupted != nullptr && Kokkos::atomic_load(t.interrupted) != 0;
}

KOKKOS_INLINE_FUNCTION void hand_out(SceneState& s, const OpenShock& shock) {
  RA2D_CHECK(s.shock_count < s.shock_capacity);
  s.shock_rows[s.shock_count++] = {shock.serial,  shock.start,  shock.last, shock.peak,
                                   shock.impulse, shock.moment, shock.place};
}

/// Hands out the open shocks that had no contact at `step`; every other one keeps its place in the
/// runs.
KOKKOS_INLINE_FUNCTION void end_shocks(SceneState& s, std::int64_t step) {
  for (int i = s.open_count - 1; i >= 0; --i) {
    if (s.open[i].last == step) continue;
    hand_out(s, s.open[i]);
    const int moved = --s.open_count;  // the last one fills the hole
    if (moved == i) continue;
    s.open[i] = s.open[moved];
    for (int r = 0; r < s.run_count; ++r)
      if (s.runs[r].shock == moved) s.runs[r].shock = i;
  }
}

/// The two shocks turned out to be one: the older takes over, the younger's serial stays unused.
/// Its peak is the larger of the two until they met.
KOKKOS_INLINE_FUNCTION int merge_shocks(SceneState& s, int a, int b, int new_runs) {
  if (a == b) return a;
  const int keep = s.open[a].serial < s.open[b].serial ? a : b, drop = a + b - keep;
  OpenShock &old = s.open[keep], &young = s.open[drop];
  old.impulse += young.impulse;
  old.moment += young.moment;
  old.peak = old.peak > young.peak ? old.peak : young.peak;
  const std::int64_t last = old.last > young.last ? old.last : young.last;
  old.force = (old.last == last ? old.force : 0.0) + (young.last == last ? young.force : 0.0);
  old.last = last;
  const int moved = --s.open_count;
  if (drop != moved) s.open[drop] = s.open[moved];
  const auto relabel = [&](ContactRun* runs, int count) {
    for (int r = 0; r < count; ++r) {
      if (runs[r].shock == drop) runs[r].shock = keep;
      if (runs[r].shock == moved) runs[r].shock = drop == moved ? keep : drop;
    }
  };
  relabel(s.runs, s.run_count);
  relabel(s.new_runs, new_runs);
  return keep == moved ? drop : keep;
}

/// Takes in the contact from step `first` to step `last`, in which the same nodes touch: `count` of
/// them in ascending order, with their forces [N], summed over those steps, and these forces'
/// moments about the place that is `position` [chi] away from where shocks are measured from.
template <class Moment>
KOKKOS_INLINE_FUNCTION void join_shocks(SceneState& s, std::int64_t first, std::int64_t last,
                                        double position, int count, const Moment& moment) {
  // the runs of neighbouring nodes at this step
  int runs = 0;
  for (int e = 0; e < count; ++e) {
    const int node = s.touched[e];
    if (runs == 0 || s.new_runs[runs - 1].last != node - 1) {
      RA2D_CHECK(runs < s.run_capacity);
      s.new_runs[runs++] = {node, node, -1, 0.0, 0.0};
    }
    ContactRun& run = s.new_runs[runs - 1];
    run.last = node;
    run.force += s.touched_force[e];
    run.moment += moment(e);
  }
  // each continues what touched next to it one step ago, or begins a shock
  if (s.runs_step != first - 1) s.run_count = 0;
  int before = 0;
  for (int r = 0; r < runs; ++r) {
    ContactRun& run = s.new_runs[r];
    while (before < s.run_count && s.runs[before].last < run.first - 1) ++before;
    int shock = -1;
    for (int b = before; b < s.run_count && s.runs[b].first <= run.last + 1; ++b)
      shock = shock < 0 ? s.runs[b].shock : merge_shocks(s, shock, s.runs[b].shock, r);
    if (shock < 0) {
      RA2D_CHECK(s.open_count < 2 * s.run_capacity);
      shock = s.open_count++;
      s.open[shock] = {s.shocks_begun++, first, last, 0.0, 0.0, 0.0, 0.0, run.first + position};
    }
    run.shock = shock;
    OpenShock& open = s.open[shock];
    open.force = open.last == last ? open.force + run.force : run.force;
    open.last = last;
    open.impulse += run.force;
    open.moment += run.moment + run.force * position;
  }
  ContactRun* const old = s.runs;
  s.runs = s.new_runs;
  s.new_runs = old;
  s.run_count = runs;
  s.runs_step = last;
  end_shocks(s, last);
}

/// Takes in the contact of one step: the `count` touched nodes in ascending order; `position` of
/// slider node 0 on the resonator, in chi.
KOKKOS_INLINE_FUNCTION void track_shocks(SceneState& s, std::int64_t step, double position,
                                         int count) {
  join_shocks(s, step, step, position, count,
              [&](int e) { return s.touched_force[e] * s.touched[e]; });
  for (int i = 0; i < s.open_count; ++i)
    if (s.open[i].force > s.open[i].peak) s.open[i].peak = s.open[i].force;
}

/// The usual case of track_shocks: every run of neighbouring nodes continues one run of the step
/// before, as the only one, and every open shock is one run. False, with nothing changed, when it
/// is not so.
KOKKOS_FORCEINLINE_FUNCTION bool continue_shocks(SceneState& s, std::int64_t step, double position,
                                                 int count) {
  if (s.runs_step != step - 1 || s.open_count != s.run_count) return false;
  int run = 0, e = 0;
  for (; e < count && run < s.run_count; ++run) {
    const int first = s.touched[e];
    int last = first;
    double force = s.touched_force[e], moment = force * first;
    while (++e < count && s.touched[e] == last + 1) {
      ++last;
      force += s.touched_force[e];
      moment += s.touched_force[e] * last;
    }
    const ContactRun& before = s.runs[run];
    if (first > before.last + 1 || last < before.first - 1) return false;
    if (run > 0 && first <= s.runs[run - 1].last + 1) return false;
    if (run + 1 < s.run_count && last >= s.runs[run + 1].first - 1) return false;
    s.new_runs[run] = {first, last, before.shock, force, moment};
  }
  if (e < count || run < s.run_count) return false;
  for (run = 0; run < s.run_count; ++run) {
    const ContactRun& now = s.new_runs[run];
    OpenShock& open = s.open[now.shock];
    open.force = now.force;
    open.last = step;
    open.peak = now.force > open.peak ? now.force : open.peak;
    open.impulse += now.force;
    open.moment += now.moment + now.force * position;
  }
  ContactRun* const old = s.runs;
  s.runs = s.new_runs;
  s.new_runs = old;
  s.runs_step = step;
  return true;
}

}  // namespace ra2d
