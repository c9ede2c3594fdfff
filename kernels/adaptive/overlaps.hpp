// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/crossing.hpp"
#include "kernels/adaptive/group_bounds.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/pace.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/candidate_groups.hpp"
#include "kernels/check.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/group_sweep.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The nodes whose contact can begin within a step of length h. That none begins unseen is proved,
/// not sampled:
///
///   find_groups  leaves out groups of nodes that cannot come into contact within the step;
///   evaluate     finds the overlap and its rate of the others at both ends of the step;
///   flag         the cubic through these four numbers is off by at most h^4/384 of the overlap's
///                fourth derivative, for which there is a bound (MotionBounds). A node whose cubic
///                stays below that has no contact in the step; every other free node is flagged;
///   search       searches the series of a flagged node for the first place where the overlap
///                comes to zero (kernels/adaptive/crossing.hpp).
///
/// Areal scenes have many candidate groups, of which few come near contact within a step. There
/// evaluate skips those that cannot (kernels/adaptive/group_bounds.hpp): no node or cell of them
/// could be flagged.
///
/// A contact begins at +tolerance and ends at -tolerance (kernels/adaptive/contacts.hpp). The
/// tolerance is more than an overlap's roundings, and never zero. So a contact that has just begun
/// cannot end at the same tick, and the march makes headway: a step of no length begins or ends
/// contacts, and at one tick each node can do only one of the two, once.
template <class Lanes, int packs>
class Overlaps {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  /// Lists nodes in `listed_nodes`; `evaluated` counts gaps. `amplitudes`: work space.
  RA2D_FUNCTION Overlaps(const Lanes& lanes, const SliderMotion& motion, const FaceTables& faces,
                         const SliderShapes& slider, const PatchTables& patches,
                         const MotionLimits& bounds, const SeriesTables& adaptive,
                         const NodeContact<Lanes, packs>& node_contact, const ContactSet& contacts,
                         CandidateLists& lists, double* amplitudes, int* listed_nodes,
                         OnsetSearch& search, GroupBuffers& groups, std::int64_t& evaluated)
      : lanes_{lanes},
        motion_{motion},
        faces_{faces},
        slider_{slider},
        patches_{patches},
        bounds_{bounds},
        adaptive_{adaptive},
        node_contact_{node_contact},
        contacts_{contacts},
        amplitudes_{amplitudes},
        listed_nodes_{listed_nodes},
        most_listed_{lists.most_listed},
        search_{search},
        evaluated_{evaluated},
        candidates_{lanes, motion, faces, slider, patches, bounds, lists, amplitudes, evaluated},
        group_bounds_{lanes, motion, faces, slider, bounds, lists, groups},
        start_{search.overlaps},
        end_{search.overlaps + 2 * faces.groups * width},
        is_selective_{faces.rows.across != nullptr && bounds.searched != Nodes::all} {}

  /// Bound on the roundings of an overlap at the displacements u [m]: 128 of half an ulp, in packs
  /// of two lanes 256, of one 512. The longest chain, over 256 modes and the terms of a series, has
  /// 53 in packs of eight lanes, 83 of four, 146 of two and 273 of one. Not zero even where nothing
  /// is rounded: between flat faces that touch, of bodies at rest.
  KOKKOS_FORCEINLINE_FUNCTION double overlap_rounding(const Real* u) const {
    constexpr double roundings = width >= 4 ? 0x1p-46 : width == 2 ? 0x1p-45 : 0x1p-44;
    constexpr double least = 1e-100;
    return Kokkos::max(least, faces_.rounding + roundings * weighted_sum<Lanes, packs>(
                                                                lanes_, bounds_.largest_shape, u));
  }

  /// Bounds on the rise of an overlap within a step from u on, and twice the error of its value.
  RA2D_FUNCTION Rise longest_rise(const Real* u, const MotionBounds& bounds,
                                  std::int64_t ticks) const {
    return with_path(u, bounds, ticks, {bounds.travel, bounds.travel, bounds.travel});
  }
  /// For a step whose end is known, if there is a footprint (knows_footprint): tighter ones.
  RA2D_FUNCTION Rise longest_rise(const Place& place, const ModalState<Lanes, packs>& now,
                                  const ModalState<Lanes, packs>& end, const MotionBounds& bounds,
                                  std::int64_t ticks) {
    const double time = static_cast<double>(ticks) * motion_.time_step;
    return longest_rise(place, now, end, bounds, ticks, time, time, cubic_error(bounds, time));
  }
  /// As above, of a step of any pace: `before`, `after` and `error` as GroupBounds::rise has them.
  RA2D_FUNCTION Rise longest_rise(const Place& place, const ModalState<Lanes, packs>& now,
                                  const ModalState<Lanes, packs>& end, const MotionBounds& bounds,
                                  std::int64_t ticks, double before, double after, double error) {
    Rise rise = group_bounds_.rise(place, now, end, before, after, error, bounds.travel);
    // of the displacements at both ends, and of the rates as far as these are more than what they
    // leave out
    const double sums = 4.0 * sums_error(bounds);
    rise = {rise.any + sums, rise.rest + sums, rise.end + sums};
    // candidate groups hold to the end of a spacing, a step may end a little beyond
    rise.any += 2.0 * (position_rounding(place) + motion_.advance) * faces_.steepest_rise;
    // and what is followed may be more than what a smooth face truly rises by
    const double distance = static_cast<double>(ticks) * motion_.advance;
    rise.any += distance * distance * faces_.largest_face_curvature;
    return with_path(now.u, bounds, ticks, rise);
  }
  KOKKOS_FORCEINLINE_FUNCTION bool knows_footprint() const {
    return group_bounds_.footprint().exists();
  }

  /// Finds candidate groups that hold over the step, and likely over the `later` ticks after it.
  RA2D_FUNCTION void find_groups(const Place& place, const ModalState<Lanes, packs>& now,
                                 const MotionBounds& bounds, const Rise& rise, std::int64_t later) {
    if (bounds_.searched == Nodes::all) return;
    if (knows_footprint()) {  // then longest_rise() has found the sums
      const double travel = rise.any + sums_error(bounds) + reference_error_;
      if (candidates_.holds(now.u, group_bounds_.start_sums(), place, travel)) return;
      reference_error_ = sums_error(bounds);
    } else if (candidates_.holds(now.u, place, rise.any)) {
      return;
    }
    // what the modes may do within the step, and can be expected to do after it
    const double time = static_cast<double>(later) * motion_.time_step;
    const double expected = time < 1e30 ? time * group_bounds_.footprint().most(place, now.v) : 0.0;
    candidates_.find(now.u, place, 1.5 * rise.any + 0.5 * expected + bounds_.least_range,
                     bounds.rounding(), 0.0);
    start_is_valid_ = false;
    if (is_selective_) [[unlikely]]
      group_bounds_.begin(place, candidates_.count());
  }

  /// Areal scenes: selects the groups whose overlaps are to be found for a step from u on, which
  /// rise by no more than `rise`.
  RA2D_FUNCTION void select(const Place& place, const Real* u, const MotionBounds& bounds,
                            const Rise& rise, std::int64_t ticks) {
    if (!is_selective_) [[likely]]
      return;
    start_is_valid_ = false;  // of the groups of the step before
    // the roundings of what is followed are far less than an overlap's error
    double least = highest_start(bounds, rise) - overlap_error(bounds);
    if (faces_.smooth) [[unlikely]]
      least -= modes_sag(u, bounds.travel);
    group_bounds_.select(place, candidates_.count(), static_cast<double>(ticks) * motion_.advance,
                         least);
    rise_at_end_ = rise.end;
  }
  /// For a step of so many ticks that ends elsewhere than groups were selected for.
  RA2D_FUNCTION void end_at(const Place& place, const ModalState<Lanes, packs>& now,
                            const ModalState<Lanes, packs>& end, const MotionBounds& bounds,
                            std::int64_t ticks) {
    if (!knows_footprint()) return;
    const double rise = group_bounds_.rise_at_end(place, now, end) + 2.0 * sums_error(bounds);
    rise_at_end_ = with_path(now.u, bounds, ticks, {rise, rise, rise}).end;
  }
  /// Finds overlaps and rates at both ends of the step; at its beginning, where the modes are at u0
  /// and v0, unless they are known.
  RA2D_FUNCTION void evaluate(const Place& start, const Real* u0, const Real* v0, const Place& end,
                              const Real* u1, const Real* v1) {
    if (groups() > 0)
      for (int side = start_is_valid_ ? 1 : 0; side < 2; ++side) {
        // copies: a choice between the two themselves would have them in a GPU's memory
        Real u[packs], v[packs];
        for (int p = 0; p < filled<packs>(lanes_); ++p) {
          u[p] = side == 0 ? u0[p] : u1[p];
          v[p] = side == 0 ? v0[p] : v1[p];
        }
        evaluate_at(side == 0 ? start : end, u, v, side == 0 ? start_ : end_);
      }
    start_is_valid_ = true;
  }
  /// Takes the overlaps at the end of a step for the beginning of the next, where the modes are at
  /// u. Where a node has passed another, or a contact has begun, they must be found anew:
  /// discard_start().
  RA2D_FUNCTION void end_becomes_start(const Place& end, const Real* u) {
    double* const swap = start_;
    start_ = end_;
    end_ = swap;
    end_bounds();
    if (is_selective_) [[unlikely]]
      group_bounds_.take(end, u, start_);
  }
  RA2D_FUNCTION void discard_start() {
    start_is_valid_ = false;
    end_bounds();
  }
  /// As discard_start(), where there is no bound on what a step has raised overlaps by.
  RA2D_FUNCTION void forget_start() {
    start_is_valid_ = false;
    if (is_selective_) [[unlikely]]
      group_bounds_.forget(candidates_.count());
  }

  /// Whether so many nodes could be flagged. In plane scenes all can.
  KOKKOS_FORCEINLINE_FUNCTION bool has_room(int flagged) const { return flagged <= most_listed_; }
  /// A number of nodes for which there never is.
  static constexpr int no_room = 0x7fffffff;
  /// Nodes that can be listed.
  KOKKOS_FORCEINLINE_FUNCTION int most_listed() const { return most_listed_; }

  /// Whether the cubics of a step of `time` [s] are off by more than the overlaps that they go
  /// through: if not, those of a shorter step are no better.
  KOKKOS_FORCEINLINE_FUNCTION bool shorter_is_better(double time,
                                                     const MotionBounds& bounds) const {
    return cubic_error(bounds, time) > overlap_error(bounds);
  }

  /// Lists the nodes whose contact could begin within a step of `time` [s], or (smooth faces, none
  /// in contact) the cells. They may be more than there is room for (has_room).
  /// The length of the next step depends on these nodes, so they must be the same whichever groups
  /// are listed. Hence no node is flagged that a list of candidate groups may leave out.
  RA2D_FUNCTION int flag(const Place& place, const Real* u, double time, const MotionBounds& bounds,
                         const Rise& rise) const {
    const int all = groups();
    if (all == 0) return 0;
    const double sag = faces_.smooth ? modes_sag(u, bounds.travel) : 0.0;
    const double level = -(cubic_error(bounds, time) + overlap_error(bounds) + sag);
    const double start = highest_start(bounds, rise) - sag;
    const double third = time / 3.0, distance = time * (motion_.advance / motion_.time_step);
    int count = 0, at = 0;
    for (int i = 0; i < all; ++i) {
      const int e = index(i);
      const double* first = start_ + 2 * e * width;
      const double* last = end_ + 2 * e * width;
      // the cubic lies between the smallest and the largest of its Bernstein coefficients
      const Real b0 = lanes_.load(first), b3 = lanes_.load(last);
      const Real b1 = multiply_add(third, lanes_.load(first + width), b0);
      const Real b2 = multiply_add(-third, lanes_.load(last + width), b3);
      const Real most = Kokkos::max(Kokkos::max(b0, b1), Kokkos::max(b2, b3));
      if (faces_.smooth) [[unlikely]] {
        flag_cells(place, group(e), b0, most, level, distance, start, count, at);
        continue;
      }
      std::uint32_t bits = lanes_.at_least(most, level);
      if (bits != 0) bits &= starts_high(place, group(e), b0, distance, start);
      const int left = nodes_left(faces_, group(e), width);
      if (left < width) bits &= (1u << left) - 1u;
      for (; bits != 0; bits &= bits - 1) {
        const int node = group(e) * width + Kokkos::Experimental::countr_zero_builtin(bits);
        while (at < contacts_.count && contacts_.nodes[at] < node) ++at;
        if (at < contacts_.count && contacts_.nodes[at] == node) continue;
        if (lanes_.leader() && count < most_listed_) listed_nodes_[count] = node;
        ++count;
      }
    }
    lanes_.sync();
    return count;
  }

  /// Where the first contact at a flagged node begins, in units of the series; beyond `end` if none
  /// does. OnsetSearch::onsets gets the place of each.
  /// Negative where there is no room for the nodes.
  RA2D_FUNCTION double search(const ModalSeries<Lanes, packs>& series, const Place& place,
                              int flagged, double end, double tolerance) const {
    if (faces_.smooth) [[unlikely]] {
      const PolynomialMotion<Lanes, packs> motion = series.motion(end);
      return search_cells(motion, motion.bounds(lanes_, bounds_, motion_.spacing).curvature, place,
                          flagged, tolerance);
    }
    if (!series.expand_nodes(place, listed_nodes_, flagged)) [[unlikely]]
      return -1.0;
    double first = 2.0 * end + 1.0;
    for (int e = 0; e < flagged; ++e) {
      series.overlap_of(listed_nodes_[e], place, search_.polynomial);
      const int n = series.degree();
      const Hull hull =
          hull_of(lanes_, series.hull_table(), search_.polynomial, n, end, search_.bernstein);
      double x = 2.0 * end + 1.0;
      if (hull.most >= 0.75 * tolerance)
        x = first_crossing(search_.polynomial, n, 1.0, tolerance, 0.25 * tolerance, end,
                           hull.curvature);
      lanes_.sync();
      if (lanes_.leader()) search_.onsets[e] = x;
      if (x < first) first = x;
    }
    lanes_.sync();
    return first;
  }

  // ---- smooth faces

  /// Of the cells flagged for a flight, those that its cubics leave.
  RA2D_FUNCTION int keep_close_in_flight(const Place& place, const Place& end_place,
                                         const ModalState<Lanes, packs>& now,
                                         const ModalState<Lanes, packs>& end, std::int64_t ticks,
                                         const MotionBounds& bounds, int flagged) const {
    const double time = static_cast<double>(ticks) * motion_.time_step,
                 slide_rate = static_cast<double>(ticks) * motion_.advance;
    Real rate0[packs], rate1[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      rate0[p] = Real(time) * now.v[p];
      rate1[p] = Real(time) * end.v[p];
    }
    return keep_close({place, now.u, rate0, slide_rate}, {end_place, end.u, rate1, slide_rate},
                      flagged, cubic_error(bounds, time) + overlap_error(bounds), slide_rate, 0.0,
                      overlap_rounding(now.u));
  }

  /// Lists the cells in contact and those beside them. -1: more than `capacity`.
  RA2D_FUNCTION int list_contacts(int* cells, int capacity) const {
    int count = 0, last = 0;
    lanes_.sync();
    for (int e = 0; e < contacts_.count; ++e)
      for (int cell = contacts_.nodes[e] - 1; cell <= contacts_.nodes[e] + 1; ++cell)
        list_cell(cell, cells, capacity, count, last);
    lanes_.sync();
    return count <= capacity ? count : -1;
  }

  /// Lists the cells in which there could be contact within a step in which the modes follow
  /// `motion`, not counting runs of cells around those in contact. At both ends overlaps and rates
  /// are known; between them there is a bound on what the cubic through these leaves out. As in
  /// flag(), none that a list of candidate groups may leave out.
  RA2D_FUNCTION int flag_over(const Place& place, const Real* u,
                              const PolynomialMotion<Lanes, packs>& motion,
                              const typename PolynomialMotion<Lanes, packs>::Bounds& bounds,
                              double ticks, const MotionBounds& motion_bounds,
                              const Rise& rise) const {
    const double slide_rate = motion.most_slide_rate();
    const double of_face = slide_rate * slide_rate * faces_.largest_face_curvature +
                           motion.change_of_slide_rate() * faces_.steepest_rise;
    const double sag = modes_sag(u, bounds.travel);
    const double level = -(bounds.remainder() + of_face / 3.0 + overlap_error(motion_bounds) + sag);
    // plane scenes leave none out, for the bits that they have always had
    const bool is_areal = faces_.rows.across != nullptr;
    const double start = is_areal ? highest_start(motion_bounds, rise) - sag : -1e300,
                 distance = ticks * motion_.advance;
    const double third = ticks * motion_.time_step / 3.0;
    const double rate0 = third * pace_rate(motion.pace, 0.0),
                 rate1 = -third * pace_rate(motion.pace, 1.0);
    int count = 0, last = 0;
    const int all = groups();
    for (int i = 0; i < all; ++i) {
      const int e = index(i);
      const double* first = start_ + 2 * e * width;
      const double* end = end_ + 2 * e * width;
      // the cubic lies between the smallest and the largest of its Bernstein coefficients
      const Real b0 = lanes_.load(first), b3 = lanes_.load(end);
      const Real b1 = multiply_add(rate0, lanes_.load(first + width), b0);
      const Real b2 = multiply_add(rate1, lanes_.load(end + width), b3);
      flag_cells(place, group(e), b0, Kokkos::max(Kokkos::max(b0, b1), Kokkos::max(b2, b3)), level,
                 distance, start, count, last);
    }
    lanes_.sync();
    return count;
  }

  /// The state of the modes at an end of a step, and the change of both bodies there per share of
  /// the step.
  struct End {
    const Place& place;
    const Real *u, *rate;
    double slide_rate;  // chi
  };
  /// Takes out of the listed cells those whose cubics rule out contact over a step: at each place
  /// of a cell the overlap is at most the largest Bernstein coefficient of the cubic through both
  /// ends, but for what that leaves out. `modes_left_out` [m], and of the faces a third of their
  /// second derivative: from the rate at which the slider moves, and its change. Returns the number
  /// of those left, or no_room.
  RA2D_FUNCTION int keep_close(const End& start, const End& end, int flagged, double modes_left_out,
                               double slide_rate, double change, double tolerance) const {
    return keep_those(start.place, flagged, [&](int cell) {
      const MovingCell before = moving_cell(cell, start);
      const double free =
          0.5 * tolerance - modes_left_out -
          (slide_rate * slide_rate * before.steepness.curvature + change * before.steepness.slope) /
              3.0;
      if (before.highest_after(0.0) >= free || before.highest_after(1.0 / 3.0) >= free) return true;
      const MovingCell after = moving_cell(cell, end);
      return after.highest_after(0.0) >= free || after.highest_after(-1.0 / 3.0) >= free;
    });
  }
  /// Where contact first begins in the listed cells along the `motion` of a step from `place` on;
  /// beyond 1 where none does. Leaves those cells in which one does, with its x in
  /// OnsetSearch::onsets; `flagged`: their number, or no_room. `near`: of a cell and a level [m],
  /// the part of the motion within which alone its overlap may come to that level; one that begins
  /// beyond 1 where there is none.
  template <class Near>
  RA2D_FUNCTION double search_near(const PolynomialMotion<Lanes, packs>& motion, double curvature,
                                   const Place& place, int& flagged, double tolerance,
                                   const Near& near) const {
    double first = 2.0 * motion.most + 1.0;
    int kept = 0;
    flagged = keep_those(place, flagged, [&](int cell) {
      // sums over the modes, one after the other, round more than those over lanes
      const OnsetInterval interval = near(cell, -4.0 * tolerance);
      if (interval.from > 1.0) return false;
      const double x = first_contact(lanes_, node_contact_, motion, place, cell, interval,
                                     curvature, tolerance, 0.25 * tolerance);
      if (x > motion.most) return false;
      if (lanes_.leader()) search_.onsets[kept] = x;
      ++kept;
      if (x < first) first = x;
      return true;
    });
    return first;
  }

  /// As search(), along a motion from `place` on, in the listed cells.
  RA2D_FUNCTION double search_cells(const PolynomialMotion<Lanes, packs>& motion, double curvature,
                                    const Place& place, int flagged, double tolerance) const {
    if (!node_contact_.expand(place, listed_nodes_, flagged)) [[unlikely]]
      return -1.0;
    double first = 2.0 * motion.most + 1.0;
    for (int e = 0; e < flagged; ++e) {
      const double x = first_contact(lanes_, node_contact_, motion, place, listed_nodes_[e],
                                     {0.0, motion.most}, curvature, tolerance, 0.25 * tolerance);
      lanes_.sync();
      if (lanes_.leader()) search_.onsets[e] = x;
      if (x < first) first = x;
    }
    lanes_.sync();
    return first;
  }

 private:
  /// All that is kept for the next step, also where every group is evaluated: the footprint's sums.
  KOKKOS_FORCEINLINE_FUNCTION void end_bounds() {
    if (is_selective_ || knows_footprint()) [[unlikely]]
      group_bounds_.end_step(rise_at_end_);
  }
  RA2D_FUNCTION MovingCell moving_cell(int cell, const End& at) const {
    return node_contact_.moving_cell(cell, at.place, at.u, at.rate, at.slide_rate);
  }
  /// Leaves those of the listed cells that are `close`. Returns their number, or no_room.
  template <class Close>
  RA2D_FUNCTION int keep_those(const Place& place, int listed, const Close& close) const {
    if (!node_contact_.expand(place, listed_nodes_, listed)) [[unlikely]]
      return no_room;
    int kept = 0;
    for (int e = 0; e < listed; ++e) {
      const int cell = listed_nodes_[e];
      const bool keeps = close(cell);
      lanes_.sync();
      if (keeps) {
        if (lanes_.leader()) listed_nodes_[kept] = cell;
        ++kept;
      }
    }
    lanes_.sync();
    return kept;
  }

  Lanes lanes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  const MotionLimits& bounds_;
  const SeriesTables& adaptive_;
  NodeContact<Lanes, packs> node_contact_;
  const ContactSet& contacts_;
  double* amplitudes_;
  int* listed_nodes_;
  int most_listed_;
  OnsetSearch& search_;
  std::int64_t& evaluated_;
  CandidateGroups<Lanes, packs> candidates_;
  GroupBounds<Lanes, packs> group_bounds_;
  // overlaps and their rates at the beginning and at the end of a step
  double *start_, *end_;
  bool start_is_valid_ = false;   // `start_` is of the present state and candidate groups
  double rise_at_end_ = 0.0;      // Rise::end of the step
  double reference_error_ = 0.0;  // sums_error where the candidate groups were found
  bool is_selective_;             // areal scenes: evaluates selected groups

  /// Lists the cells of a group that may come to `level`, but for those that the node's overlaps at
  /// the beginning, `overlap`, rule out (starts_high). `most`: what these become at the most.
  KOKKOS_FORCEINLINE_FUNCTION void flag_cells(const Place& place, int group, const Real& overlap,
                                              const Real& most, double level, double distance,
                                              double start, int& count, int& last) const {
    const Real sag = cell_sag(lanes_, faces_, place, group);
    std::uint32_t ends = lanes_.at_least(most + sag, level);
    if (ends == 0) return;
    const std::uint32_t high = starts_high(place, group, overlap + sag, distance, start);
    ends &= high;
    // plane scenes go by the higher end alone, for the bits that they have always had
    const std::uint32_t inside =
        faces_.rows.across == nullptr
            ? ends | ends >> 1
            : lanes_.at_least(most_in_cells(lanes_, most, sag), level) & (high | high >> 1);
    list_cells_of<width>(faces_, group, inside, ends, [&](int cell) {
      list_cell(cell, listed_nodes_, most_listed_, count, last);
    });
  }
  /// Lists a cell that exists; they come in ascending order. `last`: one beyond the latest.
  KOKKOS_FORCEINLINE_FUNCTION void list_cell(int cell, int* cells, int capacity, int& count,
                                             int& last) const {
    if (cell < last || !is_cell(faces_, cell)) return;
    if (lanes_.leader() && count < capacity) cells[count] = cell;
    ++count;
    last = cell + 1;
  }

  KOKKOS_FORCEINLINE_FUNCTION double modes_sag(const Real* u, double travel) const {
    return ra2d::modes_sag<Lanes, packs>(lanes_, faces_, bounds_, u, travel);
  }

  /// Groups to evaluate, the i-th of which is number index(i) of the candidate groups.
  KOKKOS_FORCEINLINE_FUNCTION int groups() const {
    if (is_selective_) [[unlikely]]
      return group_bounds_.selected();
    return bounds_.searched == Nodes::all ? faces_.groups : candidates_.count();
  }
  KOKKOS_FORCEINLINE_FUNCTION int index(int i) const {
    return is_selective_ ? group_bounds_[i] : i;
  }
  KOKKOS_FORCEINLINE_FUNCTION int group(int e) const {
    return bounds_.searched == Nodes::all ? e : candidates_[e];
  }

  /// `travel` by the modes, with what a node's way over the faces adds, and the errors.
  KOKKOS_FORCEINLINE_FUNCTION Rise with_path(const Real* u, const MotionBounds& bounds,
                                             std::int64_t ticks, const Rise& travel) const {
    const double distance = static_cast<double>(ticks) * motion_.advance;
    double slope = group_bounds_.follows() ? 0.0 : faces_.steepest_rise;
    if (distance > 0.0)
      slope += motion_.spacing * weighted_sum<Lanes, packs>(lanes_, bounds_.largest_slope, u);
    const double path = distance * slope, errors = 2.0 * overlap_error(bounds);
    return {travel.any + path + errors, travel.rest + path + errors, travel.end + path + errors};
  }
  /// The overlap that a node must have at the beginning of a step to come into contact within it,
  /// beside what is followed.
  KOKKOS_FORCEINLINE_FUNCTION double highest_start(const MotionBounds& bounds,
                                                   const Rise& rise) const {
    return -(rise.rest - overlap_error(bounds));
  }

  /// The nodes of a group whose overlaps at the beginning of a step, with what is followed on a way
  /// of `distance` [chi], come to the level `start`.
  KOKKOS_FORCEINLINE_FUNCTION std::uint32_t starts_high(const Place& place, int group,
                                                        const Real& overlap, double distance,
                                                        double start) const {
    Real most = overlap;
    if (group_bounds_.follows()) most = most + group_bounds_.followed_rise(place, group, distance);
    return lanes_.at_least(most, start);
  }

  /// Error of an evaluated overlap [m]. Roundings: one of the value, up to a third of one of the
  /// rate over the step, one of the series that is searched.
  KOKKOS_FORCEINLINE_FUNCTION double overlap_error(const MotionBounds& bounds) const {
    return bounds.cubic_remainder + 3.0 * bounds.rounding() + 2.0 * faces_.rounding;
  }
  /// Error of the sums of the footprint's terms at a displacement [m]: each is off by its
  /// roundings, half of bounds.rounding() of what it adds up, and all polynomials of a mode
  /// together are less than 25 times its largest shape.
  KOKKOS_FORCEINLINE_FUNCTION static double sums_error(const MotionBounds& bounds) {
    return 13.0 * bounds.rounding();
  }
  /// Error of the cubic through overlaps and rates at both ends of a step [m].
  KOKKOS_FORCEINLINE_FUNCTION double cubic_error(const MotionBounds& bounds, double time) const {
    const double square = time * time;
    return adaptive_.cubic_excess * bounds.fourth_derivative * square * square / 384.0;
  }

  /// Overlaps and their rates [m, m/s] of the candidate groups, by the cubics over their patches.
  RA2D_FUNCTION void evaluate_at(const Place& place, const Real* u, const Real* v, double* to) {
    GroupSweep<Lanes, packs> sweep(lanes_, faces_, slider_, patches_, place, amplitudes_, u, v);
    const double speed = motion_.advance / motion_.time_step;  // chi/s
    const int count = groups();
    int found = 0;
    for (int i = 0; i < count; ++i) {
      const int e = index(i);
      if (is_selective_ && to == start_ && group_bounds_.knows(e)) [[unlikely]] {
        ++found;
        continue;
      }
      const auto [overlap, modes, slope] = sweep.overlap_and_rates(group(e));
      lanes_.store(to + (2 * e) * width, overlap);
      lanes_.store(to + (2 * e + 1) * width, multiply_add(speed, slope, modes));
    }
    if (is_selective_ && to == start_) [[unlikely]]
      group_bounds_.know_selected();
    if (lanes_.leader()) evaluated_ += static_cast<std::int64_t>(count - found) * width;
    lanes_.sync();
  }
};

}  // namespace ra2d
