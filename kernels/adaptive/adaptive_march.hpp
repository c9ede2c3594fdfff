// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/adaptive_recorder.hpp"
#include "kernels/adaptive/contacts.hpp"
#include "kernels/adaptive/flight.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/overlaps.hpp"
#include "kernels/adaptive/push.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/adaptive/slider_way.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
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
/// contact begins or ends. That none begins unseen is proved, not sampled
/// (kernels/adaptive/overlaps.hpp).
///
/// The record is that of the motion itself (kernels/adaptive/adaptive_recorder.hpp). Nothing here
/// depends on where a launch ends: a step is kept whole, or done again in the next launch.
namespace ra2d {

template <class Lanes, int K>
class AdaptiveMarcher {
  using Real = typename Lanes::Real;
  using Modes = ModalState<Lanes, K>;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION AdaptiveMarcher(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes},
        t_{tables},
        s_{state},
        way_{tables},
        contact_{lanes, tables, state},
        flight_{lanes, tables},
        series_{lanes, tables, state, contact_},
        push_{lanes, tables, state},
        overlaps_{lanes, tables, state, contact_, series_},
        contacts_{lanes, tables, state, series_},
        recorder_{lanes, tables, state, flight_, series_, push_},
        step_{state.step} {
    for (int p = 0; p < K; ++p) {
      now_.u[p] = lanes_.load(s_.u + p * width);
      now_.v[p] = lanes_.load(s_.v + p * width);
      now_.square[p] = lanes_.load(s_.square_part + p * width);
    }
  }

  /// Marches to `target` or a little beyond, the end of the scene, a full buffer, an interrupt or a
  /// failure, whichever is first.
  KOKKOS_FUNCTION void run(std::int64_t target) {
    const std::int64_t stop = target < t_.total_steps ? target : t_.total_steps;
    while (s_.status == Status::running && step_ < stop && has_room_for_shocks(s_) &&
           !is_interrupted(t_))
      if (!stride()) break;
    const bool done = s_.status == Status::running && step_ == t_.total_steps && last_sample();
    lanes_.sync();
    if (done && lanes_.leader()) s_.status = Status::done;
    lanes_.sync();
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.u + p * width, now_.u[p]);
      lanes_.store(s_.v + p * width, now_.v[p]);
      lanes_.store(s_.square_part + p * width, now_.square[p]);
    }
    if (lanes_.leader()) s_.step = step_;
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  SliderWay way_;
  NodeContact<Lanes, K> contact_;
  Flight<Lanes, K> flight_;
  ModalSeries<Lanes, K> series_;
  Push<Lanes, K> push_;
  Overlaps<Lanes, K> overlaps_;
  Contacts<Lanes, K> contacts_;
  AdaptiveRecorder<Lanes, K> recorder_;
  std::int64_t step_;  // ticks
  Modes now_;

  KOKKOS_FUNCTION bool fail(Status why) {
    if (lanes_.leader()) s_.status = why;
    lanes_.sync();
    return false;
  }

  /// What no step goes beyond.
  KOKKOS_FUNCTION std::int64_t end() const {
    return step_ < t_.counted_from ? t_.counted_from : t_.total_steps;
  }

  /// One step. False when it could not be made, or is to be made in the next launch.
  KOKKOS_FUNCTION bool stride() {
    const Place place = way_.stand(step_);
    const bool free = s_.closed_count == 0 && t_.moving_forces == 0;
    std::int64_t room = free ? way_.ticks_to_next_node(place) : way_.ticks_to_next_window(place);
    if (end() - step_ < room) room = end() - step_;
    if (!(free ? fly(place, room) : drive(place, room))) return false;
    if (lanes_.leader()) ++s_.strides;
    lanes_.sync();
    if ((s_.strides & 4095) == 0) recorder_.close_parts(now_);
    lanes_.sync();
    return true;
  }

  /// What was seen at the end of the step is what the next one begins with, unless a node has
  /// passed another.
  KOKKOS_FUNCTION void pass_on(const Place& place) {
    if (way_.stand(step_).base == place.base)
      overlaps_.pass_on();
    else
      overlaps_.forget();
  }

  // ---- fly
  //
  // A flight is exact at any length: what limits it is whether contact can be ruled out. Flights
  // aim at 2^level ticks, about the length at which the cubics decide that by themselves: the next
  // one is to be longer if they did so over all of it, shorter if they could not and a shorter one
  // tells more.

  static constexpr int longest_level = 60;

  /// The length that a flight begins with.
  struct Aim {
    std::int64_t ticks;
    bool whole;  // it is the one aimed at: neither a node's passing nor the end comes before
    bool clear;  // the bodies are so far apart that no node could touch any other
  };
  KOKKOS_FUNCTION Aim take_aim(std::int64_t room) const {
    const std::int64_t length = std::int64_t{1} << s_.level;
    const std::int64_t whole = length - (step_ & (length - 1));  // to a multiple of it
    if (whole <= room) return {whole, true, false};
    // nodes may pass each other where faces and modes could not meet anywhere
    const std::int64_t left = end() - step_;
    const std::int64_t far = whole < left ? whole : left;
    const MotionBounds bounds = flight_.bounds(now_.u, now_.v, far * t_.step);
    if (t_.top + bounds.size + t_.slack + bounds.rounding() < 0.0) return {far, far == whole, true};
    return {room, false, false};
  }

  KOKKOS_FUNCTION bool fly(const Place& place, std::int64_t room) {
    const Aim aim = take_aim(room);
    const int longer = aim.whole && s_.level < longest_level ? s_.level + 1 : s_.level;
    if (aim.clear) {
      if (!land(aim.ticks, flown(aim.ticks), longer)) return false;
      overlaps_.forget();
      return true;
    }
    const MotionBounds bounds = flight_.bounds(now_.u, now_.v, aim.ticks * t_.step);
    const double rise = overlaps_.longest_rise(now_.u, bounds, aim.ticks);
    overlaps_.find_near(place, now_, bounds, rise, room - aim.ticks);
    overlaps_.see_beginning(place, now_);
    if (!(bounds.size < 1e300)) return fail(Status::not_finite);
    Modes end = flown(aim.ticks);
    const int flagged = see_and_flag(place, end, aim.ticks, bounds, rise);
    if (flagged > 0) return fly_and_search(place, end, aim.ticks, bounds, rise, flagged);
    if (!land(aim.ticks, end, longer)) return false;
    pass_on(place);
    return true;
  }

  /// A flight of which the cubics cannot rule out that one of the flagged nodes touches: their
  /// series are searched, over no more than these hold for.
  KOKKOS_FUNCTION bool fly_and_search(const Place& place, Modes& end, std::int64_t aimed,
                                      const MotionBounds& bounds, double rise, int flagged) {
    std::int64_t ticks = aimed;
    const double scale = Kokkos::min(ticks * t_.step, t_.longest_scale);
    series_.expand(now_.u, now_.v, place, scale);
    const double extent = series_.extent(t_.tolerance);
    if (!(extent > 0.0)) return fail(Status::not_finite);
    const double reach = extent * (scale / t_.step);
    if (reach < static_cast<double>(ticks)) ticks = static_cast<std::int64_t>(reach);
    if (ticks < 1) return fail(Status::stalled);
    // a length at which the cubics may decide by themselves
    int level = s_.level;
    if (overlaps_.shorter_tells_more(aimed * t_.step, bounds))
      level = Kokkos::max(ticks < aimed ? whole_level(ticks) : level - 1, t_.first_level);
    // the nodes' shapes that the series are made of hold for a window
    const std::int64_t window = way_.ticks_to_next_window(place);
    if (window < ticks) ticks = window;
    if (ticks < aimed) {  // of a shorter flight the cubics tell more
      end = flown(ticks);
      flagged = see_and_flag(place, end, ticks, bounds, rise);
    }
    if (flagged > 0) {
      const double x = series_.x_at(ticks);
      const double first = overlaps_.search(place, flagged, x, overlaps_.touch(now_.u));
      if (first <= x) return touch_down(series_.ticks_to(first, ticks), flagged);
    }
    if (!land(ticks, end, level)) return false;
    pass_on(place);
    return true;
  }

  /// Ends a flight in contact with the flagged nodes that touch by then.
  KOKKOS_FUNCTION bool touch_down(std::int64_t ticks, int flagged) {
    const double x = series_.x_at(ticks);
    if (!contacts_.have_room(flagged, x)) return fail(Status::crowded);
    if (!recorder_.fly_samples(step_, now_, ticks)) return false;
    Modes end = flown(ticks);
    series_.state(x, end.u, end.v);  // to the bit where the search found the overlap
    now_ = end;
    if (ticks > 0) recorder_.add_flight(step_);
    step_ += ticks;
    overlaps_.forget();
    contacts_.close(flagged, x);
    return true;
  }

  /// Ends a flight without contact; the next one aims at 2^level ticks.
  KOKKOS_FUNCTION bool land(std::int64_t ticks, const Modes& end, int level) {
    if (!recorder_.fly_samples(step_, now_, ticks)) return false;
    now_ = end;
    recorder_.add_flight(step_);
    step_ += ticks;
    if (lanes_.leader()) s_.level = level;
    lanes_.sync();
    return true;
  }

  KOKKOS_FORCEINLINE_FUNCTION Modes flown(std::int64_t ticks) const {
    Modes there = now_;
    flight_(there.u, there.v, there.square, ticks);
    return there;
  }
  /// The l with 2^l <= ticks < 2^(l + 1).
  KOKKOS_FORCEINLINE_FUNCTION static int whole_level(std::int64_t ticks) {
    return Kokkos::bit_width(static_cast<std::uint64_t>(ticks)) - 1;
  }

  // ---- drive

  KOKKOS_FUNCTION bool drive(const Place& place, std::int64_t room) {
    double reach;  // s
    if (!expand(place, room, reach)) return false;
    const double longest = reach / t_.step;
    std::int64_t ticks =
        longest < static_cast<double>(room) ? static_cast<std::int64_t>(longest) : room;
    double end = series_.x_at(ticks);

    // contacts that end
    const double touch = overlaps_.touch(now_.u) + series_.neglected();
    const double release = contacts_.first_to_let_go(end, touch);
    if (release <= end) {
      ticks = series_.ticks_to(release, ticks);
      end = series_.x_at(ticks);
    }
    // contacts that begin
    const MotionBounds bounds = series_.bounds(end);
    const double rise = overlaps_.longest_rise(now_.u, bounds, ticks);
    overlaps_.find_near(place, now_, bounds, rise, room - ticks);
    overlaps_.see_beginning(place, now_);
    Modes there;
    series_.state(end, there.u, there.v);
    const int flagged = see_and_flag(place, there, ticks, bounds, rise);
    bool onset = false;
    if (flagged > 0) {
      const double first = overlaps_.search(place, flagged, end, touch);
      onset = first <= end;
      if (onset) {
        ticks = series_.ticks_to(first, ticks);
        end = series_.x_at(ticks);
        if (!contacts_.have_room(flagged, end)) return fail(Status::crowded);
        series_.state(end, there.u, there.v);
      }
    }

    if (!recorder_.drive_samples(step_, now_, ticks)) return false;
    recorder_.add_drive(place, step_, ticks, end);
    series_.squares(end, there.square);
    for (int p = 0; p < K; ++p) there.square[p] = now_.square[p] + there.square[p];
    now_ = there;
    if (s_.closed_count > 0 && lanes_.leader()) s_.shape_terms = series_.wanted_terms();
    step_ += ticks;
    if (release <= end) contacts_.open(end);
    if (onset) contacts_.close(flagged, end);
    // at rest it would grow for ever
    if (lanes_.leader()) s_.stride = Kokkos::min(reach, t_.longest_scale);
    lanes_.sync();
    if (onset)
      overlaps_.forget();
    else
      pass_on(place);
    return true;
  }

  /// Expands the motion, in units that suit it: `reach` is how far its series may be used [s]. Cuts
  /// `room` to the ticks for which those of the moving forces hold.
  KOKKOS_FUNCTION bool expand(const Place& place, std::int64_t& room, double& reach) {
    while (true) {
      const double scale = s_.stride;
      if (t_.moving_forces > 0) {
        const std::int64_t push_room = push_.expand(step_, scale);
        if (push_room < room) room = push_room;
      }
      series_.expand(now_.u, now_.v, place, scale);
      const double extent = series_.extent(t_.tolerance);
      if (!(extent > 0.0)) return fail(Status::not_finite);
      reach = extent * scale;
      if (!(reach >= t_.step)) return fail(Status::stalled);
      // where the step before told little about this one, once more in better units
      lanes_.sync();
      if (extent < 0.25 && lanes_.leader()) s_.stride = reach;
      lanes_.sync();
      if (!(extent < 0.25)) return true;
    }
  }

  // ---- both

  /// Sees the end of a step of so many ticks, whose beginning has been seen, and flags the nodes
  /// that could touch within it.
  KOKKOS_FUNCTION int see_and_flag(const Place& place, const Modes& end, std::int64_t ticks,
                                   const MotionBounds& bounds, double rise) {
    overlaps_.see_end(way_.moved(place, step_ + ticks), end.u, end.v);
    return overlaps_.flag(ticks * t_.step, bounds, rise);
  }

  /// The sample that falls on the end of the scene. False when it is still to be written.
  KOKKOS_FUNCTION bool last_sample() {
    if (recorder_.is_complete()) return true;
    if (!recorder_.has_room_for_sample()) return false;
    if (s_.closed_count > 0) series_.expand(now_.u, now_.v, way_.stand(step_), s_.stride);
    recorder_.write_last_sample(now_);
    return true;
  }
};

}  // namespace ra2d
