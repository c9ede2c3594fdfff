// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/check.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// How the search for the contact forces of a step ended: found; no motion of the modes keeps the
/// bodies apart; more nodes carry force than there is room for, or than a list of nodes is good
/// for; or the launch is to end (is_interrupted), and nothing has been done.
enum class Solution { solved, blocked, crowded, interrupted };

/// Contact forces that are found together with the end of the step: Lagrange multipliers (paper,
/// section 3, equation 11), and the penalty spring at the new time.
///
/// A step without contact ends at U*. Contact forces f_n that are held over the step add -b_k sum_n
/// f_n phi_nk to mode k, b_k = U1 of a unit force (SceneTables::receptance). With the overlap o_n =
/// -g_n at the end of the step, o* without contact, and W_nm = sum_k b_k phi_nk phi_mk:
///
///   0 <= f_n,   o_n = o*_n - sum_m W_nm f_m <= compliance f_n,   and f_n > 0 only where both
///   agree.
///
/// With compliance 0 these are Signorini's conditions at the end of the step: no penetration, no
/// adhesion, force only where the bodies touch. With compliance 1/(kappa chi w) it is the penalty
/// law, f = kappa chi w max(0, o), of the new time; so penalty with growing kappa is the
/// multiplier.
///
/// W is positive semidefinite and of the rank of the modes at the most: of more nodes than modes,
/// or of modes that do not tell two nodes apart, the f_n are not unique, but U1 is. It is the state
/// without penetration that is nearest to U* in the metric 1/b, and the dual active set method of
/// Goldfarb and Idnani (Math. Programming 27, 1983) goes there in steps that are all unique: take
/// the node that penetrates most; raise its force until it is clear; where that would turn another
/// node's force negative, that node is let go first, and where the new node depends on those that
/// carry force already (the Cholesky factor's next pivot vanishes), it takes one's place. At the
/// most as many nodes as modes carry force. Nodes that touch without force never come in.
///
/// Every node taken in moves U1 further from U*, so no set of nodes can come twice and the method
/// ends; roundings are kept from turning it in circles by a bound of `rounds` on the work, which is
/// several times what is ever seen. When no motion of the modes keeps the bodies apart (a rigid
/// slider pressed onto few modes from both sides of a vibration node), the method finds that, too.
///
/// From step to step the same one or two nodes mostly carry the force: they are tried first, and
/// taken when their forces are positive and nothing else overlaps, which are all the conditions
/// there are.
///
/// Each node that comes in costs the square of how many there are, so n of them n^3. On springs
/// (compliance > 0) there may be thousands, where faces lie flat on one another: from `many` on
/// Newton's method in the modes takes over (newton()), whose steps cost the nodes times the square
/// of the modes. It goes to the same end, which is unique there.
///
/// What is left: overlaps of the order of the roundings of a gap (SceneTables::touch) and, where
/// that is not to be had, of the modes' sums.
///
/// An impact of a mass. Coming from a distance theta tau |V| (0 <= theta < 1), without force for
/// the rest of the step it would penetrate. Backward Euler and midpoint (U1 = U0 + tau V1) leave it
/// on the face and stop it in the next step: nothing comes back. The one-step schemes that hold the
/// force (exact, Heun, RK4, RK8: U1 of a force is tau/2 times V1 of it) leave with V1 = -(1 - 2
/// theta) V: the share (1 - 2 theta)^2 of the energy, anything from 0 to 1, on average a third, and
/// no limit for tau -> 0. No scheme gains energy from it; in lasting contact Heun may
/// (kernels/schemes/heun.hpp).
template <class Lanes, int K>
class Complementarity {
  using Real = typename Lanes::Real;

 public:
  KOKKOS_FUNCTION Complementarity(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                                  const NodeContact<Lanes, K>& contact)
      : lanes_{lanes}, t_{tables}, s_{state}, contact_{contact} {}

  /// Tries the nodes that carried force at the end of the step before, one or two. True when they
  /// are the answer.
  template <class List>
  KOKKOS_FORCEINLINE_FUNCTION bool resume(const Place& place, Real* u, Real* v, const List& list,
                                          ContactTotals<Real>& totals, double& most) {
    const int count = s_.contact_nodes;
    if (count < 1 || count > 2) return false;
    const int first = s_.contact_pair[0], second = count > 1 ? s_.contact_pair[1] : first;
    contact_.expand(place, s_.contact_pair, count);
    Real phi[K], slope[K], weighted[K], other[K], other_slope[K];
    contact_.shapes(first, place.offset, phi, slope);
    for (int p = 0; p < K; ++p) weighted[p] = receptance(p) * phi[p];
    const double own = yielding(weighted, phi) + t_.compliance;
    const double over = contact_.overlap(first, place.theta, phi, u);
    double force = over / own, other_force = 0.0;
    if (count > 1) {
      contact_.shapes(second, place.offset, other, other_slope);
      const double across = yielding(weighted, other);
      for (int p = 0; p < K; ++p) weighted[p] = receptance(p) * other[p];
      const double other_own = yielding(weighted, other) + t_.compliance;
      const double other_over = contact_.overlap(second, place.theta, other, u);
      const double share = across / own, pivot = other_own - share * across;
      if (!(pivot > 1e-6 * other_own)) return false;  // leave it to the careful way
      other_force = (other_over - share * over) / pivot;
      force -= share * other_force;
      if (!(other_force > 0.0)) return false;
    }
    if (!(force > 0.0 && force < never)) return false;
    Real push[K], now[K];
    for (int p = 0; p < K; ++p) {
      push[p] = Real(force) * phi[p];
      if (count > 1) push[p] = multiply_add(other_force, other[p], push[p]);
      now[p] = multiply_add(-receptance(p), push[p], u[p]);
    }
    most = force + other_force;
    const int nodes = list(now);
    for (int e = 0; e < nodes; ++e) {
      const int node = s_.watch[e];
      if (node == first || node == second) continue;
      Real at[K];
      contact_.shape(node, place.offset, at);
      if (contact_.overlap(node, place.theta, at, now) > t_.touch) return false;
    }
    totals.touched = count;
    totals.force = most;
    totals.climb = force * contact_.rise(first) + other_force * contact_.rise(second);
    for (int p = 0; p < K; ++p) {
      Real bend = Real(force) * slope[p];
      if (count > 1) bend = multiply_add(other_force, other_slope[p], bend);
      totals.bend = multiply_add(bend, now[p], totals.bend);
      u[p] = now[p];
      v[p] = multiply_add(-lanes_.load(t_.mobility + p * Lanes::width), push[p], v[p]);
    }
    lanes_.sync();
    if (lanes_.leader()) {
      s_.touched[0] = first;
      s_.touched_force[0] = force;
      if (count > 1) {
        s_.touched[1] = second;
        s_.touched_force[1] = other_force;
      }
    }
    lanes_.sync();
    return true;
  }

  /// More than any force or way.
  static constexpr double never = 1e300;
  /// Nodes that carry force from which on newton() finds the forces, in a step or in the one
  /// before.
  static constexpr int many = 256;
  /// Relative size of a pivot at which a node counts as depending on those that carry force.
  static constexpr double dependent = 1e-13;

  /// Finds the contact forces of a step: corrects its end (u, v), lists in the state's work space
  /// the nodes that carry force, in ascending order. `list(u)` gives the number of nodes to look
  /// at, listed in the state's `watch` and expanded: all that overlap at u must be among them.
  /// `most` is the largest total force [N] on the way, not less than what it comes with. `step`
  /// ends at `place`. `anywhere`: whether `list` is good for any u; if not, many nodes are left to
  /// a caller whose list is (crowded).
  template <class List>
  KOKKOS_FORCEINLINE_FUNCTION Solution operator()(const Place& place, std::int64_t step, Real* u,
                                                  Real* v, const List& list,
                                                  ContactTotals<Real>& totals, double& most,
                                                  bool anywhere = true) {
    if (s_.contact_step == step - 1) {
      if (resume(place, u, v, list, totals, most)) return Solution::solved;
      if (t_.compliance > 0.0 && s_.contact_nodes > many)
        return anywhere ? newton(place, u, v, list, totals, most) : Solution::crowded;
    }
    return seek(place, u, v, list, totals, most, anywhere);
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  const NodeContact<Lanes, K>& contact_;
  int count_ = 0;        // nodes that carry force
  bool let_go_ = false;  // some no longer do since the forces were settled

  /// The careful way, from no force on.
  template <class List>
  KOKKOS_FUNCTION Solution seek(const Place& place, Real* u, Real* v, const List& list,
                                ContactTotals<Real>& totals, double& most, bool anywhere) {
    Real now[K];
    for (int p = 0; p < K; ++p) now[p] = u[p];
    count_ = 0;
    let_go_ = false;
    Solution result = Solution::solved;
    const int rounds = 64 + 8 * t_.nodes;
    double wide = 0.0;
    for (int round = 0;; ++round) {
      const int nodes = list(now);
      double over = t_.touch + wide;
      const int worst = most_overlapping(place, now, nodes, over);
      if (worst < 0) break;
      if (t_.compliance > 0.0 && count_ == many) {
        release();
        return anywhere ? newton(place, u, v, list, totals, most) : Solution::crowded;
      }
      if (round % 16 == 15 && is_interrupted(t_)) {
        result = Solution::interrupted;
        break;
      }
      result = round < rounds ? press(place, worst, over) : Solution::blocked;
      if (result != Solution::solved) break;
      if (count_ > 1 || let_go_) settle(place, u);
      let_go_ = false;
      end_of(place, u, now);
      const double sum = total();
      if (sum > most) most = sum;
      // roundings of the modes' sums are rarely met, and could otherwise turn in circles
      if (round == 4) wide = rounding_of(now, u);
    }
    if (result == Solution::solved && count_ > 0) finish(place, u, v, totals);
    release();
    return result;
  }

  KOKKOS_FUNCTION void release() {
    for (int j = 0; j < count_; ++j)
      if (lanes_.leader()) s_.pressed_place[s_.pressed[j]] = -1;
    lanes_.sync();
    count_ = 0;
  }

  // ---- many nodes on springs

  /// With u = U* + D w, D = sqrt(b), the end of the step is where the convex function
  ///
  ///   E(w) = w^2/2 + sum_n max(0, o_n(u))^2 / (2 compliance)
  ///
  /// is least: its slope is w + D sum_n f_n phi_n, f_n = max(0, o_n)/compliance. E is quadratic as
  /// long as the same nodes overlap, so Newton's step with those goes to the end at once, or is
  /// shortened until E falls (Armijo). It ends after two steps in a row that move no overlap by
  /// more than the roundings of a gap or of the modes' sums: after the first, nodes may have come
  /// to touch or let go by as much.
  template <class List>
  KOKKOS_FUNCTION Solution newton(const Place& place, Real* u, Real* v, const List& list,
                                  ContactTotals<Real>& totals, double& most) {
    constexpr int rows = K * Lanes::width, rounds = 200, halvings = 40;
    if (s_.pressed_capacity < (rows > many ? rows : many)) return Solution::crowded;
    Real d[K], w[K], now[K], slope[K], next[K], at[K], next_slope[K];
    for (int p = 0; p < K; ++p) {
      d[p] = Kokkos::sqrt(receptance(p));
      w[p] = Real(0.0);
      now[p] = u[p];
    }
    bool rests = false;
    int nodes = list(now);
    double energy = descend(place, now, nodes, d, w, slope, most);
    for (int round = 0; round < rounds; ++round) {
      if (is_interrupted(t_)) return Solution::interrupted;
      solve_newton(place, now, nodes, d, slope, next);
      Real part = slope[0] * next[0];
      for (int p = 1; p < K; ++p) part = multiply_add(slope[p], next[p], part);
      const double fall = lanes_.sum(part);
      double share = 1.0;
      for (int half = 0; half < halvings; ++half, share *= 0.5) {
        Real to[K];
        for (int p = 0; p < K; ++p) {
          to[p] = multiply_add(share, next[p], w[p]);
          at[p] = multiply_add(d[p], to[p], u[p]);
        }
        nodes = list(at);
        const double there = descend(place, at, nodes, d, to, next_slope, most);
        // the second is what roundings do to sums of squares
        if (there <= energy + 1e-4 * share * fall + 1e-13 * energy || half + 1 == halvings) {
          energy = there;
          for (int p = 0; p < K; ++p) w[p] = to[p];
          break;
        }
      }
      Real moved(0.0);
      for (int p = 0; p < K; ++p) {
        moved = multiply_add(lanes_.load(t_.largest_shape + p * Lanes::width),
                             Kokkos::abs(at[p] - now[p]), moved);
        now[p] = at[p];
        slope[p] = next_slope[p];
      }
      const bool rested = rests;
      rests = lanes_.sum(moved) <= t_.touch + rounding_of(now, u);
      if (!rests || !rested) continue;
      list_touching(place, now, nodes, totals);
      end_step(place, u, v, totals);
      return Solution::solved;
    }
    return Solution::blocked;
  }

  /// E at w, where the modes are at `now`, and its slope. `most` learns of the forces there.
  KOKKOS_FUNCTION double descend(const Place& place, const Real* now, int nodes, const Real* d,
                                 const Real* w, Real* slope, double& most) const {
    const double stiffness = 1.0 / t_.compliance;
    Real phi[K], square = w[0] * w[0];
    for (int p = 0; p < K; ++p) slope[p] = Real(0.0);
    for (int p = 1; p < K; ++p) square = multiply_add(w[p], w[p], square);
    double work = 0.0, force = 0.0;
    for (int e = 0; e < nodes; ++e) {
      contact_.shape(s_.watch[e], place.offset, phi);
      const double over = contact_.overlap(s_.watch[e], place.theta, phi, now);
      if (!(over > 0.0)) continue;
      const double f = stiffness * over;
      work += f * over;
      force += f;
      for (int p = 0; p < K; ++p) slope[p] = multiply_add(f, phi[p], slope[p]);
    }
    for (int p = 0; p < K; ++p) slope[p] = multiply_add(d[p], slope[p], w[p]);
    if (force > most) most = force;
    return 0.5 * (lanes_.sum(square) + work);
  }

  /// Newton's step from a slope: with the nodes that overlap at `now` it solves
  /// (I + D sum_n phi_n phi_n^T D / compliance) step = -slope.
  KOKKOS_FUNCTION void solve_newton(const Place& place, const Real* now, int nodes, const Real* d,
                                    const Real* slope, Real* step) {
    constexpr int width = Lanes::width, rows = K * width;
    const double stiffness = 1.0 / t_.compliance;
    lanes_.sync();
    for (int i = 0; i < rows; ++i)
      for (int p = 0; p < K; ++p) lanes_.store(&factor(i, p * width), Real(0.0));
    for (int p = 0; p < K; ++p) lanes_.store(s_.share + p * width, -slope[p]);
    for (int e = 0; e < nodes; ++e) {
      Real phi[K];
      contact_.shape(s_.watch[e], place.offset, phi);
      if (!(contact_.overlap(s_.watch[e], place.theta, phi, now) > 0.0)) continue;
      lanes_.sync();
      for (int p = 0; p < K; ++p) {
        phi[p] = d[p] * phi[p];
        lanes_.store(s_.across + p * width, phi[p]);
      }
      lanes_.sync();
      for (int i = 0; i < rows; ++i) {
        const double left = stiffness * s_.across[i];
        if (left == 0.0) continue;  // of a lane without a mode
        for (int p = 0; p < K; ++p)
          lanes_.store(&factor(i, p * width),
                       multiply_add(left, phi[p], lanes_.load(&factor(i, p * width))));
      }
    }
    lanes_.sync();
    count_ = rows;
    if (lanes_.leader()) {
      for (int i = 0; i < rows; ++i)  // Cholesky; the eigenvalues are 1 and more
        for (int j = 0; j <= i; ++j) {
          double sum = factor(i, j) + (i == j ? 1.0 : 0.0);
          for (int l = 0; l < j; ++l) sum -= factor(i, l) * factor(j, l);
          factor(i, j) = i == j ? Kokkos::sqrt(sum) : sum / factor(j, j);
        }
      solve_lower();
      solve_upper();
    }
    count_ = 0;
    lanes_.sync();
    for (int p = 0; p < K; ++p) step[p] = lanes_.load(s_.share + p * width);
    lanes_.sync();
  }

  /// The nodes that carry force where the modes are at `now`.
  KOKKOS_FUNCTION void list_touching(const Place& place, const Real* now, int nodes,
                                     ContactTotals<Real>& totals) {
    Real phi[K];
    totals.touched = 0;
    lanes_.sync();
    for (int e = 0; e < nodes; ++e) {
      const int node = s_.watch[e];
      contact_.shape(node, place.offset, phi);
      const double over = contact_.overlap(node, place.theta, phi, now);
      if (!(over > 0.0)) continue;
      if (lanes_.leader()) {
        s_.touched[totals.touched] = node;
        s_.touched_force[totals.touched] = over / t_.compliance;
      }
      ++totals.touched;
    }
    lanes_.sync();
  }

  KOKKOS_FORCEINLINE_FUNCTION Real receptance(int p) const {
    return lanes_.load(t_.receptance + p * Lanes::width);
  }
  KOKKOS_FORCEINLINE_FUNCTION double& factor(int row, int column) const {
    return s_.factor[static_cast<std::int64_t>(row) * s_.pressed_capacity + column];
  }

  /// Bound on the rounding of an overlap's sum over the modes [m], and of the displacement `u`
  /// itself: of what the forces make of `free`, roundings of the larger of the two are left.
  KOKKOS_FUNCTION double rounding_of(const Real* u, const Real* free) const {
    Real part(0.0);
    for (int p = 0; p < K; ++p)
      part = multiply_add(lanes_.load(t_.largest_shape + p * Lanes::width),
                          Kokkos::abs(u[p]) + Kokkos::abs(free[p]), part);
    return rounding(0) * lanes_.sum(part);
  }

  /// The node that overlaps most, by more than `over`, among those without force; or -1.
  KOKKOS_FUNCTION int most_overlapping(const Place& place, const Real* u, int nodes,
                                       double& over) const {
    int worst = -1;
    for (int e = 0; e < nodes; ++e) {
      const int node = s_.watch[e];
      if (s_.pressed_place[node] >= 0) continue;
      Real phi[K];
      contact_.shape(node, place.offset, phi);
      const double overlap = contact_.overlap(node, place.theta, phi, u);
      if (!(overlap > over)) continue;
      over = overlap;
      worst = node;
    }
    return worst;
  }

  /// W_nm plus, for a node with itself, the compliance.
  KOKKOS_FUNCTION double yielding(const Real* weighted, const Real* phi) const {
    Real part = weighted[0] * phi[0];
    for (int p = 1; p < K; ++p) part = multiply_add(weighted[p], phi[p], part);
    return lanes_.sum(part);
  }

  /// share = L^-1 share and share = L^-T share, L the factor; one lane.
  KOKKOS_FUNCTION void solve_lower() const {
    for (int i = 0; i < count_; ++i) {
      for (int j = 0; j < i; ++j) s_.share[i] -= factor(i, j) * s_.share[j];
      s_.share[i] /= factor(i, i);
    }
  }
  KOKKOS_FUNCTION void solve_upper() const {
    for (int i = count_ - 1; i >= 0; --i) {
      for (int j = i + 1; j < count_; ++j) s_.share[i] -= factor(j, i) * s_.share[j];
      s_.share[i] /= factor(i, i);
    }
  }

  /// Raises the force on `node` until its overlap `over` is gone, lets go what would have to pull.
  KOKKOS_FUNCTION Solution press(const Place& place, int node, double over) {
    Real weighted[K], phi[K];
    contact_.shape(node, place.offset, phi);
    for (int p = 0; p < K; ++p) weighted[p] = receptance(p) * phi[p];
    const double own = yielding(weighted, phi) + t_.compliance;
    for (int j = 0; j < count_; ++j) {
      contact_.shape(s_.pressed[j], place.offset, phi);
      const double w = yielding(weighted, phi);
      if (lanes_.leader()) s_.across[j] = w;
    }
    lanes_.sync();
    double force = 0.0;
    for (;;) {
      // the pivot that the node would bring, and what the others give up for a newton on it
      if (lanes_.leader()) {
        for (int j = 0; j < count_; ++j) s_.share[j] = s_.across[j];
        solve_lower();
      }
      lanes_.sync();
      double pivot = own;
      for (int j = 0; j < count_; ++j) pivot -= s_.share[j] * s_.share[j];
      const bool full = count_ == s_.pressed_capacity;
      const bool depends = !(pivot > dependent * own) || !(own > t_.least_yielding) ||
                           (full && t_.compliance == 0.0);
      const double clear = depends ? never : over / pivot;
      if (count_ > 0) {
        lanes_.sync();
        if (lanes_.leader()) {
          for (int j = 0; j < count_; ++j) factor(count_, j) = s_.share[j];  // its row, if it comes
          solve_upper();
        }
        lanes_.sync();
      }
      double most = never;
      int first = -1;
      for (int j = 0; j < count_; ++j) {
        if (!(s_.share[j] > 0.0)) continue;
        const double until = s_.pressed_force[j] / s_.share[j];
        if (!(until < most)) continue;
        most = until;
        first = j;
      }
      if (first < 0 && !(clear < never)) return Solution::blocked;
      const double more = clear < most ? clear : most;
      lanes_.sync();
      if (lanes_.leader())
        for (int j = 0; j < count_; ++j) {
          const double left = s_.pressed_force[j] - more * s_.share[j];
          s_.pressed_force[j] = left > 0.0 ? left : 0.0;
        }
      lanes_.sync();
      force += more;
      if (clear <= most) {
        if (full) return Solution::crowded;
        if (lanes_.leader()) {
          RA2D_CHECK(count_ < s_.pressed_capacity);
          s_.pressed[count_] = node;
          s_.pressed_force[count_] = force;
          s_.pressed_place[node] = count_;
          factor(count_, count_) = Kokkos::sqrt(pivot);
        }
        ++count_;
        lanes_.sync();
        return Solution::solved;
      }
      if (!depends) over -= more * pivot;
      let_go(place, first);
    }
  }

  /// Takes a node out, and factors what is left anew from there on.
  KOKKOS_FUNCTION void let_go(const Place& place, int out) {
    let_go_ = true;
    lanes_.sync();
    if (lanes_.leader()) {
      s_.pressed_place[s_.pressed[out]] = -1;
      for (int j = out; j + 1 < count_; ++j) {
        s_.pressed[j] = s_.pressed[j + 1];
        s_.pressed_force[j] = s_.pressed_force[j + 1];
        s_.pressed_place[s_.pressed[j]] = j;
        s_.across[j] = s_.across[j + 1];
      }
    }
    --count_;
    lanes_.sync();
    Real phi[K], weighted[K];
    for (int i = out; i < count_; ++i) {
      contact_.shape(s_.pressed[i], place.offset, weighted);
      for (int p = 0; p < K; ++p) weighted[p] = receptance(p) * weighted[p];
      for (int j = 0; j <= i; ++j) {
        contact_.shape(s_.pressed[j], place.offset, phi);
        double w = yielding(weighted, phi);
        if (j == i) w += t_.compliance;
        for (int l = 0; l < j; ++l) w -= factor(i, l) * factor(j, l);
        w = j == i ? Kokkos::sqrt(w > 0.0 ? w : 0.0) : w / factor(j, j);
        lanes_.sync();
        if (lanes_.leader()) factor(i, j) = w;
        lanes_.sync();
      }
    }
  }

  /// Takes out of the forces what roundings have left in them: solves for what the overlaps at the
  /// end of the step still miss. A node whose force that would turn negative is let go: with its
  /// force merely cut off at zero, nodes that depend on it all but for roundings would keep what it
  /// was to take from them.
  KOKKOS_FUNCTION void settle(const Place& place, const Real* free) {
    for (int pass = 0; pass < 3;) {
      Real now[K], phi[K];
      end_of(place, free, now);
      double worst = 0.0;
      for (int j = 0; j < count_; ++j) {
        contact_.shape(s_.pressed[j], place.offset, phi);
        const double missing = contact_.overlap(s_.pressed[j], place.theta, phi, now) -
                               t_.compliance * s_.pressed_force[j];
        if (lanes_.leader()) s_.share[j] = missing;
        const double size = missing < 0.0 ? -missing : missing;
        if (size > worst) worst = size;
      }
      lanes_.sync();
      if (!(worst > t_.touch)) return;
      if (lanes_.leader()) {
        solve_lower();
        solve_upper();
      }
      lanes_.sync();
      double way = 1.0;
      int first = -1;
      for (int j = 0; j < count_; ++j) {
        if (!(s_.pressed_force[j] + s_.share[j] < 0.0)) continue;
        const double until = -s_.pressed_force[j] / s_.share[j];
        if (first >= 0 && !(until < way)) continue;
        way = until;
        first = j;
      }
      lanes_.sync();
      if (lanes_.leader())
        for (int j = 0; j < count_; ++j) {
          const double corrected = s_.pressed_force[j] + way * s_.share[j];
          s_.pressed_force[j] = corrected > 0.0 ? corrected : 0.0;
        }
      lanes_.sync();
      if (first < 0)
        ++pass;
      else
        let_go(place, first);
    }
  }

  /// Displacement at the end of the step under the present forces.
  KOKKOS_FUNCTION void end_of(const Place& place, const Real* free, Real* u) const {
    Real push[K], phi[K];
    for (int p = 0; p < K; ++p) push[p] = Real(0.0);
    for (int j = 0; j < count_; ++j) {
      contact_.shape(s_.pressed[j], place.offset, phi);
      const Real f(s_.pressed_force[j]);
      for (int p = 0; p < K; ++p) push[p] = multiply_add(f, phi[p], push[p]);
    }
    for (int p = 0; p < K; ++p) u[p] = multiply_add(-receptance(p), push[p], free[p]);
  }

  KOKKOS_FUNCTION double total() const {
    double sum = 0.0;
    for (int j = 0; j < count_; ++j) sum += s_.pressed_force[j];
    return sum;
  }

  /// The end of the step, and the record of the nodes that carry force.
  KOKKOS_FUNCTION void finish(const Place& place, Real* u, Real* v, ContactTotals<Real>& totals) {
    lanes_.sync();
    if (lanes_.leader()) {
      int touched = 0;
      for (int j = 0; j < count_; ++j) {  // in ascending order
        if (!(s_.pressed_force[j] > 0.0)) continue;
        int at = touched++;
        for (; at > 0 && s_.touched[at - 1] > s_.pressed[j]; --at) {
          s_.touched[at] = s_.touched[at - 1];
          s_.touched_force[at] = s_.touched_force[at - 1];
        }
        s_.touched[at] = s_.pressed[j];
        s_.touched_force[at] = s_.pressed_force[j];
      }
    }
    lanes_.sync();
    for (int j = 0; j < count_; ++j) totals.touched += s_.pressed_force[j] > 0.0 ? 1 : 0;
    end_step(place, u, v, totals);
  }

  /// The end of the step under the forces of the nodes that are listed as touching.
  KOKKOS_FUNCTION void end_step(const Place& place, Real* u, Real* v, ContactTotals<Real>& totals) {
    Real push[K], bend[K], phi[K], slope[K];
    for (int p = 0; p < K; ++p) push[p] = bend[p] = Real(0.0);
    for (int e = 0; e < totals.touched; ++e) {
      const int node = s_.touched[e];
      const double f = s_.touched_force[e];
      contact_.shapes(node, place.offset, phi, slope);
      for (int p = 0; p < K; ++p) {
        push[p] = multiply_add(f, phi[p], push[p]);
        bend[p] = multiply_add(f, slope[p], bend[p]);
      }
      totals.climb = Kokkos::fma(f, contact_.rise(node), totals.climb);
      totals.force += f;
    }
    for (int p = 0; p < K; ++p) {
      u[p] = multiply_add(-receptance(p), push[p], u[p]);
      v[p] = multiply_add(-lanes_.load(t_.mobility + p * Lanes::width), push[p], v[p]);
    }
    for (int p = 0; p < K; ++p) totals.bend = multiply_add(bend[p], u[p], totals.bend);
  }
};

}  // namespace ra2d
