// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidate_groups.hpp"
#include "kernels/check.hpp"
#include "kernels/displacement.hpp"
#include "kernels/function.hpp"
#include "kernels/group_sweep.hpp"
#include "kernels/lanes.hpp"
#include "kernels/limits.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// Which nodes can come into contact, and for how long none can. A node is left out if, and only
/// if, it provably cannot.
///
/// Flight: at the present state the overlap o of a node and its rate along the straight line U + t
/// V are known. In free flight the modes depart from that line by at most A t^2/2 with
///
///   A = sum_k max|psi_k| (p_k (E_k + t a_k) + a_k),   E_k^2 = V_k^2 + omega_k^2 U_k^2,
///
/// where p_k (MotionLimits::acceleration_per_energy_norm) follows from the scheme's step, for
/// backward Euler (1 + 2 zeta) omega_k at the most, and a_k (outer_acceleration) from the outer
/// forces and the step. host/model/step_bounds.hpp shows that this holds for a number of steps, at
/// all their stages, of stable and unstable schemes. The path of the node over the deflected beam
/// adds the curvature B = 2 V sum_k max|psi_k'| |V_k| + V^2 sum_k max|psi_k''| |U_k|. So no contact
/// begins before the smallest root of o + rate t + (A + B) t^2/2 = 0. Until then the march flies:
/// it advances the modes, nothing else.
///
/// Listed nodes: when that time is too short, the march evaluates a list of nodes at every step. It
/// holds all nodes that could come into contact within N steps while the modes stay within a margin
/// rho of their line. While they do, the contact force is at most f = kappa chi w sum_n max(0,
/// overlap_n on the line + rho). So they depart from the line by at most (A + f (n + j t)) t^2/2,
/// where n (acceleration_per_newton) bounds sum_k |psi_k(x) psi_k(y)| n_k at any two places, n_k
/// being 1/m_k times the step's own factor, and j (jerk_per_newton) the same sum with p_k n_k. N is
/// the last step at which this is still within rho. Forces that are found with the end of the step
/// (Form::implicit) have no such bound, and with many modes it ends a list long before the forces
/// do: there the march sums the forces of the steps so far. Where the list would
/// not have covered a step, the march repeats it and searches for the nodes in contact.
///
/// Search: where neither is safe, the march searches for the nodes in contact at every state.
///
/// Kept lists: with many modes these bounds are wide and a forecast costs as much as many steps.
/// Where steps are long, or squares of nodes make listed nodes cheap (CandidateLists::kept),
/// nothing is forecast. A list holds on a way that was chosen, while the modes stay within its
/// margin of their line, and the march asks for that at every state: how far they are off it now is
/// bounded by the polynomials of the footprint (Footprint::most). The margin is what they have
/// needed of late.
///
/// All of them evaluate only groups of nodes that can come into contact
/// (kernels/candidate_groups.hpp).
///
/// Every comparison has a slack for the roundings: of the faces, of the position, of sums over the
/// modes and of the steps ahead.
namespace ra2d {

/// Steps for which nodes are listed, if nothing ends the list earlier.
inline constexpr int most_listed_steps = 256;
/// A shorter flight is not worth its forecast: evaluating listed nodes costs less.
inline constexpr int shortest_flight = 24;
/// Kept lists: making one costs about as much as evaluating so many nodes. From runs of
/// bench_areal's cases with gautschi: 10 to 30 are about as good, 80 takes a third longer.
inline constexpr double bearable_evaluations = 25;
/// Under Form::implicit: with more nodes than this, a search at every state costs less than a
/// list.
inline constexpr int most_listed_nodes = 48;
/// Bound on the rounding of a displacement, relative to sum max|psi_k| |U_k|: of a sum of
/// polynomials over the modes, and one rounding of U_k for every step ahead. Twice the rounding of
/// one sum over most_modes, for the displacement is compared with another such sum.
KOKKOS_INLINE_FUNCTION double rounding(int steps) { return (256 + steps) * 0x1p-52; }

/// Bound on the rounding of an overlap's sum over the modes [m], and of the displacement `u`
/// itself: of what the forces make of `free`, roundings of the larger of the two are left.
template <class Lanes, int packs>
KOKKOS_INLINE_FUNCTION double displacement_rounding(const Lanes& lanes, const MotionLimits& bounds,
                                                    const typename Lanes::Real* u,
                                                    const typename Lanes::Real* free) {
  using Real = typename Lanes::Real;
  Real part(0.0);
  for (int p = 0; p < filled<packs>(lanes); ++p)
    part = multiply_add(lanes.load(bounds.largest_shape + p * Lanes::width),
                        Kokkos::abs(u[p]) + Kokkos::abs(free[p]), part);
  return rounding(0) * lanes.sum(part);
}

/// Whether lists can be kept.
template <class Lanes, int packs>
inline constexpr bool keeps_lists = packs* Lanes::width > 64 && Lanes::width <= square_nodes;

/// Where contact can begin in the next steps: nowhere (flight), at listed nodes alone (listed), or
/// anywhere (search: for contact at every state anew).
struct ContactForecast {
  enum Kind { flight, listed, search } kind;
  int steps;  // for which it holds at the most
  int count;  // listed nodes, in WorkSpace::listed_nodes
  /// The list covers step n as long as the departure of the modes from their line, over the margin,
  ///
  ///   free_departure n (n + 1) + departure_per_newton sum_{j<n} (n - j) f_j
  ///
  /// is at most 1. f_j is the contact force [N] of step j.
  double free_departure = 0, departure_per_newton = 0;
};

template <class Lanes, int packs>
class Candidates {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  /// Lists nodes in `listed_nodes`; `evaluated` counts gaps. `amplitudes`: work space.
  RA2D_FUNCTION Candidates(const Lanes& lanes, const ModeTables& modes, const SliderMotion& motion,
                           const FaceTables& faces, const SliderShapes& slider,
                           const PatchTables& patches, const ContactTables& contact,
                           const SchemeWeights& scheme, const MotionLimits& bounds,
                           CandidateLists& lists, double* amplitudes, int* listed_nodes,
                           std::int64_t& evaluated)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        faces_{faces},
        slider_{slider},
        patches_{patches},
        contact_{contact},
        scheme_{scheme},
        bounds_{bounds},
        amplitudes_{amplitudes},
        listed_nodes_{listed_nodes},
        lists_{lists},
        most_listed_{lists.most_listed},
        evaluated_{evaluated},
        groups_{lanes, motion, faces, slider, patches, bounds, lists, amplitudes, evaluated} {}

  /// Forecasts contact from the state at `step` on, no further than step `next`. `last_force` [N],
  /// of the latest contact, serves as a guess of the forces on listed nodes.
  RA2D_FUNCTION ContactForecast forecast_contact(const Real* u, const Real* v, std::int64_t step,
                                                 std::int64_t next, double last_force) {
    const Place place(motion_, step);
    int longest = steps_to(1.0, place, bounds_.valid_steps);
    if (longest < 1) {  // a node passes another within this step
      if (evaluates_later_states()) return {ContactForecast::search, 1, 0};
      longest = 1;
    }
    // no further than is of use: bounds of more steps are wider
    std::int64_t horizon = next - step;
    if (horizon < longest) longest = static_cast<int>(horizon);
    const double tau = motion_.time_step;
    const Bounds b = bounds(place, u, v, longest);

    // the candidate groups must hold for all states up to then
    int listed_steps = steps_of_list(place, longest);
    const bool short_of_window = listed_steps < 1;
    if (short_of_window) listed_steps = 1;
    const double listed_time = listed_steps * tau;
    // what is expected of free motion and of the usual force, and a fifth more
    const double margin = 0.6 * listed_time * listed_time *
                              (b.acceleration + b.acceleration_per_newton * last_force) +
                          0.5 * listed_time * tau * b.acceleration + bounds_.least_margin;
    const double listed_travel = b.speed * listed_time + margin;
    double travelled = groups_.travelled(u, place);
    if (!groups_.holds(place, travelled, listed_travel)) {
      find_groups(u, v, place);
      travelled = 0.0;
    }
    const double remaining = groups_.range() - travelled;
    if (remaining < listed_travel) {
      aim_at(aimed_steps_ / 2);
      return {ContactForecast::search, 1, 0};  // too fast: step by step
    }

    const double half_curve = 0.5 * b.curvature * tau * tau;
    // A node is not listed if it stays free along the line, with the margin and its own motion.
    Slack slack = slack_of(b, u, v, place, half_curve);
    if (faces_.smooth) [[unlikely]]  // a cell may be closed where its ends are not
      slack.overlap +=
          modes_sag<Lanes, packs>(lanes_, faces_, bounds_, u, listed_travel + remaining);
    // the modes' own departure is in the margin
    const double half_path = 0.5 * (b.curvature - b.acceleration) * tau * tau;
    const double level = -(margin + half_path * listed_steps * listed_steps + slack.overlap);
    int count = 0;
    last_listed_ = -1;
    Real pressed(0.0);
    double flight = faces_.smooth
                        ? steps_to_contact<true>(u, v, place, longest, listed_steps, half_curve,
                                                 slack, level, count, pressed)
                        : steps_to_contact<false>(u, v, place, longest, listed_steps, half_curve,
                                                  slack, level, count, pressed);
    // the list of candidate groups may end the flight earlier
    const double valid_steps = steps_of_travel(b.speed * tau + half_curve, half_curve, remaining);
    if (valid_steps < flight) flight = valid_steps;
    if (!(flight >= 0.0)) flight = 0.0;  // the state is not a number
    if (flight >= shortest_flight || count == 0 || flight >= longest) {
      int steps = flight >= longest ? longest : static_cast<int>(flight);
      if (count == 0 && steps < listed_steps)
        steps = listed_steps;  // no node to list: the same as a flight
      if (steps < 1 && evaluates_later_states()) return {ContactForecast::search, 1, 0};
      return {ContactForecast::flight, steps < 1 ? 1 : steps, 0};
    }
    if (scheme_.form == Form::implicit && count > most_listed_nodes) {
      aim_at(aimed_steps_ / 2);
      return {ContactForecast::search, 1, 0};
    }
    const ContactForecast forecast =
        forecast_of_list(b, listed_steps, short_of_window, count, margin, pressed);
    aim_at(2 * forecast.steps);
    return forecast;
  }

  /// Where lists are kept (CandidateLists::kept): the number of nodes in `listed_nodes` if they are
  /// all that can be in contact at the state u, else -1.
  RA2D_FUNCTION int kept_list(const Real* u, const Place& place) {
    const double gone = place.position - line_.position, time = line_.time_per_chi * gone;
    if (line_.count < 0 || place.base != line_.base ||
        !(gone >= -line_.back && gone <= line_.distance))
      return -1;
    Real away[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      away[p] = multiply_add(-time, load_pack(lanes_, lists_.line_v, p),
                             u[p] - load_pack(lanes_, lists_.line_u, p));
    const double most = line_.margin - rounding(0) * bound(bounds_.largest_shape, u);
    // a bound that is wide and costs a tenth does at the beginning of a list
    if (bound(bounds_.largest_shape, away) <= most) return line_.count;
    const double departure = Footprint<Lanes, packs>(lanes_, bounds_).most(place, away);
    if (const double longer = Kokkos::abs(time) + motion_.time_step; motion_.advance > 0.0)
      acceleration_ = Kokkos::max(acceleration_, departure / (longer * longer));
    return departure <= most ? line_.count : -1;
  }
  /// Lists the nodes that come into contact while the modes stay within a margin of their line, U +
  /// t V: on so long a way that evaluating those that stay open costs about as much as the list,
  /// and no further than to the end of the spacing. Returns their number; they may be more than
  /// there is room for (has_room).
  RA2D_FUNCTION int keep_list(const Real* u, const Real* v, const Place& place) {
    const double tau = motion_.time_step, advance = motion_.advance;
    if (line_.count >= 0)
      aim_at(open_evaluations_ > bearable_evaluations ? 3 * aimed_steps_ / 4
                                                      : 5 * aimed_steps_ / 4 + 1);
    const bool moves = advance > 0.0;
    const double left = moves ? (1.0 - place.theta) / advance + 1.0 : 1e300,
                 steps = left < aimed_steps_ ? Kokkos::ceil(left) : aimed_steps_,
                 time = steps * tau;
    const Bounds b = bounds(place, u, v, static_cast<int>(steps));
    // a fifth more than of late; without a way there is no line
    acceleration_ = Kokkos::max(acceleration_, 1e-3 * b.acceleration);
    const double margin = 1.2 * acceleration_ * time * time + bounds_.least_margin +
                          2.0 * b.rounding + (moves ? 0.0 : b.speed * time);
    acceleration_ *= 0.8;
    const double travel = b.speed * time + margin;
    // an earlier stage of this step may stand further back
    const double back = scheme_.stages > 1 ? Kokkos::min(place.theta, advance) : 0.0;
    if (!groups_.holds(u, place, travel))
      groups_.find(u, place, 2.0 * travel + bounds_.least_range, b.rounding, back);
    line_ = {place.position, steps * advance, back, moves ? tau / advance : 0.0,
             margin,         place.base,      0};
    lanes_.sync();
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(lists_.line_u + p * width, u[p]);
      lanes_.store(lists_.line_v + p * width, v[p]);
    }
    lanes_.sync();
    const double half_curve = 0.5 * b.curvature * tau * tau,
                 half_path = 0.5 * (b.curvature - b.acceleration) * tau * tau;
    const Slack slack = slack_of(b, u, v, place, half_curve);
    const double level = -(margin + half_path * steps * steps + slack.overlap);
    GroupSweep<Lanes, packs> sweep(lanes_, faces_, slider_, patches_, place, amplitudes_, u, v);
    const double steps_back = moves ? back / advance : 0.0;
    int count = 0, closed = 0;
    for (int e = 0; e < groups_.count(); ++e) {
      const auto [overlap, modes, slope] = sweep.overlap_and_rates(groups_[e]);
      const Real rate = moves ? multiply_add(tau, modes, Real(advance) * slope) : Real(0.0),
                 slow(slack.closing);  // a step
      const Real ahead = Real(steps) * (rate + slow), behind = Real(steps_back) * (slow - rate);
      const Real most = overlap + Kokkos::max(Kokkos::max(ahead, behind), Real(0.0));
      const std::uint32_t bits = lanes_.at_least(most, level);
      if (bits == 0) continue;
      list_nodes(groups_[e], nodes_left(faces_, groups_[e], width), bits, count);
      closed += Kokkos::Experimental::popcount_builtin(lanes_.at_least(overlap, 0.0));
    }
    if (lanes_.leader()) evaluated_ += static_cast<std::int64_t>(groups_.count()) * width;
    lanes_.sync();
    line_.count = count;
    open_evaluations_ = (count - closed) * steps;
    return count;
  }
  KOKKOS_FORCEINLINE_FUNCTION void drop_list() { line_.count = -1; }

  /// Whether so many nodes could be listed. In plane scenes all can.
  KOKKOS_FORCEINLINE_FUNCTION bool has_room(int count) const { return count <= most_listed_; }

  /// Whether a step evaluates the contact at a state later than its beginning.
  KOKKOS_FORCEINLINE_FUNCTION bool evaluates_later_states() const {
    return scheme_.stages > 1 || scheme_.form == Form::implicit;
  }

  /// Lists in `listed_nodes` every node in contact at the present state, and perhaps a few that
  /// miss contact by a rounding. Evaluates all nodes or the candidate groups, as the scene says.
  /// They may be more than there is room for (has_room).
  RA2D_FUNCTION int find_contacts(const Real* u, const Real* v, const Place& place) {
    const bool all = bounds_.searched == Nodes::all;
    line_.count = -1;
    if (!all && !groups_.holds(u, place, 0.0)) find_groups(u, v, place);
    double level = -(faces_.rounding + rounding(0) * bound(bounds_.largest_shape, u) +
                     bound(bounds_.cubic_remainder, u));
    if (faces_.smooth) [[unlikely]]
      level -= modes_sag<Lanes, packs>(lanes_, faces_, bounds_, u, 0.0);
    GroupSweep<Lanes, packs> sweep(lanes_, faces_, slider_, patches_, place, amplitudes_, u);
    int count = 0;
    last_listed_ = -1;
    const int groups = all ? faces_.groups : groups_.count();
    for (int e = 0; e < groups; ++e) {
      const int group = all ? e : groups_[e];
      const Real overlap = sweep.overlap(group).overlap;
      if (!faces_.smooth) [[likely]] {
        if (const std::uint32_t bits = lanes_.at_least(overlap, level); bits != 0)
          list_nodes(group, nodes_left(faces_, group, width), bits, count);
      } else {
        list_cells(group, overlap, cell_sag(lanes_, faces_, place, group), level, count);
      }
    }
    lanes_.sync();
    return count;
  }

 private:
  Lanes lanes_;
  const ModeTables& modes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  const ContactTables& contact_;
  const SchemeWeights& scheme_;
  const MotionLimits& bounds_;
  double* amplitudes_;
  int* listed_nodes_;
  const CandidateLists& lists_;
  int most_listed_;
  std::int64_t& evaluated_;
  CandidateGroups<Lanes, packs> groups_;
  int last_listed_ = -1;  // smooth faces: the latest cell
  // where lists are kept: the present one
  struct {
    // chi: where it begins, how far it goes, and how far back
    double position = 0, distance = 0, back = 0;
    double time_per_chi = 0;   // s
    double margin = 0;         // m
    int base = 0, count = -1;  // Place::base; nodes, -1: there is no list
  } line_;
  double acceleration_ = 0;      // half the largest off the line of late, m/s^2
  double open_evaluations_ = 0;  // nodes not in contact when it was made, times its steps
  // Areal scenes: steps that the next list is for. A list for more holds nodes so far from contact
  // that the bound on their forces ends it sooner. The first list of a launch is for few
  // steps: of bodies that move, one for many would hold nearly all nodes, and so would the
  // candidate groups, for long.
  int aimed_steps_ = 16;

  KOKKOS_FORCEINLINE_FUNCTION void aim_at(int steps) {
    constexpr int least = 4;
    aimed_steps_ = steps < least ? least : steps > most_listed_steps ? most_listed_steps : steps;
  }
  KOKKOS_FORCEINLINE_FUNCTION double bound(const double* weight, const Real* x) const {
    return weighted_sum<Lanes, packs>(lanes_, weight, x);
  }
  /// Lists the nodes of a group whose bits are set. The last group of a row, with `left` nodes, is
  /// padded with nodes that do not exist. They lie low, but a motion that diverges, or is not a
  /// number, would reach them.
  KOKKOS_FORCEINLINE_FUNCTION void list_nodes(int group, int left, std::uint32_t bits, int& count) {
    if (left < width) bits &= (1u << left) - 1u;
    for (; bits != 0; bits &= bits - 1)
      list(group * width + Kokkos::Experimental::countr_zero_builtin(bits), count);
  }
  /// Smooth faces: lists the cells beside the nodes of a group whose overlap may reach `level`.
  /// `ends`: bounds on the overlaps at the nodes, `sag` as cell_sag.
  RA2D_FUNCTION void list_cells(int group, const Real& ends, const Real& sag, double level,
                                int& count) {
    const std::uint32_t inside = lanes_.at_least(most_in_cells(lanes_, ends, sag), level);
    list_cells_of<width>(faces_, group, inside, lanes_.at_least(ends + sag, level), [&](int cell) {
      if (cell <= last_listed_ || !is_cell(faces_, cell)) return;
      last_listed_ = cell;
      list(cell, count);
    });
  }
  KOKKOS_FORCEINLINE_FUNCTION void list(int node, int& count) {
    if (lanes_.leader() && count < most_listed_) listed_nodes_[count] = node;
    ++count;
  }

  /// Bounds on what the modes can do within a number of steps.
  struct Bounds {
    double rounding;                 // of a displacement
    double speed;                    // sum max|psi| |V|
    double acceleration;             // A of the header
    double curvature;                // A + B
    double acceleration_per_newton;  // 1/kg, of contact force, as in the header
  };

  /// Allowances of the bounds: for roundings, and for what the cubics leave out.
  struct Slack {
    double overlap;  // m
    double closing;  // m, a step
  };
  RA2D_FUNCTION Slack slack_of(const Bounds& b, const Real* u, const Real* v, const Place& place,
                               double half_curve) const {
    return {faces_.rounding + b.rounding + bound(bounds_.cubic_remainder, u) +
                position_rounding(place) * faces_.steepest_rise + 2.0 * half_curve,
            motion_.time_step * bound(bounds_.cubic_remainder, v) +
                motion_.advance * motion_.spacing * bound(bounds_.cubic_slope_remainder, u) +
                2.0 * half_curve};
  }

  /// Steps for which no node of the candidate groups comes into contact, `longest` at the most:
  /// until the gap is closed by the closing speed, the curvature and what the cubics leave out.
  /// Lists the nodes whose overlap may exceed `level` within `listed_steps`; `pressed`: the sum of
  /// what they may exceed it by [m].
  template <bool smooth>
  KOKKOS_FORCEINLINE_FUNCTION double steps_to_contact(const Real* u, const Real* v,
                                                      const Place& place, int longest,
                                                      int listed_steps, double half_curve,
                                                      const Slack& slack, double level, int& count,
                                                      Real& pressed) {
    const double tau = motion_.time_step;
    GroupSweep<Lanes, packs> sweep(lanes_, faces_, slider_, patches_, place, amplitudes_, u, v);
    Real soonest(static_cast<double>(longest));
    for (int e = 0; e < groups_.count(); ++e) {
      const int group = groups_[e];
      auto [overlap, modes, slope] = sweep.overlap_and_rates(group);
      // closing per step: the modes, and the node's path over the resonator's face
      Real closing =
          multiply_add(tau, modes, multiply_add(motion_.advance, slope, Real(slack.closing)));
      Real curve(half_curve), sag(0.0);
      if constexpr (smooth) {  // the curvature of the path, with the slacks that it takes
        const Real lift = Real(0.5 * motion_.advance * motion_.advance) *
                          PiecePassed<Lanes>(lanes_, faces_, place, group).upward();
        curve = curve + lift;
        closing = multiply_add(2.0, lift, closing);
        overlap = multiply_add(2.0, lift, overlap);
        sag = cell_sag(lanes_, faces_, place, group);
      }
      Real most =
          multiply_add(static_cast<double>(listed_steps), Kokkos::max(closing, Real(0.0)), overlap);
      if constexpr (smooth) {
        most = multiply_add(static_cast<double>(listed_steps) * listed_steps,
                            curve - Real(half_curve), most);
        list_cells(group, most, sag, level, count);
        most = most + sag;
        overlap = overlap + sag;
      } else {
        if (const std::uint32_t bits = lanes_.at_least(most, level); bits != 0)
          list_nodes(group, nodes_left(faces_, group, width), bits, count);
      }
      pressed = pressed + Kokkos::max(most - Real(level), Real(0.0));
      // the root of open = i closing + i (i + 1) half_curve
      const Real open = Kokkos::max(-overlap - Real(slack.overlap), Real(0.0));
      const Real linear = closing + curve;
      const Real root =
          Kokkos::sqrt(multiply_add(linear, linear, Real(4.0) * curve * open)) + linear;
      soonest = Kokkos::min(soonest, Real(2.0) * open / (root + Real(1e-300)));
    }
    if (lanes_.leader()) evaluated_ += static_cast<std::int64_t>(groups_.count()) * width;
    lanes_.sync();
    return groups_.count() > 0 ? lanes_.min(soonest) : longest;
  }

  /// Steps for which the listed nodes hold: as long as forces and modes cannot move a node by more
  /// than the margin off its line.
  KOKKOS_FORCEINLINE_FUNCTION ContactForecast forecast_of_list(const Bounds& b, int listed_steps,
                                                               bool short_of_window, int count,
                                                               double margin,
                                                               const Real& pressed) const {
    const double tau = motion_.time_step;
    double acceleration = b.acceleration;  // off the line
    ContactForecast forecast{ContactForecast::listed, listed_steps, count};
    if (scheme_.form == Form::implicit) {
      forecast.free_departure = 0.5 * b.acceleration * tau * tau / margin;
      forecast.departure_per_newton = b.acceleration_per_newton * tau * tau / margin;
    } else {
      // a cell is pressed by no more than the two nodes at its ends
      const double per_node =
          faces_.smooth ? 2.0 * contact_.node_stiffness : contact_.node_stiffness;
      acceleration += b.acceleration_per_newton * per_node * lanes_.sum(pressed);
    }
    const double lasting = Kokkos::sqrt(2.0 * margin / (acceleration + 1e-300)) / tau - 1.0;
    if (!(lasting >= listed_steps))
      forecast.steps = !(lasting >= 1.0) ? 0 : static_cast<int>(lasting);
    if (forecast.steps < 1 || short_of_window) {
      if (evaluates_later_states()) return {ContactForecast::search, 1, 0};
      forecast.steps = 1;  // the list always covers the first step: the line begins there
    }
    return forecast;
  }

  RA2D_FUNCTION Bounds bounds(const Place& place, const Real* u, const Real* v, int steps) const {
    const double time = steps * motion_.time_step;
    Real energy[packs], acceleration[packs], rate[packs], displacement[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real outer = load_pack(lanes_, bounds_.outer_acceleration, p);
      const Real per_norm = load_pack(lanes_, bounds_.acceleration_per_energy_norm, p);
      const Real stretch = load_pack(lanes_, modes_.omega, p) * u[p];
      energy[p] = Kokkos::sqrt(multiply_add(v[p], v[p], stretch * stretch));
      acceleration[p] = multiply_add(per_norm, multiply_add(time, outer, energy[p]), outer);
      rate[p] = multiply_add(time, acceleration[p], Kokkos::abs(v[p]));
      displacement[p] = multiply_add(time, rate[p], Kokkos::abs(u[p]));
    }
    Bounds b;
    b.rounding = rounding(steps) * bound(bounds_.largest_shape, displacement);
    b.speed = Footprint<Lanes, packs>(lanes_, bounds_).most(place, v);
    b.acceleration = bound(bounds_.largest_shape, acceleration);
    const double speed = motion_.advance * motion_.spacing / motion_.time_step;
    b.curvature = b.acceleration + 2.0 * speed * bound(bounds_.largest_slope, rate) +
                  speed * speed * bound(bounds_.largest_curvature, displacement);
    b.acceleration_per_newton =
        Kokkos::fma(time, bounds_.jerk_per_newton, bounds_.acceleration_per_newton);
    return b;
  }

  /// Steps over which a list of nodes is to hold: no further than the window.
  KOKKOS_FORCEINLINE_FUNCTION int steps_of_list(const Place& place, int longest) const {
    const bool is_areal = faces_.rows.across != nullptr;
    int steps = steps_to((place.part + 1) * motion_.window_width, place,
                         is_areal ? aimed_steps_ : most_listed_steps);
    return longest < steps ? longest : steps;
  }
  /// The n with linear n + half_curve n^2 = travel, or a little less.
  KOKKOS_FORCEINLINE_FUNCTION static double steps_of_travel(double linear, double half_curve,
                                                            double travel) {
    return 2.0 * travel /
           (Kokkos::sqrt(linear * linear + 4.0 * half_curve * travel) + linear + 1e-300);
  }
  /// Steps until the slider's nodes stand `edge` [chi] behind the resonator's, at the most
  /// `longest`; less than one when they get there within this step.
  RA2D_FUNCTION int steps_to(double edge, const Place& place, int longest) const {
    if (motion_.advance == 0.0) return longest;
    // one step less than to the crossing, and less the roundings of the position
    const double steps = (edge - place.theta - position_rounding(place)) / motion_.advance - 1.0;
    return steps > longest ? longest : steps < 1.0 ? 0 : static_cast<int>(steps);
  }

  /// Finds the candidate groups. They hold for the travel that can be expected of the modes until a
  /// node passes another.
  RA2D_FUNCTION void find_groups(const Real* u, const Real* v, const Place& place) {
    // Areal scenes have more modes, of which the bounds are wide, and wider nodes: over all that
    // time most of the groups would be candidates. There they serve for two lists of nodes.
    int left = steps_to(1.0, place, bounds_.valid_steps);
    if (faces_.rows.across != nullptr && left > 2 * aimed_steps_) left = 2 * aimed_steps_;
    const int steps = left < 1 ? 1 : left;
    const double time = steps * motion_.time_step;
    const Bounds b = bounds(place, u, v, steps);
    // an earlier stage of this step may stand further back
    const double back = scheme_.stages > 1 ? Kokkos::min(place.theta, motion_.advance) : 0.0;
    groups_.find(u, place,
                 2.0 * (b.speed * time + 0.5 * b.curvature * time * time) + bounds_.least_range,
                 b.rounding, back);
  }
};

}  // namespace ra2d
