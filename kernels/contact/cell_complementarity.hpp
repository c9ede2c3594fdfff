// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/candidates.hpp"
#include "kernels/contact/active_forces.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/contact/expanded_cells.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// A place of the slider where smooth faces may touch.
struct CellPoint {
  int cell;
  double at;  // chi, from the middle of the cell
};

/// Lagrange multipliers between smooth faces: no overlap anywhere along the slider, and force only
/// where it is zero (kernels/contact/complementarity.hpp says what holds at nodes, and how the dual
/// active set method finds it). Here the conditions are infinitely many, one for each place. The
/// method takes them as they come: it adds the place where the overlap is largest, a summit of one
/// of the cubics, and looks for the summits again, which have moved with the modes (an exchange
/// method for a semi-infinite programme). A place next to one that carries force takes its force
/// over.
///
/// Each place that enters overlaps by more than the tolerance. It moves U1 further from U* by so
/// much at least, and no further than the answer is. So the method ends, or finds that no motion of
/// the modes keeps the faces apart. Next to the answer the distance of a place from the summit
/// falls by f W''/o'' each time, W'' the compliance of slopes; with short steps that is next to
/// nothing. An overlap is half of o'' times the distance squared: when it is below the roundings,
/// the place is known to their root.
template <class Lanes, int packs>
class CellComplementarity {
  using Real = typename Lanes::Real;
  static constexpr int rows = packs * Lanes::width;

  /// Places in cells as points of the active set, each with the shapes of the modes there.
  class Places {
   public:
    using Point = CellPoint;
    RA2D_FUNCTION Places(const Lanes& lanes, const ExpandedCells<Lanes, packs>& cells,
                         ActiveSet& active)
        : lanes_{lanes}, cells_{cells}, active_{active} {}

    RA2D_FUNCTION void shape(const Place& place, const CellPoint& point, Real* phi) const {
      Real along[4][packs];
      cells_.shapes(point.cell, place.offset, along);
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        phi[p] = ExpandedCells<Lanes, packs>::at(along, p, point.at);
    }
    KOKKOS_FORCEINLINE_FUNCTION void active_shape(const Place&, int j, Real* phi) const {
      for (int p = 0; p < filled<packs>(lanes_); ++p) phi[p] = lanes_.load(row(j, p));
    }
    KOKKOS_FORCEINLINE_FUNCTION double active_overlap(const Place& place, int j, const Real* phi,
                                                      const Real* u) const {
      Real part(0.0);
      for (int p = 0; p < filled<packs>(lanes_); ++p) part = multiply_add(phi[p], u[p], part);
      return cells_.face(active_.nodes[j], place.theta, active_.places[j]) + lanes_.sum(part);
    }
    RA2D_FUNCTION void put(const Place& place, int j, const CellPoint& point) const {
      Real phi[packs];
      shape(place, point, phi);
      for (int p = 0; p < filled<packs>(lanes_); ++p) lanes_.store(row(j, p), phi[p]);
      if (!lanes_.leader()) return;
      active_.nodes[j] = point.cell;
      active_.places[j] = point.at;
    }
    RA2D_FUNCTION void move(int from, int to) const {
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        lanes_.store(row(to, p), lanes_.load(row(from, p)));
      if (!lanes_.leader()) return;
      active_.nodes[to] = active_.nodes[from];
      active_.places[to] = active_.places[from];
    }
    KOKKOS_FORCEINLINE_FUNCTION void leave(int) const {}

   private:
    Lanes lanes_;
    ExpandedCells<Lanes, packs> cells_;
    ActiveSet& active_;

    KOKKOS_FORCEINLINE_FUNCTION double* row(int j, int p) const {
      return active_.rows + static_cast<std::int64_t>(j) * rows + p * Lanes::width;
    }
  };

 public:
  RA2D_FUNCTION CellComplementarity(const Lanes& lanes, const FaceTables& faces,
                                    const ContactTables& contact, const MotionLimits& bounds,
                                    const Marks& marks, const Caches& caches, ActiveSet& active,
                                    ContactList& contact_list, const int* listed_cells,
                                    const int* interrupted)
      : lanes_{lanes},
        faces_{faces},
        contact_{contact},
        bounds_{bounds},
        cells_{lanes, marks, caches},
        active_{active},
        forces_{lanes, contact, active, Places(lanes, cells_, active)},
        contact_list_{contact_list},
        listed_cells_{listed_cells},
        interrupted_{interrupted} {}

  /// As Complementarity: corrects the end (u, v) of a step to `place`, and records the contact.
  template <class List>
  RA2D_FUNCTION Solution operator()(const Place& place, Real* u, Real* v, const List& list,
                                    ContactTotals<Real>& totals, double& most) {
    Real now[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) now[p] = u[p];
    Solution result = Solution::solved;
    const int rounds = 64 + 8 * faces_.nodes;
    double wide = 0.0;
    for (int round = 0;; ++round) {
      const int cells = list(now);
      if (cells < 0) [[unlikely]] {
        result = Solution::crowded;
        break;
      }
      double over = contact_.tolerance + wide;
      const CellPoint worst = most_overlapping(place, now, cells, over);
      if (worst.cell < 0) break;
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

 private:
  Lanes lanes_;
  const FaceTables& faces_;
  const ContactTables& contact_;
  const MotionLimits& bounds_;
  ExpandedCells<Lanes, packs> cells_;
  ActiveSet& active_;
  ActiveForces<Lanes, packs, Places> forces_;
  ContactList& contact_list_;
  const int* listed_cells_;
  const int* interrupted_;

  /// The place that overlaps most, by more than `over`; cell -1 where none does.
  RA2D_FUNCTION CellPoint most_overlapping(const Place& place, const Real* u, int cells,
                                           double& over) const {
    CellPoint worst{-1, 0.0};
    for (int e = 0; e < cells; ++e) {
      const int cell = listed_cells_[e];
      Real phi[4][packs];
      cells_.shapes(cell, place.offset, phi);
      const CellOverlap overlap = cells_.overlap(cell, place.theta, cells_.displacement(phi, u));
      for (int i = 0; i < 2; ++i) {
        if (is_open(overlap.side[i])) continue;
        const Highest highest = highest_on(overlap.side[i], overlap.from(i), overlap.to(i));
        if (!(highest.value > over)) continue;
        over = highest.value;
        worst = {cell, highest.place};
      }
    }
    return worst;
  }

  /// The end of the step, and the record of the cells that carry force, in ascending order.
  RA2D_FUNCTION void finish(const Place& place, Real* u, Real* v, ContactTotals<Real>& totals) {
    Real force_on_modes[packs], slope_force[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) force_on_modes[p] = slope_force[p] = Real(0.0);
    for (int done = -1;;) {
      int cell = faces_.nodes;  // the next
      for (int j = 0; j < forces_.count(); ++j)
        if (active_.forces[j] > 0.0 && active_.nodes[j] > done && active_.nodes[j] < cell)
          cell = active_.nodes[j];
      if (cell == faces_.nodes) break;
      done = cell;
      Real path[4][packs];
      cells_.path(cell, place.offset, path);
      double force = 0.0, moment = 0.0;
      for (int j = 0; j < forces_.count(); ++j) {
        if (active_.nodes[j] != cell || !(active_.forces[j] > 0.0)) continue;
        const double f = active_.forces[j], at = active_.places[j];
        force += f;
        moment = Kokkos::fma(f, at, moment);
        totals.face_work = Kokkos::fma(f, cells_.rise(cell, place.theta, at), totals.face_work);
        for (int p = 0; p < filled<packs>(lanes_); ++p) {
          const Real shape =
              lanes_.load(active_.rows + static_cast<std::int64_t>(j) * rows + p * Lanes::width);
          force_on_modes[p] = multiply_add(f, shape, force_on_modes[p]);
          const Real steeper = multiply_add(Real(3.0 * at), path[3][p], Real(2.0) * path[2][p]);
          slope_force[p] = multiply_add(f, multiply_add(at, steeper, path[1][p]), slope_force[p]);
        }
      }
      totals.force += force;
      RA2D_CHECK(totals.nodes < faces_.nodes);
      if (lanes_.leader()) {
        contact_list_.nodes[totals.nodes] = cell;
        contact_list_.forces[totals.nodes] = force;
        contact_list_.centres[totals.nodes] = along_row(faces_, cell) + 0.5 + moment / force;
      }
      ++totals.nodes;
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      u[p] = multiply_add(-forces_.receptance(p), force_on_modes[p], u[p]);
      v[p] =
          multiply_add(-lanes_.load(contact_.mobility + p * Lanes::width), force_on_modes[p], v[p]);
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      totals.deflection_work = multiply_add(slope_force[p], u[p], totals.deflection_work);
    lanes_.sync();
  }
};

}  // namespace ra2d
