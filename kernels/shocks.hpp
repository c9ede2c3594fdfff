// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/function.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// Shocks: connected pieces of contact in space and time. A slider node in contact belongs to the
/// same shock as its neighbours, at this step and at the one before: in a plane scene the node
/// before and the node after it, in an areal one the eight around it. Functions without lanes run
/// on one.
namespace ra2d {

/// Whether the buffer of ended shocks can take all that a single step can end.
KOKKOS_INLINE_FUNCTION bool can_record_shocks(const ShockBuffer& ended, const RunBuffer& runs) {
  return ended.capacity - ended.count > runs.capacity;
}

/// Whether the launch is to end, wherever it is (SceneTables::interrupted).
KOKKOS_INLINE_FUNCTION bool is_interrupted(const int* interrupted) {
  return interrupted != nullptr && Kokkos::atomic_load(interrupted) != 0;
}

KOKKOS_INLINE_FUNCTION void record_shock(ShockBuffer& ended, const OpenShock& shock) {
  RA2D_CHECK(ended.count < ended.capacity);
  ended.rows[ended.count++] = {shock.serial, shock.start,         shock.last,
                               shock.peak,   shock.impulse,       shock.moment,
                               shock.place,  shock.across_moment, shock.row};
}

/// Records the open shocks that had no contact at `step`. The runs still point to the others.
KOKKOS_INLINE_FUNCTION void end_shocks(ShockTracking& shocks, ShockBuffer& ended,
                                       std::int64_t step) {
  for (int i = shocks.open_count - 1; i >= 0; --i) {
    if (shocks.open[i].last == step) continue;
    record_shock(ended, shocks.open[i]);
    const int moved = --shocks.open_count;  // the last one fills the hole
    if (moved == i) continue;
    shocks.open[i] = shocks.open[moved];
    for (int r = 0; r < shocks.run_count; ++r)
      if (shocks.runs[r].shock == moved) shocks.runs[r].shock = i;
  }
}

/// The two shocks turned out to be one: the older takes over, the younger's serial stays unused.
/// Its peak is the larger of the two until they met.
KOKKOS_INLINE_FUNCTION int merge_shocks(ShockTracking& shocks, RunBuffer& runs, int a, int b,
                                        int new_runs) {
  if (a == b) return a;
  const int keep = shocks.open[a].serial < shocks.open[b].serial ? a : b, drop = a + b - keep;
  OpenShock &old = shocks.open[keep], &young = shocks.open[drop];
  old.impulse += young.impulse;
  old.moment += young.moment;
  old.across_moment += young.across_moment;
  old.peak = old.peak > young.peak ? old.peak : young.peak;
  const std::int64_t last = old.last > young.last ? old.last : young.last;
  old.force = (old.last == last ? old.force : 0.0) + (young.last == last ? young.force : 0.0);
  old.last = last;
  const int moved = --shocks.open_count;
  if (drop != moved) shocks.open[drop] = shocks.open[moved];
  const auto relabel = [&](ContactRun* list, int count) {
    for (int r = 0; r < count; ++r) {
      if (list[r].shock == drop) list[r].shock = keep;
      if (list[r].shock == moved) list[r].shock = drop == moved ? keep : drop;
    }
  };
  relabel(shocks.runs, shocks.run_count);
  relabel(runs.next, new_runs);
  return keep == moved ? drop : keep;
}

/// Where a force acts on the slider, along x [chi].
KOKKOS_FORCEINLINE_FUNCTION double centre(const ContactList& list, const RunBuffer& runs, int e) {
  if (list.centres != nullptr) return list.centres[e];
  return runs.row == 0 ? list.nodes[e] : list.nodes[e] % runs.row;
}

/// Merges `shock` (none: negative) with those of the runs of a list, `count` in ascending order,
/// that have nodes from `first` to `last`. `from`: the run to begin with; it moves on to the first
/// of them, for later calls with higher nodes.
KOKKOS_INLINE_FUNCTION int merge_met(ShockTracking& shocks, RunBuffer& runs, const ContactRun* list,
                                     int count, int first, int last, int new_runs, int shock,
                                     int& from) {
  while (from < count && list[from].last < first) ++from;
  for (int b = from; b < count && list[b].first <= last; ++b)
    shock = shock < 0 ? list[b].shock : merge_shocks(shocks, runs, shock, list[b].shock, new_runs);
  return shock;
}

/// Takes in the contact from step `first` to step `last`, with the same nodes in contact: `count`
/// of them in ascending order, their forces [N] summed over those steps, and the moments of these
/// forces about `position` [chi].
template <class Moment>
KOKKOS_INLINE_FUNCTION void join_shocks(ShockTracking& shocks, RunBuffer& runs, ShockBuffer& ended,
                                        const ContactList& list, int count, std::int64_t first,
                                        std::int64_t last, double position, const Moment& moment) {
  // the runs of neighbouring nodes at this step
  int made = 0;
  RA2D_KEEP_LOOP
  for (int e = 0; e < count; ++e) {
    const int node = list.nodes[e];
    if (made == 0 || runs.next[made - 1].last != node - 1) {
      RA2D_CHECK(made < runs.capacity);
      runs.next[made++] = {node, node, -1, 0.0, 0.0};
    }
    ContactRun& run = runs.next[made - 1];
    run.last = node;
    run.force += list.forces[e];
    run.moment += moment(e);
  }
  // each continues a run that was next to it one step ago, or begins a shock
  if (shocks.runs_step != first - 1) shocks.run_count = 0;
  int before = 0, row_before = 0, row_after = 0, this_step = 0;
  for (int r = 0; r < made; ++r) {
    ContactRun& run = runs.next[r];
    const int left = run.first - 1, right = run.last + 1, row = runs.row;
    int shock = merge_met(shocks, runs, shocks.runs, shocks.run_count, left, right, r, -1, before);
    if (row != 0) [[unlikely]] {
      // the rows beside it, one step ago; the row before it, at this step: those are done
      shock = merge_met(shocks, runs, shocks.runs, shocks.run_count, left - row, right - row, r,
                        shock, row_before);
      shock = merge_met(shocks, runs, shocks.runs, shocks.run_count, left + row, right + row, r,
                        shock, row_after);
      shock = merge_met(shocks, runs, runs.next, r, left - row, right - row, r, shock, this_step);
    }
    if (shock < 0) {
      RA2D_CHECK(shocks.open_count < 2 * runs.capacity);
      shock = shocks.open_count++;
      const int across = row == 0 ? 0 : run.first / row, along = run.first - across * row;
      OpenShock begun{};
      begun.serial = shocks.begun++;
      begun.start = first;
      begun.last = last;
      begun.place = along + position;
      begun.row = across;
      shocks.open[shock] = begun;
    }
    run.shock = shock;
    OpenShock& open = shocks.open[shock];
    open.force = open.last == last ? open.force + run.force : run.force;
    open.last = last;
    open.impulse += run.force;
    open.moment += run.moment + run.force * position;
    if (row != 0) open.across_moment += run.force * (run.first / row);
  }
  ContactRun* const old = shocks.runs;
  shocks.runs = runs.next;
  runs.next = old;
  shocks.run_count = made;
  shocks.runs_step = last;
  end_shocks(shocks, ended, last);
}

/// Takes in the contact of one step: the `count` listed nodes in ascending order; `position` of
/// slider node 0 on the resonator, in chi.
KOKKOS_INLINE_FUNCTION void track_shocks(ShockTracking& shocks, RunBuffer& runs, ShockBuffer& ended,
                                         const ContactList& list, int count, std::int64_t step,
                                         double position) {
  join_shocks(shocks, runs, ended, list, count, step, step, position,
              [&](int e) { return list.forces[e] * centre(list, runs, e); });
  for (int i = 0; i < shocks.open_count; ++i)
    if (shocks.open[i].force > shocks.open[i].peak) shocks.open[i].peak = shocks.open[i].force;
}

/// The usual case of track_shocks: every run of neighbouring nodes continues one run of the step
/// before, as the only one, and every open shock is one run. False, with nothing changed, when it
/// is not so, and in areal scenes, where contacts mostly reach over several rows.
KOKKOS_FORCEINLINE_FUNCTION bool continue_shocks(ShockTracking& shocks, RunBuffer& runs,
                                                 const ContactList& list, int count,
                                                 std::int64_t step, double position) {
  if (shocks.runs_step != step - 1 || shocks.open_count != shocks.run_count || runs.row != 0)
    return false;
  int run = 0, e = 0;
  for (; e < count && run < shocks.run_count; ++run) {
    const int first = list.nodes[e];
    int last = first;
    double force = list.forces[e], moment = force * centre(list, runs, e);
    while (++e < count && list.nodes[e] == last + 1) {
      ++last;
      force += list.forces[e];
      moment += list.forces[e] * centre(list, runs, e);
    }
    const ContactRun& before = shocks.runs[run];
    if (first > before.last + 1 || last < before.first - 1) return false;
    if (run > 0 && first <= shocks.runs[run - 1].last + 1) return false;
    if (run + 1 < shocks.run_count && last >= shocks.runs[run + 1].first - 1) return false;
    runs.next[run] = {first, last, before.shock, force, moment};
  }
  if (e < count || run < shocks.run_count) return false;
  for (run = 0; run < shocks.run_count; ++run) {
    const ContactRun& now = runs.next[run];
    OpenShock& open = shocks.open[now.shock];
    open.force = now.force;
    open.last = step;
    open.peak = now.force > open.peak ? now.force : open.peak;
    open.impulse += now.force;
    open.moment += now.moment + now.force * position;
  }
  ContactRun* const old = shocks.runs;
  shocks.runs = runs.next;
  runs.next = old;
  shocks.runs_step = step;
  return true;
}

/// The nodes of a list that are in contact, and the sums of their forces in two parts of the list.
struct ListedContact {
  std::uint32_t nodes = 0;  // a bit for each, of the first 32 of the list
  double force[2] = {};     // N
  double moment[2] = {};    // N, sum of f_n n

  /// Adds listed node number e, of the second part from the bit `second` on. `bit`: 1 << e.
  KOKKOS_FORCEINLINE_FUNCTION void add(std::uint32_t bit, std::uint32_t second, int node,
                                       double f) {
    nodes |= bit;
    const double own = f * node;
    if (bit < second) {
      force[0] += f;
      moment[0] += own;
    } else {
      force[1] += f;
      moment[1] += own;
    }
  }
};

/// The most usual case of track_shocks, out of memory: the same few runs of neighbouring nodes
/// touch step after step, a shock each. Not in areal scenes. Each lane has it.
class SteadyShocks {
 public:
  /// Moves the open shocks from `shocks` here if the steady case may apply. `step`: the latest one
  /// that they include.
  KOKKOS_FORCEINLINE_FUNCTION void take_over(const ShockTracking& shocks, const RunBuffer& runs,
                                             std::int64_t step) {
    if (runs.row != 0 || shocks.run_count > most || shocks.open_count != shocks.run_count) return;
    next_ = step + 1;
    count_ = shocks.run_count;
    for (int r = 0; r < most; ++r) {
      if (r >= count_) continue;
      const ContactRun& run = shocks.runs[r];
      const OpenShock& open = shocks.open[run.shock];
      steady_[r] = {run.first, run.last,     run.shock,  open.force,
                    open.peak, open.impulse, open.moment};
    }
  }
  /// Whether at `step` the nodes in contact of the same list would be enough.
  KOKKOS_FORCEINLINE_FUNCTION bool lasts_to(std::int64_t step) const {
    return step == next_ && listed_ != 0;
  }
  /// The bit that the second run begins with, for ListedContact; without one there is none so high.
  KOKKOS_FORCEINLINE_FUNCTION std::uint32_t second() const { return second_; }
  /// Takes in the contact of the step that lasts_to() was asked about. False, with nothing changed,
  /// when other nodes of the list are in contact than a step ago.
  KOKKOS_FORCEINLINE_FUNCTION bool take(const ListedContact& now, double position) {
    if (now.nodes != listed_) return false;
    ++next_;
    add(steady_[0], now.force[0], now.moment[0], position);
    if (count_ > 1) add(steady_[1], now.force[1], now.moment[1], position);
    return true;
  }
  /// After the contact of a step, which was `nodes` of a list of `length`.
  KOKKOS_FORCEINLINE_FUNCTION void hold(std::uint32_t nodes, int length) {
    listed_ = next_ >= 0 && length <= 32 ? nodes : 0;
    if (listed_ == 0) return;
    std::uint32_t rest = listed_;
    for (int node = steady_[0].first; node <= steady_[0].last; ++node) rest &= rest - 1;
    second_ = count_ > 1 ? rest & (~rest + 1) : ~0u;
  }
  /// Nodes are listed anew.
  KOKKOS_FORCEINLINE_FUNCTION void begin_list() { listed_ = 0; }

  /// Takes in the contact of one step, as track_shocks does. False, with nothing changed, when it
  /// is not this case.
  KOKKOS_FORCEINLINE_FUNCTION bool take(const ContactList& list, int count, std::int64_t step,
                                        double position) {
    if (step != next_) return false;
    int e = 0;
    for (int r = 0; r < most; ++r) {
      if (r >= count_) continue;
      const int end = e + steady_[r].last - steady_[r].first;
      if (end >= count || list.nodes[e] != steady_[r].first || list.nodes[end] != steady_[r].last)
        return false;
      e = end + 1;
    }
    if (e < count) return false;
    ++next_;
    e = 0;
    for (int r = 0; r < most; ++r) {
      if (r >= count_) continue;
      Steady& now = steady_[r];
      double force = list.forces[e], moment = force * place(list, e, now.first);
      ++e;
      for (int node = now.first; node < now.last; ++e) {
        ++node;
        force += list.forces[e];
        moment += list.forces[e] * place(list, e, node);
      }
      add(now, force, moment, position);
    }
    return true;
  }
  /// Back to `shocks`, before anything else reads or changes them. The leader writes.
  KOKKOS_FORCEINLINE_FUNCTION void put_back(ShockTracking& shocks, bool leader) {
    if (next_ < 0) return;
    if (leader) shocks.runs_step = next_ - 1;
    for (int r = 0; r < most; ++r) {
      if (r >= count_ || !leader) continue;
      OpenShock& open = shocks.open[steady_[r].shock];
      open.last = next_ - 1;
      open.force = steady_[r].force;
      open.peak = steady_[r].peak;
      open.impulse = steady_[r].impulse;
      open.moment = steady_[r].moment;
    }
    next_ = -1;
    listed_ = 0;
  }

 private:
  static constexpr int most = 2;  // a loop of so many rounds is unrolled: registers have no index
  struct Steady {
    int first, last, shock;               // see ContactRun
    double force, peak, impulse, moment;  // see OpenShock
  };
  std::int64_t next_ = -1;  // the step that would continue it; negative: it is not this case
  int count_ = 0;
  Steady steady_[most]{};
  std::uint32_t listed_ = 0, second_ = ~0u;  // see hold(); none: it is not known

  KOKKOS_FORCEINLINE_FUNCTION static void add(Steady& now, double force, double moment,
                                              double position) {
    now.force = force;
    if (force > now.peak) now.peak = force;
    now.impulse += force;
    now.moment += moment + force * position;
  }
  /// As centre(), without reading the node.
  KOKKOS_FORCEINLINE_FUNCTION static double place(const ContactList& list, int e, int node) {
    return list.centres == nullptr ? node : list.centres[e];
  }
};

/// The cheapest variant of track_shocks that applies; called by all lanes.
template <class Lanes>
KOKKOS_FORCEINLINE_FUNCTION void take_contact(const Lanes& lanes, SteadyShocks& steady,
                                              ShockTracking& shocks, RunBuffer& runs,
                                              ShockBuffer& ended, const ContactList& list,
                                              int count, std::int64_t step, double position) {
  lanes.sync();  // the list
  if (steady.take(list, count, step, position)) [[likely]]
    return;
  steady.put_back(shocks, lanes.leader());
  lanes.sync();
  if (lanes.leader() && !continue_shocks(shocks, runs, list, count, step, position))
    track_shocks(shocks, runs, ended, list, count, step, position);
  lanes.sync();
  steady.take_over(shocks, runs, step);
}

}  // namespace ra2d
