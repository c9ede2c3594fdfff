// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/contact/complementarity.hpp"
#include "kernels/contact/expanded_cells.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The penalty force of the new time between smooth faces. A step without contact ends at U*. With
/// u = U* + D w, D = sqrt(b), b the receptance (ContactTables), its end is where the convex
/// function
///
///   E(w) = w^2/2 + s/2 sum over the cells of the integral of max(0, o(eta))^2,   s = kappa chi w,
///
/// is least: there the force over the step, -w/D, is that of the overlap at its end. Newton's
/// method finds it, with the Hessian 1 + s D sum_ij P_(i+j) phi_i phi_j^T D, P_j the integral of
/// eta^j over what is in contact of a cell. By Cholesky's factor of its 4 by 4 moments a cell adds
/// at the most four products a a^T. Those with a^2 far below 1 are left out: with short steps, or
/// soft springs, all are. Few make a system as small as they are many (Woodbury); else it is one in
/// the modes, and exact. What is left out is at the most `left_out` in all, and by so much each
/// step of Newton's comes closer. A step that passes the least E of its line by
/// far is halved. E is strictly convex and its slope continuous, so the steps go to the minimum
/// from anywhere. They end where one moves no overlap by more than the roundings of a gap or of the
/// modes' sums.
template <class Lanes, int packs>
class CellSprings {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width, row = packs * width;

 public:
  RA2D_FUNCTION CellSprings(const Lanes& lanes, const ContactTables& contact,
                            const MotionLimits& bounds,
                            const NodeContact<Lanes, packs>& node_contact, const Marks& marks,
                            const Caches& caches, ActiveSet& products, const int* listed_cells,
                            const int* interrupted)
      : lanes_{lanes},
        contact_{contact},
        bounds_{bounds},
        node_contact_{node_contact},
        cells_{lanes, marks, caches},
        products_{products},
        listed_cells_{listed_cells},
        interrupted_{interrupted} {}

  /// Corrects the end (u, v) of a step to `place`, and records the contact there. `guess`: where it
  /// may end, or null. The rest as in Complementarity.
  template <class List>
  RA2D_FUNCTION Solution operator()(const Place& place, const Real* guess, Real* u, Real* v,
                                    const List& list, ContactTotals<Real>& totals,
                                    double& most) const {
    constexpr int rounds = 200, halvings = 40;
    Real d[packs], w[packs], now[packs], pressing[packs], next[packs], step[packs];
    const Scene scene = scene_of(d);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      w[p] = Real(0.0);
      now[p] = u[p];
    }
    if (guess != nullptr)
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        w[p] = (guess[p] - u[p]) / Kokkos::max(d[p], Real(1e-150));
        now[p] = multiply_add(d[p], w[p], u[p]);
      }
    int cells = list(now);
    if (cells < 0) [[unlikely]]
      return Solution::crowded;
    Found found = evaluate(place, now, cells, d, scene, pressing);
    if (guess == nullptr && !found.touches) return Solution::solved;
    for (int round = 0; round < rounds; ++round) {
      if (round % 16 == 15 && is_interrupted(interrupted_)) return Solution::interrupted;
      if (found.products > scene.modes || found.left_out > left_out)
        solve_in_modes(place, now, cells, d, w, pressing, next);
      else
        solve_by_products(found.products, w, pressing, next);
      Real moved(0.0), away(0.0), falling(0.0);
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        const Real motion = d[p] * largest_shape(p);
        step[p] = next[p] - w[p];
        moved = multiply_add(motion, Kokkos::abs(step[p]), moved);
        away = multiply_add(motion, Kokkos::abs(next[p]), away);
        falling = multiply_add(w[p] + pressing[p], step[p], falling);
      }
      double distance, pushed;
      lanes_.sum(moved, away, distance, pushed);
      if (!(distance < 1e300))
        return Solution::solved;  // not a number: left to the check of the energy
      const double fall = lanes_.sum(falling);
      // the least force that moves a node as far
      pushed /= scene.most_compliance;
      if (pushed > most) most = pushed;
      if (distance <=
          contact_.tolerance + displacement_rounding<Lanes, packs>(lanes_, bounds_, now, u)) {
        return finish(place, d, next, u, v, list, totals);
      }
      // by its slope along the step: of E roundings of the overlaps would be seen sooner
      double share = 1.0;
      for (int half = 0;; ++half, share *= 0.5) {
        Real to[packs], part(0.0);
        for (int p = 0; p < filled<packs>(lanes_); ++p) {
          to[p] = half == 0 ? next[p] : multiply_add(share, step[p], w[p]);
          now[p] = multiply_add(d[p], to[p], u[p]);
        }
        cells = list(now);
        if (cells < 0) [[unlikely]]
          return Solution::crowded;
        found = evaluate(place, now, cells, d, scene, pressing);
        for (int p = 0; p < filled<packs>(lanes_); ++p)
          part = multiply_add(to[p] + pressing[p], step[p], part);
        if (lanes_.sum(part) <= -0.1 * fall || half == halvings) {
          for (int p = 0; p < filled<packs>(lanes_); ++p) w[p] = to[p];
          break;
        }
      }
    }
    return Solution::blocked;
  }

 private:
  Lanes lanes_;
  const ContactTables& contact_;
  const MotionLimits& bounds_;
  NodeContact<Lanes, packs> node_contact_;
  ExpandedCells<Lanes, packs> cells_;
  ActiveSet& products_;  // rows: the vectors a
  const int* listed_cells_;
  const int* interrupted_;

  /// Share of the Hessian that may be left out: of a product, and of all.
  static constexpr double small = 1e-4, left_out = 1e-2;

  struct Scene {
    int modes = 0;
    double most_compliance = 0;  // m/N, of any node: sum b max psi^2
  };
  /// Sets d to the square roots of the modes' receptances.
  KOKKOS_FORCEINLINE_FUNCTION Scene scene_of(Real* d) const {
    Scene scene;
    Real part(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real b = lanes_.load(contact_.receptance + p * width), most_shape = largest_shape(p);
      scene.modes += Kokkos::Experimental::popcount_builtin(lanes_.at_least(b, 1e-300));
      part = multiply_add(b * most_shape, most_shape, part);
      d[p] = Kokkos::sqrt(b);
    }
    scene.most_compliance = lanes_.sum(part);
    return scene;
  }
  /// The contact at a state: the products of its Hessian, and a bound on the size of those
  /// that it lacks.
  struct Found {
    int products;
    double left_out;
    bool touches;
  };

  KOKKOS_FORCEINLINE_FUNCTION Real largest_shape(int p) const {
    return lanes_.load(bounds_.largest_shape + p * width);
  }

  /// Calls visit(eta, weight, overlap) for the points of the rule over each stretch in contact.
  template <class Visit>
  KOKKOS_FORCEINLINE_FUNCTION static void visit_points(const CellOverlap& overlap,
                                                       const Visit& visit) {
    for (int side = 0; side < 2; ++side) {
      const Cubic& o = overlap.side[side];
      if (is_open(o)) continue;
      visit_contact(o, overlap.from(side), overlap.to(side), [&](double left, double right) {
        const double middle = 0.5 * (left + right), half = 0.5 * (right - left);
        if (!(half > 0.0)) return;
        const Cubic about = o.about(middle);
        for (int i = 0; i < 4; ++i) {
          const double at = i == 0 || i == 3 ? 0.8611363115940526 : 0.3399810435848563;
          const double weight = i == 0 || i == 3 ? 0.3478548451374538 : 0.6521451548625461;
          const double x = i < 2 ? -half * at : half * at;
          visit(middle + x, half * weight, about(x));
        }
      });
    }
  }

  /// Where the modes are at `now`: the slope of E but for w, D times what pushes the modes, and the
  /// products of the Hessian.
  RA2D_FUNCTION Found evaluate(const Place& place, const Real* now, int cells, const Real* d,
                               const Scene& scene, Real* pressing) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) pressing[p] = Real(0.0);
    Found found{};
    for (int e = 0; e < cells; ++e) {
      Real phi[4][packs];
      cells_.shapes(listed_cells_[e], place.offset, phi);
      double force[4] = {}, stiffness[7] = {};  // N, N/m: times eta^j
      visit_points(cells_.overlap(listed_cells_[e], place.theta, cells_.displacement(phi, now)),
                   [&](double eta, double weight, double over) {
                     double spring = contact_.node_stiffness * weight, f = spring * over;
                     for (int j = 0; j < 4; ++j, f *= eta) force[j] += f;
                     for (int j = 0; j < 7; ++j, spring *= eta) stiffness[j] += spring;
                   });
      if (stiffness[0] == 0.0) continue;
      found.touches = true;
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        for (int j = 0; j < 4; ++j) pressing[p] = multiply_add(force[j], phi[j][p], pressing[p]);
      const double most = stiffness[0] * scene.most_compliance;
      if (most <= small)
        found.left_out += most;
      else
        add_products(phi, d, stiffness, scene.modes, found);
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p) pressing[p] = d[p] * pressing[p];
    lanes_.sync();
    return found;
  }

  /// Adds the products of a cell with these moments; stores them while they are no more than the
  /// modes.
  RA2D_FUNCTION void add_products(const Real (*phi)[packs], const Real* d, const double* stiffness,
                                  int modes, Found& found) const {
    double factor[4][4];
    for (int l = 0; l < 4; ++l)
      for (int i = l; i < 4; ++i) {
        double sum = stiffness[i + l];
        for (int n = 0; n < l; ++n) sum -= factor[i][n] * factor[l][n];
        if (i == l)  // below: a narrow stretch has no more
          factor[i][l] = sum > 0x1p-48 * stiffness[2 * l] ? Kokkos::sqrt(sum) : 0.0;
        else
          factor[i][l] = factor[l][l] > 0.0 ? sum / factor[l][l] : 0.0;
      }
    for (int l = 0; l < 4; ++l) {
      Real product[packs], part(0.0);
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        product[p] = factor[l][l] * phi[l][p];
        for (int i = l + 1; i < 4; ++i)
          product[p] = multiply_add(factor[i][l], phi[i][p], product[p]);
        product[p] = d[p] * product[p];
        part = multiply_add(product[p], product[p], part);
      }
      const double size = lanes_.sum(part);
      if (size <= small) {
        found.left_out += size;
        continue;
      }
      if (found.products < modes)
        for (int p = 0; p < filled<packs>(lanes_); ++p)
          lanes_.store(products_.rows + found.products * row + p * width, product[p]);
      ++found.products;
    }
  }

  /// The end of Newton's step: (1 + A^T A)^-1 = 1 - A^T (1 + A A^T)^-1 A, A the products' rows. It
  /// is found from the pressing alone: the roundings of w, which are those of a displacement, would
  /// be more than those of the forces.
  RA2D_FUNCTION void solve_by_products(int count, const Real* w, const Real* pressing,
                                       Real* next) const {
    const auto product = [&](int i, int p) {
      return lanes_.load(products_.rows + i * row + p * width);
    };
    const auto dot = [&](int i, const auto& other) {
      Real part(0.0);
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        part = multiply_add(product(i, p), other(p), part);
      return lanes_.sum(part);
    };
    for (int i = 0; i < count; ++i) {
      const double along = dot(i, [&](int p) { return w[p] + pressing[p]; });
      if (lanes_.leader()) products_.solution[i] = along;
      for (int j = 0; j <= i; ++j) {
        const double both = dot(i, [&](int p) { return product(j, p); });
        if (lanes_.leader()) factor(i, j) = both;
      }
    }
    solve(count);
    for (int p = 0; p < filled<packs>(lanes_); ++p) next[p] = -pressing[p];
    for (int i = 0; i < count; ++i)
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        next[p] = multiply_add(products_.solution[i], product(i, p), next[p]);
    lanes_.sync();
  }

  /// The end of Newton's step where there are many products.
  RA2D_FUNCTION void solve_in_modes(const Place& place, const Real* now, int cells, const Real* d,
                                    const Real* w, const Real* pressing, Real* next) const {
    const int rows = filled<packs>(lanes_) * width;
    for (int i = 0; i < rows; ++i)
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        lanes_.store(&factor(i, p * width), Real(0.0));
    for (int e = 0; e < cells; ++e) {
      Real phi[4][packs];
      cells_.shapes(listed_cells_[e], place.offset, phi);
      double stiffness[7] = {};
      visit_points(cells_.overlap(listed_cells_[e], place.theta, cells_.displacement(phi, now)),
                   [&](double eta, double weight, double) {
                     double spring = contact_.node_stiffness * weight;
                     for (int j = 0; j < 7; ++j, spring *= eta) stiffness[j] += spring;
                   });
      if (stiffness[0] == 0.0) continue;
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        for (int j = 0; j < 4; ++j) phi[j][p] = d[p] * phi[j][p];
      for (int i = 0; i < 4; ++i) {
        Real pressed[packs];
        for (int p = 0; p < filled<packs>(lanes_); ++p) {
          pressed[p] = stiffness[i] * phi[0][p];
          for (int j = 1; j < 4; ++j)
            pressed[p] = multiply_add(stiffness[i + j], phi[j][p], pressed[p]);
        }
        lanes_.sync();
        for (int p = 0; p < filled<packs>(lanes_); ++p)
          lanes_.store(products_.coupling + p * width, phi[i][p]);
        lanes_.sync();
        for (int r = 0; r < rows; ++r) {
          const double left = products_.coupling[r];
          if (left == 0.0) continue;  // of a lane without a mode
          for (int p = 0; p < filled<packs>(lanes_); ++p) {
            double* const entry = &factor(r, p * width);
            lanes_.store(entry, multiply_add(left, pressed[p], lanes_.load(entry)));
          }
        }
      }
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      lanes_.store(products_.solution + p * width, -(w[p] + pressing[p]));
    solve(rows);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      next[p] = w[p] + lanes_.load(products_.solution + p * width);
    lanes_.sync();
  }

  /// Solves (1 + matrix) solution = solution by Cholesky's factor; the eigenvalues are 1 and more.
  RA2D_FUNCTION void solve(int count) const {
    lanes_.sync();
    if (lanes_.leader()) {
      double* const x = products_.solution;
      for (int i = 0; i < count; ++i)
        for (int j = 0; j <= i; ++j) {
          double sum = factor(i, j) + (i == j ? 1.0 : 0.0);
          for (int l = 0; l < j; ++l) sum -= factor(i, l) * factor(j, l);
          factor(i, j) = i == j ? Kokkos::sqrt(sum) : sum / factor(j, j);
        }
      for (int i = 0; i < count; ++i) {
        for (int j = 0; j < i; ++j) x[i] -= factor(i, j) * x[j];
        x[i] /= factor(i, i);
      }
      for (int i = count - 1; i >= 0; --i) {
        for (int j = i + 1; j < count; ++j) x[i] -= factor(j, i) * x[j];
        x[i] /= factor(i, i);
      }
    }
    lanes_.sync();
  }
  KOKKOS_FORCEINLINE_FUNCTION double& factor(int row, int column) const {
    return products_.factor[static_cast<std::int64_t>(row) * products_.capacity + column];
  }

  /// The end of the step, and the record of the contact there.
  template <class List>
  RA2D_FUNCTION Solution finish(const Place& place, const Real* d, const Real* w, Real* u, Real* v,
                                const List& list, ContactTotals<Real>& totals) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      u[p] = multiply_add(d[p], w[p], u[p]);
      // the force over the step is -w/D
      v[p] = multiply_add(lanes_.load(contact_.mobility + p * width),
                          w[p] / Kokkos::max(d[p], Real(1e-150)), v[p]);
    }
    Real force[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = Real(0.0);
    const int cells = list(u);
    if (cells < 0) [[unlikely]]
      return Solution::crowded;
    totals = node_contact_(place, u, listed_cells_, cells, force);
    return Solution::solved;
  }
};

}  // namespace ra2d
