// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/fixed/contact_step.hpp"
#include "kernels/fixed/fixed_recorder.hpp"
#include "kernels/fixed/modes_step.hpp"
#include "kernels/fixed/outer_forces.hpp"
#include "kernels/gap.hpp"
#include "kernels/lanes.hpp"
#include "kernels/limits.hpp"
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
/// What differs between `Nodes::all` and `Nodes::candidates` is only which nodes are looked at
/// (kernels/candidates.hpp). The arithmetic of a step does not depend on that, nor on where a
/// launch ends: the results of all nodes and candidates, of one launch or many, are equal bit for
/// bit.
template <class Lanes, Form form, int K>
class FixedMarch {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION FixedMarch(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes},
        t_{tables},
        s_{state},
        outer_{lanes, tables},
        modes_{lanes, tables, outer_},
        contact_{lanes, tables, state},
        candidates_{lanes, tables, state},
        recorder_{lanes, tables, state, outer_, modes_, contact_, candidates_},
        contact_step_{lanes, tables, state, outer_, modes_, contact_, recorder_} {
    for (int p = 0; p < K; ++p) {
      now_.u[p] = lanes_.load(s_.u + p * width);
      now_.v[p] = lanes_.load(s_.v + p * width);
      now_.square[p] = lanes_.load(s_.square_part + p * width);
    }
    now_.bend = lanes_.load(s_.bend_part);
    now_.step = s_.step;
    begin();
  }

  /// Marches until step `target`, the end of the scene, a full buffer, an interrupt or a failure,
  /// whichever is first.
  KOKKOS_FUNCTION void run(std::int64_t target) {
    const std::int64_t stop = target < t_.total_steps ? target : t_.total_steps;
    while (s_.status == Status::running) {
      if (!recorder_.take_sample(now_)) break;
      if (now_.step % longest_flight == 0 || now_.step == t_.total_steps)
        recorder_.watch_energy(now_);
      if (s_.status != Status::running || now_.step >= stop || !has_room_for_shocks(s_) ||
          is_interrupted(t_))
        break;
      const std::int64_t next = recorder_.next_event(now_.step, stop);
      if (t_.look_at == Nodes::all)
        march_all(next);
      else
        march_candidates(next);
    }
    const bool done =
        s_.status == Status::running && now_.step == t_.total_steps && recorder_.is_complete();
    lanes_.sync();
    if (done && lanes_.leader()) s_.status = Status::done;
    save();
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  OuterForces<Lanes, K> outer_;
  ModesStep<Lanes, form, K> modes_;
  NodeContact<Lanes, K> contact_;
  Candidates<Lanes, K> candidates_;
  FixedRecorder<Lanes, form, K> recorder_;
  ContactStep<Lanes, form, K> contact_step_;
  Motion<Lanes, K> now_;

  KOKKOS_FUNCTION void save() {
    lanes_.sync();
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.u + p * width, now_.u[p]);
      lanes_.store(s_.v + p * width, now_.v[p]);
      lanes_.store(s_.square_part + p * width, now_.square[p]);
    }
    lanes_.store(s_.bend_part, now_.bend);
    if (lanes_.leader()) s_.step = now_.step;
  }

  /// Once a scene: takes the velocity of t = 0 to where the scheme has it.
  KOKKOS_FUNCTION void begin() {
    if (s_.begun) return;
    // what rests under contact forces that are yet to be found is not pushed
    const bool pushed_freely = form != Form::implicit || s_.contact_nodes == 0;
    if (t_.velocity_lag > 0.0 && pushed_freely) {
      Real force[K], moving[K];
      outer_(now_.step, force, moving);
      if constexpr (form != Form::implicit) {
        const Place place(t_, now_.step);
        const int count = candidates_.find_touching(now_.u, now_.v, place);
        contact_.expand(place, s_.watch, count);
        contact_(place, now_.u, s_.watch, count, force);
      }
      modes_.lag(now_.u, now_.v, force);
    }
    lanes_.sync();
    if (lanes_.leader()) s_.begun = true;
    lanes_.sync();
  }

  // ---- every node at every step

  KOKKOS_FUNCTION void march_all(std::int64_t next) {
    const std::int64_t first = now_.step;
    look(static_cast<int>(next - first));
    if (lanes_.leader()) s_.evaluated += (now_.step - first) * t_.nodes;
    lanes_.sync();
  }

  /// Steps that look at every state anew.
  KOKKOS_FUNCTION void look(int steps) {
    const auto w = modes_.weights();
    Motion<Lanes, K> y = now_;
    LookedNodes<Lanes, K> nodes(s_, candidates_, contact_);
    for (int i = 0; i < steps && has_room_for_shocks(s_); ++i) {
      Place place(t_, y.step);
      if (!contact_step_(y, w, place, nodes)) break;
    }
    now_ = y;
  }

  // ---- only what can touch

  KOKKOS_FUNCTION void march_candidates(std::int64_t next) {
    while (now_.step < next && has_room_for_shocks(s_) && s_.status == Status::running) {
      const Outlook plan =
          candidates_.look_ahead(now_.u, now_.v, now_.step, next, recorder_.usual_force());
      if (plan.kind == Outlook::fly)
        fly(plan.steps);
      else if (plan.kind == Outlook::look || !watch(plan)) {
        const std::int64_t before = now_.step;
        look(1);
        if (now_.step == before) break;  // it failed, or was interrupted
      }
    }
  }

  /// Steps that provably have no contact.
  KOKKOS_FUNCTION void fly(int steps) {
    recorder_.take_flight(now_.step);
    if (t_.moving_forces == 0)
      fly_under_load(steps);
    else
      fly_under_moving_forces(steps);
    now_.step += steps;
    lanes_.sync();
  }
  KOKKOS_FORCEINLINE_FUNCTION void fly_under_load(int steps) {
    const auto w = modes_.weights();
    // arrays of their own, so that they stay in registers
    Real u[K], v[K], square[K], force[K];
    for (int p = 0; p < K; ++p) {
      u[p] = now_.u[p];
      v[p] = now_.v[p];
      square[p] = now_.square[p];
      force[p] = outer_.load()[p];
    }
    for (int i = 0; i < steps; ++i) {
      if constexpr (form == Form::semi_implicit) {
        modes_.advance(u, v, square, force, w);
      } else {
        modes_.advance(u, v, w, 0u, nullptr);
        for (int p = 0; p < K; ++p) square[p] = multiply_add(v[p], v[p], square[p]);
      }
    }
    for (int p = 0; p < K; ++p) {
      now_.u[p] = u[p];
      now_.v[p] = v[p];
      now_.square[p] = square[p];
    }
  }
  KOKKOS_FUNCTION void fly_under_moving_forces(int steps) {
    const auto w = modes_.weights();
    for (int i = 0; i < steps; ++i) {
      if constexpr (form == Form::semi_implicit) {
        Real force[K], moving[K];
        outer_(now_.step + i, force, moving);
        modes_.advance(now_.u, now_.v, now_.square, force, w);
        recorder_.take_force_work(outer_.work(moving, now_.v));
      } else {
        Real force[most_stages][K];
        const unsigned acting = modes_.stage_forces(now_.step + i, force);
        const bool before = t_.loss_ends > 0.0;  // work is taken with the velocity before the step
        if (before) recorder_.take_force_work(outer_.work(force[0], now_.v));
        modes_.advance(now_.u, now_.v, w, acting, force);
        if (!before) recorder_.take_force_work(outer_.work(force[0], now_.v));
        now_.add_squares();
      }
    }
  }

  /// Steps with the watched nodes evaluated. False when not even one was covered by the list.
  KOKKOS_FUNCTION bool watch(const Outlook& plan) {
    const auto w = modes_.weights();
    Motion<Lanes, K> y = now_;
    Place place(t_, y.step);
    contact_.expand(place, s_.watch, plan.count);
    ListedNodes nodes(plan);
    int done = 0;
    while (done < plan.steps && has_room_for_shocks(s_)) {
      place.move_to(t_, y.step);
      if (!contact_step_(y, w, place, nodes)) break;
      ++done;
    }
    now_ = y;
    const int states = form == Form::implicit ? 1 : t_.stages;  // looked at in a step
    if (lanes_.leader()) s_.evaluated += static_cast<std::int64_t>(done) * plan.count * states;
    lanes_.sync();
    return done > 0;
  }
};

}  // namespace ra2d
