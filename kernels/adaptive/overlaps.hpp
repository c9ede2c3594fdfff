// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/crossing.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/check.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/group_sweep.hpp"
#include "kernels/lanes.hpp"
#include "kernels/near_groups.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// What can touch within a step of length h. That no contact begins unseen is proved, not sampled:
///
///   find_near  groups of nodes that cannot come near within the step are left out;
///   see        of the others the overlap and its rate are taken at both ends of the step;
///   flag       the cubic through these four numbers is off by at most h^4/384 of the overlap's
///   fourth
///              derivative, for which there is a bound (MotionBounds). A node whose cubic stays
///              below that is open throughout; every other open node is flagged;
///   search     a flagged node's own series is searched for the first place where the overlap
///   reaches
///              zero (kernels/adaptive/crossing.hpp).
///
/// To touch, an overlap must come to +touch, to let go to -touch (kernels/adaptive/contacts.hpp), a
/// bound on its roundings: otherwise a contact that has just begun could end by a rounding.
template <class Lanes, int K>
class Overlaps {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION Overlaps(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                           const NodeContact<Lanes, K>& contact,
                           const ModalSeries<Lanes, K>& series)
      : lanes_{lanes},
        t_{tables},
        s_{state},
        contact_{contact},
        series_{series},
        near_{lanes, tables, state},
        before_{state.seen},
        after_{state.seen + 2 * tables.groups * width} {}

  /// Bound on the roundings of an overlap at the displacements u [m]: 128 of half an ulp, in packs
  /// of two lanes 256, of one 512. The longest chain, over 256 modes and the terms of a series, has
  /// 53 in packs of eight lanes, 83 of four, 146 of two and 273 of one.
  KOKKOS_FORCEINLINE_FUNCTION double touch(const Real* u) const {
    constexpr double roundings = width >= 4 ? 0x1p-46 : width == 2 ? 0x1p-45 : 0x1p-44;
    return t_.slack + roundings * weighted_sum<Lanes, K>(lanes_, t_.largest_shape, u);
  }

  /// What an overlap can rise by within a step from u on [m], and twice the error of seeing it.
  KOKKOS_FUNCTION double longest_rise(const Real* u, const MotionBounds& bounds,
                                      std::int64_t ticks) const {
    const double way = static_cast<double>(ticks) * t_.advance;
    double slope = t_.steepest;
    if (way > 0.0) slope += t_.spacing * weighted_sum<Lanes, K>(lanes_, t_.largest_slope, u);
    return bounds.travel + way * slope + 2.0 * blur(bounds);
  }

  /// A near list that holds over the step, and likely over the `later` ticks after it.
  KOKKOS_FUNCTION void find_near(const Place& place, const ModalState<Lanes, K>& now,
                                 const MotionBounds& bounds, double rise, std::int64_t later) {
    if (t_.look_at == Nodes::all || near_.holds(now.u, place, rise)) return;
    // what the modes may do within the step, and can be expected to do after it
    const double time = static_cast<double>(later) * t_.step;
    const double expected =
        time < 1e30 ? time * weighted_sum<Lanes, K>(lanes_, t_.largest_shape, now.v) : 0.0;
    near_.find(now.u, place, 1.5 * rise + 0.5 * expected + t_.least_reach, bounds.rounding(), 0.0);
    seen_ = false;
  }

  /// Sees the beginning of the step, ...
  KOKKOS_FUNCTION void see_beginning(const Place& place, const ModalState<Lanes, K>& now) {
    if (!seen_ && groups() > 0) see(place, now.u, now.v, before_);
    seen_ = true;
  }
  /// ... and its end.
  KOKKOS_FUNCTION void see_end(const Place& place, const Real* u, const Real* v) {
    if (groups() > 0) see(place, u, v, after_);
  }
  /// What was seen at the end of a step is what the next one begins with; but where a node has
  /// passed another, or a contact has begun, the present must be seen anew.
  KOKKOS_FUNCTION void pass_on() {
    double* const swap = before_;
    before_ = after_;
    after_ = swap;
  }
  KOKKOS_FUNCTION void forget() { seen_ = false; }

  /// Whether the cubics of a step of `time` [s] are off by more than what is seen: if not, those of
  /// a shorter step tell no more.
  KOKKOS_FORCEINLINE_FUNCTION bool shorter_tells_more(double time,
                                                      const MotionBounds& bounds) const {
    return cubic_error(bounds, time) > blur(bounds);
  }

  /// Lists the open nodes that could touch within a step of `time` [s] whose ends have been seen.
  /// Which they are must not depend on the near list: the length of the next step does on them. So
  /// they are none of those that every near list may leave out.
  KOKKOS_FUNCTION int flag(double time, const MotionBounds& bounds, double rise) const {
    const int all = groups();
    if (all == 0) return 0;
    const double level = -(cubic_error(bounds, time) + blur(bounds));
    const double start = -(rise - blur(bounds));
    const double third = time / 3.0;
    int count = 0, closed = 0;
    for (int e = 0; e < all; ++e) {
      const double* first = before_ + 2 * e * width;
      const double* last = after_ + 2 * e * width;
      // the cubic lies between the smallest and the largest of its Bernstein coefficients
      const Real b0 = lanes_.load(first), b3 = lanes_.load(last);
      const Real b1 = multiply_add(third, lanes_.load(first + width), b0);
      const Real b2 = multiply_add(-third, lanes_.load(last + width), b3);
      const Real most = Kokkos::max(Kokkos::max(b0, b1), Kokkos::max(b2, b3));
      std::uint32_t bits = lanes_.at_least(most, level);
      if (bits != 0) bits &= lanes_.at_least(b0, start);
      const int left = t_.nodes - group(e) * width;
      if (left < width) bits &= (1u << left) - 1u;
      for (; bits != 0; bits &= bits - 1) {
        const int node = group(e) * width + Kokkos::countr_zero(bits);
        while (closed < s_.closed_count && s_.closed[closed] < node) ++closed;
        if (closed < s_.closed_count && s_.closed[closed] == node) continue;
        RA2D_CHECK(count < t_.nodes);
        if (lanes_.leader()) s_.watch[count] = node;
        ++count;
      }
    }
    lanes_.sync();
    return count;
  }

  /// Where the first of the flagged nodes touches, in units of the series; beyond `end` if none.
  /// Each one's own place is left in the list of roots.
  KOKKOS_FUNCTION double search(const Place& place, int flagged, double end, double touch) const {
    contact_.expand(place, s_.watch, flagged);
    double first = 2.0 * end + 1.0;
    for (int e = 0; e < flagged; ++e) {
      series_.overlap_of(s_.watch[e], place, s_.scan);
      const int n = series_.degree();
      const Hull hull = hull_of(lanes_, t_, s_.scan, n, end, s_.hull_room);
      double x = 2.0 * end + 1.0;
      if (hull.most >= 0.75 * touch)
        x = first_crossing(s_.scan, n, 1.0, touch, 0.25 * touch, end, hull.curve);
      lanes_.sync();
      if (lanes_.leader()) s_.roots[e] = x;
      if (x < first) first = x;
    }
    lanes_.sync();
    return first;
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  const NodeContact<Lanes, K>& contact_;
  const ModalSeries<Lanes, K>& series_;
  NearGroups<Lanes, K> near_;
  // overlaps and their rates at the beginning and at the end of a step
  double *before_, *after_;
  bool seen_ = false;  // `before_` is of the present state and near list

  KOKKOS_FORCEINLINE_FUNCTION int groups() const {
    return t_.look_at == Nodes::all ? t_.groups : near_.count();
  }
  KOKKOS_FORCEINLINE_FUNCTION int group(int e) const {
    return t_.look_at == Nodes::all ? e : near_[e];
  }

  /// Error of an overlap that is seen [m]. Of the roundings one is of the value, up to a third of
  /// one of the rate over the step, and one of the series that is searched.
  KOKKOS_FORCEINLINE_FUNCTION double blur(const MotionBounds& bounds) const {
    return bounds.cubic_remainder + 3.0 * bounds.rounding() + 2.0 * t_.slack;
  }
  /// ... and of the cubic through what is seen at both ends of a step.
  KOKKOS_FORCEINLINE_FUNCTION double cubic_error(const MotionBounds& bounds, double time) const {
    const double square = time * time;
    return t_.cubic_excess * bounds.fourth * square * square / 384.0;
  }

  /// Overlaps and their rates [m, m/s] of the near groups, to the cubics over their patches.
  KOKKOS_FUNCTION void see(const Place& place, const Real* u, const Real* v, double* to) {
    GroupSweep<Lanes, K> sweep(lanes_, t_, place, s_.lanes, u, v);
    const double speed = t_.advance / t_.step;  // chi/s
    const int count = groups();
    for (int e = 0; e < count; ++e) {
      const auto [overlap, modes, way] = sweep.overlap_and_rates(group(e));
      lanes_.store(to + (2 * e) * width, overlap);
      lanes_.store(to + (2 * e + 1) * width, multiply_add(speed, way, modes));
    }
    if (lanes_.leader()) s_.evaluated += static_cast<std::int64_t>(count) * width;
    lanes_.sync();
  }
};

}  // namespace ra2d
