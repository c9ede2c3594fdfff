// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/contact/penalty.hpp"
#include "kernels/displacement.hpp"
#include "kernels/gap.hpp"
#include "kernels/lanes.hpp"
#include "kernels/modal_state.hpp"
#include "kernels/model.hpp"
#include "kernels/record.hpp"

/// The time loop: one team marches one scene through many steps inside one launch.
///
/// Every step is the paper's: contact detection, contact force, time integration. What differs
/// between `Look::all` and `Look::candidates` is only which nodes are looked at, and the latter
/// leaves out a node when, and only when, it provably cannot touch:
///
/// * Look (look_ahead). At a reference state the overlap o of a node and its rate along the
/// straight line
///   U + t V are known. In free flight the modes leave that line by at most A t^2/2 with
///     A = sum_k max|psi_k| ((1 + 2 zeta) omega_k E_k + |load_k|/m_k),   E_k^2 = V_k^2 + omega_k^2
///     U_k^2,
///   since E_k grows by the load alone; the node's own motion over the bent beam adds the curvature
///   B = 2 V sum max|psi_k'| |V_k| + V^2 sum max|psi_k''| |U_k|. So no node touches before the
///   smallest root of o + rate t + (A + B) t^2/2 = 0. Until then the march flies: it advances the
///   modes and nothing else.
/// * Watch. When that is too short, the nodes that could touch within N steps, if the modes stay
/// within a
///   leeway rho of their line, are evaluated at every step. While they stay, the contact force is
///   at most f = kappa chi w sum_n max(0, overlap_n on the line + rho), so they leave the line by
///   at most (A + sum_k max|psi_k|^2/m_k (1 + (1 + 2 zeta) omega_k t) f) t^2/2: N is the last step
///   at which this is still within rho.
/// * Near. Both draw from a list of groups of nodes that can touch while no node passes another and
///   sum_k max|psi_k| |U_k - U_k^near| <= reach. It is rebuilt by a pass over block maxima.
///
/// The arithmetic of a step does not depend on any of this, nor on where a launch ends: the results
/// of all nodes and candidates, of one launch or many, are equal bit for bit.
namespace ra2d {

/// Steps for which the watch list is made, if nothing ends it earlier.
inline constexpr int watch_steps = 256;
/// A flight shorter than this costs more in looking than in evaluating the contact.
inline constexpr int shortest_flight = 24;
/// Longest stretch that a look covers, and steps between two looks at the energy.
inline constexpr int longest_flight = 4096;
/// Energy may exceed what was put in by this factor before the run counts as unstable. The contact
/// energy of a scheme near its limit swings by a factor of a few; beyond the limit it grows without
/// bound.
inline constexpr double energy_factor = 10.0;

/// Bound on the rounding of a displacement, over sum max|psi_k| |U_k|: a sum over the modes of a
/// polynomial, and one rounding of U_k for every step that is looked ahead.
KOKKOS_INLINE_FUNCTION double rounding(int steps) { return (256 + steps) * 0x1p-52; }

template <class Lanes, class Scheme, int K>
class Marcher {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

  /// What the contact did at one state.
  struct ContactTotals {
    double force = 0;  // N
    double climb = 0;  // N m: forces times the rise of the resonator's face over one spacing
    Real bend{0.0};    // N m: the same for its bent line, still to be summed over the lanes
    int touched = 0;   // nodes in contact, listed in the state's work space
  };

 public:
  KOKKOS_FUNCTION Marcher(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes}, t_{tables}, s_{state}, penalty_{tables.node_stiffness} {
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
  Penalty penalty_;
  std::int64_t step_;
  Real u_[K], v_[K], square_[K], bend_, load_[K];

  // the near list
  int near_count_ = 0, near_base_ = -1;
  double near_reach_ = -1.0;

  double last_force_ = 0.0;  // of the latest step with contact: guesses how long a watch will hold

  KOKKOS_FORCEINLINE_FUNCTION Real load(const double* lanes, int pack) const {
    return lanes_.load(lanes + pack * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION const double* rows(int patch) const {
    return t_.patch + static_cast<std::int64_t>(patch) * 4 * K * width;
  }
  /// sum over the modes of weight_k |x_k|
  KOKKOS_FORCEINLINE_FUNCTION double bound(const double* weight, const Real* x) const {
    Real part = load(weight, 0) * Kokkos::abs(x[0]);
    for (int p = 1; p < K; ++p) part = multiply_add(load(weight, p), Kokkos::abs(x[p]), part);
    return lanes_.sum(part);
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
  // --------------------------------------------------------------------------

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
    const int count = find_touching(place);
    Real force[K];
    for (int p = 0; p < K; ++p) force[p] = Real(0.0);
    expand_nodes(place, s_.watch, count);
    const ContactTotals contact = contact_at(place, u_, s_.watch, count, force);
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
    const double limit = energy_factor * (s_.energy_start + paid(lanes_.sum(load_work)) +
                                          paid(s_.force_work + s_.force_part) + s_.gross_work);
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
  // ------------------------------------------------------------------------------------

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

  /// Expands the listed nodes that are not expanded for this window yet.
  KOKKOS_FUNCTION void expand_nodes(const Place& place, const int* nodes, int count) {
    const std::int64_t window = place.window(t_);
    for (int e = 0; e < count; ++e) {
      const int node = nodes[e];
      if (s_.node_window[node] == window) continue;
      lanes_.sync();
      expand_node<Lanes, K>(lanes_, t_, place, node, s_.node_shape + node_offset(node),
                            s_.node_face + 2 * node);
      if (lanes_.leader()) s_.node_window[node] = window;
      lanes_.sync();
    }
  }
  KOKKOS_FORCEINLINE_FUNCTION static std::int64_t node_offset(int node) {
    return static_cast<std::int64_t>(node) * (4 * K * width);
  }

  /// Contact detection and contact force at a state: adds the modal contact force of the listed
  /// nodes (in ascending order, expanded for this window) to `force`, and lists those that touch.
  KOKKOS_FORCEINLINE_FUNCTION ContactTotals contact_at(const Place& place, const Real* u,
                                                       const int* nodes, int count,
                                                       Real* force) const {
    ContactTotals totals;
    Real bend[K];  // sum_n f_n dphi/dx: the slope that the bent beam adds to the faces'
    for (int p = 0; p < K; ++p) bend[p] = Real(0.0);
    const Real offset(place.offset);
    for (int e = 0; e < count; ++e) {
      const int node = nodes[e];
      const double* c = s_.node_shape + node_offset(node);
      Real phi[K], slope[K];
      for (int p = 0; p < K; ++p) {
        const Real c3 = load(c, 3 * K + p);
        const Real c2 = multiply_add(c3, offset, load(c, 2 * K + p));
        const Real c1 = multiply_add(c2, offset, load(c, K + p));
        phi[p] = multiply_add(c1, offset, load(c, p));
        slope[p] = multiply_add(multiply_add(c3, offset, c2), offset, c1);
      }
      Real product = phi[0] * u[0];
      for (int p = 1; p < K; ++p) product = multiply_add(phi[p], u[p], product);
      const double rise = s_.node_face[2 * node + 1];
      const double overlap =
          Kokkos::fma(place.theta, rise, s_.node_face[2 * node]) + lanes_.sum(product);
      if (!(overlap >= 0.0)) continue;

      const double f = penalty_.force(overlap);
      for (int p = 0; p < K; ++p) {
        force[p] = multiply_add(-f, phi[p], force[p]);
        bend[p] = multiply_add(f, slope[p], bend[p]);
      }
      totals.climb = Kokkos::fma(f, rise, totals.climb);
      totals.force += f;
      if (lanes_.leader()) {
        s_.touched[totals.touched] = node;
        s_.touched_force[totals.touched] = f;
      }
      ++totals.touched;
    }
    if (totals.touched > 0) {
      for (int p = 0; p < K; ++p) totals.bend = multiply_add(bend[p], u[p], totals.bend);
      lanes_.sync();
    }
    return totals;
  }

  /// Lists in `watch` every node that touches at the present state, and perhaps a few that miss by
  /// a rounding. Looks at all the nodes or at those near, as the scene asks.
  KOKKOS_FUNCTION int find_touching(const Place& place) {
    const bool all = t_.look == Look::all;
    if (!all && !near_holds(place, 0.0)) find_near(place);
    for (int p = 0; p < K; ++p) lanes_.store(s_.lanes + p * width, u_[p]);
    lanes_.sync();
    const double level = -(t_.slack + rounding(0) * bound(t_.reach, u_) + bound(t_.tail, u_));
    const Real lane_eta = Real(t_.inverse_radius) * lanes_.index();
    double q[4];
    int patch = -1, count = 0;
    const int groups = all ? t_.groups : near_count_;
    for (int e = 0; e < groups; ++e) {
      const int group = all ? e : s_.near[e];
      const GroupPlace<Lanes> at(t_, place, group);
      if (at.patch != patch) {
        patch = at.patch;
        series_coefficients<Lanes, K>(lanes_, rows(patch), u_, q);
      }
      const StaticOverlap<Lanes> faces(lanes_, t_, place, group);
      const Real overlap = add_slider_displacement(lanes_, t_, s_.lanes, group, faces.height) +
                           cubic(q, lane_eta + Real(at.eta));
      list_nodes(group, lanes_.at_least(overlap, level), count);
    }
    lanes_.sync();
    return count;
  }

  KOKKOS_FORCEINLINE_FUNCTION void list_nodes(int group, std::uint32_t bits, int& count) {
    for (; bits != 0; bits &= bits - 1) {
      if (lanes_.leader()) s_.watch[count] = group * width + Kokkos::countr_zero(bits);
      ++count;
    }
  }

  /// What a step adds to the record.
  KOKKOS_FORCEINLINE_FUNCTION void record(const ContactTotals& totals, const Place& place,
                                          std::int64_t step) {
    if (totals.touched > 0) last_force_ = totals.force;
    if (!lanes_.leader()) return;
    if (totals.touched > 0) {
      s_.climb_part += totals.climb;
      s_.gross_work += t_.advance * Kokkos::abs(totals.climb);
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
    const ContactTotals totals = contact_at(place, u, nodes, count, force);
    record(totals, place, step_);
    bend = bend + totals.bend;
    lanes_.sync();
    advance(u, v, square, force, c0, c1, c2);
    moving_force_work(moving, v);
    ++step_;
  }

  // ---- every node at every step
  // --------------------------------------------------------------------

  KOKKOS_FUNCTION void march_all(std::int64_t next) {
    Real c0[K], c1[K], c2[K];
    load_scheme(c0, c1, c2);
    const std::int64_t first = step_;
    while (step_ < next && has_room_for_shocks(s_)) {
      const Place place(t_, step_);
      const int count = find_touching(place);
      expand_nodes(place, s_.watch, count);
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
  // -------------------------------------------------------------------------

  KOKKOS_FUNCTION void march_candidates(std::int64_t next) {
    while (step_ < next && has_room_for_shocks(s_)) {
      const Plan plan = look_ahead(next);
      if (plan.flight)
        fly(plan.steps);
      else
        watch(plan);
    }
  }

  struct Plan {
    bool flight;
    int steps;  // to fly, or to watch at the most
    int count;  // nodes to watch
  };

  /// Bounds on what the modes can do within a number of steps.
  struct Bounds {
    double rounding;      // of a displacement
    double speed;         // sum max|psi| |V|
    double acceleration;  // A of the header
    double curvature;     // A + B
    double yield;  // 1/kg, acceleration that a newton of contact force can add, as in the header
  };

  KOKKOS_FUNCTION Bounds bounds(int steps) const {
    const double time = steps * t_.step;
    Real energy[K], acceleration[K], rate[K], displacement[K], yield[K];
    for (int p = 0; p < K; ++p) {
      const Real omega = load(t_.omega, p), push = load(t_.push, p);
      const Real stretch = omega * u_[p];
      energy[p] = Kokkos::sqrt(multiply_add(v_[p], v_[p], stretch * stretch));
      acceleration[p] = multiply_add(load(t_.pull, p), multiply_add(time, push, energy[p]), push);
      rate[p] = multiply_add(time, acceleration[p], Kokkos::abs(v_[p]));
      displacement[p] = multiply_add(time, rate[p], Kokkos::abs(u_[p]));
      yield[p] = load(t_.yield, p) * multiply_add(time, load(t_.pull, p), Real(1.0));
    }
    Bounds b;
    b.rounding = rounding(steps) * bound(t_.reach, displacement);
    b.speed = bound(t_.reach, v_);
    b.acceleration = bound(t_.reach, acceleration);
    const double speed = t_.advance * t_.spacing / t_.step;
    b.curvature = b.acceleration + 2.0 * speed * bound(t_.reach_slope, rate) +
                  speed * speed * bound(t_.reach_curve, displacement);
    b.yield = bound(t_.reach, yield);
    return b;
  }

  /// Distance that the near list's reference has been left behind by.
  KOKKOS_FORCEINLINE_FUNCTION double moved() const {
    Real away[K];
    for (int p = 0; p < K; ++p) away[p] = u_[p] - load(s_.near_u, p);
    return bound(t_.reach, away);
  }

  KOKKOS_FUNCTION bool near_holds(const Place& place, double travel) const {
    return place.base == near_base_ && moved() + travel <= near_reach_;
  }

  /// Roundings of two positions, in chi: below one of these the slider moves in stairs, not along a
  /// line.
  KOKKOS_FORCEINLINE_FUNCTION static double position_rounding(const Place& place) {
    return 2 * 0x1p-52 * (place.position + 1.0);
  }

  /// Steps until the slider's nodes stand `edge` behind the resonator's, at the most `longest`.
  KOKKOS_FUNCTION int steps_to(double edge, const Place& place, int longest) const {
    if (t_.advance == 0.0) return longest;
    // short of the crossing by a step and by the roundings of the position; at least this very step
    const double steps = (edge - place.theta - position_rounding(place)) / t_.advance - 1.0;
    return steps > longest ? longest : steps < 1.0 ? 1 : static_cast<int>(steps);
  }

  /// Finds the groups that can touch while the modes stay within a reach of where they are now and
  /// no node passes another. The reach is what they can be expected to travel until then.
  KOKKOS_FUNCTION void find_near(const Place& place) {
    const int steps = steps_to(1.0, place, longest_flight);
    const double time = steps * t_.step;
    const Bounds b = bounds(steps);
    near_base_ = place.base;
    near_reach_ = 2.0 * (b.speed * time + 0.5 * b.curvature * time * time) + t_.least_reach;
    if (!(near_reach_ < 1e300)) near_reach_ = 1e300;  // not a number, too: then everything is near
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.near_u + p * width, u_[p]);
      lanes_.store(s_.lanes + p * width, u_[p]);
    }
    lanes_.sync();
    const double to_end = place.base + 1 - place.position;  // chi
    const double slope = bound(t_.reach_slope, u_);
    const double radius = t_.spacing / t_.inverse_radius;
    const double level = -(near_reach_ + t_.slack + b.rounding + bound(t_.tail, u_) +
                           to_end * t_.spacing * slope + position_rounding(place) * t_.steepest);
    const Real lane_eta = Real(t_.inverse_radius) * lanes_.index();
    double q[4];
    int patch = -1, count = 0;
    bool have_series = false;
    std::int64_t evaluated = 0;
    double highest = 0.0;  // bound on u_2 over the patch
    for (int group = 0; group < t_.groups; ++group) {
      const GroupPlace<Lanes> at(t_, place, group);
      if (at.patch != patch) {
        patch = at.patch;
        have_series = false;
        Real centre = load(rows(patch), 0) * u_[0];
        for (int p = 1; p < K; ++p) centre = multiply_add(load(rows(patch), p), u_[p], centre);
        highest = lanes_.sum(centre) + radius * slope;
      }
      // the highest of the two blocks that the group's nodes and their neighbours lie in
      const int block = (place.base + group * width) / width;
      const double left = t_.block_max2[block], right = t_.block_max2[block + 1];
      const Real top = add_slider_displacement(lanes_, t_, s_.lanes, group,
                                               lanes_.load(t_.height1 + group * width)) +
                       Real(highest + (left > right ? left : right));
      if (lanes_.at_least(top, level) == 0) continue;
      if (!have_series) series_coefficients<Lanes, K>(lanes_, rows(patch), u_, q);
      have_series = true;
      const StaticOverlap<Lanes> faces(lanes_, t_, place, group);
      const Real now = add_slider_displacement(lanes_, t_, s_.lanes, group, faces.height) +
                       cubic(q, lane_eta + Real(at.eta));
      const Real most = now + Kokkos::max(Real(to_end) * faces.rise, Real(0.0));
      evaluated += width;
      if (lanes_.at_least(most, level) == 0) continue;
      if (lanes_.leader()) s_.near[count] = group;
      ++count;
    }
    near_count_ = count;
    if (lanes_.leader()) s_.evaluated += evaluated;
    lanes_.sync();
  }

  /// Decides how to go on from the present state, for no longer than until step `next`.
  KOKKOS_FUNCTION Plan look_ahead(std::int64_t next) {
    const Place place(t_, step_);
    int longest = steps_to(1.0, place, longest_flight);
    if (next - step_ < longest) longest = static_cast<int>(next - step_);
    const double tau = t_.step;
    const Bounds b = bounds(longest);

    // the near list must hold for all the states that this look speaks of
    int watched = steps_to((place.part + 1) * t_.window_width, place, watch_steps);
    if (longest < watched) watched = longest;
    const double watch_time = watched * tau;
    const double leeway =
        watch_time * watch_time * (0.75 * b.acceleration + b.yield * last_force_) + t_.least_leeway;
    const double watch_travel = b.speed * watch_time + leeway;
    if (!near_holds(place, watch_travel)) find_near(place);
    const double room = near_reach_ - moved();
    if (room < watch_travel) return {false, 1, find_touching(place)};  // wild: step by step

    if (near_count_ > 0) {
      for (int p = 0; p < K; ++p) lanes_.store(s_.lanes + p * width, u_[p]);
      for (int p = 0; p < K; ++p) lanes_.store(s_.lanes + (K + p) * width, v_[p]);
      lanes_.sync();
    }
    const Real lane_eta = Real(t_.inverse_radius) * lanes_.index();
    const double half_curve = 0.5 * b.curvature * tau * tau;
    // A node is left out of the watch when it stays open along the line, with leeway and its own
    // motion.
    const double slack =
        t_.slack + b.rounding + bound(t_.tail, u_) + position_rounding(place) * t_.steepest;
    // what the cubics leave out of the closing per step
    const double closing_slack =
        tau * bound(t_.tail, v_) + t_.advance * t_.spacing * bound(t_.tail_slope, u_);
    const double level = -(leeway + half_curve * watched * watched + slack);
    double q[4], rate_q[4];
    Real soonest(static_cast<double>(longest)), pressed(0.0);
    int patch = -1, count = 0;
    for (int e = 0; e < near_count_; ++e) {
      const int group = s_.near[e];
      const GroupPlace<Lanes> at(t_, place, group);
      if (at.patch != patch) {
        patch = at.patch;
        series_coefficients<Lanes, K>(lanes_, rows(patch), u_, q);
        series_coefficients<Lanes, K>(lanes_, rows(patch), v_, rate_q);
      }
      const StaticOverlap<Lanes> faces(lanes_, t_, place, group);
      const Real eta = lane_eta + Real(at.eta);
      const Real overlap =
          add_slider_displacement(lanes_, t_, s_.lanes, group, faces.height) + cubic(q, eta);
      // closing per step: the modes, and the node's way over the resonator's face
      const Real modes =
          add_slider_displacement(lanes_, t_, s_.lanes + K * width, group, cubic(rate_q, eta));
      const Real way = faces.rise + Real(t_.inverse_radius) * cubic_slope(q, eta);
      const Real closing =
          multiply_add(tau, modes, multiply_add(t_.advance, way, Real(closing_slack)));
      const Real most =
          multiply_add(static_cast<double>(watched), Kokkos::max(closing, Real(0.0)), overlap);
      list_nodes(group, lanes_.at_least(most, level), count);
      pressed = pressed + Kokkos::max(most - Real(level), Real(0.0));
      // the root of open = i closing + i (i + 1) half_curve
      const Real open = Kokkos::max(-overlap - Real(slack), Real(0.0));
      const Real linear = closing + Real(half_curve);
      const Real root =
          Kokkos::sqrt(multiply_add(linear, linear, Real(4.0 * half_curve) * open)) + linear;
      soonest = Kokkos::min(soonest, Real(2.0) * open / (root + Real(1e-300)));
    }
    if (lanes_.leader()) s_.evaluated += static_cast<std::int64_t>(near_count_) * width;
    lanes_.sync();
    double flight = near_count_ > 0 ? lanes_.min(soonest) : longest;
    // ... and no further than the near list reaches
    const double linear = b.speed * tau + half_curve;
    const double reach =
        2.0 * room / (Kokkos::sqrt(linear * linear + 4.0 * half_curve * room) + linear + 1e-300);
    if (reach < flight) flight = reach;
    if (flight >= shortest_flight || count == 0 || flight >= longest) {
      int steps = flight >= longest ? longest : static_cast<int>(flight);
      if (count == 0 && steps < watched) steps = watched;  // nothing to watch: the same as flying
      return {true, steps < 1 ? 1 : steps, 0};
    }
    // the first step may always be watched: the line begins there
    const double strongest = t_.node_stiffness * lanes_.sum(pressed);
    const double pull = b.acceleration + b.yield * strongest;
    const double held = Kokkos::sqrt(2.0 * leeway / (pull + 1e-300)) / tau - 1.0;
    return {false, held >= watched ? watched : held < 1.0 ? 1 : static_cast<int>(held), count};
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
  KOKKOS_FUNCTION void watch(const Plan& plan) {
    Real c0[K], c1[K], c2[K], u[K], v[K], square[K];
    load_scheme(c0, c1, c2);
    for (int p = 0; p < K; ++p) {
      u[p] = u_[p];
      v[p] = v_[p];
      square[p] = square_[p];
    }
    Real bend = bend_;
    Place place(t_, step_);
    expand_nodes(place, s_.watch, plan.count);
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
