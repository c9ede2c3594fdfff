// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/crossing.hpp"
#include "kernels/adaptive/flight.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/check.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/displacement.hpp"
#include "kernels/gap.hpp"
#include "kernels/group_sweep.hpp"
#include "kernels/lanes.hpp"
#include "kernels/near_groups.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// The adaptive scheme: steps of any length, each with the same nodes in contact from its beginning
/// to its end. It knows two kinds of step.
///
///   fly    nothing touches and no force travels: closed form (kernels/adaptive/flight.hpp)
///   drive  everything else: a power series whose length the error control chooses
///          (kernels/adaptive/series.hpp)
///
/// A step ends at the latest where a node passes another (the faces have a kink there), and where a
/// contact begins or ends. That none begins unseen is proved, not sampled: the cubic through an
/// overlap and its rate at both ends of a step of length h is off by at most h^4/384 of the fourth
/// derivative, for which there is a bound. A node whose cubic stays below that is open throughout; of
/// every other one the overlap's own series is searched for the first place where it reaches zero
/// (kernels/adaptive/crossing.hpp).
///
/// To touch, an overlap must come to +touch, to let go to -touch, a bound on its roundings: otherwise
/// a contact that has just begun could end by a rounding.
///
/// The record is that of the motion itself: samples at their own times, sums and shocks integrated
/// over the series. Nothing here depends on where a launch ends: when the samples of a step do not
/// fit into their buffer, the step is done again in the next launch.
namespace ra2d {

template <class Lanes, int K>
class AdaptiveMarcher {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION AdaptiveMarcher(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes},
        t_{tables},
        s_{state},
        contact_{lanes, tables, state},
        near_{lanes, tables, state},
        flight_{lanes, tables},
        series_{lanes, tables, state, contact_},
        step_{state.step},
        before_{state.seen},
        after_{state.seen + 2 * tables.groups * width} {
    for (int p = 0; p < K; ++p) {
      u_[p] = lanes_.load(s_.u + p * width);
      v_[p] = lanes_.load(s_.v + p * width);
      square_[p] = lanes_.load(s_.square_part + p * width);
    }
  }

  /// Marches to `target` or a little beyond, the end of the scene, a full buffer, an interrupt or a
  /// failure, whichever is first.
  KOKKOS_FUNCTION void run(std::int64_t target) {
    const std::int64_t stop = target < t_.total_steps ? target : t_.total_steps;
    while (s_.status == Status::running && step_ < stop && has_room_for_shocks(s_) &&
           !is_interrupted(t_))
      if (!stride()) break;
    if (s_.status == Status::running && step_ == t_.total_steps && last_sample() && lanes_.leader())
      s_.status = Status::done;
    lanes_.sync();
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.u + p * width, u_[p]);
      lanes_.store(s_.v + p * width, v_[p]);
      lanes_.store(s_.square_part + p * width, square_[p]);
    }
    if (lanes_.leader()) s_.step = step_;
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  NodeContact<Lanes, K> contact_;
  NearGroups<Lanes, K> near_;
  Flight<Lanes, K> flight_;
  ModalSeries<Lanes, K> series_;
  std::int64_t step_;  // ticks
  Real u_[K], v_[K], square_[K];
  // overlaps and their rates at the beginning and at the end of a step
  double *before_, *after_;
  bool seen_ = false;  // `before_` is of the present state and near list

  static constexpr int longest_level = 60;

  // ---- the step

  KOKKOS_FUNCTION bool stride() {
    const Place place = stand(step_);
    const bool free = s_.closed_count == 0 && t_.moving_forces == 0;
    std::int64_t room = ticks_left(place, free ? 1.0 : (place.part + 1) * t_.window_width);
    if (end() - step_ < room) room = end() - step_;
    if (!(free ? fly(place, room) : drive(place, room))) return false;
    if (lanes_.leader()) ++s_.strides;
    lanes_.sync();
    if ((s_.strides & 4095) == 0) close_parts();
    lanes_.sync();
    return true;
  }

  /// What no step goes beyond.
  KOKKOS_FUNCTION std::int64_t end() const {
    return step_ < t_.counted_from ? t_.counted_from : t_.total_steps;
  }

  /// from + step advance, rounded once at the end: a step has more digits than a double, and the two
  /// parts may cancel.
  KOKKOS_FORCEINLINE_FUNCTION double way_to(std::int64_t step, double from) const {
    const std::int64_t low = step & 2047;
    return Kokkos::fma(static_cast<double>(low), t_.advance,
                       Kokkos::fma(static_cast<double>(step - low), t_.advance, from));
  }

  /// Where the slider stands, theta to its own rounding.
  KOKKOS_FUNCTION Place stand(std::int64_t step) const {
    Place place(t_, step);
    place.theta = way_to(step, t_.position - place.base);
    place.offset = place.theta - (place.part + 0.5) * t_.window_width;
    return place;
  }

  /// Ticks until all nodes are `edge` chi behind the resonator's.
  KOKKOS_FUNCTION std::int64_t ticks_left(const Place& place, double edge) const {
    constexpr double forever = 4e18;
    if (t_.advance == 0.0) return static_cast<std::int64_t>(forever);
    // on to where the roundings of the position cannot hold it back
    const double way = Kokkos::max(edge - place.theta, 0.0) + 2.0 * position_rounding(place);
    const double ticks = Kokkos::ceil(way / t_.advance);
    return ticks < forever ? static_cast<std::int64_t>(ticks) + 1
                           : static_cast<std::int64_t>(forever);
  }

  KOKKOS_FUNCTION bool fly(const Place& place, std::int64_t room) {
    const std::int64_t whole = std::int64_t{1} << s_.level;
    std::int64_t ticks =
        whole - (step_ & (whole - 1));  // to a multiple of the length that is aimed at
    bool look = true, cut = false, coarse = false, shortened = false;
    int shorter = s_.level - 1;  // level of a step that may be decided sooner
    MotionBounds bounds;
    if (ticks > room) {
      const std::int64_t left = end() - step_;
      const std::int64_t far = ticks < left ? ticks : left;
      bounds = flight_.bounds(u_, v_, far * t_.step);
      // so far away that faces and modes could not meet anywhere
      look = !(t_.top + bounds.size + t_.slack + bounds.rounding() < 0.0);
      ticks = look ? room : far;
      cut = ticks < whole - (step_ & (whole - 1));
    }
    Real u[K], v[K], square[K];
    int flagged = 0;
    double rise = 0.0;
    if (look) {
      bounds = flight_.bounds(u_, v_, ticks * t_.step);
      rise = longest_rise(bounds, ticks);
      find_near(place, rise, bounds.rounding(), room, ticks);
      if (groups() > 0) {
        if (!seen_) see(place, u_, v_, before_);
        seen_ = true;
      }
    }
    if (!(bounds.size < 1e300)) return fail(Status::not_finite);
    go(ticks, u, v, square);
    if (look && groups() > 0) {
      see(moved(place, ticks), u, v, after_);
      flagged = flag(ticks * t_.step, bounds, rise);
      // closer than can be seen a shorter step decides nothing
      coarse = cubic_error(bounds, ticks * t_.step) > blur(bounds);
    }
    if (flagged > 0) {
      const double scale = Kokkos::min(ticks * t_.step, t_.longest_scale);
      series_.expand(u_, v_, place, scale);
      const double x = series_.extent(t_.tolerance);
      if (!(x > 0.0)) return fail(Status::not_finite);
      const std::int64_t most = ticks;
      const double longest = x * (scale / t_.step);
      if (longest < static_cast<double>(ticks)) ticks = static_cast<std::int64_t>(longest);
      if (ticks < 1) return fail(Status::stalled);
      if (ticks < most) shorter = whole_level(ticks);
      // no further than the shapes hold that the search goes by
      const std::int64_t window = ticks_left(place, (place.part + 1) * t_.window_width);
      if (window < ticks) ticks = window;
      if (ticks < most) {  // of a shorter step the cubics tell more
        shortened = true;
        go(ticks, u, v, square);
        see(moved(place, ticks), u, v, after_);
        flagged = flag(ticks * t_.step, bounds, rise);
      }
    }
    if (flagged > 0) {
      const double end = x_of(ticks);
      const double first = search(place, flagged, end, touch_of(u_));
      if (first <= end) {
        ticks = ticks_to(first, ticks);
        const double x = x_of(ticks);
        if (!has_room_for_contacts(flagged, x)) return fail(Status::crowded);
        if (!fly_samples(ticks)) return false;
        Real on[K], on_v[K];
        series_.state(x, on, on_v);
        Real off[K], off_v[K];
        go(ticks, off, off_v, square);
        take(on, on_v, square);
        if (ticks > 0) end_flight();
        step_ += ticks;
        seen_ = false;
        close_contacts(flagged, x);
        return true;
      }
    }
    if (!fly_samples(ticks)) return false;
    take(u, v, square);
    end_flight();
    step_ += ticks;
    // the length at which the cubics may decide by themselves
    if (lanes_.leader()) {
      if (coarse && (shortened || flagged > 0))
        s_.level = Kokkos::max(shorter, t_.first_level);
      else if (!cut && !shortened && flagged == 0 && s_.level < longest_level)
        ++s_.level;
    }
    lanes_.sync();
    pass_on(look, place);
    return true;
  }

  KOKKOS_FUNCTION bool drive(const Place& place, std::int64_t room) {
    double scale, extent;
    do {
      scale = s_.stride;
      if (t_.moving_forces > 0) {
        const std::int64_t push_room = expand_push(scale);
        if (push_room < room) room = push_room;
      }
      series_.expand(u_, v_, place, scale);
      extent = series_.extent(t_.tolerance);
      if (!(extent > 0.0)) return fail(Status::not_finite);
      if (!(extent * scale >= t_.step)) return fail(Status::stalled);
      // where the step before told little about this one, once more in better units
      lanes_.sync();
      if (extent < 0.25 && lanes_.leader()) s_.stride = extent * scale;
      lanes_.sync();
    } while (extent < 0.25);
    const double longest = extent * scale / t_.step;
    std::int64_t ticks =
        longest < static_cast<double>(room) ? static_cast<std::int64_t>(longest) : room;
    double end = x_of(ticks);

    const double touch = touch_of(u_) + series_.neglected();
    // contacts that end
    double first = 2.0 * end + 1.0;
    for (int e = 0; e < s_.closed_count; ++e) {
      const double* o = series_.overlap(e);
      const int n = series_.degree();
      const Hull hull = hull_of(lanes_, t_, o, n, end, s_.hull_room);
      double x = 2.0 * end + 1.0;
      if (hull.least <= -0.75 * touch)
        x = first_crossing(o, n, -1.0, touch, 0.25 * touch, end, hull.curve);
      if (lanes_.leader()) {
        s_.closed_hull[e] = hull;
        s_.closed_roots[e] = x;
      }
      if (x < first) first = x;
    }
    lanes_.sync();
    if (first <= end) {
      ticks = ticks_to(first, ticks);
      end = x_of(ticks);
    }
    // contacts that begin
    const MotionBounds bounds = series_.bounds(end);
    const double rise = longest_rise(bounds, ticks);
    find_near(place, rise, bounds.rounding(), room, ticks);
    if (!seen_ && groups() > 0) see(place, u_, v_, before_);
    seen_ = true;
    Real u[K], v[K];
    series_.state(end, u, v);
    int flagged = 0;
    if (groups() > 0) {
      see(moved(place, ticks), u, v, after_);
      flagged = flag(ticks * t_.step, bounds, rise);
    }
    bool onset = false;
    if (flagged > 0) {
      const double x = search(place, flagged, end, touch);
      onset = x <= end;
      if (onset) {
        ticks = ticks_to(x, ticks);
        end = x_of(ticks);
        if (!has_room_for_contacts(flagged, end)) return fail(Status::crowded);
        series_.state(end, u, v);
      }
    }
    if (!drive_samples(ticks)) return false;
    record(place, ticks, end);
    Real squares[K];
    series_.squares(end, squares);
    for (int p = 0; p < K; ++p) squares[p] = square_[p] + squares[p];
    take(u, v, squares);
    if (s_.closed_count > 0 && lanes_.leader()) s_.shape_terms = series_.wanted_terms();
    step_ += ticks;
    const bool release = first <= end;
    if (release) open_contacts(end);
    if (onset) close_contacts(flagged, end);
    // at rest it would grow for ever
    if (lanes_.leader()) s_.stride = Kokkos::min(extent * scale, t_.longest_scale);
    lanes_.sync();
    if (onset)
      seen_ = false;
    else
      pass_on(true, place);
    return true;
  }

  /// The l with 2^l <= ticks < 2^(l + 1).
  KOKKOS_FORCEINLINE_FUNCTION static int whole_level(std::int64_t ticks) {
    return Kokkos::bit_width(static_cast<std::uint64_t>(ticks)) - 1;
  }
  KOKKOS_FUNCTION bool fail(Status why) {
    if (lanes_.leader()) s_.status = why;
    lanes_.sync();
    return false;
  }
  KOKKOS_FORCEINLINE_FUNCTION void take(const Real* u, const Real* v, const Real* square) {
    for (int p = 0; p < K; ++p) {
      u_[p] = u[p];
      v_[p] = v[p];
      square_[p] = square[p];
    }
  }
  KOKKOS_FORCEINLINE_FUNCTION void go(std::int64_t ticks, Real* u, Real* v, Real* square) const {
    for (int p = 0; p < K; ++p) {
      u[p] = u_[p];
      v[p] = v_[p];
      square[p] = square_[p];
    }
    flight_(u, v, square, ticks);
  }
  /// In units of the series.
  KOKKOS_FORCEINLINE_FUNCTION double x_of(std::int64_t ticks) const {
    return static_cast<double>(ticks) * t_.step / series_.scale();
  }
  /// The first tick that is not before x.
  KOKKOS_FORCEINLINE_FUNCTION std::int64_t ticks_to(double x, std::int64_t most) const {
    const auto ticks = static_cast<std::int64_t>(Kokkos::ceil(x * (series_.scale() / t_.step)));
    return ticks < most ? ticks : most;
  }
  /// The place some ticks on, seen from the same window; else to the bit what stand() says there.
  KOKKOS_FORCEINLINE_FUNCTION Place moved(const Place& place, std::int64_t ticks) const {
    Place there = place;
    const auto step = static_cast<double>(step_ + ticks);
    there.position = Kokkos::fma(step, t_.advance, t_.position);
    there.theta = way_to(step_ + ticks, t_.position - place.base);
    there.offset = there.theta - (place.part + 0.5) * t_.window_width;
    return there;
  }
  /// What was seen at the end of a step is what the next one begins with, unless a node has passed
  /// another.
  KOKKOS_FUNCTION void pass_on(bool looked, const Place& place) {
    seen_ = looked && stand(step_).base == place.base;
    double* const swap = before_;
    before_ = after_;
    after_ = swap;
  }

  /// Roundings of an overlap [m].
  KOKKOS_FORCEINLINE_FUNCTION double touch_of(const Real* u) const {
    return t_.slack + 0x1p-46 * weighted_sum<Lanes, K>(lanes_, t_.largest_shape, u);
  }

  // ---- what can touch

  KOKKOS_FORCEINLINE_FUNCTION int groups() const {
    return t_.look_at == Nodes::all ? t_.groups : near_.count();
  }
  KOKKOS_FORCEINLINE_FUNCTION int group(int e) const {
    return t_.look_at == Nodes::all ? e : near_[e];
  }

  /// Error of an overlap that is seen [m].
  KOKKOS_FORCEINLINE_FUNCTION double blur(const MotionBounds& bounds) const {
    return bounds.cubic_remainder + 3.0 * bounds.rounding() + 2.0 * t_.slack;
  }
  /// ... and of the cubic through what is seen at both ends of a step.
  KOKKOS_FORCEINLINE_FUNCTION double cubic_error(const MotionBounds& bounds, double time) const {
    const double square = time * time;
    return t_.cubic_excess * bounds.fourth * square * square / 384.0;
  }
  /// What an overlap can rise by within a step [m], and twice the error of seeing it.
  KOKKOS_FUNCTION double longest_rise(const MotionBounds& bounds, std::int64_t ticks) const {
    const double way = static_cast<double>(ticks) * t_.advance;
    double slope = t_.steepest;
    if (way > 0.0) slope += t_.spacing * weighted_sum<Lanes, K>(lanes_, t_.largest_slope, u_);
    return bounds.travel + way * slope + 2.0 * blur(bounds);
  }

  /// A near list that holds over a step, and likely over the rest of the window.
  KOKKOS_FUNCTION void find_near(const Place& place, double travel, double rounding,
                                 std::int64_t room, std::int64_t ticks) {
    if (t_.look_at == Nodes::all || near_.holds(u_, place, travel)) return;
    // what the modes may do within the step, and can be expected to do after it
    const double time = static_cast<double>(room - ticks) * t_.step;
    const double later =
        time < 1e30 ? time * weighted_sum<Lanes, K>(lanes_, t_.largest_shape, v_) : 0.0;
    near_.find(u_, place, 1.5 * travel + 0.5 * later + t_.least_reach, rounding, 0.0);
    seen_ = false;
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

  /// Lists the open nodes that could touch within a step of `time` [s] whose ends have been seen.
  /// Which they are must not depend on the near list: the length of the next step does on them. So
  /// they are none of those that every near list may leave out.
  KOKKOS_FUNCTION int flag(double time, const MotionBounds& bounds, double rise) const {
    const double level = -(cubic_error(bounds, time) + blur(bounds));
    const double start = -(rise - blur(bounds));
    const double third = time / 3.0;
    int count = 0, closed = 0;
    const int all = groups();
    for (int e = 0; e < all; ++e) {
      const double* first = before_ + 2 * e * width;
      const double* last = after_ + 2 * e * width;
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
        if (lanes_.leader()) s_.watch[count] = node;
        ++count;
      }
    }
    lanes_.sync();
    return count;
  }

  /// Where the first of the flagged nodes touches, in units of the series; beyond `end` if none.
  KOKKOS_FUNCTION double search(const Place& place, int flagged, double end, double touch) {
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

  /// Whether there is room for the flagged nodes that touch by x. Asked before anything of the step
  /// is kept, so that it can be done again once there is.
  KOKKOS_FUNCTION bool has_room_for_contacts(int flagged, double x) const {
    int count = s_.closed_count;
    for (int e = 0; e < flagged; ++e) count += s_.roots[e] <= x ? 1 : 0;
    return count <= s_.closed_capacity;
  }
  /// Of the flagged nodes those that touch by x.
  KOKKOS_FUNCTION void close_contacts(int flagged, double x) {
    if (lanes_.leader())
      for (int e = 0; e < flagged; ++e) {
        if (!(s_.roots[e] <= x)) continue;
        RA2D_CHECK(s_.closed_count < s_.closed_capacity);
        int i = s_.closed_count++;
        for (; i > 0 && s_.closed[i - 1] > s_.watch[e]; --i) s_.closed[i] = s_.closed[i - 1];
        s_.closed[i] = s_.watch[e];
      }
    lanes_.sync();
  }
  /// The closed nodes that let go by x.
  KOKKOS_FUNCTION void open_contacts(double x) {
    if (lanes_.leader()) {
      int kept = 0;
      for (int e = 0; e < s_.closed_count; ++e)
        if (!(s_.closed_roots[e] <= x)) s_.closed[kept++] = s_.closed[e];
      s_.closed_count = kept;
    }
    lanes_.sync();
  }

  // ---- the record

  KOKKOS_FORCEINLINE_FUNCTION std::int64_t sample_tick() const {
    return s_.next_sample * static_cast<std::int64_t>(t_.steps_per_sample);
  }
  KOKKOS_FORCEINLINE_FUNCTION bool has_room_for_sample() const {
    return s_.sample_count < s_.sample_capacity;
  }

  struct Contact {
    double force = 0, energy = 0, sliding_work = 0, force_work = 0;
    int nodes = 0;
  };
  KOKKOS_FUNCTION void write_sample(const Real* u, const Real* v, const Real* square,
                                    const Contact& contact) {
    double* row_ = s_.sample_rows +
                   static_cast<std::int64_t>(s_.sample_count) * (2 * K * width + sample::columns);
    Real loss(0.0);
    for (int p = 0; p < K; ++p) {
      lanes_.store(row_ + p * width, u[p]);
      lanes_.store(row_ + (K + p) * width, v[p]);
      loss = multiply_add(lanes_.load(t_.damping + p * width),
                          lanes_.load(s_.square + p * width) + square[p], loss);
    }
    const double damping_loss = lanes_.sum(loss);
    lanes_.sync();
    if (lanes_.leader()) {
      double* column = row_ + 2 * K * width;
      column[sample::force] = contact.force;
      column[sample::nodes] = contact.nodes;
      column[sample::contact_energy] = contact.energy;
      column[sample::damping_loss] = damping_loss;
      column[sample::sliding_work] = s_.sliding_work + contact.sliding_work;
      column[sample::force_work] = s_.force_work + contact.force_work;
      ++s_.sample_count;
      ++s_.next_sample;
    }
    lanes_.sync();
  }

  /// The samples within the next `ticks`. False when the buffer is full.
  KOKKOS_FUNCTION bool fly_samples(std::int64_t ticks) {
    if (s_.next_sample >= t_.samples || sample_tick() >= step_ + ticks) return true;
    // each from the one before, those too that the launch before has written: what is flown in one
    // leap and in two has other roundings
    const auto apart = static_cast<std::int64_t>(t_.steps_per_sample);
    std::int64_t at = step_;
    Real u[K], v[K], square[K];
    go(0, u, v, square);
    for (std::int64_t sample = (step_ + apart - 1) / apart * apart; sample < step_ + ticks;
         sample += apart) {
      if (s_.next_sample >= t_.samples) break;
      flight_(u, v, square, sample - at);
      at = sample;
      if (sample < sample_tick()) continue;
      if (!has_room_for_sample()) return false;
      write_sample(u, v, square, Contact{});
    }
    return true;
  }

  KOKKOS_FUNCTION bool drive_samples(std::int64_t ticks) {
    series_.expand_squares();
    while (s_.next_sample < t_.samples && sample_tick() < step_ + ticks) {
      if (!has_room_for_sample()) return false;
      const double x = x_of(sample_tick() - step_);
      Real u[K], v[K], square[K];
      series_.state(x, u, v);
      series_.squares(x, square);
      for (int p = 0; p < K; ++p) square[p] = square_[p] + square[p];
      write_sample(u, v, square, contact_at(x));
    }
    return true;
  }

  /// The closed nodes at x, and the work since the step began.
  KOKKOS_FUNCTION Contact contact_at(double x) const {
    Contact contact;
    for (int e = 0; e < s_.closed_count; ++e) {
      const double over = polynomial(series_.overlap(e), series_.degree(), x);
      contact.force += t_.node_stiffness * over;
      contact.energy += 0.5 * t_.node_stiffness * over * over;
    }
    contact.nodes = s_.closed_count;
    sum_nodes(x);
    contact.sliding_work = sliding_work();
    contact.force_work = force_work(x);
    return contact;
  }

  /// The integrals of the closed nodes from the beginning of the step to x.
  KOKKOS_FUNCTION void sum_nodes(double x) const {
    const int n = series_.degree();
    for (int e = 0; e < s_.closed_count; ++e) {
      const double *o = series_.overlap(e), *c = series_.climb(e);
      constexpr int packs = (gauss_points + width - 1) / width;
      Real at[packs], over[packs], climb[packs];
      for (int g = 0; g < packs; ++g) {
        at[g] = Real(x) * lanes_.load(t_.gauss + g * width);
        over[g] = Real(o[n]);
        climb[g] = Real(c[n]);
      }
      for (int j = n - 1; j >= 0; --j)
        for (int g = 0; g < packs; ++g) {
          over[g] = multiply_add(over[g], at[g], Real(o[j]));
          climb[g] = multiply_add(climb[g], at[g], Real(c[j]));
        }
      Real sum(0.0), moment(0.0), work(0.0);
      for (int g = 0; g < packs; ++g) {
        const Real weighted = lanes_.load(t_.gauss + gauss_room + g * width) * over[g];
        sum = sum + weighted;
        moment = multiply_add(weighted, at[g], moment);
        work = multiply_add(weighted, climb[g], work);
      }
      double of_sum, of_moment;
      lanes_.sum(sum, moment, of_sum, of_moment);
      const NodeSums sums{x * of_sum, x * of_moment, x * lanes_.sum(work)};
      if (lanes_.leader()) s_.closed_sums[e] = sums;
    }
    lanes_.sync();
  }

  /// Work of the imposed motion, sum_n f_n V (dh_2/dx + du_2/dx) [J].
  KOKKOS_FUNCTION double sliding_work() const {
    double work = 0.0;
    for (int e = 0; e < s_.closed_count; ++e) work += s_.closed_sums[e].work;
    return t_.node_stiffness * work;
  }
  /// Work of the moving forces from the beginning of the step to x [J].
  KOKKOS_FUNCTION double force_work(double x) const {
    if (t_.moving_forces == 0) return 0.0;
    Real sum(0.0);
    for (int g = 0; g < gauss_points; ++g) {
      const double at = x * t_.gauss[g];
      Real v[K];
      series_.velocity(at, v);
      for (int p = 0; p < K; ++p) {
        Real push = lanes_.load(s_.push_series + (t_.order * K + p) * width);
        for (int j = t_.order - 1; j >= 0; --j)
          push = multiply_add(push, Real(at), lanes_.load(s_.push_series + (j * K + p) * width));
        sum = multiply_add(Real(t_.gauss[gauss_room + g]) * push, v[p], sum);
      }
    }
    return x * series_.scale() * lanes_.sum(sum);
  }

  /// The step's share of shocks and sums.
  KOKKOS_FUNCTION void record(const Place& place, std::int64_t ticks, double end) {
    if (ticks == 0) return;
    sum_nodes(end);
    const double sliding = sliding_work(), moving = force_work(end);
    if (!lanes_.leader()) return;
    s_.sliding_work += sliding;
    s_.force_work += moving;
    const int count = s_.closed_count;
    if (count == 0) {
      if (s_.open_count > 0) end_shocks(s_, step_);
      return;
    }
    s_.contact_steps += ticks;
    if (count > s_.most_nodes) s_.most_nodes = count;
    const double newton_ticks = t_.node_stiffness * series_.scale() / t_.step;
    const double way = t_.advance * (series_.scale() / t_.step);  // chi per x
    for (int e = 0; e < count; ++e) {
      s_.touched[e] = s_.closed[e];
      s_.touched_force[e] = newton_ticks * s_.closed_sums[e].overlap;
    }
    join_shocks(s_, step_, step_ + ticks - 1, place.base + place.theta, count, [&](int e) {
      return Kokkos::fma(s_.touched_force[e], s_.touched[e],
                         newton_ticks * way * s_.closed_sums[e].moment);
    });
    for (int i = 0; i < s_.open_count; ++i) {
      const double peak = highest_force(i, end);
      if (peak > s_.open[i].peak) s_.open[i].peak = peak;
    }
  }

  /// The largest sum of the forces that belong to open shock i, over the step [N].
  KOKKOS_FUNCTION double highest_force(int i, double end) const {
    const int n = series_.degree();
    const double* sum = nullptr;
    double falling = 0.0, rising = 0.0, most = 0.0;
    int e = 0;
    for (int r = 0; r < s_.run_count; ++r)
      for (; e < s_.closed_count && s_.closed[e] <= s_.runs[r].last; ++e) {
        if (s_.runs[r].shock != i) continue;
        const double* o = series_.overlap(e);
        const Hull& hull = s_.closed_hull[e];
        falling += hull.falling;
        rising += hull.rising;
        most += hull.most;
        if (sum == nullptr) {
          sum = o;
        } else {
          for (int j = 0; j <= n; ++j) s_.scan[j] = sum[j] + o[j];
          sum = s_.scan;
        }
      }
    if (sum == nullptr || t_.node_stiffness * most <= s_.open[i].peak) return 0.0;
    double highest;
    if (rising <= 0.0)
      highest = sum[0];
    else if (falling >= 0.0)
      highest = polynomial(sum, n, end);
    else
      highest = highest_value(sum, n, end);
    return t_.node_stiffness * highest;
  }

  /// Nothing touches from now on.
  KOKKOS_FUNCTION void end_flight() {
    if (lanes_.leader() && s_.open_count > 0) end_shocks(s_, step_);
    lanes_.sync();
  }

  /// Sums are kept in two parts, so that many small terms are not added to one large number.
  KOKKOS_FUNCTION void close_parts() {
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.square + p * width, lanes_.load(s_.square + p * width) + square_[p]);
      square_[p] = Real(0.0);
    }
  }

  /// The sample that falls on the end of the scene. False when it is still to be written.
  KOKKOS_FUNCTION bool last_sample() {
    if (s_.next_sample >= t_.samples) return true;
    if (!has_room_for_sample()) return false;
    Contact contact;
    if (s_.closed_count > 0) {
      series_.expand(u_, v_, stand(step_), s_.stride);
      contact = contact_at(0.0);
    }
    write_sample(u_, v_, square_, contact);
    return true;
  }

  /// The series of the moving forces' modal forces, in units of `scale` [s]. Returns the ticks for
  /// which it holds: until a force enters or leaves the beam or a patch of it.
  KOKKOS_FUNCTION std::int64_t expand_push(double scale) {
    const Real zero(0.0);
    for (int j = 0; j <= t_.order; ++j)
      for (int p = 0; p < K; ++p) lanes_.store(s_.push_series + (j * K + p) * width, zero);
    double room = 4e18;  // ticks
    for (int i = 0; i < t_.moving_forces; ++i) {
      const MovingForceTable& f = t_.moving_force[i];
      const double x = Kokkos::fma(static_cast<double>(step_), f.advance, f.position);  // m
      const double width_of_patch = t_.patch_nodes * t_.spacing;
      const bool on = x >= 0.0 && x <= t_.resonator_length;
      const int patch = on ? static_cast<int>(x / t_.spacing) / t_.patch_nodes : 0;
      double edge = -1.0;  // that it comes to next
      if (on && f.advance > 0.0)
        edge = Kokkos::min((patch + 1) * width_of_patch, t_.resonator_length);
      else if (on)
        edge = patch * width_of_patch;
      else if (x < 0.0)
        edge = 0.0;
      else
        edge = t_.resonator_length;
      const double ahead = (edge - x) / f.advance;  // not a number, or infinite, at rest
      if (f.advance != 0.0 && ahead >= 0.0) {
        // on to where the roundings of the place cannot hold it back
        const double stairs = 4 * 0x1p-52 * (Kokkos::abs(x) + Kokkos::abs(edge));
        const double ticks = Kokkos::floor(ahead + stairs / Kokkos::abs(f.advance)) + 1.0;
        if (ticks < room) room = ticks;
      }
      if (!on) continue;
      const Real eta((x / t_.spacing - (patch + 0.5) * t_.patch_nodes) * t_.inverse_radius);
      const double step = f.advance * (scale / t_.step) * t_.inverse_radius / t_.spacing;
      const double* rows = t_.patch + static_cast<std::int64_t>(patch) * 4 * K * width;
      for (int p = 0; p < K; ++p) {
        Real c[most_terms];
        full_series<Lanes, K>(lanes_, t_, rows, p, c);
        double power = f.force;
        for (int m = 0; m < t_.terms && m <= t_.order; ++m) {  // repeated synthetic division
          for (int j = t_.terms - 2; j >= m; --j) c[j] = multiply_add(eta, c[j + 1], c[j]);
          double* to = s_.push_series + (m * K + p) * width;
          lanes_.store(to, multiply_add(power, c[m], lanes_.load(to)));
          power *= step;
        }
      }
    }
    return static_cast<std::int64_t>(room);
  }
};

}  // namespace ra2d
