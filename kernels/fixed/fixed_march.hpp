// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/contact/clustered_contact.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/fixed/contact_step.hpp"
#include "kernels/fixed/fixed_recorder.hpp"
#include "kernels/fixed/modes_step.hpp"
#include "kernels/fixed/outer_forces.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/limits.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The time loop of the schemes with fixed steps: one team marches one scene through many steps
/// inside one launch.
///
/// Every step is the paper's: contact detection, contact force, time integration. Which scheme
/// integrates stands in the scene's tables (kernels/schemes/mode_step.hpp); the march knows three
/// forms of a step (Form, kernels/tables.hpp).
///
/// `Nodes::all` and `Nodes::candidates` differ only in which nodes are evaluated
/// (kernels/candidates.hpp). The arithmetic of a step does not depend on that, nor on where a
/// launch ends: the results of all nodes and candidates, of one launch or many, are equal bit for
/// bit.
template <class Lanes, Form form, int packs>
class FixedMarch {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;
  using List = ListedNodes<form == Form::implicit>;
  static constexpr bool can_keep = keeps_lists<Lanes, packs> && form != Form::implicit;

 public:
  RA2D_FUNCTION FixedMarch(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes},
        tables_{tables},
        state_{state},
        outer_{lanes, tables.modes, tables.motion, tables.patches, tables.forces},
        integrate_{lanes, tables.motion, tables.scheme, outer_},
        node_contact_{lanes,         tables.motion,  tables.faces,
                      tables.slider, tables.patches, tables.contact,
                      state.marks,   state.caches,   state.work.contact_list},
        contact_{lanes, tables, state, node_contact_},
        candidates_{lanes,
                    tables.modes,
                    tables.motion,
                    tables.faces,
                    tables.slider,
                    tables.patches,
                    tables.contact,
                    tables.scheme,
                    tables.bounds,
                    state.work.candidates,
                    state.work.amplitudes,
                    state.work.listed_nodes,
                    state.carried.sums.evaluated},
        recorder_{lanes,
                  tables.modes,
                  tables.motion,
                  tables.contact,
                  tables.scheme,
                  tables.output,
                  outer_,
                  integrate_,
                  contact_,
                  state.carried,
                  state.work.listed_nodes,
                  state.work.contact_list,
                  state.work.runs,
                  state.out},
        contact_step_{
            lanes,
            tables.motion,
            tables.contact,
            tables.scheme,
            outer_,
            integrate_,
            contact_,
            {lanes, tables.faces, tables.contact, tables.bounds, node_contact_,
             state.carried.latest_contact, state.marks.active_index, state.work.active,
             state.work.contact_list, state.work.listed_nodes, tables.interrupted},
            {lanes, tables.contact, tables.bounds, node_contact_, state.marks, state.caches,
             state.work.active, state.work.listed_nodes, tables.interrupted},
            {lanes, tables.faces, tables.contact, tables.bounds, state.marks, state.caches,
             state.work.active, state.work.contact_list, state.work.listed_nodes,
             tables.interrupted},
            state.carried.status,
            state.carried.latest_contact,
            state.work.contact_list,
            state.work.listed_nodes} {
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      now_.u[p] = lanes_.load(state_.carried.modal.u + p * width);
      now_.v[p] = lanes_.load(state_.carried.modal.v + p * width);
      now_.square[p] = lanes_.load(state_.carried.modal.square_part + p * width);
    }
    now_.deflection_work = lanes_.load(state_.carried.sums.deflection_work_part);
    now_.step = state_.carried.step;
    begin();
  }

  /// Marches until step `target`, the end of the scene or of the time, a full buffer, an interrupt
  /// or a failure, whichever is first.
  ///
  /// All that lies between two lists of nodes is one branch of one loop: so scenes that share a
  /// warp make their steps in contact together, whenever their lists end.
  KOKKOS_FORCEINLINE_FUNCTION void run(std::int64_t target) {
    const std::int64_t stop =
        target < tables_.output.total_steps ? target : tables_.output.total_steps;
    const auto w = integrate_.weights();
    List nodes;
    bool searches = false;  // the next step, instead of making a list
    Motion<Lanes, packs> y = now_;
    const SliderMotion motion = tables_.motion;  // a copy stays in registers
    Place place(motion, y.step);
    recorder_.begin_stretch();
    while (true) {
      lanes_.meet_in_warp();
      if (nodes.left() == 0 || !recorder_.has_room()) {
        now_ = y;  // of which calls take the address: y stays in registers
        const bool listed = march_to_list(stop, searches, nodes);
        y = now_;
        if (!listed) break;
        recorder_.begin_list();
        place = Place(motion, y.step);
      }
      place.move_to(motion, y.step);
      if (contact_step_(y, w, place, nodes, recorder_)) {
        nodes.take_step();
      } else {  // the list does not cover this step
        searches = nodes.made() == 0;
        nodes.end();
      }
    }
    const bool done = state_.carried.status == Status::running &&
                      now_.step == tables_.output.total_steps && recorder_.is_complete();
    lanes_.sync();
    if (done && lanes_.leader()) state_.carried.status = Status::done;
    save();
  }

 private:
  Lanes lanes_;
  const SceneTables& tables_;
  SceneState& state_;
  OuterForces<Lanes, packs> outer_;
  ModesStep<Lanes, form, packs> integrate_;
  NodeContact<Lanes, packs> node_contact_;
  ClusteredContact<Lanes, packs> contact_;
  Candidates<Lanes, packs> candidates_;
  FixedRecorder<Lanes, form, packs> recorder_;
  ContactStep<Lanes, form, packs> contact_step_;
  Motion<Lanes, packs> now_;
  std::int64_t next_ = 0;  // the step to which this stretch of the record goes

  KOKKOS_FORCEINLINE_FUNCTION bool can_record_shocks() const {
    return ra2d::can_record_shocks(state_.out.ended_shocks, state_.work.runs);
  }
  RA2D_FUNCTION void save() {
    lanes_.sync();
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(state_.carried.modal.u + p * width, now_.u[p]);
      lanes_.store(state_.carried.modal.v + p * width, now_.v[p]);
      lanes_.store(state_.carried.modal.square_part + p * width, now_.square[p]);
    }
    lanes_.store(state_.carried.sums.deflection_work_part, now_.deflection_work);
    if (lanes_.leader()) state_.carried.step = now_.step;
  }

  /// Once a scene: takes the velocity of t = 0 to where the scheme has it.
  RA2D_FUNCTION void begin() {
    if (state_.carried.modal.begun) return;
    // a body at rest under contact forces that are yet to be found is not accelerated
    const bool pushed_freely = form != Form::implicit || state_.carried.latest_contact.nodes == 0;
    if (tables_.scheme.velocity_lag > 0.0 && pushed_freely) {
      Real force[packs], moving[packs];
      outer_(now_.step, force, moving);
      if constexpr (form != Form::implicit) {
        const Place place(tables_.motion, now_.step);
        const int count = candidates_.find_contacts(now_.u, now_.v, place);
        if (!candidates_.has_room(count) ||
            !contact_.expand(place, state_.work.listed_nodes, count)) [[unlikely]]
          return lack_room();
        contact_(place, now_.u, state_.work.listed_nodes, count, force);
      }
      integrate_.lag(now_.u, now_.v, force);
    }
    lanes_.sync();
    if (lanes_.leader()) state_.carried.modal.begun = true;
    lanes_.sync();
  }

  /// Ends the launch, until there is memory for more nodes.
  RA2D_FUNCTION void lack_room() {
    lanes_.sync();
    if (lanes_.leader()) state_.carried.status = Status::crowded;
    lanes_.sync();
  }

  /// Writes what is due at this step, and begins a stretch of the record to where the next is.
  /// False where the launch ends.
  RA2D_FUNCTION bool begin_stretch(std::int64_t stop) {
    if (state_.carried.status != Status::running) return false;
    int listed = -1;
    if (keeps() && recorder_.samples_at(now_.step)) {
      // the contact that a sample finds serves the step from there, too
      listed = kept_nodes().find(now_.u, now_.v, Place(tables_.motion, now_.step));
      if (listed < 0) [[unlikely]] {
        lack_room();
        return false;
      }
    }
    if (!recorder_.take_sample(now_, candidates_, listed)) return false;
    if (now_.step % longest_flight == 0 || now_.step == tables_.output.total_steps)
      recorder_.check_energy(now_);
    if (state_.carried.status != Status::running || now_.step >= stop || !can_record_shocks() ||
        is_interrupted(tables_.interrupted) || lanes_.time_is_up())
      return false;
    next_ = recorder_.next_event(now_.step, stop);
    recorder_.begin_stretch();
    return true;
  }

  // ---- every node at every step

  RA2D_FUNCTION void march_all(std::int64_t next) {
    const std::int64_t first = now_.step;
    march_with_search(static_cast<int>(next - first));
    if (lanes_.leader()) state_.carried.sums.evaluated += (now_.step - first) * tables_.faces.nodes;
    lanes_.sync();
  }

  /// Steps that search for contact at every state.
  RA2D_FUNCTION void march_with_search(int steps) {
    const auto w = integrate_.weights();
    Motion<Lanes, packs> y = now_;
    SearchedNodes<Lanes, packs> nodes(state_.work.listed_nodes, candidates_, contact_);
    for (int i = 0; i < steps && can_record_shocks(); ++i) {
      Place place(tables_.motion, y.step);
      if (!contact_step_(y, w, place, nodes, recorder_)) break;
    }
    now_ = y;
  }

  // ---- only nodes that can come into contact

  KOKKOS_FORCEINLINE_FUNCTION bool keeps() const {
    return can_keep && state_.work.candidates.kept && tables_.bounds.searched != Nodes::all;
  }
  KOKKOS_FORCEINLINE_FUNCTION KeptNodes<Lanes, packs> kept_nodes() {
    return {state_.work.listed_nodes, candidates_, contact_};
  }
  RA2D_FUNCTION void march_on_kept_lists(std::int64_t next) {
    const auto w = integrate_.weights();
    Motion<Lanes, packs> y = now_;
    KeptNodes<Lanes, packs> nodes = kept_nodes();
    while (y.step < next && can_record_shocks()) {
      Place place(tables_.motion, y.step);
      if (!contact_step_(y, w, place, nodes, recorder_)) break;
    }
    now_ = y;
    if (lanes_.leader()) state_.carried.sums.evaluated += nodes.evaluated();
    lanes_.sync();
  }

  /// Marches to where nodes are listed for the steps to come. False where the launch ends before.
  /// `searches`: for the next step a list is of no use.
  RA2D_FUNCTION bool march_to_list(std::int64_t stop, bool& searches, List& nodes) {
    count_evaluated(nodes);
    nodes = List();
    bool stretch_ends = now_.step >= next_ || !can_record_shocks();
    while (true) {
      if (stretch_ends) {
        recorder_.end_stretch();
        if (!begin_stretch(stop)) return false;
      }
      const std::int64_t before = now_.step;
      stretch_ends = true;
      if (tables_.bounds.searched == Nodes::all) {
        march_all(next_);
      } else if (keeps()) {
        march_on_kept_lists(next_);
      } else {
        if (march_by_forecast(searches, nodes)) return true;
        // without a step it failed, or was interrupted
        stretch_ends = now_.step >= next_ || now_.step == before || !can_record_shocks() ||
                       state_.carried.status != Status::running;
      }
    }
  }
  /// A flight, a list for the steps to come, or a step that searches. Returns whether it is a list.
  RA2D_FUNCTION bool march_by_forecast(bool& searches, List& nodes) {
    if (!searches) {
      const ContactForecast plan =
          candidates_.forecast_contact(now_.u, now_.v, now_.step, next_, recorder_.usual_force());
      if (plan.kind == ContactForecast::flight) {
        fly(plan.steps);
        return false;
      }
      if (plan.kind == ContactForecast::listed) {
        const Place place(tables_.motion, now_.step);
        if (!candidates_.has_room(plan.count) ||
            !contact_.expand(place, state_.work.listed_nodes, plan.count)) [[unlikely]] {
          lack_room();
          return false;
        }
        nodes = List(plan);
        return true;
      }
    }
    searches = false;
    march_with_search(1);
    return false;
  }
  /// Counts what was evaluated of a list.
  RA2D_FUNCTION void count_evaluated(const List& nodes) {
    const int states = form == Form::implicit ? 1 : tables_.scheme.stages;  // of a step
    if (lanes_.leader())
      state_.carried.sums.evaluated +=
          static_cast<std::int64_t>(nodes.made()) * nodes.count() * states;
    lanes_.sync();
  }

  /// Steps that provably have no contact.
  RA2D_FUNCTION void fly(int steps) {
    recorder_.take_flight(now_.step);
    if (tables_.forces.count == 0)
      fly_under_load(steps);
    else
      fly_under_moving_forces(steps);
    now_.step += steps;
    lanes_.sync();
  }
  KOKKOS_FORCEINLINE_FUNCTION void fly_under_load(int steps) {
    const auto w = integrate_.weights();
    // arrays of their own, so that they stay in registers
    Real u[packs], v[packs], square[packs], force[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      u[p] = now_.u[p];
      v[p] = now_.v[p];
      square[p] = now_.square[p];
      force[p] = outer_.load(p);
    }
    for (int i = 0; i < steps; ++i) {
      if constexpr (form == Form::semi_implicit) {
        integrate_.advance(u, v, square, force, w);
      } else {
        integrate_.advance(u, v, w, 0u, nullptr);
        for (int p = 0; p < filled<packs>(lanes_); ++p)
          square[p] = multiply_add(v[p], v[p], square[p]);
      }
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      now_.u[p] = u[p];
      now_.v[p] = v[p];
      now_.square[p] = square[p];
    }
  }
  RA2D_FUNCTION void fly_under_moving_forces(int steps) {
    const auto w = integrate_.weights();
    for (int i = 0; i < steps; ++i) {
      if constexpr (form == Form::semi_implicit) {
        Real force[packs], moving[packs];
        outer_(now_.step + i, force, moving);
        integrate_.advance(now_.u, now_.v, now_.square, force, w);
        recorder_.take_force_work(outer_.work(moving, now_.v));
      } else {
        Real force[most_stages][packs];
        const unsigned acting = integrate_.stage_forces(now_.step + i, force);
        const bool before =
            tables_.scheme.loss_ends > 0.0;  // work is taken with the velocity before the step
        if (before) recorder_.take_force_work(outer_.work(force[0], now_.v));
        integrate_.advance(now_.u, now_.v, w, acting, force);
        if (!before) recorder_.take_force_work(outer_.work(force[0], now_.v));
        now_.add_squares(lanes_);
      }
    }
  }
};

}  // namespace ra2d
