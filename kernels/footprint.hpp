// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// sum over the modes of weight_k |x_k|
template <class Lanes, int packs>
KOKKOS_FORCEINLINE_FUNCTION double weighted_sum(const Lanes& lanes, const double* weight,
                                                const typename Lanes::Real* x) {
  typename Lanes::Real part = lanes.load(weight) * Kokkos::abs(x[0]);
  for (int p = 1; p < filled<packs>(lanes); ++p)
    part = multiply_add(lanes.load(weight + p * Lanes::width), Kokkos::abs(x[p]), part);
  return lanes.sum(part);
}

/// Areal scenes: psi of the slider's mode k in the middle of a group of nodes.
template <class Lanes, int packs>
RA2D_FUNCTION double shape_in_group(const FaceTables& faces, const SliderShapes& slider, int group,
                                    int k) {
  constexpr int width = Lanes::width;
  const int row = group / faces.rows.groups, left = nodes_left(faces, group, width);
  const int middle = (group - row * faces.rows.groups) * width + (left < width ? left : width) / 2;
  return slider.shape[static_cast<std::int64_t>(k) * slider.row + middle] *
         faces.rows
             .across[static_cast<std::int64_t>(row) * (packs * width) + slider.first_lane + k];
}

/// Bounds on what the modes move any node of the slider by.
///
/// sum_k max|psi_k| |x_k| is one, but with many modes it is far too large: it takes each mode
/// where it is largest, and with the sign that adds to the others. The slider of an areal scene
/// stands on a part of the resonator, its footprint, that is a few of the modes' shortest waves
/// long at the most. There their shapes are polynomials of a low degree, up to a small remainder,
///
///   psi_k(x, y) = sum_(a+b<=degree) Phi_kab T_a(xi) T_b(eta),   |xi|, |eta| <= 1,
///
/// T the polynomials of Chebyshev. Since |T| <= 1, at every node
///
///   |sum_k psi_k x_k| <= sum_ab |sum_k Phi_kab x_k| + sum_k remainder_k |x_k|.
///
/// The slider's own modes are left to the remainder, which is max|psi_k| there. A scene without
/// such polynomials (FootprintTables::terms is 0) has the first bound alone.
template <class Lanes, int packs>
class Footprint {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;
  static constexpr int row = packs * width;

 public:
  static constexpr bool can_exist = packs >= least_footprint_packs;

  RA2D_FUNCTION Footprint(const Lanes& lanes, const MotionLimits& limits)
      : lanes_{lanes}, limits_{limits} {}

  KOKKOS_FORCEINLINE_FUNCTION bool exists() const {
    if constexpr (can_exist)
      return limits_.footprint.terms > 0;
    else
      return false;
  }

  /// Bound on |sum_k psi_k x_k| at every node.
  RA2D_FUNCTION double most(const Place& place, const Real* x) const {
    if constexpr (can_exist)
      if (exists()) {
        double first;
        return sum_terms(place, x, first);
      }
    return weighted_sum<Lanes, packs>(lanes_, limits_.largest_shape, x);
  }
  /// Bound on sum_k psi_k x_k itself: what moves all nodes alike, the first polynomial and the
  /// slider's heave, counts with its sign. Raised by its own roundings. Without a footprint it is
  /// most().
  RA2D_FUNCTION double most_raised(const Place& place, const Real* x) const {
    if constexpr (can_exist)
      if (exists()) {
        double first;
        const double bound = sum_terms(place, x, first);
        return with_sign(bound, first, x);
      }
    return most(place, x);
  }
  /// As above, of x, the difference of two vectors whose sums are given (expand).
  RA2D_FUNCTION double most_raised(const double* sums_of, const double* from, const Real* x) const {
    return with_sign(most(sums_of, from, x), sums_of[0] - from[0], x);
  }
  /// As most(), of x, the difference of two vectors whose sums are given.
  RA2D_FUNCTION double most(const double* sums_of, const double* from, const Real* x) const {
    return difference(limits_.footprint.remainder, sums_of, from, x);
  }
  /// As most(), with of the slider's modes only what they differ by from the middle of a group.
  RA2D_FUNCTION double most_in_group(const double* sums_of, const double* from,
                                     const Real* x) const {
    return difference(limits_.footprint.remainder_in_group, sums_of, from, x);
  }

  /// The place of the path, with polynomials of its own, that serves.
  KOKKOS_FORCEINLINE_FUNCTION int place_of(const Place& place) const {
    const FootprintTables& tables = limits_.footprint;
    const int at = (place.base - tables.first) / tables.nodes;
    RA2D_CHECK(place.base >= tables.first && at < tables.places);
    return at;
  }
  /// Length of a row of sums: whole packs, filled up with zeros.
  KOKKOS_FORCEINLINE_FUNCTION int sums() const {
    return (limits_.footprint.terms + width - 1) / width * width;
  }
  /// Writes the sums c_ab = sum_k Phi_kab x_k over the resonator's modes of some vectors to `to`,
  /// a row of sums() after the other.
  template <int count>
  RA2D_FUNCTION void expand(const Place& place, const Real* const (&x)[count], double* to) const {
    if constexpr (can_exist) {
      const double* const phi = rows_at(place);
      const int terms = limits_.footprint.terms, all = sums();
      lanes_.sync();
      for (int t = 0; t < terms; t += footprint_side_by_side) {
        Real part[count][footprint_side_by_side];
        sum_side_by_side<count>(phi + t * row, x, part);
        for (int i = 0; i < count; ++i)
          for (int s = 0; s < footprint_side_by_side; s += 2) {
            double one, other;
            lanes_.sum(part[i][s], part[i][s + 1], one, other);
            if (!lanes_.leader()) continue;
            to[i * all + t + s] = one;
            to[i * all + t + s + 1] = other;
          }
      }
      if (lanes_.leader())
        for (int i = 0; i < count; ++i)
          for (int t = terms; t < all; ++t) to[i * all + t] = 0.0;
      lanes_.sync();
    }
  }
  /// On a row of `rows`: the sums over b of the terms c_ab T_b(eta), for each a.
  KOKKOS_FORCEINLINE_FUNCTION void take_row(const double* terms, double row_number, int rows,
                                            double (&c)[highest_footprint_degree + 1]) const {
    const double eta = rows > 1 ? 2.0 * row_number / (rows - 1) - 1.0 : 0.0;
    double across[highest_footprint_degree + 1];
    across[0] = 1.0, across[1] = eta;
    for (int b = 2; b <= limits_.footprint.degree; ++b)
      across[b] = 2.0 * eta * across[b - 1] - across[b - 2];
    for (int a = 0; a <= limits_.footprint.degree; ++a) {
      c[a] = 0.0;
      for (int b = 0; a + b <= limits_.footprint.degree; ++b)
        c[a] += terms[(a + b) * (a + b + 1) / 2 + b] * across[b];
    }
  }
  /// sum_a c_a T_a(xi) at the slider's nodes `node` of a row of `nodes`, counted from where its
  /// first stands at the place's `base`, by Clenshaw's algorithm.
  KOKKOS_FORCEINLINE_FUNCTION Real displacement(const Place& place,
                                                const double (&c)[highest_footprint_degree + 1],
                                                const Real& node, int nodes) const {
    const FootprintTables& tables = limits_.footprint;
    const double middle = tables.first + (place_of(place) + 0.5) * tables.nodes + 0.5 * (nodes - 1);
    const Real xi = (node + Real(place.base - middle)) * Real(tables.inverse_half);
    Real last(0.0), next(0.0);
    for (int a = tables.degree; a > 0; --a) {
      const Real now = multiply_add(2.0, xi * last, Real(c[a]) - next);
      next = last;
      last = now;
    }
    return multiply_add(xi, last, Real(c[0]) - next);
  }

  /// Bound on what the polynomials leave out of sum_k psi_k x_k over the resonator's modes, which
  /// are those before `first_of_slider`.
  RA2D_FUNCTION double left_out(const Real* x, int first_of_slider) const {
    Real part(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real own = lanes_.index() + Real(p * width + 0.5 - first_of_slider);
      part = multiply_add(remainder(p), if_positive(own, Real(0.0), Kokkos::abs(x[p])), part);
    }
    return lanes_.sum(part);
  }
  /// Of pack p of the modes, what the polynomials leave out of each; in a group (most_in_group).
  KOKKOS_FORCEINLINE_FUNCTION Real remainder(int p) const {
    return load_pack(lanes_, limits_.footprint.remainder, p);
  }
  KOKKOS_FORCEINLINE_FUNCTION Real remainder_in_group(int p) const {
    return load_pack(lanes_, limits_.footprint.remainder_in_group, p);
  }

 private:
  Lanes lanes_;
  const MotionLimits& limits_;

  static constexpr double roundings = 0x1p-43;

  /// Makes a bound on |sum_k psi_k x_k| one on the sum itself; `first`: its first term.
  RA2D_FUNCTION double with_sign(double bound, double first, const Real* x) const {
    Real part(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      part = multiply_add(load_pack(lanes_, limits_.footprint.alike, p), x[p], part);
    const double heave = lanes_.sum(part);
    return (1.0 + roundings) * bound + 2.0 * (Kokkos::min(first, 0.0) + Kokkos::min(heave, 0.0));
  }
  RA2D_FUNCTION double difference(const double* remainder, const double* sums_of,
                                  const double* from, const Real* x) const {
    Real part(0.0);
    for (int t = 0; t < sums(); t += width)
      part = part + Kokkos::abs(lanes_.load(sums_of + t) - lanes_.load(from + t));
    return weighted_sum<Lanes, packs>(lanes_, remainder, x) + lanes_.sum(part);
  }
  KOKKOS_FORCEINLINE_FUNCTION const double* rows_at(const Place& place) const {
    const FootprintTables& tables = limits_.footprint;
    return tables.rows + static_cast<std::int64_t>(place_of(place)) * tables.terms * row;
  }

  /// Bound on |sum_k psi_k x_k|, and its first term.
  RA2D_FUNCTION double sum_terms(const Place& place, const Real* x, double& first) const {
    const FootprintTables& tables = limits_.footprint;
    const double* const phi = rows_at(place);
    const Real* const one_of[] = {x};
    double bound = weighted_sum<Lanes, packs>(lanes_, tables.remainder, x);
    for (int t = 0; t < tables.terms; t += footprint_side_by_side) {
      Real part[1][footprint_side_by_side];
      sum_side_by_side<1>(phi + t * row, one_of, part);
      for (int s = 0; s < footprint_side_by_side; s += 2) {
        double one, other;
        lanes_.sum(part[0][s], part[0][s + 1], one, other);
        if (t + s == 0) first = one;
        bound += Kokkos::abs(one) + Kokkos::abs(other);
      }
    }
    return bound;
  }
  /// The lanes' parts of the sums of some terms: one sum by itself waits for each addition.
  template <int count>
  KOKKOS_FORCEINLINE_FUNCTION void sum_side_by_side(
      const double* phi, const Real* const (&x)[count],
      Real (&part)[count][footprint_side_by_side]) const {
    for (int i = 0; i < count; ++i)
      for (int s = 0; s < footprint_side_by_side; ++s) part[i][s] = Real(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      for (int s = 0; s < footprint_side_by_side; ++s) {
        const Real shape = load_pack(lanes_, phi + s * row, p);
        for (int i = 0; i < count; ++i) part[i][s] = multiply_add(shape, x[i][p], part[i][s]);
      }
  }
};

}  // namespace ra2d
