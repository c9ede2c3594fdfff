// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/contact/active_forces.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Contact forces that are found together with the end of the step: Lagrange multipliers (paper,
/// section 3, equation 11), and the penalty spring at the new time.
///
/// A step without contact ends at U*. Contact forces f_n that are held over the step add -b_k sum_n
/// f_n phi_nk to mode k, b_k = U1 of a unit force (ContactTables::receptance). With the overlap o_n
/// = -g_n at the end of the step, o* without contact, and W_nm = sum_k b_k phi_nk phi_mk:
///
///   0 <= f_n,   o_n = o*_n - sum_m W_nm f_m <= compliance f_n,   and f_n > 0 only where both
///   agree.
///
/// With compliance 0 these are Signorini's conditions at the end of the step: no penetration, no
/// adhesion, force only where the bodies touch. With compliance 1/(kappa chi w) it is the penalty
/// law, f = kappa chi w max(0, o), of the new time; so penalty with growing kappa is the
/// multiplier.
///
/// W is positive semidefinite, and its rank is that of the modes at the most. With more nodes than
/// modes, or nodes that the modes cannot distinguish, the f_n are not unique, but U1 is. It is the
/// state without penetration that is nearest to U* in the metric 1/b. The dual active set method of
/// Goldfarb and Idnani (Math. Programming 27, 1983) reaches it in steps that are all unique: take
/// the node that penetrates most and raise its force until it is clear. A node whose force this
/// would turn negative leaves the active set first. Where the new node depends on those in the set
/// (the Cholesky factor's next pivot vanishes), it takes the place of one of them. At the most as
/// many nodes as modes carry force. Nodes in contact without force never enter the set.
///
/// Every node that enters moves U1 further from U*, so no active set comes twice and the method
/// ends. Roundings could make it cycle: `rounds` bounds the work, at a multiple of what was ever
/// seen. Where no motion of the modes keeps the bodies apart (a rigid slider pressed onto few modes
/// from both sides of a vibration node), the method finds that, too.
///
/// From step to step the same one or two nodes mostly carry the force. They are tried first, and
/// accepted when their forces are positive and no other node overlaps: there are no other
/// conditions.
///
/// With n nodes in the set the next one costs n^2, so all of them n^3. On springs (compliance > 0)
/// there may be thousands, where faces lie flat on one another. From `many` on Newton's method in
/// the modes takes over (newton()), whose steps cost the nodes times the square of the modes. It
/// finds the same end of the step, which is unique there.
///
/// The solution leaves small overlaps: as large as the rounding error of a gap
/// (ContactTables::tolerance). Where that cannot be reached, they are as large as the rounding
/// error of the sums over the modes.
///
/// An impact of a mass. Coming from a distance theta tau |V| (0 <= theta < 1), without force for
/// the rest of the step it would penetrate. Backward Euler and midpoint (U1 = U0 + tau V1) leave it
/// on the face and stop it in the next step: nothing comes back. The one-step schemes that hold the
/// force (exact, Heun, RK4, RK8: U1 of a force is tau/2 times V1 of it) leave with V1 = -(1 - 2
/// theta) V: the share (1 - 2 theta)^2 of the energy, anything from 0 to 1, on average a third, and
/// no limit for tau -> 0. No scheme gains energy from it; in lasting contact Heun may
/// (kernels/schemes/heun.hpp).
template <class Lanes, int packs>
class Complementarity {
  using Real = typename Lanes::Real;

  /// The nodes as points of the active set.
  class Nodes {
   public:
    using Point = int;
    RA2D_FUNCTION Nodes(const Lanes& lanes, const NodeContact<Lanes, packs>& node_contact,
                        ActiveSet& active, int* active_index)
        : lanes_{lanes},
          node_contact_{node_contact},
          active_{active},
          active_index_{active_index} {}

    KOKKOS_FORCEINLINE_FUNCTION void shape(const Place& place, int node, Real* phi) const {
      node_contact_.shape(node, place.offset, phi);
    }
    KOKKOS_FORCEINLINE_FUNCTION void active_shape(const Place& place, int j, Real* phi) const {
      node_contact_.shape(active_.nodes[j], place.offset, phi);
    }
    KOKKOS_FORCEINLINE_FUNCTION double active_overlap(const Place& place, int j, const Real* phi,
                                                      const Real* u) const {
      return node_contact_.overlap(active_.nodes[j], place.theta, phi, u);
    }
    KOKKOS_FORCEINLINE_FUNCTION void put(const Place&, int j, int node) const {
      if (!lanes_.leader()) return;
      active_.nodes[j] = node;
      active_index_[node] = j;
    }
    KOKKOS_FORCEINLINE_FUNCTION void move(int from, int to) const {
      if (!lanes_.leader()) return;
      active_.nodes[to] = active_.nodes[from];
      active_index_[active_.nodes[to]] = to;
    }
    KOKKOS_FORCEINLINE_FUNCTION void leave(int j) const {
      if (lanes_.leader()) active_index_[active_.nodes[j]] = -1;
    }

   private:
    Lanes lanes_;
    NodeContact<Lanes, packs> node_contact_;
    ActiveSet& active_;
    int* active_index_;
  };

 public:
  /// `listed_nodes`: see operator(). `interrupted`: SceneTables::interrupted.
  RA2D_FUNCTION Complementarity(const Lanes& lanes, const FaceTables& faces,
                                const ContactTables& contact, const MotionLimits& bounds,
                                const NodeContact<Lanes, packs>& node_contact,
                                const LatestContact& latest, int* active_index, ActiveSet& active,
                                ContactList& contact_list, const int* listed_nodes,
                                const int* interrupted)
      : lanes_{lanes},
        faces_{faces},
        contact_{contact},
        bounds_{bounds},
        node_contact_{node_contact},
        latest_contact_{latest},
        active_index_{active_index},
        active_{active},
        forces_{lanes, contact, active, Nodes(lanes, node_contact, active, active_index)},
        contact_list_{contact_list},
        listed_nodes_{listed_nodes},
        interrupted_{interrupted} {}

  /// Tries the nodes that carried force at the end of the step before, one or two. True when they
  /// are the answer.
  template <class List>
  KOKKOS_FORCEINLINE_FUNCTION bool resume(const Place& place, Real* u, Real* v, const List& list,
                                          ContactTotals<Real>& totals, double& most) {
    const int count = latest_contact_.nodes;
    if (count < 1 || count > 2) return false;
    const int first = latest_contact_.pair[0], second = count > 1 ? latest_contact_.pair[1] : first;
    if (!node_contact_.expand(place, latest_contact_.pair, count)) return false;
    Real phi[packs], slope[packs], weighted[packs], other[packs], other_slope[packs];
    node_contact_.shapes(first, place.offset, phi, slope);
    for (int p = 0; p < filled<packs>(lanes_); ++p) weighted[p] = receptance(p) * phi[p];
    const double own = forces_.compliance_of(weighted, phi) + contact_.compliance;
    const double over = node_contact_.overlap(first, place.theta, phi, u);
    double force = over / own, other_force = 0.0;
    if (count > 1) {
      node_contact_.shapes(second, place.offset, other, other_slope);
      const double coupling = forces_.compliance_of(weighted, other);
      for (int p = 0; p < filled<packs>(lanes_); ++p) weighted[p] = receptance(p) * other[p];
      const double other_own = forces_.compliance_of(weighted, other) + contact_.compliance;
      const double other_over = node_contact_.overlap(second, place.theta, other, u);
      const double share = coupling / own, pivot = other_own - share * coupling;
      if (!(pivot > 1e-6 * other_own)) return false;  // seek() is more careful
      other_force = (other_over - share * over) / pivot;
      force -= share * other_force;
      if (!(other_force > 0.0)) return false;
    }
    if (!(force > 0.0 && force < never)) return false;
    Real force_on_modes[packs], now[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      force_on_modes[p] = Real(force) * phi[p];
      if (count > 1) force_on_modes[p] = multiply_add(other_force, other[p], force_on_modes[p]);
      now[p] = multiply_add(-receptance(p), force_on_modes[p], u[p]);
    }
    most = force + other_force;
    const int nodes = list(now);
    if (nodes < 0 || !others_stay_open(place, now, first, second, nodes)) return false;
    totals.nodes = count;
    totals.force = most;
    totals.face_work = force * node_contact_.rise(first) + other_force * node_contact_.rise(second);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real slope_force = Real(force) * slope[p];
      if (count > 1) slope_force = multiply_add(other_force, other_slope[p], slope_force);
      totals.deflection_work = multiply_add(slope_force, now[p], totals.deflection_work);
      u[p] = now[p];
      v[p] =
          multiply_add(-lanes_.load(contact_.mobility + p * Lanes::width), force_on_modes[p], v[p]);
    }
    lanes_.sync();
    if (lanes_.leader()) {
      contact_list_.nodes[0] = first;
      contact_list_.forces[0] = force;
      if (count > 1) {
        contact_list_.nodes[1] = second;
        contact_list_.forces[1] = other_force;
      }
    }
    lanes_.sync();
    return true;
  }

  static constexpr double never = ActiveForces<Lanes, packs, Nodes>::never;
  /// Nodes that carry force from which on newton() finds the forces, in a step or in the one
  /// before.
  static constexpr int many = 256;
  /// Finds the contact forces of a step: corrects its end (u, v), lists in the state's work space
  /// the nodes that carry force, in ascending order. `list(u)` expands the nodes to evaluate, lists
  /// them in `listed_nodes` and returns their number: all that overlap at u must be among them. A
  /// negative number: there is no room for them, the answer is `crowded`.
  /// `most` becomes the largest total force [N] at any stage of the search, if it was less. `step`
  /// ends at `place`. `anywhere`: whether `list` is good for any u; if not, the answer with many
  /// nodes is `crowded`: repeat it with a list that is.
  template <class List>
  KOKKOS_FORCEINLINE_FUNCTION Solution operator()(const Place& place, std::int64_t step, Real* u,
                                                  Real* v, const List& list,
                                                  ContactTotals<Real>& totals, double& most,
                                                  bool anywhere = true) {
    if (latest_contact_.step == step - 1) {
      if (resume(place, u, v, list, totals, most)) return Solution::solved;
      if (contact_.compliance > 0.0 && latest_contact_.nodes > many)
        return anywhere ? newton(place, u, v, list, totals, most) : Solution::crowded;
    }
    return seek(place, u, v, list, totals, most, anywhere);
  }

 private:
  Lanes lanes_;
  const FaceTables& faces_;
  const ContactTables& contact_;
  const MotionLimits& bounds_;
  NodeContact<Lanes, packs> node_contact_;
  const LatestContact& latest_contact_;
  int* active_index_;
  ActiveSet& active_;
  ActiveForces<Lanes, packs, Nodes> forces_;
  ContactList& contact_list_;
  const int* listed_nodes_;
  const int* interrupted_;

  /// The active set method, from no force on.
  template <class List>
  RA2D_FUNCTION Solution seek(const Place& place, Real* u, Real* v, const List& list,
                              ContactTotals<Real>& totals, double& most, bool anywhere) {
    Real now[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) now[p] = u[p];
    Solution result = Solution::solved;
    const int rounds = 64 + 8 * faces_.nodes;
    double wide = 0.0;
    for (int round = 0;; ++round) {
      const int nodes = list(now);
      if (nodes < 0) {
        result = Solution::crowded;
        break;
      }
      double over = contact_.tolerance + wide;
      const int worst = most_overlapping(place, now, nodes, over);
      if (worst < 0) break;
      if (contact_.compliance > 0.0 && forces_.count() == many) {
        forces_.clear();
        return anywhere ? newton(place, u, v, list, totals, most) : Solution::crowded;
      }
      if (round % 16 == 15 && is_interrupted(interrupted_)) {
        result = Solution::interrupted;
        break;
      }
      result = round < rounds ? forces_.activate(place, worst, over) : Solution::blocked;
      if (result != Solution::solved) break;
      forces_.settle_after_change(place, u);
      forces_.end_of(place, u, now);
      const double sum = forces_.total();
      if (sum > most) most = sum;
      // roundings of the modes' sums are rarely met, and could otherwise turn in circles
      if (round == 4) wide = displacement_rounding<Lanes, packs>(lanes_, bounds_, now, u);
    }
    if (result == Solution::solved && forces_.count() > 0) finish(place, u, v, totals);
    forces_.clear();
    return result;
  }

  // ---- many nodes on springs

  /// With u = U* + D w, D = sqrt(b), the end of the step is where the convex function
  ///
  ///   E(w) = w^2/2 + sum_n max(0, o_n(u))^2 / (2 compliance)
  ///
  /// is least: its slope is w + D sum_n f_n phi_n, f_n = max(0, o_n)/compliance. E is quadratic as
  /// long as the same nodes overlap, so Newton's step with those goes to the end at once, or is
  /// shortened until E falls (Armijo). It ends after two steps in a row that move no overlap by
  /// more than the roundings of a gap or of the modes' sums: after the first, contacts may
  /// have begun or ended by as much.
  template <class List>
  RA2D_FUNCTION Solution newton(const Place& place, Real* u, Real* v, const List& list,
                                ContactTotals<Real>& totals, double& most) {
    constexpr int rows = packs * Lanes::width, rounds = 200, halvings = 40;
    if (active_.capacity < (rows > many ? rows : many)) return Solution::crowded;
    Real d[packs], w[packs], now[packs], slope[packs], next[packs], at[packs], next_slope[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      d[p] = Kokkos::sqrt(receptance(p));
      w[p] = Real(0.0);
      now[p] = u[p];
    }
    bool rests = false;
    int nodes = list(now);
    if (nodes < 0) return Solution::crowded;
    double energy = descend(place, now, nodes, d, w, slope, most);
    for (int round = 0; round < rounds; ++round) {
      if (is_interrupted(interrupted_)) return Solution::interrupted;
      solve_newton(place, now, nodes, d, slope, next);
      Real part = slope[0] * next[0];
      for (int p = 1; p < filled<packs>(lanes_); ++p) part = multiply_add(slope[p], next[p], part);
      const double fall = lanes_.sum(part);
      double share = 1.0;
      for (int half = 0; half < halvings; ++half, share *= 0.5) {
        Real to[packs];
        for (int p = 0; p < filled<packs>(lanes_); ++p) {
          to[p] = multiply_add(share, next[p], w[p]);
          at[p] = multiply_add(d[p], to[p], u[p]);
        }
        nodes = list(at);
        if (nodes < 0) return Solution::crowded;
        const double there = descend(place, at, nodes, d, to, next_slope, most);
        // the second is what roundings do to sums of squares
        if (there <= energy + 1e-4 * share * fall + 1e-13 * energy || half + 1 == halvings) {
          energy = there;
          for (int p = 0; p < filled<packs>(lanes_); ++p) w[p] = to[p];
          break;
        }
      }
      Real moved(0.0);
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        moved = multiply_add(lanes_.load(bounds_.largest_shape + p * Lanes::width),
                             Kokkos::abs(at[p] - now[p]), moved);
        now[p] = at[p];
        slope[p] = next_slope[p];
      }
      const bool rested = rests;
      rests = lanes_.sum(moved) <=
              contact_.tolerance + displacement_rounding<Lanes, packs>(lanes_, bounds_, now, u);
      if (!rests || !rested) continue;
      list_contacts(place, now, nodes, totals);
      end_step(place, u, v, totals);
      return Solution::solved;
    }
    return Solution::blocked;
  }

  /// E at w, where the modes are at `now`, and its slope. `most` learns of the forces there.
  RA2D_FUNCTION double descend(const Place& place, const Real* now, int nodes, const Real* d,
                               const Real* w, Real* slope, double& most) const {
    const double stiffness = 1.0 / contact_.compliance;
    Real phi[packs], square = w[0] * w[0];
    for (int p = 0; p < filled<packs>(lanes_); ++p) slope[p] = Real(0.0);
    for (int p = 1; p < filled<packs>(lanes_); ++p) square = multiply_add(w[p], w[p], square);
    double work = 0.0, force = 0.0;
    for (int e = 0; e < nodes; ++e) {
      node_contact_.shape(listed_nodes_[e], place.offset, phi);
      const double over = node_contact_.overlap(listed_nodes_[e], place.theta, phi, now);
      if (!(over > 0.0)) continue;
      const double f = stiffness * over;
      work += f * over;
      force += f;
      for (int p = 0; p < filled<packs>(lanes_); ++p) slope[p] = multiply_add(f, phi[p], slope[p]);
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p) slope[p] = multiply_add(d[p], slope[p], w[p]);
    if (force > most) most = force;
    return 0.5 * (lanes_.sum(square) + work);
  }

  /// Newton's step from a slope: with the nodes that overlap at `now` it solves
  /// (I + D sum_n phi_n phi_n^T D / compliance) step = -slope.
  RA2D_FUNCTION void solve_newton(const Place& place, const Real* now, int nodes, const Real* d,
                                  const Real* slope, Real* step) {
    constexpr int width = Lanes::width;
    const int rows = filled<packs>(lanes_) * width;
    const double stiffness = 1.0 / contact_.compliance;
    lanes_.sync();
    for (int i = 0; i < rows; ++i)
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        lanes_.store(&factor(i, p * width), Real(0.0));
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      lanes_.store(active_.solution + p * width, -slope[p]);
    for (int e = 0; e < nodes; ++e) {
      Real phi[packs];
      node_contact_.shape(listed_nodes_[e], place.offset, phi);
      if (!(node_contact_.overlap(listed_nodes_[e], place.theta, phi, now) > 0.0)) continue;
      lanes_.sync();
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        phi[p] = d[p] * phi[p];
        lanes_.store(active_.coupling + p * width, phi[p]);
      }
      lanes_.sync();
      for (int i = 0; i < rows; ++i) {
        const double left = stiffness * active_.coupling[i];
        if (left == 0.0) continue;  // of a lane without a mode
        for (int p = 0; p < filled<packs>(lanes_); ++p)
          lanes_.store(&factor(i, p * width),
                       multiply_add(left, phi[p], lanes_.load(&factor(i, p * width))));
      }
    }
    lanes_.sync();
    if (lanes_.leader()) {
      for (int i = 0; i < rows; ++i)  // Cholesky; the eigenvalues are 1 and more
        for (int j = 0; j <= i; ++j) {
          double sum = factor(i, j) + (i == j ? 1.0 : 0.0);
          for (int l = 0; l < j; ++l) sum -= factor(i, l) * factor(j, l);
          factor(i, j) = i == j ? Kokkos::sqrt(sum) : sum / factor(j, j);
        }
      solve_lower(active_, rows);
      solve_upper(active_, rows);
    }
    lanes_.sync();
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      step[p] = lanes_.load(active_.solution + p * width);
    lanes_.sync();
  }

  /// The nodes that carry force where the modes are at `now`.
  RA2D_FUNCTION void list_contacts(const Place& place, const Real* now, int nodes,
                                   ContactTotals<Real>& totals) {
    Real phi[packs];
    totals.nodes = 0;
    lanes_.sync();
    for (int e = 0; e < nodes; ++e) {
      const int node = listed_nodes_[e];
      node_contact_.shape(node, place.offset, phi);
      const double over = node_contact_.overlap(node, place.theta, phi, now);
      if (!(over > 0.0)) continue;
      if (lanes_.leader()) {
        contact_list_.nodes[totals.nodes] = node;
        contact_list_.forces[totals.nodes] = over / contact_.compliance;
      }
      ++totals.nodes;
    }
    lanes_.sync();
  }

  KOKKOS_FORCEINLINE_FUNCTION Real receptance(int p) const {
    return lanes_.load(contact_.receptance + p * Lanes::width);
  }
  KOKKOS_FORCEINLINE_FUNCTION double& factor(int row, int column) const {
    return active_.factor[static_cast<std::int64_t>(row) * active_.capacity + column];
  }

  /// The node that overlaps most, by more than `over`, among those without force; or -1.
  RA2D_FUNCTION int most_overlapping(const Place& place, const Real* u, int nodes,
                                     double& over) const {
    int worst = -1;
    for (int e = 0; e < nodes; ++e) {
      const int node = listed_nodes_[e];
      if (active_index_[node] >= 0) continue;
      Real phi[packs];
      node_contact_.shape(node, place.offset, phi);
      const double overlap = node_contact_.overlap(node, place.theta, phi, u);
      if (!(overlap > over)) continue;
      over = overlap;
      worst = node;
    }
    return worst;
  }

  /// Whether no listed node but these two overlaps at the displacement `u`.
  KOKKOS_FORCEINLINE_FUNCTION bool others_stay_open(const Place& place, const Real* u, int first,
                                                    int second, int nodes) const {
    for (int e = 0; e < nodes; ++e) {
      const int node = listed_nodes_[e];
      if (node == first || node == second) continue;
      Real at[packs];
      node_contact_.shape(node, place.offset, at);
      if (node_contact_.overlap(node, place.theta, at, u) > contact_.tolerance) return false;
    }
    return true;
  }

  /// The end of the step, and the record of the nodes that carry force.
  RA2D_FUNCTION void finish(const Place& place, Real* u, Real* v, ContactTotals<Real>& totals) {
    lanes_.sync();
    if (lanes_.leader()) {
      int touched = 0;
      for (int j = 0; j < forces_.count(); ++j) {  // in ascending order
        if (!(active_.forces[j] > 0.0)) continue;
        int at = touched++;
        for (; at > 0 && contact_list_.nodes[at - 1] > active_.nodes[j]; --at) {
          contact_list_.nodes[at] = contact_list_.nodes[at - 1];
          contact_list_.forces[at] = contact_list_.forces[at - 1];
        }
        contact_list_.nodes[at] = active_.nodes[j];
        contact_list_.forces[at] = active_.forces[j];
      }
    }
    lanes_.sync();
    for (int j = 0; j < forces_.count(); ++j) totals.nodes += active_.forces[j] > 0.0 ? 1 : 0;
    end_step(place, u, v, totals);
  }

  /// The end of the step under the forces in the list of contacts.
  RA2D_FUNCTION void end_step(const Place& place, Real* u, Real* v, ContactTotals<Real>& totals) {
    Real force_on_modes[packs], slope_force[packs], phi[packs], slope[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) force_on_modes[p] = slope_force[p] = Real(0.0);
    for (int e = 0; e < totals.nodes; ++e) {
      const int node = contact_list_.nodes[e];
      const double f = contact_list_.forces[e];
      node_contact_.shapes(node, place.offset, phi, slope);
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        force_on_modes[p] = multiply_add(f, phi[p], force_on_modes[p]);
        slope_force[p] = multiply_add(f, slope[p], slope_force[p]);
      }
      totals.face_work = Kokkos::fma(f, node_contact_.rise(node), totals.face_work);
      totals.force += f;
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      u[p] = multiply_add(-receptance(p), force_on_modes[p], u[p]);
      v[p] =
          multiply_add(-lanes_.load(contact_.mobility + p * Lanes::width), force_on_modes[p], v[p]);
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      totals.deflection_work = multiply_add(slope_force[p], u[p], totals.deflection_work);
  }
};

}  // namespace ra2d
