// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/contact/cell_complementarity.hpp"
#include "kernels/contact/cell_springs.hpp"
#include "kernels/contact/clustered_contact.hpp"
#include "kernels/contact/complementarity.hpp"
#include "kernels/fixed/fixed_recorder.hpp"
#include "kernels/fixed/modes_step.hpp"
#include "kernels/fixed/outer_forces.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// A list of nodes to evaluate at each of many steps. `counts`: what the forces do to it, under
/// Form::implicit.
template <bool counts>
class ListedNodes {
 public:
  ListedNodes() = default;  // an empty one, which has come to its end
  KOKKOS_FORCEINLINE_FUNCTION explicit ListedNodes(const ContactForecast& plan)
      : count_{plan.count},
        left_{plan.steps},
        free_departure_{plan.free_departure},
        departure_per_newton_{plan.departure_per_newton} {}

  template <class Real>
  KOKKOS_FORCEINLINE_FUNCTION int find(const Real*, const Real*, const Place&) const {
    return count_;
  }
  KOKKOS_FORCEINLINE_FUNCTION void move(const SliderMotion& motion, Place& place, std::int64_t step,
                                        double share) const {
    place.move_to(motion, step, share);
  }
  static constexpr bool may_end = true, may_lack_room = false, serves_samples = true, lasts = true;
  /// Where forces are counted, once a step, which ended with `force` [N] and had no more than
  /// `most` [N] during the search for it, or at its stages: whether the list held at every state
  /// evaluated (ContactForecast).
  KOKKOS_FORCEINLINE_FUNCTION bool covers(double most, double force) {
    if constexpr (!counts) return true;
    force_sum_ += most;
    double_force_sum_ += force_sum_;
    const double n = ++steps_;
    const bool covered =
        free_departure_ * n * (n + 1.0) + departure_per_newton_ * double_force_sum_ <= 1.0;
    double_force_sum_ += (force - most);
    force_sum_ += (force - most);
    return covered;
  }
  KOKKOS_FORCEINLINE_FUNCTION void take_step() {
    --left_;
    ++made_;
  }
  KOKKOS_FORCEINLINE_FUNCTION void end() { left_ = 0; }

  /// Steps for which it may serve yet, and those for which it did.
  KOKKOS_FORCEINLINE_FUNCTION int left() const { return left_; }
  KOKKOS_FORCEINLINE_FUNCTION int made() const { return made_; }
  KOKKOS_FORCEINLINE_FUNCTION int count() const { return count_; }

 private:
  int count_ = 0, left_ = 0, made_ = 0, steps_ = 0;
  double free_departure_ = 0.0, departure_per_newton_ = 0.0;
  double force_sum_ = 0.0, double_force_sum_ = 0.0;  // N: of the forces, and of these sums
};

/// The nodes to evaluate, searched for at every state anew.
template <class Lanes, int packs>
class SearchedNodes {
  using Real = typename Lanes::Real;

 public:
  KOKKOS_FORCEINLINE_FUNCTION SearchedNodes(const int* listed_nodes,
                                            Candidates<Lanes, packs>& candidates,
                                            const ClusteredContact<Lanes, packs>& contact)
      : listed_nodes_{listed_nodes}, candidates_{candidates}, contact_{contact} {}

  /// Negative where there is no room for them all.
  RA2D_FUNCTION int find(const Real* u, const Real* v, const Place& place) const {
    const int count = candidates_.find_contacts(u, v, place);
    if (!candidates_.has_room(count) || !contact_.expand(place, listed_nodes_, count)) [[unlikely]]
      return -1;
    return count;
  }
  RA2D_FUNCTION void move(const SliderMotion& motion, Place& place, std::int64_t step,
                          double share) const {
    place = Place(motion, step, share);
  }
  static constexpr bool may_end = false, may_lack_room = true, serves_samples = false,
                        lasts = false;
  KOKKOS_FORCEINLINE_FUNCTION bool covers(double, double) const { return true; }

 private:
  const int* listed_nodes_;
  Candidates<Lanes, packs>& candidates_;
  ClusteredContact<Lanes, packs> contact_;
};

/// A list of nodes to evaluate at every state for as long as it covers that
/// (Candidates::keep_list), then the next one.
template <class Lanes, int packs>
class KeptNodes {
  using Real = typename Lanes::Real;

 public:
  KOKKOS_FORCEINLINE_FUNCTION KeptNodes(const int* listed_nodes,
                                        Candidates<Lanes, packs>& candidates,
                                        const ClusteredContact<Lanes, packs>& contact)
      : listed_nodes_{listed_nodes}, candidates_{candidates}, contact_{contact} {}

  /// Negative where there is no room for them all.
  RA2D_FUNCTION int find(const Real* u, const Real* v, const Place& place) {
    int count = candidates_.kept_list(u, place);
    const bool serves = count >= 0 && contact_.is_expanded(place);  // or another window begins
    if (count < 0) {
      count = candidates_.keep_list(u, v, place);
      if (!candidates_.has_room(count)) [[unlikely]]
        count = candidates_.find_contacts(u, v, place);  // those of this state alone
    }
    if (!serves && (!candidates_.has_room(count) || !contact_.expand(place, listed_nodes_, count)))
        [[unlikely]] {
      candidates_.drop_list();
      return -1;
    }
    evaluated_ += count;
    return count;
  }
  KOKKOS_FORCEINLINE_FUNCTION void move(const SliderMotion& motion, Place& place, std::int64_t step,
                                        double share) const {
    place = Place(motion, step, share);
  }
  static constexpr bool may_end = false, may_lack_room = true, serves_samples = true, lasts = false;
  KOKKOS_FORCEINLINE_FUNCTION bool covers(double, double) const { return true; }
  /// Gaps, of all states so far.
  KOKKOS_FORCEINLINE_FUNCTION std::int64_t evaluated() const { return evaluated_; }

 private:
  const int* listed_nodes_;
  Candidates<Lanes, packs>& candidates_;
  ClusteredContact<Lanes, packs> contact_;
  std::int64_t evaluated_ = 0;
};

/// One fixed step with contact, in each of its forms: detection, force, integration.
template <class Lanes, Form form, int packs>
class ContactStep {
  using Real = typename Lanes::Real;
  using Weights = typename ModesStep<Lanes, form, packs>::Weights;
  using Recorder = FixedRecorder<Lanes, form, packs>;

 public:
  /// `listed_nodes`: the nodes to evaluate, in WorkSpace.
  RA2D_FUNCTION ContactStep(const Lanes& lanes, const SliderMotion& motion,
                            const ContactTables& contact, const SchemeWeights& scheme,
                            const OuterForces<Lanes, packs>& outer,
                            const ModesStep<Lanes, form, packs>& integrate,
                            const ClusteredContact<Lanes, packs>& node_contact,
                            const Complementarity<Lanes, packs>& solve,
                            const CellSprings<Lanes, packs>& springs,
                            const CellComplementarity<Lanes, packs>& clear, Status& status,
                            LatestContact& latest, const ContactList& contact_list,
                            const int* listed_nodes)
      : lanes_{lanes},
        motion_{motion},
        contact_{contact},
        scheme_{scheme},
        outer_{outer},
        integrate_{integrate},
        node_contact_{node_contact},
        solve_{solve},
        springs_{springs},
        clear_{clear},
        status_{status},
        latest_contact_{latest},
        contact_list_{contact_list},
        listed_nodes_{listed_nodes} {}

  /// A step from y, which stands at `place`. False, with nothing done, when a list would not cover
  /// the step, or (Form::implicit) when its forces cannot be found or the launch is to end.
  template <class NodesToEvaluate>
  KOKKOS_FORCEINLINE_FUNCTION bool operator()(Motion<Lanes, packs>& y, const Weights& w,
                                              Place& place, NodesToEvaluate& nodes,
                                              Recorder& recorder) {
    bool made;
    if constexpr (form == Form::semi_implicit) {
      made = semi_implicit(y, w, place, nodes, recorder);
    } else if constexpr (form == Form::staged) {
      made = scheme_.stages == 1 ? staged<1>(y, w, place, nodes, recorder)
                                 : staged<most_stages>(y, w, place, nodes, recorder);
    } else {
      made = implicit(y, w, place, nodes, recorder);
    }
    if (made) ++y.step;
    return made;
  }

 private:
  Lanes lanes_;
  const SliderMotion& motion_;
  const ContactTables& contact_;
  const SchemeWeights& scheme_;
  // copies: they hold nothing but addresses
  OuterForces<Lanes, packs> outer_;
  ModesStep<Lanes, form, packs> integrate_;
  ClusteredContact<Lanes, packs> node_contact_;
  Complementarity<Lanes, packs> solve_;
  CellSprings<Lanes, packs> springs_;
  CellComplementarity<Lanes, packs> clear_;
  Status& status_;
  LatestContact& latest_contact_;
  const ContactList& contact_list_;
  const int* listed_nodes_;

  /// U1 = U0 + tau V1 with the contact force of the old time.
  template <class NodesToEvaluate>
  KOKKOS_FORCEINLINE_FUNCTION bool semi_implicit(Motion<Lanes, packs>& y, const Weights& w,
                                                 const Place& place, NodesToEvaluate& nodes,
                                                 Recorder& recorder) {
    Real force[packs], moving[packs];
    outer_(y.step, force, moving);
    const int count = nodes.find(y.u, y.v, place);
    if (NodesToEvaluate::may_lack_room && count < 0) [[unlikely]]
      return fail(Solution::crowded);
    ContactTotals<Real> totals;
    if (!lasts(place, y, nodes, count, force, totals, recorder)) {
      const bool sampled = NodesToEvaluate::serves_samples && recorder.has_contact(y.step);
      totals = sampled ? recorder.contact(force)
                       : node_contact_(place, y.u, listed_nodes_, count, force);
      recorder.take_contact(totals, place, y.step);
      if (NodesToEvaluate::lasts && !sampled) recorder.hold_contact(totals, count);
      lanes_.sync();
    }
    y.deflection_work = y.deflection_work + totals.deflection_work;
    integrate_.advance(y.u, y.v, y.square, force, w);
    if (outer_.any_move()) recorder.take_force_work(outer_.work(moving, y.v));
    return true;
  }

  /// The usual case of a step's contact: whether the same nodes of a list touch as a step ago. Then
  /// it is in the record, and nothing is read or written for that.
  template <class NodesToEvaluate>
  KOKKOS_FORCEINLINE_FUNCTION bool lasts(const Place& place, const Motion<Lanes, packs>& y,
                                         const NodesToEvaluate&, int count, Real* force,
                                         ContactTotals<Real>& totals, Recorder& recorder) const {
    if constexpr (NodesToEvaluate::lasts) {
      if (!recorder.contact_may_last(y.step)) return false;
      Real pressed[packs];
      for (int p = 0; p < filled<packs>(lanes_); ++p) pressed[p] = force[p];
      totals =
          node_contact_.unlisted(place, y.u, listed_nodes_, count, pressed, recorder.second_run());
      if (!recorder.take_lasting_contact(totals, place)) return false;
      for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = pressed[p];
      return true;
    }
    return false;
  }

  /// With the contact force at each stage, `most` of them.
  template <int most, class NodesToEvaluate>
  KOKKOS_FORCEINLINE_FUNCTION bool staged(Motion<Lanes, packs>& y, const Weights& w, Place& place,
                                          NodesToEvaluate& nodes, Recorder& recorder) {
    Real force[most][packs];
    unsigned acting = 0;
    ContactTotals<Real> first;
    double work = 0.0, most_force = 0.0, most_face_work = 0.0;
    const Place start = place;
    const int stages = most == 1 ? 1 : scheme_.stages;
    for (int i = 0; i < stages; ++i) {
      Real at[packs];
      if (i == 0) {
        for (int p = 0; p < filled<packs>(lanes_); ++p) at[p] = y.u[p];
      } else {
        integrate_.stage_displacement(i, y.u, y.v, acting, force, at);
        nodes.move(motion_, place, y.step, scheme_.place[i]);
      }
      if (outer_.any_move()) {
        outer_.moving(y.step, scheme_.place[i], force[i]);
        if (i == 0) work = outer_.work(force[0], y.v);
        acting |= 1u << i;
      } else {
        for (int p = 0; p < filled<packs>(lanes_); ++p) force[i][p] = Real(0.0);
      }
      const int count = nodes.find(at, y.v, place);
      if (NodesToEvaluate::may_lack_room && count < 0) [[unlikely]]
        return fail(Solution::crowded);
      const ContactTotals<Real> totals =
          node_contact_(place, at, listed_nodes_, count, force[i], i == 0);
      if (totals.nodes > 0) acting |= 1u << i;
      if (totals.force > most_force) most_force = totals.force;
      most_face_work = Kokkos::max(most_face_work, Kokkos::abs(totals.face_work));
      if (i == 0) first = totals;
      lanes_.sync();
    }
    if (!nodes.covers(most_force, most_force)) return false;
    // the record is that of the state at the step; nothing stops the step any more
    recorder.take_contact(first, start, y.step);
    if constexpr (most > 1)
      recorder.take_later_stages(most_face_work - Kokkos::abs(first.face_work));
    if (outer_.any_move()) recorder.take_force_work(work);
    y.deflection_work = y.deflection_work + first.deflection_work;
    lanes_.sync();
    integrate_.advance(y.u, y.v, w, acting, force);
    y.add_squares(lanes_);
    return true;
  }

  /// With contact forces that hold over the step and are found with its end.
  template <class NodesToEvaluate>
  RA2D_FUNCTION bool implicit(Motion<Lanes, packs>& y, const Weights& w, Place& place,
                              NodesToEvaluate& nodes, Recorder& recorder) {
    Real u[packs], v[packs], outer[most_stages][packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      u[p] = y.u[p];
      v[p] = y.v[p];
    }
    integrate_.advance(u, v, w, integrate_.stage_forces(y.step, outer), outer);
    nodes.move(motion_, place, y.step + 1, 0.0);
    ContactTotals<Real> totals;
    double most = 0.0;
    const auto list = [&](const Real* at) { return nodes.find(at, v, place); };
    Solution found;
    if (!between_smooth_faces()) [[likely]]
      found = solve_(place, y.step + 1, u, v, list, totals, most, !NodesToEvaluate::may_end);
    else
      found = press_cells(place, y, u, v, list, totals, most);
    if (found != Solution::solved) return NodesToEvaluate::may_end ? false : fail(found);
    if (!nodes.covers(most, totals.force)) return false;
    if (outer_.any_move())
      recorder.take_force_work(outer_.work(outer[0], scheme_.loss_ends > 0.0 ? y.v : v));
    recorder.take_contact(totals, place, y.step + 1);
    keep(totals, y.step + 1);
    y.deflection_work = y.deflection_work + totals.deflection_work;
    lanes_.sync();
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      y.u[p] = u[p];
      y.v[p] = v[p];
    }
    y.add_squares(lanes_);
    return true;
  }
  KOKKOS_FORCEINLINE_FUNCTION bool between_smooth_faces() const {
    return contact_list_.centres != nullptr;
  }
  /// The contact forces of the step from y between smooth faces.
  template <class List>
  RA2D_FUNCTION Solution press_cells(const Place& place, const Motion<Lanes, packs>& y, Real* u,
                                     Real* v, const List& list, ContactTotals<Real>& totals,
                                     double& most) {
    if (contact_.compliance == 0.0) return clear_(place, u, v, list, totals, most);
    // in lasting contact the motion goes on as it was, but for the square of the step
    Real guess[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      guess[p] = multiply_add(motion_.time_step, y.v[p], y.u[p]);
    return springs_(place, latest_contact_.step == y.step ? guess : nullptr, u, v, list, totals,
                    most);
  }
  RA2D_FUNCTION bool fail(Solution found) {
    if (found == Solution::interrupted) return false;  // the launch ends before this step
    if (lanes_.leader()) status_ = found == Solution::blocked ? Status::blocked : Status::crowded;
    lanes_.sync();
    return false;
  }
  /// The contact at the end of a step, for the next one and for samples.
  KOKKOS_FORCEINLINE_FUNCTION void keep(const ContactTotals<Real>& totals, std::int64_t step) {
    if (!lanes_.leader() || totals.nodes == 0) return;
    double squares = 0.0;
    for (int e = 0; e < totals.nodes; ++e)
      squares += contact_list_.forces[e] * contact_list_.forces[e];
    latest_contact_.step = step;
    latest_contact_.force = totals.force;
    latest_contact_.energy =
        between_smooth_faces() ? totals.energy : 0.5 * contact_.compliance * squares;
    latest_contact_.nodes = totals.nodes;
    for (int e = 0; e < 2 && e < totals.nodes; ++e)
      latest_contact_.pair[e] = contact_list_.nodes[e];
  }
};

}  // namespace ra2d
