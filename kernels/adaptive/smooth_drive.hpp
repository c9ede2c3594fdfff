// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/adaptive_recorder.hpp"
#include "kernels/adaptive/brent.hpp"
#include "kernels/adaptive/contacts.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/moving_force_series.hpp"
#include "kernels/adaptive/overlaps.hpp"
#include "kernels/adaptive/pace.hpp"
#include "kernels/adaptive/slider_path.hpp"
#include "kernels/adaptive/smooth_step.hpp"
#include "kernels/candidate_groups.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Steps of the adaptive scheme in contact between smooth faces.
///
/// Such a step is made with the contacts that there are, in their cells and those beside them. It
/// ends where a new one begins; the next step begins there with the pace that suits an onset. That
/// none begins unseen is proved for the motion that the step has found. Contacts that grow, wander
/// from cell to cell or end are no events: force and its first derivative stay continuous, and the
/// error control sees to them. Where the first sweeps show that a contact ends, or the error
/// control rejects a step because one does, the step is made to end with that contact. So it is
/// where the step before it shows that a contact will begin or end: that saves tries, and proves
/// nothing.
template <class Lanes, int packs>
class SmoothDrive {
  using Real = typename Lanes::Real;
  using Modes = ModalState<Lanes, packs>;
  using Motion = PolynomialMotion<Lanes, packs>;
  using Course = typename SmoothStep<Lanes, packs>::Course;
  static constexpr int width = Lanes::width;
  static constexpr int points = 1 + padded_points(width);  // of a cell's numbers

 public:
  RA2D_FUNCTION SmoothDrive(const Lanes& lanes, const SliderMotion& motion,
                            const MotionLimits& bounds, const FaceTables& faces,
                            const SeriesTables& adaptive, const MovingForces& forces,
                            const SliderPath& path, const NodeContact<Lanes, packs>& node_contact,
                            const MovingForceSeries<Lanes, packs>& moving_forces,
                            Overlaps<Lanes, packs>& overlaps,
                            const Contacts<Lanes, packs>& contacts,
                            const AdaptiveRecorder<Lanes, packs>& recorder,
                            SmoothStep<Lanes, packs>& step, ContactSet& set, StepControl& control,
                            ShockTracking& shocks, WorkSpace& work, ShockBuffer& ended)
      : lanes_{lanes},
        motion_{motion},
        bounds_{bounds},
        faces_{faces},
        adaptive_{adaptive},
        forces_{forces},
        path_{path},
        node_contact_{node_contact},
        moving_forces_{moving_forces},
        overlaps_{overlaps},
        contacts_{contacts},
        recorder_{recorder},
        set_{set},
        control_{control},
        shocks_{shocks},
        points_{work.points},
        list_{work.contact_list},
        runs_{work.runs},
        ended_{ended},
        listed_{work.listed_nodes},
        onsets_{work.search.onsets},
        capacity_{Kokkos::min(work.spans.capacity, overlaps.most_listed())},
        step_{step} {}

  /// Errors of what is recorded do not add up from step to step.
  static constexpr double recorded_share = 0.1;

  enum class Outcome { made, full, crowded, not_finite, stalled };

  /// One step from `now` at `tick` on, of `available` ticks at the most.
  RA2D_FUNCTION Outcome operator()(Modes& now, std::int64_t& tick, const Place& place,
                                   std::int64_t available) {
    if (forces_.count > 0) {
      const std::int64_t valid = moving_forces_.expand(tick, control_.series_scale);
      if (valid < available) available = valid;
    }
    rounding_ = overlaps_.overlap_rounding(now.u);
    const double guess = control_.series_scale / motion_.time_step;
    std::int64_t ticks =
        guess < static_cast<double>(available) ? static_cast<std::int64_t>(guess) : available;
    if (control_.contact_begins)
      ticks = static_cast<std::int64_t>(0.3 * static_cast<double>(ticks));
    if (ticks < 1) ticks = 1;
    Pace pace = control_.contact_begins ? Pace::from_onset : Pace::even;
    if (!list_cells(place)) return Outcome::crowded;

    const double allowed = static_cast<double>(ticks);  // by the error control
    const double onset_after = control_.expected_onset / motion_.time_step;
    if (1.1 * onset_after < allowed) ticks = static_cast<std::int64_t>(1.1 * onset_after) + 1;
    if (ticks < available && 2 * ticks > available) ticks = available / 2 + 1;
    plan(ticks, pace, allowed);
    bool cut = static_cast<double>(ticks) < allowed || ticks == available;
    double next = 0.0;  // s, that it allows
    while (true) {
      step_.finish();
      find_runs(1.0);
      const auto errors = step_.errors(rounding_);
      Course course = Course::smooth;
      if (any_begins_or_ends())
        course = Course::kinked;
      else if (pace != Pace::even)
        course = Course::graded;
      // far from the tolerance the motion tells nothing
      const bool tells = errors.of(course == Course::kinked ? Course::graded : course) <= 10.0;
      double first = 3.0, released = 3.0;
      if (tells) {
        step_.find_motion();
        first = search(now, place, tick, ticks, available);
        if (first < 0.0) [[unlikely]]
          return Outcome::crowded;
        if (course == Course::kinked && errors.of(course) > 1.0) released = first_release(place);
      }
      // a step graded towards a release that is where it should be
      if (pace == Pace::to_release && released <= 1.0 && released > 1.0 - step_.early_release() &&
          !any_begins())
        course = Course::graded;
      const bool onset = first <= 1.0;
      // the motion within the step is what goes on from an onset, and else what is recorded
      const double error =
          Kokkos::max(errors.of(course), (onset ? 1.0 : recorded_share) * errors.inside());
      if (error <= 1.0) {
        const double growth = error > 0.0 ? Kokkos::min(4.0, errors.factor(course, error)) : 4.0;
        next = growth * static_cast<double>(ticks) * motion_.time_step;
        if (cut || pace != Pace::even || course == Course::kinked)
          next = Kokkos::max(next, control_.series_scale);
        return keep(now, tick, place, ticks, onset, first, next);
      }
      const double factor = error < 1e30 ? Kokkos::max(0.2, errors.factor(course, error)) : 0.2;
      cut = shorten(ticks, pace, factor, onset ? first : 3.0, released);
      if (ticks < 1) return error == error ? Outcome::stalled : Outcome::not_finite;
      step_.begin(ticks, pace);
    }
  }

 private:
  /// The next try of a step whose error was too large: `factor` times as long or, where a contact
  /// begins at the x `first` or ends at the share `released` of its time (beyond 1: none), up to
  /// there: but not far sooner than the error control asks for, since a motion so far off may be
  /// wrong about it. Whether it is shorter than the error control asks for. `ticks` becomes 0 where
  /// none is left.
  KOKKOS_FORCEINLINE_FUNCTION static bool shorten(std::int64_t& ticks, Pace& pace, double factor,
                                                  double first, double released) {
    double share = 2.0;
    Pace then = pace == Pace::to_release ? Pace::even : pace;
    if (first <= 1.0) share = pace_share(pace, first);
    if (released <= 1.0 && released < share) {
      share = released;
      if (pace != Pace::from_onset) then = Pace::to_release;
    }
    if (share < 0.2 * factor) {
      share = 0.2 * factor;
      if (then == Pace::to_release) then = Pace::even;
    }
    const double whole = static_cast<double>(ticks);
    std::int64_t shorter = static_cast<std::int64_t>(Kokkos::ceil(share * whole));
    const bool cut = share < 0.9999 && shorter < ticks;
    if (!cut) {
      shorter = static_cast<std::int64_t>(factor * whole);
      if (pace == Pace::to_release) then = Pace::even;
    }
    ticks = shorter < ticks ? shorter : ticks - 1;
    if (ticks < 0) ticks = 0;
    pace = then;
    return cut;
  }

  Lanes lanes_;
  const SliderMotion& motion_;
  const MotionLimits& bounds_;
  const FaceTables& faces_;
  const SeriesTables& adaptive_;
  const MovingForces& forces_;
  const SliderPath& path_;
  NodeContact<Lanes, packs> node_contact_;
  const MovingForceSeries<Lanes, packs>& moving_forces_;
  Overlaps<Lanes, packs>& overlaps_;
  const Contacts<Lanes, packs>& contacts_;
  const AdaptiveRecorder<Lanes, packs>& recorder_;
  ContactSet& set_;
  StepControl& control_;
  ShockTracking& shocks_;
  PointBuffers& points_;
  ContactList& list_;
  RunBuffer& runs_;
  ShockBuffer& ended_;
  int* listed_;
  double* onsets_;
  int capacity_;
  SmoothStep<Lanes, packs>& step_;
  int cells_ = 0, flagged_ = 0;
  double rounding_ = 0.0;          // m, bound on that of an overlap at the beginning
  double expected_onset_ = 1e300;  // s after the step: of the next contact that begins
  MotionBounds motion_bounds_{};   // of the latest search

  KOKKOS_FORCEINLINE_FUNCTION double bound(const double* weight, const Real* x) const {
    return weighted_sum<Lanes, packs>(lanes_, weight, x);
  }

  /// Begins a step of `ticks` or less, without the cells that stay open. Should contact begin in
  /// one of these, search() finds it. Where a contact is expected to end within it, by the step
  /// before or by the first two sweeps, the step is made to end there, if that is near, or else at
  /// half the time. `allowed`: ticks, by the error control.
  RA2D_FUNCTION void plan(std::int64_t& ticks, Pace& pace, double allowed) {
    constexpr int most_tries = 3;
    const std::int64_t longest = ticks;
    const double release = control_.expected_release / motion_.time_step;
    if (release > 0.02 * allowed && release < 0.4 * allowed)
      aim(release, longest, allowed, ticks, pace);
    for (int i = 0; i < most_tries; ++i) {
      step_.begin(ticks, pace);
      cells_ = step_.leave_out_open();
      double share = expected_release();
      if (suits(pace, share)) {
        step_.sweep_on();
        share = expected_release();
        if (suits(pace, share)) break;
      }
      const std::int64_t tried = ticks;
      const Pace at_pace = pace;
      aim(share * static_cast<double>(ticks), longest, allowed, ticks, pace);
      if (ticks == tried && pace == at_pace) break;
      if (pace == Pace::to_release && i + 1 < most_tries) continue;
      step_.begin(ticks, pace);
      break;
    }
  }
  /// Length and pace of a step of `longest` ticks at the most in which a contact is expected to end
  /// after `release` ticks.
  RA2D_FUNCTION void aim(double release, std::int64_t longest, double allowed, std::int64_t& ticks,
                         Pace& pace) const {
    double end = allowed;
    if (pace == Pace::to_release) pace = Pace::even;
    if (release < 0.02 * allowed) {
      // what ends sooner is within the force's roundings, or so
      end = 1.05 * release + 1e-3 * allowed;
      pace = Pace::even;
    } else if (release < 0.4 * allowed && pace != Pace::from_onset) {
      end = release * (1.0 + 0.5 * step_.early_release());
      pace = Pace::to_release;
    } else if (release < allowed) {
      end = release < 0.7 * allowed ? 0.5 * release : release - 0.35 * allowed;
    }
    ticks = end < static_cast<double>(longest) ? static_cast<std::int64_t>(end) + 1 : longest;
  }
  /// Whether a step at this pace suits a contact that ends at a share of its time.
  KOKKOS_FORCEINLINE_FUNCTION bool suits(Pace pace, double release) const {
    const double early = step_.early_release();
    return pace == Pace::to_release
               ? Kokkos::abs(release * (1.0 + 0.5 * early) - 1.0) < Kokkos::max(0.5 * early, 0.002)
               : release >= 1.0;
  }
  /// Where the first of the contacts at the beginning is expected to end, as a share of the step's
  /// time; beyond 1 where none does within it.
  RA2D_FUNCTION double expected_release() const {
    find_runs(1.0);
    double first = 4.0;
    for (int r = 0; r < points_.run_count; ++r)
      if (points_.runs[r].grown) first = Kokkos::min(first, step_.expected_end(points_.runs[r]));
    return first;
  }

  /// Lists the cells that the step evaluates, and finds the forces at its beginning. False where
  /// there is no room for them.
  RA2D_FUNCTION bool list_cells(const Place& place) {
    cells_ = overlaps_.list_contacts(points_.cells, capacity_);
    if (cells_ < 0 || !node_contact_.expand(place, points_.cells, cells_)) return false;
    step_.find_start(cells_);
    return true;
  }

  /// The x at which a contact first begins along the motion that the step has found; beyond 1 where
  /// none does, negative where there is no room for the cells.
  RA2D_FUNCTION double search(const Modes& now, const Place& place, std::int64_t tick,
                              std::int64_t ticks, std::int64_t available) {
    const Motion motion = step_.motion(1.0);
    const auto b = motion.bounds(lanes_, bounds_, motion_.spacing);
    const double size = bound(bounds_.largest_shape, now.u) + b.travel;
    flagged_ = 0;
    expected_onset_ = 1e300;
    if (!(size < 1e300)) return 3.0;
    motion_bounds_ = {b.travel, 0.0, bound(bounds_.cubic_remainder, now.u), size};
    const MotionBounds& bounds = motion_bounds_;
    const double time = static_cast<double>(ticks) * motion_.time_step;
    const Rise rise =
        overlaps_.knows_footprint()
            ? overlaps_.longest_rise(place, now, step_.end(), bounds, ticks,
                                     time * pace_rate(step_.pace(), 0.0),
                                     time * pace_rate(step_.pace(), 1.0), b.remainder())
            : overlaps_.longest_rise(now.u, bounds, ticks);
    overlaps_.find_groups(place, now, bounds, rise, available - ticks);
    overlaps_.select(place, now.u, bounds, rise, ticks);
    overlaps_.evaluate(place, now.u, now.v, path_.moved(place, tick + ticks), step_.end().u,
                       step_.end().v);
    const int flagged = overlaps_.flag_over(place, now.u, motion, b, step_.ticks(), bounds, rise);
    if (!overlaps_.has_room(flagged)) return -1.0;
    flagged_ = leave_out_grown(flagged);
    if (flagged_ == 0) return 3.0;
    const double first = overlaps_.search_near(
        motion, b.curvature, place, flagged_, rounding_, [&](int cell, double level) {
          const OnsetInterval interval = step_.near(cell, b.curvature, level);
          if (!is_beside_contact(cell))
            expected_onset_ = Kokkos::min(expected_onset_, step_.expected_onset());
          return interval;
        });
    return overlaps_.has_room(flagged_) ? first : -1.0;
  }

  /// Contact spreads to a cell beside it, it does not begin there.
  RA2D_FUNCTION bool is_beside_contact(int cell) const {
    bool adjacent = false;
    for (int c = 0; c < set_.count; ++c)
      adjacent = adjacent || (set_.nodes[c] >= cell - 1 && set_.nodes[c] <= cell + 1);
    return adjacent;
  }
  /// When, after the step, the first of the contacts at its end is expected to end [s].
  RA2D_FUNCTION double next_release() const {
    double first = 1e300;
    for (int r = 0; r < points_.run_count; ++r)
      if (points_.runs[r].at_end)
        first = Kokkos::min(first, step_.expected_release(points_.runs[r]));
    return first;
  }

  /// Keeps the step, or (onset) the part of it up to the x `first` where a contact begins.
  RA2D_FUNCTION Outcome keep(Modes& now, std::int64_t& tick, const Place& place, std::int64_t ticks,
                             bool onset, double first, double next) {
    double x = 1.0;
    std::int64_t made = ticks;
    if (onset) {
      if (Kokkos::min(cells_ + flagged_, faces_.nodes) > capacity_) return Outcome::crowded;
      const double at = pace_share(step_.pace(), first) * static_cast<double>(ticks);
      made = static_cast<std::int64_t>(Kokkos::ceil(at));
      if (made < ticks)
        x = pace_x(step_.pace(), static_cast<double>(made) / static_cast<double>(ticks));
      else
        made = ticks;
    }
    // room for what list_grazing() adds, asked for before anything is kept
    if (Kokkos::min(flagged_ + set_.count, faces_.nodes) > overlaps_.most_listed())
      return Outcome::crowded;
    if (!recorder_.contact_samples(step_, tick, now, made)) return Outcome::full;
    Modes end;
    if (made == ticks) {
      end = step_.end();
    } else {
      step_.state(x, end.u, end.v);
      find_runs(pace_share(step_.pace(), x));
    }
    const auto weights = step_.weights(x);
    step_.squares(weights, end.square);
    for (int p = 0; p < filled<packs>(lanes_); ++p) end.square[p] = now.square[p] + end.square[p];
    double sliding, moving;
    step_.works(weights, sliding, moving);
    int listed = flagged_;
    if (made > 0) {
      listed = list_grazing(place, x, rounding_);
      const std::int64_t in_contact = add_shocks(place, tick, made, x, weights);
      recorder_.add_contact(sliding, moving, in_contact, set_.count);
    }
    const double release = onset ? 1e300 : next_release();
    if (made < ticks) overlaps_.end_at(place, now, end, motion_bounds_, made);
    step_.keep_for_next(x);
    now.take(lanes_, end);
    tick += made;
    if (onset || listed > flagged_) contacts_.begin(listed, onset ? first : 1.0);
    lanes_.sync();
    if (lanes_.leader()) {
      control_.contact_begins = onset;
      control_.expected_onset = onset ? 1e300 : expected_onset_;
      control_.expected_release = release;
      control_.series_scale = Kokkos::min(next, adaptive_.longest_scale);
    }
    lanes_.sync();
    // the overlaps at the end are those of a whole step, and of this side of a node
    const Place there = path_.at(tick);
    if (made == ticks && there.base == place.base)
      overlaps_.end_becomes_start(there, now.u);
    else
      overlaps_.discard_start();
    return Outcome::made;
  }

  /// Lists, after the flagged cells, those of the contact set that carry no force at x and are free
  /// by less than the tolerance. They stay in the set: a contact begins at +tolerance and ends at
  /// -tolerance, so that none begins twice at one place. Returns the number of cells listed.
  RA2D_FUNCTION int list_grazing(const Place& place, double x, double tolerance) {
    const Motion motion = step_.motion(1.0);
    Real u[packs], rate[packs];
    motion.at(lanes_, x, u, rate);
    const Place there = motion.place_at(place, x);
    int listed = flagged_, at = 0;
    for (int e = 0; e < set_.count; ++e) {
      const int cell = set_.nodes[e];
      while (points_.cells[at] < cell) ++at;  // all of the set are evaluated
      if (x == 1.0 && points_.force[at * points + last_point] > 0.0) continue;
      double ignored;
      const double highest =
          node_contact_.moving_cell(cell, there, u, rate, motion.slide_rate(x)).highest(ignored);
      lanes_.sync();
      if (!(highest > -tolerance) || listed == overlaps_.most_listed()) continue;
      if (lanes_.leader()) {
        listed_[listed] = cell;
        onsets_[listed] = 0.0;
      }
      ++listed;
    }
    lanes_.sync();
    return listed;
  }

  // ---- runs of cells in contact

  /// Finds the runs of cells in contact at any point up to a share of the step's time.
  RA2D_FUNCTION void find_runs(double share) const {
    lanes_.sync();
    if (lanes_.leader()) {
      int count = 0;
      for (int e = 0; e < cells_; ++e) {
        const double* force = points_.force + e * points;
        bool touched = false;
        for (int i = 0; i <= last_point; ++i)
          touched = touched || (force[i] > 0.0 && step_.share(i) <= share);
        if (!touched) continue;
        const int cell = points_.cells[e];
        if (count == 0 || points_.runs[count - 1].last != cell - 1)
          points_.runs[count++] = {cell, cell, false, false, 0};
        CellRun& run = points_.runs[count - 1];
        run.last = cell;
        run.at_end = run.at_end || force[last_point] > 0.0;
      }
      for (int r = 0, c = 0; r < count; ++r) {
        CellRun& run = points_.runs[r];
        while (c < set_.count && set_.nodes[c] < run.first - 1) ++c;
        run.grown = c < set_.count && set_.nodes[c] <= run.last + 1;
      }
      points_.run_count = count;
    }
    lanes_.sync();
  }
  /// Takes out of the flagged cells those in or beside contact that has been there from the
  /// beginning, if the step evaluates them. Returns the number of those left.
  RA2D_FUNCTION int leave_out_grown(int flagged) const {
    lanes_.sync();
    if (lanes_.leader()) {
      int kept = 0, c = 0, r = 0, at = 0;
      for (int e = 0; e < flagged; ++e) {
        const int cell = listed_[e];
        while (at < cells_ && points_.cells[at] < cell) ++at;
        if (at == cells_ || points_.cells[at] != cell) {
          listed_[kept++] = cell;
          continue;
        }
        while (c < set_.count && set_.nodes[c] < cell - 1) ++c;
        if (c < set_.count && set_.nodes[c] <= cell + 1) continue;
        while (r < points_.run_count && (points_.runs[r].last < cell - 1 || !points_.runs[r].grown))
          ++r;
        if (r < points_.run_count && points_.runs[r].first <= cell + 1) continue;
        listed_[kept++] = cell;
      }
      points_.listed = kept;
    }
    lanes_.sync();
    return points_.listed;
  }

  /// The largest overlap in cells `first` to `last` at a share of the step's time [m], its rate [m
  /// over that time], and in which.
  struct LargestOverlap {
    double value, rate;
    int cell;
  };
  RA2D_FUNCTION LargestOverlap largest_overlap(const Place& place, int first, int last,
                                               double share) const {
    const Motion motion = step_.motion(1.0);
    const double x = pace_x(step_.pace(), share), per_share = 1.0 / pace_rate(step_.pace(), x);
    Real u[packs], rate[packs];
    motion.at(lanes_, x, u, rate);
    const Place there = motion.place_at(place, x);
    LargestOverlap largest{-1e300, 0.0, first};
    for (int e = 0; e < cells_; ++e) {
      const int cell = points_.cells[e];
      if (cell < first || cell > last) continue;
      double rate_there;
      const double value =
          node_contact_.moving_cell(cell, there, u, rate, motion.slide_rate(x)).highest(rate_there);
      if (value > largest.value) largest = {value, per_share * rate_there, cell};
    }
    return largest;
  }
  /// The points between which a run carries force at last and at first not, up to the share `end`.
  struct ReleaseBracket {
    double low, high;
    bool touches;  // at low
  };
  RA2D_FUNCTION ReleaseBracket release_bracket(const CellRun& run, double end) const {
    int last = -1;
    for (int e = 0; e < cells_; ++e)
      if (points_.cells[e] >= run.first && points_.cells[e] <= run.last)
        for (int i = last + 1; i <= last_point && step_.share(i) < end; ++i)
          if (points_.force[e * points + i] > 0.0) last = i;
    const double low = last < 0 ? 0.0 : step_.share(last);
    return {low, last == last_point ? end : Kokkos::min(end, step_.share(last + 1)), last >= 0};
  }
  /// The share of the step's time up to `end` at which the contact of a run ends that is free at
  /// `end`: to `closeness`, by Newton's method, halving where it leaves what is left. In the cell
  /// that overlaps most, unless another proves to be in contact there.
  RA2D_FUNCTION double release(const Place& place, const CellRun& run, double end,
                               double closeness) const {
    const int first = run.first - 1, last = run.last + 1;
    auto [low, high, touches] = release_bracket(run, end);
    LargestOverlap there = largest_overlap(place, first, last, high);
    if (!(there.value < 0.0) && high < end) there = largest_overlap(place, first, last, high = end);
    if (!(there.value < 0.0)) return end;  // free by no more than roundings
    if (!touches && !(largest_overlap(place, first, last, low).value > 0.0)) {  // it begins here
      low = 0.02 * end;
      if (!(largest_overlap(place, first, last, low).value > 0.0)) return low;
    }
    const double farthest = high;
    int cell = there.cell;
    double at = step_.expected_end(run);
    for (int i = 0; i < 60; ++i) {
      if (!(at > low && at < high)) at = 0.5 * (low + high);
      there = largest_overlap(place, cell, cell, at);
      (there.value > rounding_ ? low : high) = at;
      if (!(high - low > closeness) || Kokkos::abs(there.value) <= rounding_) {
        there = largest_overlap(place, first, last, high);
        if (!(there.value > rounding_) || there.cell == cell) break;
        cell = there.cell;
        at = low = high;
        high = farthest;
      }
      const double step = there.value / there.rate;
      // so near that the root is bracketed by going on a little beyond it
      at -= step + Kokkos::copysign(0.5 * closeness, step);
    }
    return high;
  }
  /// The share of the step's time at which the first of the runs that were in contact at the
  /// beginning ends; beyond 1 if none does.
  RA2D_FUNCTION double first_release(const Place& place) const {
    double first = 3.0;
    for (int r = 0; r < points_.run_count; ++r) {
      const CellRun run = points_.runs[r];
      if (run.grown && !run.at_end) first = Kokkos::min(first, release(place, run, 1.0, 1e-6));
    }
    return first;
  }

  /// Whether a run begins within the step.
  RA2D_FUNCTION bool any_begins() const {
    bool any = false;
    for (int r = 0; r < points_.run_count; ++r) any = any || !points_.runs[r].grown;
    return any;
  }
  /// Whether a run begins or ends within the step.
  RA2D_FUNCTION bool any_begins_or_ends() const {
    bool any = any_begins();
    for (int r = 0; r < points_.run_count; ++r) any = any || !points_.runs[r].at_end;
    return any;
  }

  // ---- shocks

  /// Takes in the step up to x, of `ticks` ticks. Leaves the cells in contact at its end in the
  /// contact set. Returns the ticks with any contact.
  RA2D_FUNCTION std::int64_t add_shocks(const Place& place, std::int64_t tick, std::int64_t ticks,
                                        double x,
                                        const typename SmoothStep<Lanes, packs>::Weights& weights) {
    keep_contacts_at_end(x);
    const int runs = points_.run_count;
    std::int64_t last_end = 0;
    int grown = 0;
    for (int r = 0; r < runs; ++r) {
      const CellRun run = points_.runs[r];
      if (!run.grown) continue;
      ++grown;
      std::int64_t ends = ticks;
      if (!run.at_end) {
        const double share = release(place, run, pace_share(step_.pace(), x), 1e-13);
        ends = static_cast<std::int64_t>(Kokkos::ceil(share * step_.ticks()));
        // what goes on in contact is taken in after it
        const std::int64_t most = set_.count > 0 && ticks > 1 ? ticks - 1 : ticks;
        if (ends > most) ends = most;
        if (ends < 1) ends = 1;
      }
      if (ends > last_end) last_end = ends;
      lanes_.sync();
      if (lanes_.leader()) points_.runs[r].ends = ends;
      lanes_.sync();
    }
    if (grown == 0) {  // an onset that came to nothing
      if (lanes_.leader() && shocks_.open_count > 0) end_shocks(shocks_, ended_, tick);
      lanes_.sync();
      return 0;
    }
    // all that was in contact, with what it carried, until the first of them ends; then the others
    std::int64_t from = 0;
    while (from < ticks) {
      std::int64_t to = ticks;
      bool any_ends = false;
      for (int r = 0; r < runs; ++r) {
        const CellRun run = points_.runs[r];
        if (!run.grown || run.at_end || run.ends <= from) continue;
        any_ends = true;
        if (run.ends < to) to = run.ends;
      }
      // at the very end only those that are still in contact: they are beside those of the next
      // step
      const bool ends_all = !any_ends && from > 0;
      if (!any_ends && from == 0 && ticks > 1) to = ticks - 1;
      lanes_.sync();
      if (lanes_.leader()) {
        const int count = ends_all ? list_set() : list_runs(from, weights);
        if (count > 0)
          join_shocks(shocks_, runs_, ended_, list_, count, tick + from, tick + to - 1,
                      place.base + place.theta, [&](int e) { return list_.centres[e]; });
      }
      lanes_.sync();
      if (from == 0) add_peaks(x);
      from = to;
      if (from < ticks && set_.count == 0 && !any_ends_after(from)) break;
    }
    return set_.count > 0 ? ticks : last_end;
  }
  RA2D_FUNCTION bool any_ends_after(std::int64_t from) const {
    bool any = false;
    for (int r = 0; r < points_.run_count; ++r)
      any =
          any || (points_.runs[r].grown && !points_.runs[r].at_end && points_.runs[r].ends > from);
    return any;
  }

  /// Puts the cells in contact at x into the contact set, but for those in which it begins there.
  RA2D_FUNCTION void keep_contacts_at_end(double x) const {
    const bool whole = x == 1.0;
    int listed = 0;
    if (!whole) listed = step_.contact_at(x).nodes;
    lanes_.sync();
    if (lanes_.leader()) {
      int count = 0;
      for (int r = 0; r < points_.run_count; ++r) points_.runs[r].at_end = false;
      const auto keep = [&](int cell) {
        for (int e = 0; e < flagged_; ++e)  // what begins here is taken in later
          if (listed_[e] == cell && onsets_[e] <= 1.0) return;
        for (int r = 0; r < points_.run_count; ++r) {
          CellRun& run = points_.runs[r];
          if (run.grown && cell >= run.first - 1 && cell <= run.last + 1) run.at_end = true;
        }
        set_.nodes[count++] = cell;
      };
      if (whole) {
        for (int e = 0; e < cells_; ++e)
          if (points_.force[e * points + last_point] > 0.0) keep(points_.cells[e]);
      } else {
        for (int e = 0; e < listed; ++e) keep(list_.nodes[e]);
      }
      set_.count = count;
    }
    lanes_.sync();
  }

  /// Lists the cells of the runs that have not ended by `from` ticks; at 0 with what they carried
  /// over the step. On the leader.
  RA2D_FUNCTION int list_runs(std::int64_t from,
                              const typename SmoothStep<Lanes, packs>::Weights& weights) const {
    int count = 0, r = 0;
    for (int e = 0; e < cells_; ++e) {
      const int cell = points_.cells[e];
      while (r < points_.run_count && points_.runs[r].last < cell) ++r;
      if (r == points_.run_count || points_.runs[r].first > cell) continue;
      const CellRun& run = points_.runs[r];
      if (!run.grown || (!run.at_end && run.ends <= from)) continue;
      double impulse = 0.0, moment = 0.0;
      if (from == 0) {
        const double *force = points_.force + e * points, *moments = points_.moment + e * points;
        for (int i = 0; i < collocation_points; ++i) {
          const double weight = weights.of[i] * step_.ticks();
          const double travelled = motion_.advance * step_.ticks() * step_.share(i);
          impulse = Kokkos::fma(weight, force[i], impulse);
          moment = Kokkos::fma(weight, Kokkos::fma(travelled, force[i], moments[i]), moment);
        }
      }
      list_.nodes[count] = cell;
      list_.forces[count] = impulse;
      list_.centres[count] = moment;
      ++count;
    }
    return count;
  }
  /// Lists the cells of the contact set, without forces. On the leader.
  RA2D_FUNCTION int list_set() const {
    for (int e = 0; e < set_.count; ++e) {
      list_.nodes[e] = set_.nodes[e];
      list_.forces[e] = list_.centres[e] = 0.0;
    }
    return set_.count;
  }

  /// The largest force of each open shock up to x.
  RA2D_FUNCTION void add_peaks(double x) const {
    const double share = pace_share(step_.pace(), x);
    for (int i = 0; i < shocks_.open_count; ++i) {
      // between the points, the polynomial through their forces shows where
      double highest = 0.0;
      int top = 0;
      lanes_.sync();
      for (int s = 0; s <= last_point; ++s) {
        double force = 0.0;
        for (int e = 0; e < cells_; ++e)
          if (belongs(i, points_.cells[e])) force += points_.force[e * points + s];
        if (lanes_.leader()) points_.shock_force[s] = force;
        if (step_.share(s) > share || force <= highest) continue;
        highest = force;
        top = s;
      }
      lanes_.sync();
      if (!(1.02 * highest > shocks_.open[i].peak)) continue;
      const auto between = [&](double place) { return step_.between(points_.shock_force, place); };
      const double from = top > 0 ? step_.place(top - 1) : 0.0,
                   to = top < last_point ? Kokkos::min(x, step_.place(top + 1)) : x;
      Highest found{highest, step_.place(top)};
      // at an end it is, where the force falls from there
      const bool at_end = (top == 0 && between(1e-4 * to) < highest) ||
                          (top == last_point && between(1.0 - 1e-4 * (to - from)) < highest);
      if (!at_end) {
        const auto at = [&](double place) { return Highest{between(place), place}; };
        const bool between_points = top > 0 && found.place < to;
        found = highest_between(at(from), at(between_points ? found.place : 0.6 * from + 0.4 * to),
                                at(to), between);
      }
      if (x < 1.0) found.take(between(x), x);
      double most = highest;
      if (found.value > highest) most = Kokkos::max(most, force_of(i, found.place));
      lanes_.sync();
      if (lanes_.leader() && most > shocks_.open[i].peak) shocks_.open[i].peak = most;
      lanes_.sync();
    }
  }
  RA2D_FUNCTION bool belongs(int shock, int cell) const {
    for (int r = 0; r < shocks_.run_count; ++r)
      if (shocks_.runs[r].shock == shock && cell >= shocks_.runs[r].first &&
          cell <= shocks_.runs[r].last)
        return true;
    return false;
  }
  RA2D_FUNCTION double force_of(int shock, double x) const {
    const int count = step_.contact_at(x).nodes;
    double force = 0.0;
    for (int e = 0; e < count; ++e)
      if (belongs(shock, list_.nodes[e])) force += list_.forces[e];
    lanes_.sync();
    return force;
  }
};

}  // namespace ra2d
