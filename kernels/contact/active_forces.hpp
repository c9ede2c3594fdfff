// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// How the search for the contact forces of a step ended. solved: they are found. blocked: no
/// motion of the modes keeps the bodies apart. crowded: more nodes carry force than there is memory
/// for, or than a list of nodes is good for. interrupted: the launch is to end (is_interrupted),
/// and nothing has been done.
enum class Solution { solved, blocked, crowded, interrupted };

/// solution = L^-1 solution and solution = L^-T solution, L the factor of `count` rows; one lane.
KOKKOS_FORCEINLINE_FUNCTION void solve_lower(const ActiveSet& active, int count) {
  for (int i = 0; i < count; ++i) {
    const double* row = active.factor + static_cast<std::int64_t>(i) * active.capacity;
    for (int j = 0; j < i; ++j) active.solution[i] -= row[j] * active.solution[j];
    active.solution[i] /= row[i];
  }
}
KOKKOS_FORCEINLINE_FUNCTION void solve_upper(const ActiveSet& active, int count) {
  const std::int64_t columns = active.capacity;
  for (int i = count - 1; i >= 0; --i) {
    for (int j = i + 1; j < count; ++j)
      active.solution[i] -= active.factor[j * columns + i] * active.solution[j];
    active.solution[i] /= active.factor[i * columns + i];
  }
}

/// The points that carry force, their forces, and the factor of W between them: the dual active set
/// method of Goldfarb and Idnani (kernels/contact/complementarity.hpp says how). `Points` knows
/// what a point is, a node or a place in a cell, keeps those of the active set, and evaluates them.
template <class Lanes, int packs, class Points>
class ActiveForces {
  using Real = typename Lanes::Real;

 public:
  using Point = typename Points::Point;

  RA2D_FUNCTION ActiveForces(const Lanes& lanes, const ContactTables& contact, ActiveSet& active,
                             const Points& points)
      : lanes_{lanes}, contact_{contact}, active_{active}, points_{points} {}

  /// More than any force or distance.
  static constexpr double never = 1e300;
  /// Relative size of a pivot at which a point counts as depending on those that carry force.
  static constexpr double dependent = 1e-13;

  KOKKOS_FORCEINLINE_FUNCTION int count() const { return count_; }
  RA2D_FUNCTION void clear() {
    for (int j = 0; j < count_; ++j) points_.leave(j);
    lanes_.sync();
    count_ = 0;
    deactivated_ = false;
  }

  /// Raises the force on a point until its overlap `over` is gone. Points that would have to pull
  /// leave the active set.
  RA2D_FUNCTION Solution activate(const Place& place, const Point& point, double over) {
    Real weighted[packs], phi[packs];
    points_.shape(place, point, phi);
    for (int p = 0; p < filled<packs>(lanes_); ++p) weighted[p] = receptance(p) * phi[p];
    const double own = compliance_of(weighted, phi) + contact_.compliance;
    for (int j = 0; j < count_; ++j) {
      points_.active_shape(place, j, phi);
      const double w = compliance_of(weighted, phi);
      if (lanes_.leader()) active_.coupling[j] = w;
    }
    lanes_.sync();
    double force = 0.0;
    for (;;) {
      // the pivot that the point would bring, and what the others give up for a newton on it
      if (lanes_.leader()) {
        for (int j = 0; j < count_; ++j) active_.solution[j] = active_.coupling[j];
        solve_lower();
      }
      lanes_.sync();
      double pivot = own;
      for (int j = 0; j < count_; ++j) pivot -= active_.solution[j] * active_.solution[j];
      const bool full = count_ == active_.capacity;
      const bool depends = !(pivot > dependent * own) || !(own > contact_.least_compliance) ||
                           (full && contact_.compliance == 0.0);
      const double clear = depends ? never : over / pivot;
      if (count_ > 0) {
        lanes_.sync();
        if (lanes_.leader()) {
          for (int j = 0; j < count_; ++j)
            factor(count_, j) = active_.solution[j];  // its row, if it comes
          solve_upper();
        }
        lanes_.sync();
      }
      double most = never;
      const int first = first_released(most);
      if (first < 0 && !(clear < never)) return Solution::blocked;
      const double more = clear < most ? clear : most;
      lanes_.sync();
      if (lanes_.leader())
        for (int j = 0; j < count_; ++j) {
          const double left = active_.forces[j] - more * active_.solution[j];
          active_.forces[j] = left > 0.0 ? left : 0.0;
        }
      lanes_.sync();
      force += more;
      if (clear <= most) {
        if (full) return Solution::crowded;
        append(place, point, force, pivot);
        return Solution::solved;
      }
      if (!depends) over -= more * pivot;
      deactivate(place, first);
    }
  }

  /// Settles the forces where more than one was found, or some left.
  RA2D_FUNCTION void settle_after_change(const Place& place, const Real* free) {
    if (count_ > 1 || deactivated_) settle(place, free);
    deactivated_ = false;
  }

  /// Displacement at the end of the step under the present forces.
  RA2D_FUNCTION void end_of(const Place& place, const Real* free, Real* u) const {
    Real force_on_modes[packs], phi[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) force_on_modes[p] = Real(0.0);
    for (int j = 0; j < count_; ++j) {
      points_.active_shape(place, j, phi);
      const Real f(active_.forces[j]);
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        force_on_modes[p] = multiply_add(f, phi[p], force_on_modes[p]);
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      u[p] = multiply_add(-receptance(p), force_on_modes[p], free[p]);
  }

  RA2D_FUNCTION double total() const {
    double sum = 0.0;
    for (int j = 0; j < count_; ++j) sum += active_.forces[j];
    return sum;
  }

  /// W_nm of two points, one of them weighted by the receptance.
  RA2D_FUNCTION double compliance_of(const Real* weighted, const Real* phi) const {
    Real part = weighted[0] * phi[0];
    for (int p = 1; p < filled<packs>(lanes_); ++p) part = multiply_add(weighted[p], phi[p], part);
    return lanes_.sum(part);
  }

  KOKKOS_FORCEINLINE_FUNCTION Real receptance(int p) const {
    return lanes_.load(contact_.receptance + p * Lanes::width);
  }

 private:
  Lanes lanes_;
  const ContactTables& contact_;
  ActiveSet& active_;
  Points points_;
  int count_ = 0;             // points that carry force
  bool deactivated_ = false;  // some no longer do since the forces were settled

  KOKKOS_FORCEINLINE_FUNCTION double& factor(int row, int column) const {
    return active_.factor[static_cast<std::int64_t>(row) * active_.capacity + column];
  }
  RA2D_FUNCTION void solve_lower() const { ra2d::solve_lower(active_, count_); }
  RA2D_FUNCTION void solve_upper() const { ra2d::solve_upper(active_, count_); }

  /// The active point whose force ends first while the forces fall by `solution` for each newton on
  /// another point, and that point's force then (`most`); -1 where none ends.
  KOKKOS_FORCEINLINE_FUNCTION int first_released(double& most) const {
    int first = -1;
    for (int j = 0; j < count_; ++j) {
      if (!(active_.solution[j] > 0.0)) continue;
      const double until = active_.forces[j] / active_.solution[j];
      if (!(until < most)) continue;
      most = until;
      first = j;
    }
    return first;
  }

  /// Adds a point to the active set; its row of the factor stands there already.
  KOKKOS_FORCEINLINE_FUNCTION void append(const Place& place, const Point& point, double force,
                                          double pivot) {
    RA2D_CHECK(count_ < active_.capacity);
    points_.put(place, count_, point);
    if (lanes_.leader()) {
      active_.forces[count_] = force;
      factor(count_, count_) = Kokkos::sqrt(pivot);
    }
    ++count_;
    lanes_.sync();
  }

  /// Takes a point out, and factors what is left anew from there on.
  RA2D_FUNCTION void deactivate(const Place& place, int out) {
    deactivated_ = true;
    lanes_.sync();
    points_.leave(out);
    for (int j = out; j + 1 < count_; ++j) {
      points_.move(j + 1, j);
      if (!lanes_.leader()) continue;
      active_.forces[j] = active_.forces[j + 1];
      active_.coupling[j] = active_.coupling[j + 1];
    }
    --count_;
    lanes_.sync();
    Real phi[packs], weighted[packs];
    for (int i = out; i < count_; ++i) {
      points_.active_shape(place, i, weighted);
      for (int p = 0; p < filled<packs>(lanes_); ++p) weighted[p] = receptance(p) * weighted[p];
      for (int j = 0; j <= i; ++j) {
        points_.active_shape(place, j, phi);
        double w = compliance_of(weighted, phi);
        if (j == i) w += contact_.compliance;
        for (int l = 0; l < j; ++l) w -= factor(i, l) * factor(j, l);
        w = j == i ? Kokkos::sqrt(w > 0.0 ? w : 0.0) : w / factor(j, j);
        lanes_.sync();
        if (lanes_.leader()) factor(i, j) = w;
        lanes_.sync();
      }
    }
  }

  /// Removes the roundings from the forces: solves for the overlaps that are left at the end of the
  /// step. A point whose force that would turn negative leaves the active set. With its force
  /// merely cut off at zero, points that depend on it all but for roundings would keep the part
  /// that it was to take from them.
  RA2D_FUNCTION void settle(const Place& place, const Real* free) {
    for (int pass = 0; pass < 3;) {
      Real now[packs], phi[packs];
      end_of(place, free, now);
      double worst = 0.0;
      for (int j = 0; j < count_; ++j) {
        points_.active_shape(place, j, phi);
        const double missing =
            points_.active_overlap(place, j, phi, now) - contact_.compliance * active_.forces[j];
        if (lanes_.leader()) active_.solution[j] = missing;
        const double size = missing < 0.0 ? -missing : missing;
        if (size > worst) worst = size;
      }
      lanes_.sync();
      if (!(worst > contact_.tolerance)) return;
      if (lanes_.leader()) {
        solve_lower();
        solve_upper();
      }
      lanes_.sync();
      double fraction = 1.0;
      int first = -1;
      for (int j = 0; j < count_; ++j) {
        if (!(active_.forces[j] + active_.solution[j] < 0.0)) continue;
        const double until = -active_.forces[j] / active_.solution[j];
        if (first >= 0 && !(until < fraction)) continue;
        fraction = until;
        first = j;
      }
      lanes_.sync();
      if (lanes_.leader())
        for (int j = 0; j < count_; ++j) {
          const double corrected = active_.forces[j] + fraction * active_.solution[j];
          active_.forces[j] = corrected > 0.0 ? corrected : 0.0;
        }
      lanes_.sync();
      if (first < 0)
        ++pass;
      else
        deactivate(place, first);
    }
  }
};

}  // namespace ra2d
