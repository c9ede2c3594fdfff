// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/adaptive_march.hpp"
#include "kernels/candidates.hpp"
#include "kernels/check.hpp"
#include "kernels/contact/complementarity.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/displacement.hpp"
#include "kernels/fixed/advance.hpp"
#include "kernels/gap.hpp"
#include "kernels/lanes.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// The time loop: one team marches one scene through many steps inside one launch.
///
/// Every step is the paper's: contact detection, contact force, time integration. Which scheme
/// integrates stands in the scene's tables (kernels/schemes/mode_step.hpp); the march knows three
/// forms of a step (Form, kernels/tables.hpp).
///
/// What differs between `Nodes::all` and `Nodes::candidates` is only which nodes are looked at
/// (kernels/candidates.hpp). The arithmetic of a step does not depend on that, nor on where a
/// launch ends: the results of all nodes and candidates, of one launch or many, are equal bit for
/// bit.
///
/// The record is that of the state at each step, whatever the scheme does within it: shocks and the
/// work of the imposed motion are summed from the contact forces there (under Form::implicit from the
/// force over the step that ends there), level and damping loss from the velocities.
namespace ra2d {

/// Energy may exceed what was put in by this factor before the run counts as unstable. The contact
/// energy of a scheme near its limit swings by a factor of a few; beyond the limit it grows without
/// bound.
inline constexpr double energy_factor = 10.0;

template <class Lanes, Form form, int K>
class Marcher {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION Marcher(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes},
        t_{tables},
        s_{state},
        contact_{lanes, tables, state},
        candidates_{lanes, tables, state},
        held_{lanes, tables, state, contact_} {
    for (int p = 0; p < K; ++p) {
      u_[p] = load(s_.u, p);
      v_[p] = load(s_.v, p);
      square_[p] = load(s_.square_part, p);
      load_[p] = load(t_.load, p);
    }
    bend_ = load(s_.bend_part, 0);
    step_ = s_.step;
    begin();
  }

  /// Marches until step `target`, the end of the scene, a full buffer, an interrupt or a failure,
  /// whichever is first.
  KOKKOS_FUNCTION void run(std::int64_t target) {
    const std::int64_t stop = target < t_.total_steps ? target : t_.total_steps;
    while (s_.status == Status::running) {
      if (!take_sample()) break;
      if (step_ % longest_flight == 0 || step_ == t_.total_steps) watch_energy();
      if (s_.status != Status::running || step_ >= stop || !has_room_for_shocks(s_) ||
          is_interrupted(t_))
        break;
      const std::int64_t next = next_event(stop);
      if (t_.look_at == Nodes::all)
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
  Complementarity<Lanes, K> held_;
  std::int64_t step_;
  Real u_[K], v_[K], square_[K], bend_, load_[K];

  double last_force_ = 0.0;  // of the latest steps with contact: guesses how long a watch will hold

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
      write_sample(share, SamplePart::second);
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
    write_sample(1.0 - share, share > 0.0 ? SamplePart::first : SamplePart::whole);
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

  enum class SamplePart { whole, first, second };

  /// The share `weight` of a sample that this step has in it: all of it, the first of two, which waits
  /// for the second, or the second.
  KOKKOS_FUNCTION void write_sample(double weight, SamplePart part) {
    const bool add = part == SamplePart::second;
    if (!add) close_parts();
    Real v[K];
    const SampledContact contact = contact_now(v);
    constexpr int size = sample::row(K * width);
    RA2D_CHECK(s_.sample_count < s_.sample_capacity);
    double* const row = part == SamplePart::first
                            ? s_.pending_row
                            : s_.sample_rows + static_cast<std::int64_t>(s_.sample_count) * size;
    const auto put = [&](int at, const Real& x) {
      lanes_.store(row + at, add ? multiply_add(weight, x, lanes_.load(s_.pending_row + at))
                                 : Real(weight) * x);
    };
    Real loss(0.0);
    for (int p = 0; p < K; ++p) {
      put(p * width, u_[p]);
      put((K + p) * width, v[p]);
      const Real before = load(s_.start_v, p);
      const Real ends = Real(t_.loss_ends) * (v_[p] * v_[p] - before * before);
      loss = multiply_add(load(t_.damping, p), load(s_.square, p) + square_[p] - ends, loss);
    }
    const double damping_loss = lanes_.sum(loss);
    const double sliding_work = s_.sliding_work + sliding_part();
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

  /// The contact at the present state, and the velocity at its time: of a scheme whose velocity lags
  /// behind, the mean of this step's and the next's.
  KOKKOS_FUNCTION SampledContact contact_now(Real* v) {
    for (int p = 0; p < K; ++p) v[p] = v_[p];
    if constexpr (form == Form::implicit) {
      // a force over a step has no value within it: where there is one, the velocity is left as it is
      if (s_.contact_step == step_) return {s_.contact_force, s_.contact_energy, s_.contact_nodes};
      if (t_.velocity_lag > 0.0) {
        Real force[K], moving[K];
        outer_force(step_, 0.0, force, moving);
        lead(v, force);
      }
      return {0.0, 0.0, 0};
    } else {
      const Place place(t_, step_);
      const int count = candidates_.find_touching(u_, v_, place);
      Real force[K], moving[K];
      outer_force(step_, 0.0, force, moving);
      contact_.expand(place, s_.watch, count);
      const ContactTotals<Real> totals = contact_(place, u_, s_.watch, count, force);
      double energy = 0.0;
      for (int e = 0; e < totals.touched; ++e) energy += s_.touched_force[e] * s_.touched_force[e];
      if (t_.velocity_lag > 0.0) lead(v, force);
      return {totals.force, 0.5 * t_.compliance * energy, totals.touched};
    }
  }

  /// Takes v from where it lags to the present, over a share of the step under `force`.
  KOKKOS_FUNCTION void lead(Real* v, const Real* force) const {
    for (int p = 0; p < K; ++p) {
      const Real pushed = multiply_add(end(end_v_u, p), u_[p], end(end_forces + 1, p) * force[p]);
      const Real next = multiply_add(end(end_v_v, p), v[p], pushed);
      v[p] = multiply_add(t_.velocity_lag, next - v[p], v[p]);
    }
  }

  /// Once a scene: takes the velocity of t = 0 to where the scheme has it, so that `lead` brings it
  /// back.
  KOKKOS_FUNCTION void begin() {
    if (s_.begun) return;
    // what rests under contact forces that are yet to be found is not pushed
    const bool pushed_freely = form != Form::implicit || s_.contact_nodes == 0;
    if (t_.velocity_lag > 0.0 && pushed_freely) {
      Real force[K], moving[K];
      outer_force(step_, 0.0, force, moving);
      if constexpr (form != Form::implicit) {
        const Place place(t_, step_);
        const int count = candidates_.find_touching(u_, v_, place);
        contact_.expand(place, s_.watch, count);
        contact_(place, u_, s_.watch, count, force);
      }
      const double lag = t_.velocity_lag;
      for (int p = 0; p < K; ++p) {
        const Real pushed = multiply_add(end(end_v_u, p), u_[p], end(end_forces + 1, p) * force[p]);
        v_[p] = (v_[p] - Real(lag) * pushed) /
                multiply_add(lag, end(end_v_v, p) - Real(1.0), Real(1.0));
      }
    }
    lanes_.sync();
    if (lanes_.leader()) s_.begun = true;
    lanes_.sync();
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
    const double put_in = paid(lanes_.sum(load_work)) + paid(s_.force_work + s_.force_part);
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

  // ---- the step

  KOKKOS_FORCEINLINE_FUNCTION Real end(int row, int p) const {
    return lanes_.load(t_.end + (row * K + p) * width);
  }

  /// Modal forces that do not depend on the state: the load, and the forces that travel, at a share
  /// `behind` of the step after `step`.
  KOKKOS_FORCEINLINE_FUNCTION void outer_force(std::int64_t step, double behind, Real* force,
                                               Real* moving) const {
    for (int p = 0; p < K; ++p) force[p] = load_[p];
    if (t_.moving_forces == 0) return;
    moving_force(step, behind, moving);
    for (int p = 0; p < K; ++p) force[p] = force[p] + moving[p];
  }
  KOKKOS_FUNCTION void moving_force(std::int64_t step, double behind, Real* moving) const {
    for (int p = 0; p < K; ++p) moving[p] = Real(0.0);
    for (int i = 0; i < t_.moving_forces; ++i) {
      const MovingForceTable& f = t_.moving_force[i];
      const double x = Kokkos::fma(static_cast<double>(step) + behind, f.advance, f.position);
      if (x < 0.0 || x > t_.resonator_length) continue;
      Real psi[K];
      mode_values<Lanes, K>(lanes_, t_, x / t_.spacing, psi);
      for (int p = 0; p < K; ++p) moving[p] = multiply_add(f.force, psi[p], moving[p]);
    }
  }

  /// What a step adds to the record.
  KOKKOS_FORCEINLINE_FUNCTION void record(const ContactTotals<Real>& totals, const Place& place,
                                          std::int64_t step) {
    if constexpr (form == Form::implicit)  // an impact's whole impulse may fall into one step
      last_force_ += 0.125 * (totals.force - last_force_);
    else if (totals.touched > 0)
      last_force_ = totals.force;
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

  /// What the free step needs of every mode; the rest is read where it is needed.
  struct Weights {
    Real v_u[K], v_v[K], v_f[K];                // Form::semi_implicit
    Real u_u[K], u_v[K], u_load[K], v_load[K];  // the others, and the first two
  };
  KOKKOS_FORCEINLINE_FUNCTION Weights load_weights() const {
    Weights w;
    for (int p = 0; p < K; ++p) {
      w.v_u[p] = end(end_v_u, p);
      w.v_v[p] = end(end_v_v, p);
      if constexpr (form == Form::semi_implicit) {
        w.v_f[p] = end(end_forces + 1, p);
      } else {
        w.u_u[p] = end(end_u_u, p);
        w.u_v[p] = end(end_u_v, p);
        w.u_load[p] = end(end_u_load, p);
        w.v_load[p] = end(end_v_load, p);
      }
    }
    return w;
  }

  /// Form::semi_implicit: one step of all the modes under the modal forces `force`.
  KOKKOS_FORCEINLINE_FUNCTION void advance(Real* u, Real* v, Real* square, const Real* force,
                                           const Weights& w) const {
    const Real tau(t_.step);
    for (int p = 0; p < K; ++p) {
      advance_semi_implicit(u[p], v[p], w.v_v[p], w.v_u[p], w.v_f[p] * force[p], tau);
      square[p] = multiply_add(v[p], v[p], square[p]);
    }
  }

  /// The other forms: one step under the load and the stages' modal forces; bit j of `acting` tells
  /// whether there is one at stage j.
  KOKKOS_FORCEINLINE_FUNCTION void advance(Real* u, Real* v, const Weights& w, unsigned acting,
                                           const Real (*force)[K]) const {
    for (int p = 0; p < K; ++p) {
      Real du = multiply_add(w.u_u[p], u[p], multiply_add(w.u_v[p], v[p], w.u_load[p]));
      Real v1 = multiply_add(w.v_u[p], u[p], multiply_add(w.v_v[p], v[p], w.v_load[p]));
      for (unsigned rest = acting; rest != 0; rest &= rest - 1) {
        const int j = Kokkos::countr_zero(rest);
        du = multiply_add(end(end_forces + 2 * j, p), force[j][p], du);
        v1 = multiply_add(end(end_forces + 2 * j + 1, p), force[j][p], v1);
      }
      u[p] = u[p] + du;
      v[p] = v1;
    }
  }

  /// The displacement that stage i >= 1 sees.
  KOKKOS_FORCEINLINE_FUNCTION void stage_displacement(int i, const Real* u, const Real* v,
                                                      unsigned acting, const Real (*force)[K],
                                                      Real* at) const {
    const double* rows = t_.stage + t_.stage_row[i] * (K * width);
    for (int p = 0; p < K; ++p) {
      Real du = multiply_add(load(rows, p), u[p],
                             multiply_add(load(rows, K + p), v[p], load(rows, 2 * K + p)));
      for (unsigned rest = acting; rest != 0; rest &= rest - 1)
        du = multiply_add(load(rows, (3 + Kokkos::countr_zero(rest)) * K + p),
                          force[Kokkos::countr_zero(rest)][p], du);
      at[p] = u[p] + du;
    }
  }

  KOKKOS_FORCEINLINE_FUNCTION void add_squares(Real* square, const Real* v) const {
    for (int p = 0; p < K; ++p) square[p] = multiply_add(v[p], v[p], square[p]);
  }

  KOKKOS_FORCEINLINE_FUNCTION void moving_force_work(const Real* moving, const Real* v) {
    if (t_.moving_forces == 0) return;
    Real power(0.0);
    for (int p = 0; p < K; ++p) power = multiply_add(moving[p], v[p], power);
    const double work = t_.step * lanes_.sum(power);
    if (lanes_.leader()) s_.force_part += work;
  }

  /// The state that a stretch of steps works on.
  struct Working {
    Real u[K], v[K], square[K], bend;
  };
  KOKKOS_FORCEINLINE_FUNCTION Working take() const {
    Working y;
    for (int p = 0; p < K; ++p) {
      y.u[p] = u_[p];
      y.v[p] = v_[p];
      y.square[p] = square_[p];
    }
    y.bend = bend_;
    return y;
  }
  KOKKOS_FORCEINLINE_FUNCTION void put_back(const Working& y) {
    for (int p = 0; p < K; ++p) {
      u_[p] = y.u[p];
      v_[p] = y.v[p];
      square_[p] = y.square[p];
    }
    bend_ = y.bend;
  }

  /// Where a stretch of steps finds the nodes that could touch: on a list that holds for all of it
  /// ...
  struct Listed {
    int count;
    KOKKOS_FORCEINLINE_FUNCTION int operator()(const Real*, const Real*, const Place&) const {
      return count;
    }
    KOKKOS_FORCEINLINE_FUNCTION void move(const SceneTables& t, Place& place, std::int64_t step,
                                          double behind) const {
      place.move_to(t, step, behind);
    }
  };
  /// ... or by looking, at every state.
  struct Looked {
    Marcher& m;
    KOKKOS_FUNCTION int operator()(const Real* u, const Real* v, const Place& place) const {
      const int count = m.candidates_.find_touching(u, v, place);
      m.contact_.expand(place, m.s_.watch, count);
      return count;
    }
    KOKKOS_FUNCTION void move(const SceneTables& t, Place& place, std::int64_t step,
                              double behind) const {
      place = Place(t, step, behind);
    }
  };

  /// One step with contact at the nodes that `nodes` lists. False, with nothing done, when a list
  /// would not cover it (`outlook`, Form::implicit alone).
  template <class Nodes>
  KOKKOS_FORCEINLINE_FUNCTION bool contact_step(Working& y, const Weights& w, Place& place,
                                                const Nodes& nodes, const Outlook* outlook,
                                                double& pushed, double& pushes, int done) {
    if constexpr (form == Form::semi_implicit) {
      (void)outlook, (void)pushed, (void)pushes, (void)done;
      Real force[K], moving[K];
      outer_force(step_, 0.0, force, moving);
      const int count = nodes(y.u, y.v, place);
      const ContactTotals<Real> totals = contact_(place, y.u, s_.watch, count, force);
      record(totals, place, step_);
      y.bend = y.bend + totals.bend;
      lanes_.sync();
      advance(y.u, y.v, y.square, force, w);
      moving_force_work(moving, y.v);
    } else if constexpr (form == Form::staged) {
      (void)outlook, (void)pushed, (void)pushes, (void)done;
      if (t_.stages == 1)
        staged_step<1>(y, w, place, nodes);
      else
        staged_step<most_stages>(y, w, place, nodes);
    } else {
      if (!held_step(y, w, place, nodes, outlook, pushed, pushes, done)) return false;
    }
    ++step_;
    return true;
  }

  /// With the contact force at each stage, `most` of them.
  template <int most, class Nodes>
  KOKKOS_FORCEINLINE_FUNCTION void staged_step(Working& y, const Weights& w, Place& place,
                                               const Nodes& nodes) {
    Real force[most][K];
    unsigned acting = 0;
    const int stages = most == 1 ? 1 : t_.stages;
    for (int i = 0; i < stages; ++i) {
      Real at[K];
      if (i == 0) {
        for (int p = 0; p < K; ++p) at[p] = y.u[p];
      } else {
        stage_displacement(i, y.u, y.v, acting, force, at);
        nodes.move(t_, place, step_, t_.place[i]);
      }
      if (t_.moving_forces > 0) {
        moving_force(step_, t_.place[i], force[i]);
        if (i == 0) moving_force_work(force[0], y.v);
        acting |= 1u << i;
      } else {
        for (int p = 0; p < K; ++p) force[i][p] = Real(0.0);
      }
      const int count = nodes(at, y.v, place);
      const ContactTotals<Real> totals = contact_(place, at, s_.watch, count, force[i]);
      if (totals.touched > 0) acting |= 1u << i;
      if (i == 0) {  // the record is that of the state at the step
        record(totals, place, step_);
        y.bend = y.bend + totals.bend;
      }
      lanes_.sync();
    }
    advance(y.u, y.v, w, acting, force);
    add_squares(y.square, y.v);
  }

  /// Contact forces that hold over the step and are found with its end.
  template <class Nodes>
  KOKKOS_FUNCTION bool held_step(Working& y, const Weights& w, Place& place, const Nodes& nodes,
                                 const Outlook* outlook, double& pushed, double& pushes, int done) {
    Real u[K], v[K];
    for (int p = 0; p < K; ++p) {
      u[p] = y.u[p];
      v[p] = y.v[p];
    }
    free_step(u, v, w, step_, true);
    nodes.move(t_, place, step_ + 1, 0.0);
    ContactTotals<Real> totals;
    double most = 0.0;
    const auto list = [&](const Real* at) { return nodes(at, v, place); };
    const Solution found = held_(place, step_ + 1, u, v, list, totals, most);
    if (outlook != nullptr) {
      // did all that was looked at stay where the list holds?
      pushed += most;
      pushes += pushed;
      const double n = done + 1.0;
      if (found != Solution::solved ||
          !(outlook->line * n * (n + 1.0) + outlook->kick * pushes <= 1.0))
        return false;
      pushes += (totals.force - most);
      pushed += (totals.force - most);
    } else if (found != Solution::solved) {
      if (lanes_.leader())
        s_.status = found == Solution::blocked ? Status::blocked : Status::crowded;
      lanes_.sync();
      return false;
    }
    if (t_.moving_forces > 0) {
      Real moving[K];
      moving_force(step_, 0.0, moving);
      moving_force_work(moving, t_.loss_ends > 0.0 ? y.v : v);
    }
    record(totals, place, step_ + 1);
    if (lanes_.leader() && totals.touched > 0) {
      double energy = 0.0;
      for (int e = 0; e < totals.touched; ++e) energy += s_.touched_force[e] * s_.touched_force[e];
      s_.contact_step = step_ + 1;
      s_.contact_force = totals.force;
      s_.contact_energy = 0.5 * t_.compliance * energy;
      s_.contact_nodes = totals.touched;
      for (int e = 0; e < 2 && e < totals.touched; ++e) s_.contact_pair[e] = s_.touched[e];
    }
    y.bend = y.bend + totals.bend;
    lanes_.sync();
    for (int p = 0; p < K; ++p) {
      y.u[p] = u[p];
      y.v[p] = v[p];
    }
    add_squares(y.square, y.v);
    return true;
  }

  /// A step that no contact takes part in.
  KOKKOS_FUNCTION void free_step(Real* u, Real* v, const Weights& w, std::int64_t step,
                                 bool work_later) {
    unsigned acting = 0;
    Real force[most_stages][K];
    if (t_.moving_forces > 0) {
      for (int i = 0; i < t_.stages; ++i) moving_force(step, t_.place[i], force[i]);
      acting = (1u << t_.stages) - 1;
      if (!work_later && t_.loss_ends > 0.0) moving_force_work(force[0], v);
    }
    advance(u, v, w, acting, force);
    if (t_.moving_forces > 0 && !work_later && !(t_.loss_ends > 0.0))
      moving_force_work(force[0], v);
  }

  // ---- every node at every step

  KOKKOS_FUNCTION void march_all(std::int64_t next) {
    const std::int64_t first = step_;
    look(static_cast<int>(next - step_));
    if (lanes_.leader()) s_.evaluated += (step_ - first) * t_.nodes;
    lanes_.sync();
  }

  /// Steps that look at every state anew.
  KOKKOS_FUNCTION void look(int steps) {
    const Weights w = load_weights();
    Working y = take();
    double pushed = 0.0, pushes = 0.0;
    for (int i = 0; i < steps && has_room_for_shocks(s_); ++i) {
      Place place(t_, step_);
      if (!contact_step(y, w, place, Looked{*this}, nullptr, pushed, pushes, 0)) break;
    }
    put_back(y);
  }

  // ---- only what can touch

  KOKKOS_FUNCTION void march_candidates(std::int64_t next) {
    while (step_ < next && has_room_for_shocks(s_) && s_.status == Status::running) {
      const Outlook plan = candidates_.look_ahead(u_, v_, step_, next, last_force_);
      if (plan.kind == Outlook::fly)
        fly(plan.steps);
      else if (plan.kind == Outlook::look || !watch(plan))
        look(1);
    }
  }

  /// Steps that provably have no contact.
  KOKKOS_FUNCTION void fly(int steps) {
    const Weights w = load_weights();
    // contact is recorded at the beginning of a step, or (Form::implicit) at its end
    if (lanes_.leader() && s_.open_count > 0)
      end_shocks(s_, form == Form::implicit ? step_ + 1 : step_);
    if (t_.moving_forces == 0) {
      // arrays of their own, so that they stay in registers
      Real u[K], v[K], square[K], force[K];
      for (int p = 0; p < K; ++p) {
        u[p] = u_[p];
        v[p] = v_[p];
        square[p] = square_[p];
        force[p] = load_[p];
      }
      for (int i = 0; i < steps; ++i) {
        if constexpr (form == Form::semi_implicit) {
          advance(u, v, square, force, w);
        } else {
          advance(u, v, w, 0u, nullptr);
          add_squares(square, v);
        }
      }
      for (int p = 0; p < K; ++p) {
        u_[p] = u[p];
        v_[p] = v[p];
        square_[p] = square[p];
      }
    } else if constexpr (form == Form::semi_implicit) {
      Real force[K], moving[K];
      for (int i = 0; i < steps; ++i) {
        outer_force(step_ + i, 0.0, force, moving);
        advance(u_, v_, square_, force, w);
        moving_force_work(moving, v_);
      }
    } else {
      for (int i = 0; i < steps; ++i) {
        free_step(u_, v_, w, step_ + i, false);
        add_squares(square_, v_);
      }
    }
    step_ += steps;
    lanes_.sync();
  }

  /// Steps with the watched nodes evaluated. False when not even one was covered by the list.
  KOKKOS_FUNCTION bool watch(const Outlook& plan) {
    const Weights w = load_weights();
    Working y = take();
    Place place(t_, step_);
    contact_.expand(place, s_.watch, plan.count);
    int done = 0;
    double pushed = 0.0, pushes = 0.0;
    while (done < plan.steps && has_room_for_shocks(s_)) {
      place.move_to(t_, step_);
      if (!contact_step(y, w, place, Listed{plan.count}, &plan, pushed, pushes, done)) break;
      ++done;
    }
    put_back(y);
    const int states = form == Form::implicit ? 1 : t_.stages;  // looked at in a step
    if (lanes_.leader()) s_.evaluated += static_cast<std::int64_t>(done) * plan.count * states;
    lanes_.sync();
    return done > 0;
  }
};

/// Marches one scene to step `target`, its end, a full buffer, an interrupt or a failure.
template <class Lanes, Form form, int K>
KOKKOS_FUNCTION void march_scene(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                                 std::int64_t target) {
  if constexpr (form == Form::adaptive)
    AdaptiveMarcher<Lanes, K>(lanes, tables, state).run(target);
  else
    Marcher<Lanes, form, K>(lanes, tables, state).run(target);
}

/// A launch on a GPU: scenes of one form, a team each, to their targets.
template <class Space, Form form, int K>
struct March {
  using Policy = Kokkos::TeamPolicy<Space>;
  using Member = typename Policy::member_type;
  using Lanes = typename LanesOf<Space>::template type<Member>;

  Kokkos::View<const SceneTables*, Space> tables;
  Kokkos::View<SceneState*, Space> states;
  Kokkos::View<const int*, Space> scenes;
  Kokkos::View<const std::int64_t*, Space> targets;

  KOKKOS_FUNCTION void operator()(const Member& member) const {
    const int scene = scenes(member.league_rank());
    march_scene<Lanes, form, K>(Lanes(member), tables(scene), states(scene), targets(scene));
  }
  void launch(const Space& space) const {
    Kokkos::parallel_for("ra2d::march",
                         Policy(space, scenes.extent_int(0), 1, LanesOf<Space>::vector_length),
                         *this);
  }
};

}  // namespace ra2d
