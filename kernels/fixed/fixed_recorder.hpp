// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/check.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/fixed/modes_step.hpp"
#include "kernels/fixed/outer_forces.hpp"
#include "kernels/gap.hpp"
#include "kernels/lanes.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Energy may exceed what was put in by this factor before the run counts as unstable. The contact
/// energy of a scheme near its limit swings by a factor of a few; beyond the limit it grows without
/// bound.
inline constexpr double energy_factor = 10.0;

/// The record of fixed steps: samples, sums, shocks, and the watch over the energy.
///
/// It is that of the state at each step, whatever the scheme does within it: shocks and the work of
/// the imposed motion are summed from the contact forces there (under Form::implicit from the force
/// over the step that ends there), level and damping loss from the velocities.
template <class Lanes, Form form, int K>
class FixedRecorder {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION FixedRecorder(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                                const OuterForces<Lanes, K>& outer,
                                const ModesStep<Lanes, form, K>& modes,
                                const NodeContact<Lanes, K>& contact,
                                Candidates<Lanes, K>& candidates)
      : lanes_{lanes},
        t_{tables},
        s_{state},
        outer_{outer},
        modes_{modes},
        contact_{contact},
        candidates_{candidates} {}

  /// The next step at which something is to be written, no later than `stop`.
  KOKKOS_FUNCTION std::int64_t next_event(std::int64_t step, std::int64_t stop) const {
    std::int64_t next = (step / longest_flight + 1) * longest_flight;
    if (stop < next) next = stop;
    if (s_.sample_pending) return step + 1;
    if (s_.next_sample < t_.samples) {
      std::int64_t at;
      double share;
      sample_place(s_.next_sample, at, share);
      if (at < next) next = at;
    }
    return next > step ? next : step + 1;
  }

  /// Writes what is due at this step. False when the buffer is full.
  KOKKOS_FUNCTION bool take_sample(Motion<Lanes, K>& now) {
    std::int64_t at;
    double share;
    if (s_.sample_pending) {
      sample_place(s_.next_sample, at, share);
      if (at + 1 != now.step) return true;
      write_sample(now, share, Part::second);
      lanes_.sync();
      if (lanes_.leader()) {
        s_.sample_pending = false;
        ++s_.sample_count;
        ++s_.next_sample;
      }
      lanes_.sync();
    }
    if (s_.next_sample >= t_.samples) return true;
    sample_place(s_.next_sample, at, share);
    if (at != now.step) return true;
    if (s_.sample_count == s_.sample_capacity) return false;
    write_sample(now, 1.0 - share, share > 0.0 ? Part::first : Part::whole);
    watch_energy(now);
    lanes_.sync();
    if (lanes_.leader()) {
      if (share > 0.0) {
        s_.sample_pending = true;
      } else {
        ++s_.sample_count;
        ++s_.next_sample;
      }
    }
    lanes_.sync();
    return true;
  }

  /// Whether all that there is to write has been written.
  KOKKOS_FUNCTION bool is_complete() const {
    return !s_.sample_pending && s_.next_sample >= t_.samples;
  }

  /// Kinetic + elastic energy against what was put in. Ends the scene when it is not finite or has
  /// grown without work to pay for it.
  KOKKOS_FUNCTION void watch_energy(const Motion<Lanes, K>& now) {
    Real part(0.0), load_work(0.0);
    for (int p = 0; p < K; ++p) {
      const Real stretch = load(t_.omega, p) * now.u[p];
      part =
          multiply_add(load(t_.mass, p), multiply_add(now.v[p], now.v[p], stretch * stretch), part);
      load_work = multiply_add(outer_.load()[p], now.u[p] - load(s_.start, p), load_work);
    }
    const double energy = 0.5 * lanes_.sum(part);
    const auto paid = [](double work) { return work > 0.0 ? work : 0.0; };
    const double put_in = paid(lanes_.sum(load_work)) + paid(s_.force_work + s_.force_part) +
                          paid(s_.sliding_work + sliding_part(now));
    if (lanes_.leader()) {
      // what a load gives on the way down it takes back at the top: it went through all the same
      if (put_in > s_.most_paid) s_.most_paid = put_in;
      s_.energy = energy;
      s_.energy_limit =
          energy_factor * (s_.energy_start + s_.most_paid + t_.advance * s_.gross_climb);
      if (!(energy <= 1e300))
        s_.status = Status::not_finite;
      else if (energy > s_.energy_limit && energy > t_.least_energy)
        s_.status = Status::unstable;
    }
    lanes_.sync();
  }

  /// What the contact at a step adds to sums and shocks.
  KOKKOS_FORCEINLINE_FUNCTION void take_contact(const ContactTotals<Real>& totals,
                                                const Place& place, std::int64_t step) {
    if constexpr (form == Form::implicit)  // an impact's whole impulse may fall into one step
      usual_force_ += 0.125 * (totals.force - usual_force_);
    else if (totals.touched > 0)
      usual_force_ = totals.force;
    if (totals.touched == 0 && s_.open_count > 0)
      lanes_.sync();  // what ends is about to be written
    if (!lanes_.leader()) return;
    if (totals.touched > 0) {
      s_.climb_part += totals.climb;
      s_.gross_climb += Kokkos::abs(totals.climb);
      ++s_.contact_steps;
      if (totals.touched > s_.most_nodes) s_.most_nodes = totals.touched;
      if (!continue_shocks(s_, step, place.position, totals.touched))
        track_shocks(s_, step, place.position, totals.touched);
    } else if (s_.open_count > 0) {
      end_shocks(s_, step);
    }
  }
  /// Nothing touches at this step or until the next contact.
  KOKKOS_FORCEINLINE_FUNCTION void take_flight(std::int64_t step) {
    // contact is recorded at the beginning of a step, or (Form::implicit) at its end
    if (lanes_.leader() && s_.open_count > 0)
      end_shocks(s_, form == Form::implicit ? step + 1 : step);
  }
  KOKKOS_FORCEINLINE_FUNCTION void take_force_work(double work) {
    if (lanes_.leader()) s_.force_part += work;
  }

  /// Total force [N] of the latest steps with contact: guesses how long a watch will hold.
  KOKKOS_FORCEINLINE_FUNCTION double usual_force() const { return usual_force_; }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  const OuterForces<Lanes, K>& outer_;
  const ModesStep<Lanes, form, K>& modes_;
  const NodeContact<Lanes, K>& contact_;
  Candidates<Lanes, K>& candidates_;
  double usual_force_ = 0.0;

  KOKKOS_FORCEINLINE_FUNCTION Real load(const double* lanes, int pack) const {
    return lanes_.load(lanes + pack * width);
  }

  /// Sample j stands at step j steps_per_sample: between two steps it is interpolated linearly.
  KOKKOS_FUNCTION void sample_place(std::int64_t sample, std::int64_t& step, double& share) const {
    const double place = static_cast<double>(sample) * t_.steps_per_sample;
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
  /// waits for the second, or the second.
  KOKKOS_FUNCTION void write_sample(Motion<Lanes, K>& now, double weight, Part part) {
    const bool add = part == Part::second;
    if (!add) close_parts(now);
    Real v[K];
    const SampledContact contact = contact_at(now, v);
    constexpr int size = 2 * K * width + sample::columns;
    RA2D_CHECK(s_.sample_count < s_.sample_capacity);
    double* const row = part == Part::first
                            ? s_.pending_row
                            : s_.sample_rows + static_cast<std::int64_t>(s_.sample_count) * size;
    const auto put = [&](int at, const Real& x) {
      lanes_.store(row + at, add ? multiply_add(weight, x, lanes_.load(s_.pending_row + at))
                                 : Real(weight) * x);
    };
    Real loss(0.0);
    for (int p = 0; p < K; ++p) {
      put(p * width, now.u[p]);
      put((K + p) * width, v[p]);
      const Real before = load(s_.start_v, p);
      const Real ends = Real(t_.loss_ends) * (now.v[p] * now.v[p] - before * before);
      loss = multiply_add(load(t_.damping, p), load(s_.square, p) + now.square[p] - ends, loss);
    }
    const double damping_loss = lanes_.sum(loss);
    const double sliding_work = s_.sliding_work + sliding_part(now);
    if (!lanes_.leader()) return;
    // the number of nodes is not interpolated: it is that of the step before the sample
    const double nodes = add ? 0.0 : contact.nodes / weight;
    const double values[sample::columns] = {contact.force,  nodes,
                                            contact.energy, damping_loss,
                                            sliding_work,   s_.force_work + s_.force_part};
    double* const column = row + 2 * K * width;
    const double* const first = s_.pending_row + 2 * K * width;
    for (int i = 0; i < sample::columns; ++i)
      column[i] = weight * values[i] + (add ? first[i] : 0.0);
  }

  struct SampledContact {
    double force, energy;
    int nodes;
  };

  /// The contact at the present state, and the velocity at its time: of a scheme whose velocity
  /// lags behind, the mean of this step's and the next's.
  KOKKOS_FUNCTION SampledContact contact_at(const Motion<Lanes, K>& now, Real* v) {
    for (int p = 0; p < K; ++p) v[p] = now.v[p];
    if constexpr (form == Form::implicit) {
      // a force over a step has no value within it: where there is one, the velocity is left as it
      // is
      if (s_.contact_step == now.step)
        return {s_.contact_force, s_.contact_energy, s_.contact_nodes};
      if (t_.velocity_lag > 0.0) {
        Real force[K], moving[K];
        outer_(now.step, force, moving);
        modes_.lead(now.u, v, force);
      }
      return {0.0, 0.0, 0};
    } else {
      const Place place(t_, now.step);
      const int count = candidates_.find_touching(now.u, now.v, place);
      Real force[K], moving[K];
      outer_(now.step, force, moving);
      contact_.expand(place, s_.watch, count);
      const ContactTotals<Real> totals = contact_(place, now.u, s_.watch, count, force);
      double energy = 0.0;
      for (int e = 0; e < totals.touched; ++e) energy += s_.touched_force[e] * s_.touched_force[e];
      if (t_.velocity_lag > 0.0) modes_.lead(now.u, v, force);
      return {totals.force, 0.5 * t_.compliance * energy, totals.touched};
    }
  }

  /// Sums are kept in two parts, so that 1e8 small terms are not added to one large number.
  KOKKOS_FUNCTION void close_parts(Motion<Lanes, K>& now) {
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.square + p * width, load(s_.square, p) + now.square[p]);
      now.square[p] = Real(0.0);
    }
    const double part = sliding_part(now);
    now.bend = Real(0.0);
    lanes_.sync();
    if (lanes_.leader()) {
      s_.sliding_work += part;
      s_.force_work += s_.force_part;
      s_.climb_part = s_.force_part = 0.0;
    }
    lanes_.sync();
  }

  /// Work of the imposed motion since the last sample: sum_n f_n V tau (dh_2/dx + du_2/dx).
  KOKKOS_FUNCTION double sliding_part(const Motion<Lanes, K>& now) const {
    return t_.advance * (s_.climb_part + lanes_.sum(now.bend));
  }
};

}  // namespace ra2d
