// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/displacement.hpp"
#include "kernels/gap.hpp"
#include "kernels/lanes.hpp"
#include "kernels/modal_state.hpp"
#include "kernels/model.hpp"
#include "kernels/record.hpp"

/// The time loop: one team marches one scene through many steps inside one launch.
///
/// Every step is the paper's: contact detection, contact force, time integration. What differs
/// between `Look::all` and `Look::candidates` is only which nodes are looked at
/// (kernels/candidates.hpp). The arithmetic of a step does not depend on that, nor on where a
/// launch ends: the results of all nodes and candidates, of one launch or many, are equal bit for
/// bit.
namespace ra2d {

/// Energy may exceed what was put in by this factor before the run counts as unstable. The contact
/// energy of a scheme near its limit swings by a factor of a few; beyond the limit it grows without
/// bound.
inline constexpr double energy_factor = 10.0;

template <class Lanes, class Scheme, int K>
class Marcher {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION Marcher(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes},
        t_{tables},
        s_{state},
        contact_{lanes, tables, state},
        candidates_{lanes, tables, state} {
    for (int p = 0; p < K; ++p) {
      u_[p] = load(s_.u, p);
      v_[p] = load(s_.v, p);
      square_[p] = load(s_.square_part, p);
      load_[p] = load(t_.load, p);
    }
    bend_ = load(s_.bend_part, 0);
    step_ = s_.step;
  }

  /// Marches until step `target`, the end of the scene, a full buffer or a failure, whichever is
  /// first.
  KOKKOS_FUNCTION void run(std::int64_t target) {
    const std::int64_t stop = target < t_.total_steps ? target : t_.total_steps;
    while (s_.status == Status::running) {
      if (!take_sample()) break;
      if (step_ % longest_flight == 0 || step_ == t_.total_steps) watch_energy();
      if (s_.status != Status::running || step_ >= stop || !has_room_for_shocks(s_)) break;
      const std::int64_t next = next_event(stop);
      if (t_.look == Look::all)
        march_all(next);
      else
        march_candidates(next);
    }
    if (s_.status == Status::running && step_ == t_.total_steps && !s_.sample_pending &&
        s_.next_sample >= t_.samples && lanes_.leader())
      s_.status = Status::done;
    save();
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  NodeContact<Lanes, K> contact_;
  Candidates<Lanes, K> candidates_;
  std::int64_t step_;
  Real u_[K], v_[K], square_[K], bend_, load_[K];

  double last_force_ = 0.0;  // of the latest step with contact: guesses how long a watch will hold

  KOKKOS_FORCEINLINE_FUNCTION Real load(const double* lanes, int pack) const {
    return lanes_.load(lanes + pack * width);
  }

  KOKKOS_FUNCTION void save() {
    lanes_.sync();
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.u + p * width, u_[p]);
      lanes_.store(s_.v + p * width, v_[p]);
      lanes_.store(s_.square_part + p * width, square_[p]);
    }
    lanes_.store(s_.bend_part, bend_);
    if (lanes_.leader()) s_.step = step_;
  }

  // ---- when things happen

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

  KOKKOS_FUNCTION std::int64_t next_event(std::int64_t stop) const {
    std::int64_t next = (step_ / longest_flight + 1) * longest_flight;
    if (stop < next) next = stop;
    if (s_.sample_pending) return step_ + 1;
    if (s_.next_sample < t_.samples) {
      std::int64_t at;
      double share;
      sample_place(s_.next_sample, at, share);
      if (at < next) next = at;
    }
    return next > step_ ? next : step_ + 1;
  }

  /// Writes what is due at this step. False when the buffer is full.
  KOKKOS_FUNCTION bool take_sample() {
    std::int64_t at;
    double share;
    if (s_.sample_pending) {
      sample_place(s_.next_sample, at, share);
      if (at + 1 != step_) return true;
      write_sample(share, true);
      if (lanes_.leader()) {
        s_.sample_pending = false;
        ++s_.sample_count;
        ++s_.next_sample;
      }
      lanes_.sync();
    }
    if (s_.next_sample >= t_.samples) return true;
    sample_place(s_.next_sample, at, share);
    if (at != step_) return true;
    if (s_.sample_count == s_.sample_capacity) return false;
    write_sample(1.0 - share, false);
    watch_energy();
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

  KOKKOS_FUNCTION void write_sample(double weight, bool add) {
    if (!add) close_parts();
    const Place place(t_, step_);
    const int count = candidates_.find_touching(u_, v_, place);
    Real force[K];
    for (int p = 0; p < K; ++p) force[p] = Real(0.0);
    contact_.expand(place, s_.watch, count);
    const ContactTotals<Real> contact = contact_(place, u_, s_.watch, count, force);
    double* row = s_.sample_rows +
                  static_cast<std::int64_t>(s_.sample_count) * (2 * K * width + sample::columns);
    const auto put = [&](double* to, const Real& x) {
      lanes_.store(to, add ? multiply_add(weight, x, lanes_.load(to)) : Real(weight) * x);
    };
    Real loss(0.0);
    for (int p = 0; p < K; ++p) {
      put(row + p * width, u_[p]);
      put(row + (K + p) * width, v_[p]);
      loss = multiply_add(load(t_.damping, p), load(s_.square, p) + square_[p], loss);
    }
    const double damping_loss = lanes_.sum(loss);
    const double sliding_work = s_.sliding_work + sliding_part();
    if (!lanes_.leader()) return;
    double energy = 0.0;
    for (int e = 0; e < contact.touched; ++e) energy += s_.touched_force[e] * s_.touched_force[e];
    if (energy > 0.0) energy *= 0.5 / t_.node_stiffness;
    // the number of nodes is not interpolated: it is that of the step before the sample
    const double nodes = add ? 0.0 : contact.touched / weight;
    const double values[sample::columns] = {
        contact.force, nodes, energy, damping_loss, sliding_work, s_.force_work + s_.force_part};
    double* column = row + 2 * K * width;
    for (int i = 0; i < sample::columns; ++i)
      column[i] = weight * values[i] + (add ? column[i] : 0.0);
  }

  /// Sums are kept in two parts, so that 1e8 small terms are not added to one large number.
  KOKKOS_FUNCTION void close_parts() {
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.square + p * width, load(s_.square, p) + square_[p]);
      square_[p] = Real(0.0);
    }
    const double part = sliding_part();
    bend_ = Real(0.0);
    if (lanes_.leader()) {
      s_.sliding_work += part;
      s_.force_work += s_.force_part;
      s_.climb_part = s_.force_part = 0.0;
    }
    lanes_.sync();
  }

  /// Work of the imposed motion since the last sample: sum_n f_n V tau (dh_2/dx + du_2/dx).
  KOKKOS_FUNCTION double sliding_part() const {
    return t_.advance * (s_.climb_part + lanes_.sum(bend_));
  }

  /// Kinetic + elastic energy against what was put in. Ends the scene when it is not finite or has
  /// grown without work to pay for it.
  KOKKOS_FUNCTION void watch_energy() {
    Real part(0.0), load_work(0.0);
    for (int p = 0; p < K; ++p) {
      const Real stretch = load(t_.omega, p) * u_[p];
      part = multiply_add(load(t_.mass, p), multiply_add(v_[p], v_[p], stretch * stretch), part);
      load_work = multiply_add(load_[p], u_[p] - load(s_.start, p), load_work);
    }
    const double energy = 0.5 * lanes_.sum(part);
    const auto paid = [](double work) { return work > 0.0 ? work : 0.0; };
    const double limit =
        energy_factor * (s_.energy_start + paid(lanes_.sum(load_work)) +
                         paid(s_.force_work + s_.force_part) + t_.advance * s_.gross_climb);
    if (lanes_.leader()) {
      s_.energy = energy;
      s_.energy_limit = limit;
      if (!(energy <= 1e300))
        s_.status = Status::not_finite;
      else if (energy > limit && energy > t_.least_energy)
        s_.status = Status::unstable;
    }
    lanes_.sync();
  }

  // ---- the step

  /// Modal forces that do not depend on the state: the load, and the forces that travel.
  KOKKOS_FORCEINLINE_FUNCTION void outer_force(std::int64_t step, Real* force, Real* moving) const {
    for (int p = 0; p < K; ++p) force[p] = load_[p];
    if (t_.moving_forces == 0) return;
    for (int p = 0; p < K; ++p) moving[p] = Real(0.0);
    for (int i = 0; i < t_.moving_forces; ++i) {
      const MovingForceTable& f = t_.moving_force[i];
      const double x = Kokkos::fma(static_cast<double>(step), f.advance, f.position);
      if (x < 0.0 || x > t_.resonator_length) continue;
      Real psi[K];
      mode_values<Lanes, K>(lanes_, t_, x / t_.spacing, psi);
      for (int p = 0; p < K; ++p) moving[p] = multiply_add(f.force, psi[p], moving[p]);
    }
    for (int p = 0; p < K; ++p) force[p] = force[p] + moving[p];
  }

  /// What a step adds to the record.
  KOKKOS_FORCEINLINE_FUNCTION void record(const ContactTotals<Real>& totals, const Place& place,
                                          std::int64_t step) {
    if (totals.touched > 0) last_force_ = totals.force;
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

  /// One step of all the modes under the modal forces `force`.
  KOKKOS_FORCEINLINE_FUNCTION void advance(Real* u, Real* v, Real* square, const Real* force,
                                           const Real* c0, const Real* c1, const Real* c2) const {
    const Real tau(t_.step);
    for (int p = 0; p < K; ++p) {
      Scheme::advance(u[p], v[p], c0[p], c1[p], c2[p] * force[p], tau);
      square[p] = multiply_add(v[p], v[p], square[p]);
    }
  }

  KOKKOS_FORCEINLINE_FUNCTION void moving_force_work(const Real* moving, const Real* v) {
    if (t_.moving_forces == 0) return;
    Real power(0.0);
    for (int p = 0; p < K; ++p) power = multiply_add(moving[p], v[p], power);
    const double work = t_.step * lanes_.sum(power);
    if (lanes_.leader()) s_.force_part += work;
  }

  /// One step with contact at the given nodes, expanded for this window.
  KOKKOS_FORCEINLINE_FUNCTION void contact_step(Real* u, Real* v, Real* square, Real& bend,
                                                const Real* c0, const Real* c1, const Real* c2,
                                                const Place& place, const int* nodes, int count) {
    Real force[K], moving[K];
    outer_force(step_, force, moving);
    const ContactTotals<Real> totals = contact_(place, u, nodes, count, force);
    record(totals, place, step_);
    bend = bend + totals.bend;
    lanes_.sync();
    advance(u, v, square, force, c0, c1, c2);
    moving_force_work(moving, v);
    ++step_;
  }

  // ---- every node at every step

  KOKKOS_FUNCTION void march_all(std::int64_t next) {
    Real c0[K], c1[K], c2[K];
    load_scheme(c0, c1, c2);
    const std::int64_t first = step_;
    while (step_ < next && has_room_for_shocks(s_)) {
      const Place place(t_, step_);
      const int count = candidates_.find_touching(u_, v_, place);
      contact_.expand(place, s_.watch, count);
      contact_step(u_, v_, square_, bend_, c0, c1, c2, place, s_.watch, count);
    }
    if (lanes_.leader()) s_.evaluated += (step_ - first) * t_.nodes;
    lanes_.sync();
  }

  KOKKOS_FORCEINLINE_FUNCTION void load_scheme(Real* c0, Real* c1, Real* c2) const {
    for (int p = 0; p < K; ++p) {
      c0[p] = load(t_.c0, p);
      c1[p] = load(t_.c1, p);
      c2[p] = load(t_.c2, p);
    }
  }

  // ---- only what can touch

  KOKKOS_FUNCTION void march_candidates(std::int64_t next) {
    while (step_ < next && has_room_for_shocks(s_)) {
      const Outlook plan = candidates_.look_ahead(u_, v_, step_, next, last_force_);
      if (plan.flight)
        fly(plan.steps);
      else
        watch(plan);
    }
  }

  /// Steps that provably have no contact.
  KOKKOS_FUNCTION void fly(int steps) {
    Real c0[K], c1[K], c2[K], u[K], v[K], square[K], force[K];
    load_scheme(c0, c1, c2);
    for (int p = 0; p < K; ++p) {
      u[p] = u_[p];
      v[p] = v_[p];
      square[p] = square_[p];
      force[p] = load_[p];
    }
    if (lanes_.leader() && s_.open_count > 0) end_shocks(s_, step_);
    if (t_.moving_forces == 0) {
      for (int i = 0; i < steps; ++i) advance(u, v, square, force, c0, c1, c2);
    } else {
      Real moving[K];
      for (int i = 0; i < steps; ++i) {
        outer_force(step_ + i, force, moving);
        advance(u, v, square, force, c0, c1, c2);
        moving_force_work(moving, v);
      }
    }
    for (int p = 0; p < K; ++p) {
      u_[p] = u[p];
      v_[p] = v[p];
      square_[p] = square[p];
    }
    step_ += steps;
    lanes_.sync();
  }

  /// Steps with the watched nodes evaluated.
  KOKKOS_FUNCTION void watch(const Outlook& plan) {
    Real c0[K], c1[K], c2[K], u[K], v[K], square[K];
    load_scheme(c0, c1, c2);
    for (int p = 0; p < K; ++p) {
      u[p] = u_[p];
      v[p] = v_[p];
      square[p] = square_[p];
    }
    Real bend = bend_;
    Place place(t_, step_);
    contact_.expand(place, s_.watch, plan.count);
    int done = 0;
    while (done < plan.steps && has_room_for_shocks(s_)) {
      place.move_to(t_, step_);
      contact_step(u, v, square, bend, c0, c1, c2, place, s_.watch, plan.count);
      ++done;
    }
    for (int p = 0; p < K; ++p) {
      u_[p] = u[p];
      v_[p] = v[p];
      square_[p] = square[p];
    }
    bend_ = bend;
    if (lanes_.leader()) s_.evaluated += static_cast<std::int64_t>(done) * plan.count;
    lanes_.sync();
  }
};

/// The launch: every scene of a batch, one team each, until step `target`.
template <class Space, class Scheme, int K>
struct March {
  using Policy = Kokkos::TeamPolicy<Space>;
  using Member = typename Policy::member_type;
  using Lanes = typename LanesOf<Space>::template type<Member>;

  Kokkos::View<const SceneTables*, Space> tables;
  Kokkos::View<SceneState*, Space> states;
  std::int64_t target;

  KOKKOS_FUNCTION void operator()(const Member& member) const {
    const int scene = member.league_rank();
    const Lanes lanes(member);
    Marcher<Lanes, Scheme, K>(lanes, tables(scene), states(scene)).run(target);
  }
  void launch(const Space& space) const {
    Kokkos::parallel_for("ra2d::march",
                         Policy(space, tables.extent_int(0), 1, LanesOf<Space>::vector_length),
                         *this);
  }
};

}  // namespace ra2d
