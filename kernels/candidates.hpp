// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/displacement.hpp"
#include "kernels/group_sweep.hpp"
#include "kernels/lanes.hpp"
#include "kernels/limits.hpp"
#include "kernels/near_groups.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// Which nodes can touch, and for how long none can: a node is left out when, and only when, it
/// provably cannot touch.
///
/// Look (look_ahead): at a reference state the overlap o of a node and its rate along the straight
/// line U + t V are known. In free flight the modes leave that line by at most A t^2/2 with
///
///   A = sum_k max|psi_k| (pull_k (E_k + t push_k) + push_k),   E_k^2 = V_k^2 + omega_k^2 U_k^2,
///
/// where the scheme's step gives pull_k, for backward Euler (1 + 2 zeta) omega_k at the most, and
/// the outer forces with it push_k (host/model/step_bounds.hpp: the bound holds for a number of
/// steps, at all their stages, of stable and unstable schemes); the node's own way over the bent
/// beam adds the curvature B = 2 V sum_k max|psi_k'| |V_k| + V^2 sum_k max|psi_k''| |U_k|. So no
/// node touches before the smallest root of o + rate t + (A + B) t^2/2 = 0. Until then the march
/// flies: it advances the modes, nothing else.
///
/// Watch: when that is too short, the nodes that could touch within N steps, if the modes stay
/// within a leeway rho of their line, are evaluated at every step. While they stay, the contact
/// force is at most f = kappa chi w sum_n max(0, overlap_n on the line + rho), so they leave the
/// line by at most (A + f sum_k max|psi_k| yield_k (1 + pull_k t)) t^2/2, yield_k = max|psi_k|/m_k
/// times the step's own factor: N is the last step at which this is still within rho. Forces that
/// are found with the end of the step (Form::implicit) have no such bound: there the march sums up
/// what they have done, and does a step again with every node that could touch when the list would
/// not have covered it.
///
/// Near: both draw from a list of groups of nodes that can touch (kernels/near_groups.hpp).
///
/// To every comparison belongs a slack for the roundings: of the faces, of the position, of sums
/// over the modes and of the steps looked ahead.
namespace ra2d {

/// Steps for which the watch list is made, if nothing ends it earlier.
inline constexpr int watch_steps = 256;
/// A flight shorter than this costs more in looking than in evaluating the contact.
inline constexpr int shortest_flight = 24;
/// Under Form::implicit, more nodes than this cost less in looking at every state than on a list.
inline constexpr int most_watched = 48;
/// Bound on the rounding of a displacement, over sum max|psi_k| |U_k|: a sum over the modes of a
/// polynomial, and one rounding of U_k for every step that is looked ahead. Twice what one sum over
/// most_modes reaches: what it is compared with is one, too.
KOKKOS_INLINE_FUNCTION double rounding(int steps) { return (256 + steps) * 0x1p-52; }

/// How to go on: fly, watch, or (when neither can be promised) look at every state anew.
struct Outlook {
  enum Kind { fly, watch, look } kind;
  int steps;  // to fly, or to watch at the most
  int count;  // nodes to watch, listed in the state's `watch`
  /// While the nodes are watched, step n is covered by the list as long as line n (n + 1) + kick
  /// sum_{j<n} (n - j) f_j <= 1, f_j the contact force [N] of step j.
  double line = 0, kick = 0;
};

template <class Lanes, int K>
class Candidates {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION Candidates(const Lanes& lanes, const SceneTables& tables, SceneState& state)
      : lanes_{lanes}, t_{tables}, s_{state}, near_{lanes, tables, state} {}

  /// Decides how to go on from the state at `step`, for no longer than until step `next`.
  /// `last_force`, of the latest contact, guesses how long a watch will hold.
  KOKKOS_FUNCTION Outlook look_ahead(const Real* u, const Real* v, std::int64_t step,
                                     std::int64_t next, double last_force) {
    const Place place(t_, step);
    int longest = steps_to(1.0, place, t_.longest_look);
    if (longest < 1) {  // a node passes another within this step
      if (looks_ahead()) return {Outlook::look, 1, 0};
      longest = 1;
    }
    if (next - step < longest) longest = static_cast<int>(next - step);
    const double tau = t_.step;
    const Bounds b = bounds(u, v, longest);

    // the near list must hold for all the states that this look speaks of
    int watched = steps_to((place.part + 1) * t_.window_width, place, watch_steps);
    if (longest < watched) watched = longest;
    const bool short_of_window = watched < 1;
    if (short_of_window) watched = 1;
    const double watch_time = watched * tau;
    const double leeway = watch_time * watch_time * (0.75 * b.acceleration + b.yield * last_force) +
                          0.5 * watch_time * tau * b.acceleration + t_.least_leeway;
    const double watch_travel = b.speed * watch_time + leeway;
    if (!near_.holds(u, place, watch_travel)) find_near(u, v, place);
    const double room = near_.room(u);
    if (room < watch_travel) return {Outlook::look, 1, 0};  // wild: step by step

    const double half_curve = 0.5 * b.curvature * tau * tau;
    // A node is left out of the watch when it stays open along the line, with leeway and its own
    // motion.
    const double slack = t_.slack + b.rounding + bound(t_.cubic_remainder, u) +
                         position_rounding(place) * t_.steepest + 2.0 * half_curve;
    // what the cubics leave out of the closing per step
    const double closing_slack = tau * bound(t_.cubic_remainder, v) +
                                 t_.advance * t_.spacing * bound(t_.cubic_slope_remainder, u) +
                                 2.0 * half_curve;
    const double level = -(leeway + half_curve * watched * watched + slack);
    GroupSweep<Lanes, K> sweep(lanes_, t_, place, s_.lanes, u, v);
    Real soonest(static_cast<double>(longest)), pressed(0.0);
    int count = 0;
    for (int e = 0; e < near_.count(); ++e) {
      const int group = near_[e];
      const auto [overlap, modes, way] = sweep.overlap_and_rates(group);
      // closing per step: the modes, and the node's way over the resonator's face
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
    if (lanes_.leader()) s_.evaluated += static_cast<std::int64_t>(near_.count()) * width;
    lanes_.sync();
    double flight = near_.count() > 0 ? lanes_.min(soonest) : longest;
    // ... and no further than the near list reaches
    const double linear = b.speed * tau + half_curve;
    const double reach =
        2.0 * room / (Kokkos::sqrt(linear * linear + 4.0 * half_curve * room) + linear + 1e-300);
    if (reach < flight) flight = reach;
    if (!(flight >= 0.0)) flight = 0.0;  // the state is not a number
    if (flight >= shortest_flight || count == 0 || flight >= longest) {
      int steps = flight >= longest ? longest : static_cast<int>(flight);
      if (count == 0 && steps < watched) steps = watched;  // nothing to watch: the same as flying
      if (steps < 1 && looks_ahead()) return {Outlook::look, 1, 0};
      return {Outlook::fly, steps < 1 ? 1 : steps, 0};
    }
    if (t_.form == Form::implicit && count > most_watched) return {Outlook::look, 1, 0};
    double pull = b.acceleration;
    Outlook outlook{Outlook::watch, watched, count};
    if (t_.form ==
        Form::implicit) {  // no bound on the force: the march looks at what has come of it
      outlook.line = 0.5 * b.acceleration * tau * tau / leeway;
      outlook.kick = b.yield * tau * tau / leeway;
    } else {
      pull += b.yield * t_.node_stiffness * lanes_.sum(pressed);
    }
    const double lasting = Kokkos::sqrt(2.0 * leeway / (pull + 1e-300)) / tau - 1.0;
    if (!(lasting >= watched)) outlook.steps = !(lasting >= 1.0) ? 0 : static_cast<int>(lasting);
    if (outlook.steps < 1 || short_of_window) {
      if (looks_ahead()) return {Outlook::look, 1, 0};
      outlook.steps = 1;  // the first step may always be watched: the line begins there
    }
    return outlook;
  }

  /// Whether contact is looked for at other states than that at which a step begins.
  KOKKOS_FORCEINLINE_FUNCTION bool looks_ahead() const {
    return t_.stages > 1 || t_.form == Form::implicit;
  }

  /// Lists in `watch` every node that touches at the present state, and perhaps a few that miss by
  /// a rounding. Looks at all the nodes or at those near, as the scene asks.
  KOKKOS_FUNCTION int find_touching(const Real* u, const Real* v, const Place& place) {
    const bool all = t_.look_at == Nodes::all;
    if (!all && !near_.holds(u, place, 0.0)) find_near(u, v, place);
    const double level =
        -(t_.slack + rounding(0) * bound(t_.largest_shape, u) + bound(t_.cubic_remainder, u));
    GroupSweep<Lanes, K> sweep(lanes_, t_, place, s_.lanes, u);
    int count = 0;
    const int groups = all ? t_.groups : near_.count();
    for (int e = 0; e < groups; ++e) {
      const int group = all ? e : near_[e];
      list_nodes(group, lanes_.at_least(sweep.overlap(group).overlap, level), count);
    }
    lanes_.sync();
    return count;
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  NearGroups<Lanes, K> near_;

  KOKKOS_FORCEINLINE_FUNCTION Real load(const double* lanes, int pack) const {
    return lanes_.load(lanes + pack * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION double bound(const double* weight, const Real* x) const {
    return weighted_sum<Lanes, K>(lanes_, weight, x);
  }
  /// The last group is filled up with nodes that do not exist: low as they are, a motion that has
  /// run away, or is no longer a number, would reach them.
  KOKKOS_FORCEINLINE_FUNCTION void list_nodes(int group, std::uint32_t bits, int& count) {
    const int left = t_.nodes - group * width;
    if (left < width) bits &= (1u << left) - 1u;
    for (; bits != 0; bits &= bits - 1) {
      RA2D_CHECK(count < t_.nodes);
      if (lanes_.leader()) s_.watch[count] = group * width + Kokkos::countr_zero(bits);
      ++count;
    }
  }

  /// Bounds on what the modes can do within a number of steps.
  struct Bounds {
    double rounding;      // of a displacement
    double speed;         // sum max|psi| |V|
    double acceleration;  // A of the header
    double curvature;     // A + B
    double yield;  // 1/kg, acceleration that a newton of contact force can add, as in the header
  };

  KOKKOS_FUNCTION Bounds bounds(const Real* u, const Real* v, int steps) const {
    const double time = steps * t_.step;
    Real energy[K], acceleration[K], rate[K], displacement[K], yield[K];
    for (int p = 0; p < K; ++p) {
      const Real omega = load(t_.omega, p), push = load(t_.push, p);
      const Real stretch = omega * u[p];
      energy[p] = Kokkos::sqrt(multiply_add(v[p], v[p], stretch * stretch));
      acceleration[p] = multiply_add(load(t_.pull, p), multiply_add(time, push, energy[p]), push);
      rate[p] = multiply_add(time, acceleration[p], Kokkos::abs(v[p]));
      displacement[p] = multiply_add(time, rate[p], Kokkos::abs(u[p]));
      yield[p] = load(t_.yield, p) * multiply_add(time, load(t_.pull, p), Real(1.0));
    }
    Bounds b;
    b.rounding = rounding(steps) * bound(t_.largest_shape, displacement);
    b.speed = bound(t_.largest_shape, v);
    b.acceleration = bound(t_.largest_shape, acceleration);
    const double speed = t_.advance * t_.spacing / t_.step;
    b.curvature = b.acceleration + 2.0 * speed * bound(t_.largest_slope, rate) +
                  speed * speed * bound(t_.largest_curvature, displacement);
    b.yield = bound(t_.largest_shape, yield);
    return b;
  }

  /// Steps until the slider's nodes stand `edge` behind the resonator's, at the most `longest`;
  /// less than one when they get there within this step.
  KOKKOS_FUNCTION int steps_to(double edge, const Place& place, int longest) const {
    if (t_.advance == 0.0) return longest;
    // short of the crossing by a step and by the roundings of the position
    const double steps = (edge - place.theta - position_rounding(place)) / t_.advance - 1.0;
    return steps > longest ? longest : steps < 1.0 ? 0 : static_cast<int>(steps);
  }

  /// Finds the groups that can touch. The reach is what the modes can be expected to travel until a
  /// node passes another.
  KOKKOS_FUNCTION void find_near(const Real* u, const Real* v, const Place& place) {
    const int left = steps_to(1.0, place, t_.longest_look), steps = left < 1 ? 1 : left;
    const double time = steps * t_.step;
    const Bounds b = bounds(u, v, steps);
    // an earlier stage of this step may stand further back
    const double back = t_.stages > 1 ? Kokkos::min(place.theta, t_.advance) : 0.0;
    near_.find(u, place, 2.0 * (b.speed * time + 0.5 * b.curvature * time * time) + t_.least_reach,
               b.rounding, back);
  }
};

}  // namespace ra2d
