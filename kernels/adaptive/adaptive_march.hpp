// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/adaptive_recorder.hpp"
#include "kernels/adaptive/contacts.hpp"
#include "kernels/adaptive/flight.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/moving_force_series.hpp"
#include "kernels/adaptive/overlaps.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/adaptive/slider_path.hpp"
#include "kernels/adaptive/smooth_drive.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// The adaptive scheme: steps of any length. It knows three kinds of step.
///
///   fly    no contact and no moving force: closed form (kernels/adaptive/flight.hpp)
///   drive  contact of nodes, moving forces: a power series whose length the error control chooses
///          (kernels/adaptive/series.hpp), with the same nodes in contact from beginning to end
///   drive_on_smooth_faces
///          contact between smooth faces: collocation (kernels/adaptive/smooth_drive.hpp)
///
/// A step ends at the latest where a node passes another (straight faces have a kink there), and
/// where a contact begins or, of nodes, ends. That none begins unseen is proved, not sampled
/// (kernels/adaptive/overlaps.hpp).
///
/// The record is that of the motion itself (kernels/adaptive/adaptive_recorder.hpp). Nothing here
/// depends on where a launch ends: a step is kept whole, or done again in the next launch.
namespace ra2d {

template <class Lanes, int packs>
class AdaptiveMarch {
  using Real = typename Lanes::Real;
  using Modes = ModalState<Lanes, packs>;
  static constexpr int width = Lanes::width;

 public:
  RA2D_FUNCTION AdaptiveMarch(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes},
        tables_{tables},
        state_{state},
        path_{tables.motion},
        flight_{lanes, tables.modes, tables.motion, tables.bounds, tables.adaptive, tables.flight},
        moving_forces_{lanes,         tables.motion,   tables.patches,
                       tables.forces, tables.adaptive, state.work.series.forces},
        series_{lanes,
                tables.modes,
                tables.motion,
                tables.contact,
                tables.bounds,
                tables.adaptive,
                tables.forces,
                node_contact(),
                clusters(),
                state.carried.contacts,
                state.carried.control,
                state.work.series,
                state.work.spans.hulls},
        overlaps_{lanes,
                  tables.motion,
                  tables.faces,
                  tables.slider,
                  tables.patches,
                  tables.bounds,
                  tables.adaptive,
                  node_contact(),
                  state.carried.contacts,
                  state.work.candidates,
                  state.work.amplitudes,
                  state.work.listed_nodes,
                  state.work.search,
                  state.work.groups,
                  state.carried.sums.evaluated},
        contacts_{lanes,
                  state.carried.contacts,
                  state.work.spans,
                  state.work.listed_nodes,
                  state.work.search.onsets,
                  state.work.search.bernstein},
        recorder_{lanes,
                  tables.modes,
                  tables.motion,
                  tables.contact,
                  tables.adaptive,
                  tables.output,
                  flight_,
                  moving_forces_,
                  state.carried,
                  state.work.contact_list,
                  state.work.runs,
                  state.work.spans,
                  state.work.search.polynomial,
                  state.out},
        tick_{state.carried.step} {
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      now_.u[p] = lanes_.load(state_.carried.modal.u + p * width);
      now_.v[p] = lanes_.load(state_.carried.modal.v + p * width);
      now_.square[p] = lanes_.load(state_.carried.modal.square_part + p * width);
    }
  }

  /// Marches to `target` or a little beyond, the end of the scene or of the time, a full buffer, an
  /// interrupt or a failure, whichever is first.
  KOKKOS_FORCEINLINE_FUNCTION void run(std::int64_t target) {
    const std::int64_t stop =
        target < tables_.output.total_steps ? target : tables_.output.total_steps;
    while (state_.carried.status == Status::running && tick_ < stop &&
           can_record_shocks(state_.out.ended_shocks, state_.work.runs) &&
           !is_interrupted(tables_.interrupted) && !lanes_.time_is_up())
      if (!advance()) break;
    const bool done = state_.carried.status == Status::running &&
                      tick_ == tables_.output.total_steps && last_sample();
    lanes_.sync();
    if (done && lanes_.leader()) state_.carried.status = Status::done;
    lanes_.sync();
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(state_.carried.modal.u + p * width, now_.u[p]);
      lanes_.store(state_.carried.modal.v + p * width, now_.v[p]);
      lanes_.store(state_.carried.modal.square_part + p * width, now_.square[p]);
    }
    if (lanes_.leader()) state_.carried.step = tick_;
  }

 private:
  Lanes lanes_;
  const SceneTables& tables_;
  SceneState& state_;
  SliderPath path_;
  Flight<Lanes, packs> flight_;
  MovingForceSeries<Lanes, packs> moving_forces_;
  ModalSeries<Lanes, packs> series_;
  Overlaps<Lanes, packs> overlaps_;
  Contacts<Lanes, packs> contacts_;
  AdaptiveRecorder<Lanes, packs> recorder_;
  std::int64_t tick_;
  Modes now_;
  int met_ = next_step;  // the phase that was begun last

  RA2D_FUNCTION NodeContact<Lanes, packs> node_contact() const {
    return {lanes_,         tables_.motion,  tables_.faces,
            tables_.slider, tables_.patches, tables_.contact,
            state_.marks,   state_.caches,   state_.work.contact_list};
  }

  using Series = ModalSeries<Lanes, packs>;
  RA2D_FUNCTION typename Series::Clusters clusters() const {
    if constexpr (Series::has_clusters)
      return {lanes_,          tables_.motion,  tables_.faces,       tables_.slider,
              tables_.patches, tables_.contact, tables_.clusters,    state_.carried.contacts,
              state_.marks,    state_.caches,   state_.work.clusters};
    else
      return {};
  }

  RA2D_FUNCTION bool fail(Status why) {
    if (lanes_.leader()) state_.carried.status = why;
    lanes_.sync();
    return false;
  }

  /// The tick that no step goes beyond.
  RA2D_FUNCTION std::int64_t end() const {
    return tick_ < tables_.output.counted_from ? tables_.output.counted_from
                                               : tables_.output.total_steps;
  }

  /// Parts of a step that the scenes of a block begin together, whatever kinds of step they make.
  /// One that a step does without is passed with the next.
  enum Phase { search = 1, evaluate, onsets, record, next_step };
  KOKKOS_FORCEINLINE_FUNCTION void enter(Phase phase) {
    for (; met_ < phase; ++met_) lanes_.meet_scenes();
  }

  /// One step. False when it could not be made, or is to be made in the next launch.
  KOKKOS_FORCEINLINE_FUNCTION bool advance() {
    enter(next_step);
    met_ = 0;
    const Place place = path_.at(tick_);
    const bool free = state_.carried.contacts.count == 0 && tables_.forces.count == 0;
    std::int64_t available =
        free ? path_.ticks_to_next_node(place) : path_.ticks_to_next_window(place);
    if (end() - tick_ < available) available = end() - tick_;
    if (tables_.faces.smooth && state_.carried.contacts.count > 0) [[unlikely]] {
      if (!drive_on_smooth_faces(place, available)) return false;
    } else if (!fly_or_drive(place, available, free)) {
      return false;
    }
    if (lanes_.leader()) ++state_.carried.adaptive_steps;
    lanes_.sync();
    if ((state_.carried.adaptive_steps & 4095) == 0) recorder_.close_parts(now_);
    lanes_.sync();
    return true;
  }

  /// Keeps the overlaps at the end of this step as those at the beginning of the next, unless a
  /// node has passed another.
  RA2D_FUNCTION void keep_overlaps(const Place& place) {
    const Place end = path_.at(tick_);
    if (end.base == place.base)
      overlaps_.end_becomes_start(end, now_.u);
    else
      overlaps_.discard_start();
  }

  // ---- fly
  //
  // A flight is exact at any length, but contact must be ruled out over all of it. Flights are
  // planned for 2^level ticks, about the longest for which the cubics alone rule it out. If they
  // do, the next flight is longer. If they do not, and would over a shorter one, the next is
  // shorter.

  static constexpr int longest_level = 60;

  /// Chooses the ticks of a flight, no more than `available` unless it is `clear`: the bodies are
  /// so far apart that nodes may pass each other without any contact. Returns whether the length is
  /// the one planned, which neither a node's passing nor the end cuts.
  RA2D_FUNCTION bool plan_flight(std::int64_t available, std::int64_t& ticks, bool& clear,
                                 MotionBounds& bounds) const {
    const std::int64_t length = std::int64_t{1} << state_.carried.control.flight_level;
    const std::int64_t whole = length - (tick_ & (length - 1));  // to a multiple of it
    const std::int64_t left = end() - tick_;
    ticks = whole < left ? whole : left;
    RA2D_KEEP_LOOP
    for (bool passes = whole > available;; passes = false) {
      bounds = flight_.bounds(now_.u, now_.v, ticks * tables_.motion.time_step);
      clear = passes && tables_.faces.highest_overlap + bounds.size + tables_.faces.rounding +
                                bounds.rounding() <
                            0.0;
      if (clear || !passes) return ticks == whole;
      ticks = available;
    }
  }

  /// Records a flight of so many ticks and goes to its end. False when its samples do not fit.
  RA2D_FUNCTION bool record_flight(std::int64_t ticks, const Modes& there) {
    if (!recorder_.fly_samples(tick_, now_, ticks)) return false;
    now_.take(lanes_, there);
    if (ticks > 0) recorder_.add_flight(tick_);
    tick_ += ticks;
    return true;
  }

  /// Cuts a flight for which the cubics cannot rule out contact to the `usable` ticks of its
  /// series, and to those for which the nodes' shapes in it hold; chooses the level of the next
  /// flight.
  RA2D_FUNCTION bool shorten_flight(const Place& place, const MotionBounds& bounds, double usable,
                                    std::int64_t& ticks, int& level) {
    const std::int64_t aimed = ticks;
    if (usable < static_cast<double>(ticks)) ticks = static_cast<std::int64_t>(usable);
    if (ticks < 1) return fail(Status::stalled);
    // a length at which the cubics may decide by themselves
    level = state_.carried.control.flight_level;
    if (overlaps_.shorter_is_better(aimed * tables_.motion.time_step, bounds))
      level =
          Kokkos::max(ticks < aimed ? whole_level(ticks) : level - 1, tables_.flight.first_level);
    // the nodes' shapes in the series hold for a window
    const std::int64_t window = path_.ticks_to_next_window(place);
    if (window < ticks) ticks = window;
    return true;
  }
  /// The l with 2^l <= ticks < 2^(l + 1).
  KOKKOS_FORCEINLINE_FUNCTION static int whole_level(std::int64_t ticks) {
    return Kokkos::Experimental::bit_width_builtin(static_cast<std::uint64_t>(ticks)) - 1;
  }

  // ---- drive

  /// Records a step of so many ticks and goes to its end. False when its samples do not fit.
  KOKKOS_FORCEINLINE_FUNCTION bool keep_drive(const Place& place, Modes& there, std::int64_t ticks,
                                              double end) {
    if (!recorder_.add_drive(series_, place, tick_, now_, ticks, end, there)) return false;
    now_.take(lanes_, there);
    if (state_.carried.contacts.count > 0 && lanes_.leader())
      state_.carried.control.shape_terms = series_.wanted_terms();
    tick_ += ticks;
    return true;
  }

  /// Expands the motion: of a flight in units of its `ticks`, else in units that suit it. `usable`
  /// becomes the length for which the series may be used, in these units; `available` is cut to the
  /// ticks for which those of the moving forces hold.
  RA2D_FUNCTION bool expand(const Place& place, bool free, std::int64_t ticks,
                            std::int64_t& available, double& usable) {
    while (true) {
      const double scale =
          free ? Kokkos::min(ticks * tables_.motion.time_step, tables_.adaptive.longest_scale)
               : state_.carried.control.series_scale;
      if (tables_.forces.count > 0) {
        const std::int64_t valid = moving_forces_.expand(tick_, scale);
        if (valid < available) available = valid;
      }
      if (!series_.expand(now_.u, now_.v, place, scale)) [[unlikely]]
        return fail(Status::crowded);
      usable = series_.usable_length(tables_.adaptive.tolerance);
      if (!(usable > 0.0)) return fail(Status::not_finite);
      if (free) return true;
      const double usable_time = usable * scale;
      if (!(usable_time >= tables_.motion.time_step)) return fail(Status::stalled);
      // the last step was a poor guess for this one: once more in better units
      lanes_.sync();
      if (usable < 0.25 && lanes_.leader()) state_.carried.control.series_scale = usable_time;
      lanes_.sync();
      if (!(usable < 0.25)) return true;
    }
  }

  // ---- fly or drive

  /// One step of either kind. A GPU waits for the code that it has to fetch (docs/gpu.md): so what
  /// both kinds need, or one needs twice, is written once, in a loop. Most steps go through it
  /// once. A flight does so again with its series, where the cubics cannot rule out contact; a step
  /// at whose end contact is to begin goes through it again to get there.
  KOKKOS_FORCEINLINE_FUNCTION bool fly_or_drive(const Place& place, std::int64_t available,
                                                bool free) {
    MotionBounds bounds;
    std::int64_t ticks = 0;           // of the step
    std::int64_t selected_ticks = 0;  // for which groups have been selected
    int level = 0;                    // of the next flight
    double usable_time = 0.0;         // s: of the series
    double end = 0.0, release = 0.0;  // x of the series: of the step, and where a contact ends
    double tolerance = 0.0;           // of an overlap in it
    bool clear = false;               // no node can come into contact
    if (free) {
      level = state_.carried.control.flight_level;
      if (plan_flight(available, ticks, clear, bounds) && level < longest_level) ++level;
    }

    Modes there;                               // at the end of the step
    Rise rise;                                 // of an overlap in it
    int flagged = 0;                           // nodes whose contact may begin in it
    bool expands = !free;                      // the series is found next
    bool in_series = false, searched = clear;  // it has been found; groups have been searched
    bool onset = false;                        // a contact begins at the end of the step
    while (true) {
      bool goes = true;  // to another end than before
      if (expands) {
        expands = false;
        in_series = true;
        double usable;
        if (!expand(place, free, ticks, available, usable)) return false;
        tolerance = overlaps_.overlap_rounding(now_.u) + series_.neglected();
        if (free) {
          const std::int64_t aimed = ticks;
          if (!shorten_flight(place, bounds, usable * (series_.scale() / tables_.motion.time_step),
                              ticks, level))
            return false;
          end = series_.x_at(ticks);
          goes = ticks != aimed;  // over a shorter flight the cubics are more accurate
        } else {
          usable_time = usable * series_.scale();
          const double longest = usable_time / tables_.motion.time_step;
          ticks = longest < static_cast<double>(available) ? static_cast<std::int64_t>(longest)
                                                           : available;
          end = series_.x_at(ticks);
          // contacts that end
          release = contacts_.first_end(series_, end, tolerance);
          if (release <= end) {
            ticks = series_.ticks_to(release, ticks);
            end = series_.x_at(ticks);
          }
          bounds = series_.bounds(end);
        }
      }

      enter(search);
      if (goes) {
        if (free) {
          there.take(lanes_, now_);
          flight_(there.u, there.v, there.square, ticks);
        }
        // a flight to an onset: to the bit where the search found the overlap
        if (!free || onset) series_.state(end, there.u, there.v);
      }
      if (clear || onset) break;

      // contacts that begin
      if (!searched) {
        searched = true;
        rise = overlaps_.knows_footprint()
                   ? overlaps_.longest_rise(place, now_, there, bounds, ticks)
                   : overlaps_.longest_rise(now_.u, bounds, ticks);
        overlaps_.find_groups(place, now_, bounds, rise, available - ticks);
        overlaps_.select(place, now_.u, bounds, rise, ticks);
        selected_ticks = ticks;
        if (free && !(bounds.size < 1e300)) return fail(Status::not_finite);
      }
      if (goes) {
        enter(evaluate);
        flagged = evaluate_and_flag(place, there, ticks, bounds, rise);
        if (flagged == 0) break;
        if (!in_series) {  // over a long flight they may be most of the nodes
          expands = true;
          continue;
        }
      }
      if (!overlaps_.has_room(flagged)) [[unlikely]]
        return fail(Status::crowded);
      enter(onsets);
      const double first = overlaps_.search(series_, place, flagged, end, tolerance);
      if (first < 0.0) [[unlikely]]
        return fail(Status::crowded);
      onset = first <= end;
      if (!onset) break;
      ticks = series_.ticks_to(first, ticks);
      end = series_.x_at(ticks);
      if (!contacts_.can_take(flagged, end)) return fail(Status::crowded);
    }

    if (onset || clear || ticks != selected_ticks)
      overlaps_.end_at(place, now_, there, bounds, ticks);
    enter(record);
    if (free) {
      if (!record_flight(ticks, there)) return false;
    } else if (!keep_drive(place, there, ticks, end)) {
      return false;
    }
    if (!free && release <= end) contacts_.end(end);
    if (onset) {
      contacts_.begin(flagged, end);
      begin_smooth_contact();
    }
    if (lanes_.leader()) {
      StepControl& control = state_.carried.control;
      if (!free) {
        choose_order(control, end * series_.scale() / usable_time);
        // without the limit it would grow for ever at rest
        control.series_scale = Kokkos::min(usable_time, tables_.adaptive.longest_scale);
      } else if (!onset) {
        control.flight_level = level;
      }
    }
    lanes_.sync();
    if (free && (onset || clear) && !overlaps_.knows_footprint())
      overlaps_.forget_start();  // the flight ends where its series does
    else if (onset || clear)
      overlaps_.discard_start();
    else
      keep_overlaps(place);
    return true;
  }

  /// Chooses the order of the series after a step in contact that has made so much of its usable
  /// length. A higher order makes steps longer, and each of them dearer: where contacts begin and
  /// end so often that most steps end early, that is in vain. It is never lower than usual: many
  /// short steps add up their errors.
  RA2D_FUNCTION void choose_order(StepControl& control, double share) const {
    if (tables_.adaptive.most_raised == 0) return;
    control.used_share += (share - control.used_share) / 64;
    const int raise = control.used_share > 0.6 ? 1 : control.used_share < 0.3 ? -1 : 0;
    const int raised = control.raised + raise;
    if (raise == 0 || raised > tables_.adaptive.most_raised || raised < 0) return;
    control.raised = raised;
    control.used_share = 0.45;
  }

  /// A step in contact between smooth faces.
  RA2D_FUNCTION bool drive_on_smooth_faces(const Place& place, std::int64_t available) {
    using Drive = SmoothDrive<Lanes, packs>;
    CarriedState& carried = state_.carried;
    WorkSpace& work = state_.work;
    SmoothStep<Lanes, packs> step(
        lanes_, tables_.modes, tables_.motion, tables_.faces, tables_.slider, tables_.adaptive,
        tables_.forces, tables_.contact, tables_.collocation, node_contact(),
        {lanes_, state_.marks, state_.caches}, work.contact_list, work.series.forces,
        carried.control.series_scale, now_, carried.begin, place, work.points);
    Drive make_step(lanes_, tables_.motion, tables_.bounds, tables_.faces, tables_.adaptive,
                    tables_.forces, path_, node_contact(), moving_forces_, overlaps_, contacts_,
                    recorder_, step, carried.contacts, carried.control, carried.shocks, work,
                    state_.out.ended_shocks);
    switch (make_step(now_, tick_, place, available)) {
      case Drive::Outcome::made:
        return true;
      case Drive::Outcome::full:
        return false;
      case Drive::Outcome::crowded:
        return fail(Status::crowded);
      case Drive::Outcome::not_finite:
        return fail(Status::not_finite);
      case Drive::Outcome::stalled:
        break;
    }
    return fail(Status::stalled);
  }

  // ---- all

  KOKKOS_FORCEINLINE_FUNCTION void begin_smooth_contact() {
    if (!tables_.faces.smooth) [[likely]]
      return;
    if (lanes_.leader()) {
      state_.carried.control.contact_begins = true;
      state_.carried.control.expected_onset = 1e300;
      state_.carried.control.expected_release = 1e300;
      state_.carried.begin.knows_forces = state_.carried.begin.knows_rates = false;
    }
    lanes_.sync();
  }

  /// Finds the overlaps at both ends of a step of so many ticks, and flags the nodes that could
  /// come into contact within it.
  RA2D_FUNCTION int evaluate_and_flag(const Place& place, const Modes& end, std::int64_t ticks,
                                      const MotionBounds& bounds, const Rise& rise) {
    const Place end_place = path_.moved(place, tick_ + ticks);
    overlaps_.evaluate(place, now_.u, now_.v, end_place, end.u, end.v);
    const int flagged =
        overlaps_.flag(place, now_.u, ticks * tables_.motion.time_step, bounds, rise);
    if (!tables_.faces.smooth || flagged == 0 || !overlaps_.has_room(flagged)) [[likely]]
      return flagged;
    // cells are expanded for a window
    if (ticks > path_.ticks_to_next_window(place)) return flagged;
    return overlaps_.keep_close_in_flight(place, end_place, now_, end, ticks, bounds, flagged);
  }

  /// The sample that falls on the end of the scene. False when it is still to be written.
  RA2D_FUNCTION bool last_sample() {
    if (recorder_.is_complete()) return true;
    if (!recorder_.can_take_sample()) return false;
    if (tables_.faces.smooth) [[unlikely]] {
      const Place place = path_.at(tick_);
      const NodeContact<Lanes, packs> contact = node_contact();
      const ContactSet& set = state_.carried.contacts;
      if (!contact.expand(place, set.nodes, set.count)) [[unlikely]]
        return fail(Status::crowded);
      Real force[packs];
      for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = Real(0.0);
      recorder_.write_last_sample(contact(place, now_.u, set.nodes, set.count, force), now_);
      return true;
    }
    if (state_.carried.contacts.count > 0 &&
        !series_.expand(now_.u, now_.v, path_.at(tick_), state_.carried.control.series_scale))
        [[unlikely]]
      return fail(Status::crowded);
    recorder_.write_last_sample(series_, now_);
    return true;
  }
};

}  // namespace ra2d
