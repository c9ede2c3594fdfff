// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/check.hpp"
#include "kernels/contact/clustered_contact.hpp"
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

/// The record of fixed steps: samples, sums, shocks, and the check of the energy.
///
/// It is that of the state at each step, whatever the scheme does within it: shocks and the work of
/// the imposed motion are summed from the contact forces there (under Form::implicit from the force
/// over the step that ends there), level and damping loss from the velocities.
///
/// From a contact force to the energies of the file: NodeContact finds its works (ContactTotals),
/// take_contact adds them to RunningSums, contact_at finds the springs' energy, write_sample puts
/// all into the columns of a sample. make_samples (host/run/samples.cpp) makes a SampleBlock of
/// these, and adds kinetic and elastic energy; host/store/entries.cpp names the datasets.
template <class Lanes, Form form, int packs>
class FixedRecorder {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  /// Whether the contact that a sample has found serves the step from there, too: where contact
  /// costs far more than to keep it.
  static constexpr bool keeps_contact = form == Form::semi_implicit && keeps_lists<Lanes, packs>;

  /// `listed_nodes`: the nodes that Candidates list.
  RA2D_FUNCTION FixedRecorder(const Lanes& lanes, const ModeTables& modes,
                              const SliderMotion& motion, const ContactTables& contact,
                              const SchemeWeights& scheme, const RecordTables& output,
                              const OuterForces<Lanes, packs>& outer,
                              const ModesStep<Lanes, form, packs>& integrate,
                              const ClusteredContact<Lanes, packs>& node_contact,
                              CarriedState& carried, const int* listed_nodes,
                              const ContactList& contact_list, RunBuffer& runs, RecordBuffers& out)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        contact_{contact},
        scheme_{scheme},
        output_{output},
        outer_{outer},
        integrate_{integrate},
        node_contact_{node_contact},
        status_{carried.status},
        modal_{carried.modal},
        sums_{carried.sums},
        energy_{carried.energy},
        sampling_{carried.sampling},
        shocks_{carried.shocks},
        latest_contact_{carried.latest_contact},
        listed_nodes_{listed_nodes},
        contact_list_{contact_list},
        runs_{runs},
        samples_{out.samples},
        ended_{out.ended_shocks} {}

  /// The next step at which something is to be written, no later than `stop`.
  RA2D_FUNCTION std::int64_t next_event(std::int64_t step, std::int64_t stop) const {
    std::int64_t next = (step / longest_flight + 1) * longest_flight;
    if (stop < next) next = stop;
    if (sampling_.pending) return step + 1;
    if (sampling_.next < output_.samples) {
      std::int64_t at;
      double share;
      sample_place(sampling_.next, at, share);
      if (at < next) next = at;
    }
    return next > step ? next : step + 1;
  }

  /// Whether there is a sample to write at this step, and room for it.
  RA2D_FUNCTION bool samples_at(std::int64_t step) const {
    if (sampling_.pending) return true;
    if (sampling_.next >= output_.samples || samples_.count == samples_.capacity) return false;
    std::int64_t at;
    double share;
    sample_place(sampling_.next, at, share);
    return at == step;
  }

  /// Whether the latest sample has found the contact at this step.
  KOKKOS_FORCEINLINE_FUNCTION bool has_contact(std::int64_t step) const {
    return keeps_contact && step == sampled_step_;
  }
  /// That contact, and the modal forces there. Its nodes are in ContactList.
  KOKKOS_FORCEINLINE_FUNCTION ContactTotals<Real> contact(Real* force) const {
    if constexpr (keeps_contact)
      for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = sampled_force_[p];
    return sampled_contact_;
  }

  /// Writes what is due at this step. `listed`: nodes of the list that holds there; negative: there
  /// is none. False when the buffer is full, or there is no room for the nodes in contact.
  RA2D_FUNCTION bool take_sample(Motion<Lanes, packs>& now, Candidates<Lanes, packs>& candidates,
                                 int listed) {
    std::int64_t at;
    double share;
    if (sampling_.pending) {
      sample_place(sampling_.next, at, share);
      if (at + 1 != now.step) return true;
      if (!write_sample(now, candidates, listed, share, Part::second)) return false;
      lanes_.sync();
      if (lanes_.leader()) {
        sampling_.pending = false;
        ++samples_.count;
        ++sampling_.next;
      }
      lanes_.sync();
    }
    if (sampling_.next >= output_.samples) return true;
    sample_place(sampling_.next, at, share);
    if (at != now.step) return true;
    if (samples_.count == samples_.capacity) return false;
    if (!write_sample(now, candidates, listed, 1.0 - share,
                      share > 0.0 ? Part::first : Part::whole))
      return false;
    check_energy(now);
    lanes_.sync();
    if (lanes_.leader()) {
      if (share > 0.0) {
        sampling_.pending = true;
      } else {
        ++samples_.count;
        ++sampling_.next;
      }
    }
    lanes_.sync();
    return true;
  }

  /// Whether all that there is to write has been written.
  RA2D_FUNCTION bool is_complete() const {
    return !sampling_.pending && sampling_.next >= output_.samples;
  }

  /// Kinetic + elastic energy against what was put in. Ends the scene when it is not finite or has
  /// grown without work to pay for it.
  RA2D_FUNCTION void check_energy(const Motion<Lanes, packs>& now) {
    Real part(0.0), load_work(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real stretch = load_pack(lanes_, modes_.omega, p) * now.u[p];
      part = multiply_add(load_pack(lanes_, modes_.mass, p),
                          multiply_add(now.v[p], now.v[p], stretch * stretch), part);
      load_work =
          multiply_add(outer_.load(p), now.u[p] - load_pack(lanes_, modal_.start_u, p), load_work);
    }
    const double energy = 0.5 * lanes_.sum(part);
    const auto supplied = [](double work) { return work > 0.0 ? work : 0.0; };
    const double total = supplied(lanes_.sum(load_work)) +
                         supplied(sums_.force_work + sums_.force_part) +
                         supplied(sums_.sliding_work + sliding_part(now));
    if (lanes_.leader()) {
      // the work of a load rises and falls: compare with the most that was supplied so far
      if (total > energy_.most_supplied) energy_.most_supplied = total;
      energy_.latest = energy;
      energy_.limit = energy_factor * (energy_.start + energy_.most_supplied +
                                       motion_.advance * sums_.gross_face_work);
      if (!(energy <= 1e300))
        status_ = Status::not_finite;
      else if (energy > energy_.limit && energy > output_.least_energy)
        status_ = Status::unstable;
    }
    lanes_.sync();
  }

  /// Between begin_stretch and end_stretch the sums that change at each step are in registers;
  /// end_stretch writes them back.
  RA2D_FUNCTION void begin_stretch() {
    stretch_ = {sums_.face_work_part, sums_.gross_face_work, sums_.contact_steps, sums_.most_nodes};
    has_room_ = can_record_shocks(ended_, runs_);
  }
  RA2D_FUNCTION void end_stretch() {
    lanes_.sync();
    if (lanes_.leader()) {
      sums_.face_work_part = stretch_.face_work_part;
      sums_.gross_face_work = stretch_.gross_face_work;
      sums_.contact_steps = stretch_.contact_steps;
      sums_.most_nodes = stretch_.most_nodes;
    }
    steady_.put_back(shocks_, lanes_.leader());
    lanes_.sync();
  }

  /// Within a stretch, of a scheme of several stages: what the faces' work at a later one [J/chi]
  /// is more than at the first. In the step in which a contact begins, only later stages have it,
  /// and the energy that they give would be one that nothing has supplied.
  KOKKOS_FORCEINLINE_FUNCTION void take_later_stages(double face_work) {
    stretch_.gross_face_work += face_work;
  }
  /// Within a stretch: adds the contact at a step to sums and shocks.
  KOKKOS_FORCEINLINE_FUNCTION void take_contact(const ContactTotals<Real>& totals,
                                                const Place& place, std::int64_t step) {
    if constexpr (form == Form::implicit)  // an impact's whole impulse may fall into one step
      usual_force_ += 0.125 * (totals.force - usual_force_);
    if (totals.nodes > 0) {
      add(totals);
      if (totals.nodes > stretch_.most_nodes) stretch_.most_nodes = totals.nodes;
      ra2d::take_contact(lanes_, steady_, shocks_, runs_, ended_, contact_list_, totals.nodes, step,
                         place.position);
      has_room_ = can_record_shocks(ended_, runs_);
    } else if (shocks_.open_count > 0) {
      end_open_shocks(step);
    }
  }
  /// Whether the buffer of ended shocks can take those of another step.
  KOKKOS_FORCEINLINE_FUNCTION bool has_room() const { return has_room_; }
  /// Whether the contact at this step may be that of the same nodes of a list as a step ago.
  KOKKOS_FORCEINLINE_FUNCTION bool contact_may_last(std::int64_t step) const {
    return steady_.lasts_to(step);
  }
  /// For NodeContact: see ListedContact.
  KOKKOS_FORCEINLINE_FUNCTION std::uint32_t second_run() const { return steady_.second(); }
  /// As take_contact, if it is; contact_list is not needed for it. False, with nothing changed, if
  /// not.
  KOKKOS_FORCEINLINE_FUNCTION bool take_lasting_contact(const ContactTotals<Real>& totals,
                                                        const Place& place) {
    if (!steady_.take(totals.listed, place.position)) return false;
    add(totals);
    return true;
  }
  /// After take_contact: at the next step it may last, of the same list of `length` nodes.
  KOKKOS_FORCEINLINE_FUNCTION void hold_contact(const ContactTotals<Real>& totals, int length) {
    steady_.hold(totals.listed.nodes, length);
  }
  /// Nodes are listed anew.
  KOKKOS_FORCEINLINE_FUNCTION void begin_list() { steady_.begin_list(); }
  /// There is no contact from this step until the next take_contact.
  KOKKOS_FORCEINLINE_FUNCTION void take_flight(std::int64_t step) {
    // contact is recorded at the beginning of a step, or (Form::implicit) at its end
    if (shocks_.open_count > 0) end_open_shocks(form == Form::implicit ? step + 1 : step);
  }
  KOKKOS_FORCEINLINE_FUNCTION void take_force_work(double work) {
    if (lanes_.leader()) sums_.force_part += work;
  }

  /// Total force [N] of the latest steps with contact: a guess of the forces to come.
  KOKKOS_FORCEINLINE_FUNCTION double usual_force() const { return usual_force_; }

 private:
  Lanes lanes_;
  const ModeTables& modes_;
  const SliderMotion& motion_;
  const ContactTables& contact_;
  const SchemeWeights& scheme_;
  const RecordTables& output_;
  OuterForces<Lanes, packs> outer_;
  ModesStep<Lanes, form, packs> integrate_;
  ClusteredContact<Lanes, packs> node_contact_;
  Status& status_;
  CarriedModes& modal_;
  RunningSums& sums_;
  EnergyCheck& energy_;
  Sampling& sampling_;
  ShockTracking& shocks_;
  const LatestContact& latest_contact_;
  const int* listed_nodes_;
  ContactList contact_list_;  // a copy: it holds nothing but addresses
  std::int64_t sampled_step_ = -1;
  ContactTotals<Real> sampled_contact_;
  Real sampled_force_[keeps_contact ? packs : 1];
  RunBuffer& runs_;
  SampleBuffer& samples_;
  ShockBuffer& ended_;
  double usual_force_ = 0.0;
  struct {
    double face_work_part, gross_face_work;
    std::int64_t contact_steps, most_nodes;
  } stretch_{};  // of RunningSums
  SteadyShocks steady_;
  bool has_room_ = true;  // see has_room(): only what ends shocks changes it

  /// Within a stretch: adds what a contact gives.
  KOKKOS_FORCEINLINE_FUNCTION void add(const ContactTotals<Real>& totals) {
    if constexpr (form != Form::implicit) usual_force_ = totals.force;
    stretch_.face_work_part += totals.face_work;
    stretch_.gross_face_work += Kokkos::abs(totals.face_work);
    ++stretch_.contact_steps;
  }
  RA2D_FUNCTION void end_open_shocks(std::int64_t step) {
    lanes_.sync();
    steady_.put_back(shocks_, lanes_.leader());
    if (lanes_.leader()) end_shocks(shocks_, ended_, step);
    lanes_.sync();
    has_room_ = can_record_shocks(ended_, runs_);
  }

  /// Sample j stands at step j steps_per_sample: between two steps it is interpolated linearly.
  RA2D_FUNCTION void sample_place(std::int64_t sample, std::int64_t& step, double& share) const {
    const double place = static_cast<double>(sample) * output_.steps_per_sample;
    step = static_cast<std::int64_t>(place);
    share = place - static_cast<double>(step);
    const double tiny = 1e-9 + 4e-16 * place;
    if (share < tiny) share = 0.0;
    if (share > 1.0 - tiny) {
      share = 0.0;
      ++step;
    }
  }

  enum class Part { whole, first, second };

  /// The share `weight` of a sample that this step has in it: all of it, the first of two, which
  /// waits for the second, or the second. False where there is no room for the nodes in contact.
  RA2D_FUNCTION bool write_sample(Motion<Lanes, packs>& now, Candidates<Lanes, packs>& candidates,
                                  int listed, double weight, Part part) {
    const bool add = part == Part::second;
    if (!add) close_parts(now);
    Real v[packs];
    const SampledContact contact = contact_at(now, candidates, listed, v);
    if (contact.nodes < 0) [[unlikely]] {
      lanes_.sync();
      if (lanes_.leader()) status_ = Status::crowded;
      lanes_.sync();
      return false;
    }
    constexpr int pitch = 2 * packs * width + sample::padded_columns;
    RA2D_CHECK(samples_.count < samples_.capacity);
    double* const row = part == Part::first
                            ? sampling_.pending_row
                            : samples_.rows + static_cast<std::int64_t>(samples_.count) * pitch;
    const auto put = [&](int at, const Real& x) {
      lanes_.store(row + at, add ? multiply_add(weight, x, lanes_.load(sampling_.pending_row + at))
                                 : Real(weight) * x);
    };
    Real loss(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      put(p * width, now.u[p]);
      put((packs + p) * width, v[p]);
      const Real before = load_pack(lanes_, modal_.start_v, p);
      const Real ends = Real(scheme_.loss_ends) * (now.v[p] * now.v[p] - before * before);
      loss = multiply_add(load_pack(lanes_, modes_.damping, p),
                          load_pack(lanes_, modal_.square, p) + now.square[p] - ends, loss);
    }
    const double damping_loss = lanes_.sum(loss);
    const double sliding_work = sums_.sliding_work + sliding_part(now);
    if (!lanes_.leader()) return true;
    // the number of nodes is not interpolated: it is that of the step before the sample
    const double nodes = add ? 0.0 : contact.nodes / weight;
    const double values[sample::columns] = {contact.force,  nodes,
                                            contact.energy, damping_loss,
                                            sliding_work,   sums_.force_work + sums_.force_part};
    double* const column = row + 2 * packs * width;
    const double* const first = sampling_.pending_row + 2 * packs * width;
    for (int i = 0; i < sample::columns; ++i)
      column[i] = weight * values[i] + (add ? first[i] : 0.0);
    return true;
  }

  struct SampledContact {
    double force, energy;
    int nodes;  // negative: there is no room for them
  };

  /// The contact at the present state, and the velocity at its time: of a scheme whose velocity
  /// lags behind, the mean of this step's and the next's.
  RA2D_FUNCTION SampledContact contact_at(const Motion<Lanes, packs>& now,
                                          Candidates<Lanes, packs>& candidates, int listed,
                                          Real* v) {
    for (int p = 0; p < filled<packs>(lanes_); ++p) v[p] = now.v[p];
    if constexpr (form == Form::implicit) {
      // a force over a step has no value within it: where there is one, the velocity is left as it
      // is
      if (latest_contact_.step == now.step)
        return {latest_contact_.force, latest_contact_.energy, latest_contact_.nodes};
      if (scheme_.velocity_lag > 0.0) {
        Real force[packs], moving[packs];
        outer_(now.step, force, moving);
        integrate_.lead(now.u, v, force);
      }
      return {0.0, 0.0, 0};
    } else {
      const Place place(motion_, now.step);
      Real force[packs], moving[packs];
      outer_(now.step, force, moving);
      int count = listed;
      if (!keeps_lists<Lanes, packs> || listed < 0) {
        count = candidates.find_contacts(now.u, now.v, place);
        if (!candidates.has_room(count) || !node_contact_.expand(place, listed_nodes_, count))
            [[unlikely]]
          return {0.0, 0.0, -1};
      }
      const ContactTotals<Real> totals = node_contact_(place, now.u, listed_nodes_, count, force);
      if constexpr (keeps_contact) {
        sampled_step_ = now.step;
        sampled_contact_ = totals;
        for (int p = 0; p < filled<packs>(lanes_); ++p) sampled_force_[p] = force[p];
      }
      double squares = 0.0;
      for (int e = 0; e < totals.nodes; ++e)
        squares += contact_list_.forces[e] * contact_list_.forces[e];
      const double energy =
          contact_list_.centres != nullptr ? totals.energy : 0.5 * contact_.compliance * squares;
      if (scheme_.velocity_lag > 0.0) integrate_.lead(now.u, v, force);
      return {totals.force, energy, totals.nodes};
    }
  }

  /// Adds each sum's small part (`..._part`) to the whole, so that 1e8 small terms are not added to
  /// one large number.
  RA2D_FUNCTION void close_parts(Motion<Lanes, packs>& now) {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(modal_.square + p * width, load_pack(lanes_, modal_.square, p) + now.square[p]);
      now.square[p] = Real(0.0);
    }
    const double part = sliding_part(now);
    now.deflection_work = Real(0.0);
    lanes_.sync();
    if (lanes_.leader()) {
      sums_.sliding_work += part;
      sums_.force_work += sums_.force_part;
      sums_.face_work_part = sums_.force_part = 0.0;
    }
    lanes_.sync();
  }

  /// Work of the imposed motion since the last sample: sum_n f_n V tau (dh_2/dx + du_2/dx).
  RA2D_FUNCTION double sliding_part(const Motion<Lanes, packs>& now) const {
    return motion_.advance * (sums_.face_work_part + lanes_.sum(now.deflection_work));
  }
};

}  // namespace ra2d
