// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/contact/complementarity.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/fixed/fixed_recorder.hpp"
#include "kernels/fixed/modes_step.hpp"
#include "kernels/fixed/outer_forces.hpp"
#include "kernels/gap.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Where a stretch of steps finds the nodes that could touch: on a list that holds for all of it
/// ...
class ListedNodes {
 public:
  KOKKOS_FORCEINLINE_FUNCTION explicit ListedNodes(const Outlook& plan)
      : count_{plan.count}, line_{plan.line}, kick_{plan.kick} {}

  template <class Real>
  KOKKOS_FORCEINLINE_FUNCTION int find(const Real*, const Real*, const Place&) const {
    return count_;
  }
  KOKKOS_FORCEINLINE_FUNCTION void move(const SceneTables& t, Place& place, std::int64_t step,
                                        double behind) const {
    place.move_to(t, step, behind);
  }
  static constexpr bool may_end = true;
  /// Form::implicit, once a step: whether all that was looked at on the way, under forces of up to
  /// `most` [N], stayed where the list holds (Outlook); it ended with `force`.
  KOKKOS_FORCEINLINE_FUNCTION bool covers(double most, double force) {
    pushed_ += most;
    pushes_ += pushed_;
    const double n = ++steps_;
    const bool covered = line_ * n * (n + 1.0) + kick_ * pushes_ <= 1.0;
    pushes_ += (force - most);
    pushed_ += (force - most);
    return covered;
  }

 private:
  int count_, steps_ = 0;
  double line_, kick_;
  double pushed_ = 0.0, pushes_ = 0.0;  // sums of the forces, and of these sums
};

/// ... or by looking, at every state.
template <class Lanes, int K>
class LookedNodes {
  using Real = typename Lanes::Real;

 public:
  KOKKOS_FORCEINLINE_FUNCTION LookedNodes(const SceneState& state, Candidates<Lanes, K>& candidates,
                                          const NodeContact<Lanes, K>& contact)
      : s_{state}, candidates_{candidates}, contact_{contact} {}

  KOKKOS_FUNCTION int find(const Real* u, const Real* v, const Place& place) const {
    const int count = candidates_.find_touching(u, v, place);
    contact_.expand(place, s_.watch, count);
    return count;
  }
  KOKKOS_FUNCTION void move(const SceneTables& t, Place& place, std::int64_t step,
                            double behind) const {
    place = Place(t, step, behind);
  }
  static constexpr bool may_end = false;
  KOKKOS_FORCEINLINE_FUNCTION bool covers(double, double) const { return true; }

 private:
  const SceneState& s_;
  Candidates<Lanes, K>& candidates_;
  const NodeContact<Lanes, K>& contact_;
};

/// One fixed step with contact, in each of its forms: detection, force, integration.
template <class Lanes, Form form, int K>
class ContactStep {
  using Real = typename Lanes::Real;
  using Weights = typename ModesStep<Lanes, form, K>::Weights;

 public:
  KOKKOS_FUNCTION ContactStep(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                              const OuterForces<Lanes, K>& outer,
                              const ModesStep<Lanes, form, K>& modes,
                              const NodeContact<Lanes, K>& contact,
                              FixedRecorder<Lanes, form, K>& recorder)
      : lanes_{lanes},
        t_{tables},
        s_{state},
        outer_{outer},
        modes_{modes},
        contact_{contact},
        solve_{lanes, tables, state, contact_},
        recorder_{recorder} {}

  /// From y on, which stands at `place`. False, with nothing done, when a list would not cover the
  /// step, or (Form::implicit) when its forces cannot be found or the launch is to end.
  template <class NodesToLookAt>
  KOKKOS_FORCEINLINE_FUNCTION bool operator()(Motion<Lanes, K>& y, const Weights& w, Place& place,
                                              NodesToLookAt& nodes) {
    if constexpr (form == Form::semi_implicit) {
      semi_implicit(y, w, place, nodes);
    } else if constexpr (form == Form::staged) {
      if (t_.stages == 1)
        staged<1>(y, w, place, nodes);
      else
        staged<most_stages>(y, w, place, nodes);
    } else {
      if (!implicit(y, w, place, nodes)) return false;
    }
    ++y.step;
    return true;
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  OuterForces<Lanes, K> outer_;  // copies of what does not change: that saves a way to it
  ModesStep<Lanes, form, K> modes_;
  NodeContact<Lanes, K> contact_;
  Complementarity<Lanes, K> solve_;
  FixedRecorder<Lanes, form, K>& recorder_;

  /// U1 = U0 + tau V1 with the contact force of the old time.
  template <class NodesToLookAt>
  KOKKOS_FORCEINLINE_FUNCTION void semi_implicit(Motion<Lanes, K>& y, const Weights& w,
                                                 const Place& place, NodesToLookAt& nodes) {
    Real force[K], moving[K];
    outer_(y.step, force, moving);
    const int count = nodes.find(y.u, y.v, place);
    const ContactTotals<Real> totals = contact_(place, y.u, s_.watch, count, force);
    recorder_.take_contact(totals, place, y.step);
    y.bend = y.bend + totals.bend;
    lanes_.sync();
    modes_.advance(y.u, y.v, y.square, force, w);
    if (t_.moving_forces > 0) recorder_.take_force_work(outer_.work(moving, y.v));
  }

  /// With the contact force at each stage, `most` of them.
  template <int most, class NodesToLookAt>
  KOKKOS_FORCEINLINE_FUNCTION void staged(Motion<Lanes, K>& y, const Weights& w, Place& place,
                                          NodesToLookAt& nodes) {
    Real force[most][K];
    unsigned acting = 0;
    const int stages = most == 1 ? 1 : t_.stages;
    for (int i = 0; i < stages; ++i) {
      Real at[K];
      if (i == 0) {
        for (int p = 0; p < K; ++p) at[p] = y.u[p];
      } else {
        modes_.stage_displacement(i, y.u, y.v, acting, force, at);
        nodes.move(t_, place, y.step, t_.place[i]);
      }
      if (t_.moving_forces > 0) {
        outer_.moving(y.step, t_.place[i], force[i]);
        if (i == 0) recorder_.take_force_work(outer_.work(force[0], y.v));
        acting |= 1u << i;
      } else {
        for (int p = 0; p < K; ++p) force[i][p] = Real(0.0);
      }
      const int count = nodes.find(at, y.v, place);
      const ContactTotals<Real> totals = contact_(place, at, s_.watch, count, force[i]);
      if (totals.touched > 0) acting |= 1u << i;
      if (i == 0) {  // the record is that of the state at the step
        recorder_.take_contact(totals, place, y.step);
        y.bend = y.bend + totals.bend;
      }
      lanes_.sync();
    }
    modes_.advance(y.u, y.v, w, acting, force);
    y.add_squares();
  }

  /// With contact forces that hold over the step and are found with its end.
  template <class NodesToLookAt>
  KOKKOS_FUNCTION bool implicit(Motion<Lanes, K>& y, const Weights& w, Place& place,
                                NodesToLookAt& nodes) {
    Real u[K], v[K], outer[most_stages][K];
    for (int p = 0; p < K; ++p) {
      u[p] = y.u[p];
      v[p] = y.v[p];
    }
    modes_.advance(u, v, w, modes_.stage_forces(y.step, outer), outer);
    nodes.move(t_, place, y.step + 1, 0.0);
    ContactTotals<Real> totals;
    double most = 0.0;
    const auto list = [&](const Real* at) { return nodes.find(at, v, place); };
    const Solution found =
        solve_(place, y.step + 1, u, v, list, totals, most, !NodesToLookAt::may_end);
    if (found != Solution::solved) return NodesToLookAt::may_end ? false : fail(found);
    if (!nodes.covers(most, totals.force)) return false;
    if (t_.moving_forces > 0)
      recorder_.take_force_work(outer_.work(outer[0], t_.loss_ends > 0.0 ? y.v : v));
    recorder_.take_contact(totals, place, y.step + 1);
    keep(totals, y.step + 1);
    y.bend = y.bend + totals.bend;
    lanes_.sync();
    for (int p = 0; p < K; ++p) {
      y.u[p] = u[p];
      y.v[p] = v[p];
    }
    y.add_squares();
    return true;
  }
  KOKKOS_FUNCTION bool fail(Solution found) {
    if (found == Solution::interrupted) return false;  // the launch ends before this step
    if (lanes_.leader()) s_.status = found == Solution::blocked ? Status::blocked : Status::crowded;
    lanes_.sync();
    return false;
  }
  /// The contact at the end of a step, for the next one and for samples.
  KOKKOS_FORCEINLINE_FUNCTION void keep(const ContactTotals<Real>& totals, std::int64_t step) {
    if (!lanes_.leader() || totals.touched == 0) return;
    double energy = 0.0;
    for (int e = 0; e < totals.touched; ++e) energy += s_.touched_force[e] * s_.touched_force[e];
    s_.contact_step = step;
    s_.contact_force = totals.force;
    s_.contact_energy = 0.5 * t_.compliance * energy;
    s_.contact_nodes = totals.touched;
    for (int e = 0; e < 2 && e < totals.touched; ++e) s_.contact_pair[e] = s_.touched[e];
  }
};

}  // namespace ra2d
