// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/check.hpp"
#include "kernels/displacement.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/tables.hpp"

/// The modes' shapes about a place among the nodes of an areal scene, as polynomials of low degree
/// in xi, the distance along x [nodes], and eta, the distance across [rows]:
///
///   psi_k = sum_(a+b<=degree) Phi_kab xi^a eta^b
///
/// The resonator's modes pass a node. The slider's modes do not, and are straight lines: their
/// slope along x has a term of its own, with the distance on the slider.
namespace ra2d {

/// Terms of a polynomial of two variables.
RA2D_FUNCTION constexpr int cluster_sums(int degree) { return (degree + 1) * (degree + 2) / 2; }

/// Exponents of term t: 1, xi, eta, xi^2, xi eta, eta^2, xi^3, xi^2 eta, ...
KOKKOS_FORCEINLINE_FUNCTION constexpr int power_across(int t) {
  return t == 0 ? 0 : t < 3 ? t - 1 : t < 6 ? t - 3 : t < 10 ? t - 6 : 0;
}
KOKKOS_FORCEINLINE_FUNCTION constexpr int power_along(int t) {
  return (t == 0 ? 0 : t < 3 ? 1 : t < 6 ? 2 : 3) - power_across(t);
}
/// The term of xi^a eta^b.
KOKKOS_FORCEINLINE_FUNCTION constexpr int term_of(int a, int b) {
  return (a + b) * (a + b + 1) / 2 + b;
}

/// Where term t of a pack of modes stands in a place's column, (pack, cluster_rows, lane): in the
/// order in which the sums over the modes go through it.
template <int width, class Number>
KOKKOS_FORCEINLINE_FUNCTION Number* cluster_term(Number* column, int t, int pack) {
  return column + (pack * cluster_rows + t) * width;
}

/// Writes Phi_kab of a place over a window, and the slider's slopes, to the column `to`. The place
/// has an even row.
template <class Lanes, int packs>
RA2D_FUNCTION void expand_cluster_place(const Lanes& lanes, const FaceTables& faces,
                                        const SliderShapes& slider, const PatchTables& patches,
                                        const ClusterTables& tables, const Place& place, int node,
                                        int row_number, double* to) {
  using Real = typename Lanes::Real;
  constexpr int width = Lanes::width, row = packs * width;
  const int at = place.base + node;
  Real c[4][packs];
  expand_modes<Lanes, packs>(lanes, patches, at / patches.nodes, at + place.middle, c);
  RA2D_CHECK(row_number >= 0 && row_number / 2 < tables.rows);
  const double* const across =
      tables.across + static_cast<std::int64_t>(row_number / 2) * (4 * row);
  // the slider's shapes are straight lines, and a place may lie behind their end
  const int last = faces.rows.nodes - 1;
  const double per_node = last > 0 ? 1.0 / last : 0.0;
  for (int p = 0; p < filled<packs>(lanes); ++p) {
    Real own(0.0);
    for (int k = 0; k < slider.modes; ++k) {
      const double* const shape = slider.shape + static_cast<std::int64_t>(k) * slider.row;
      const Real unit = load_pack(lanes, slider.unit + k * row, p);
      const double slope = per_node * (shape[last] - shape[0]);
      c[0][p] = multiply_add(Kokkos::fma(node, slope, shape[0]), unit, c[0][p]);
      own = multiply_add(slope, unit, own);
    }
    for (int t = 0; t < cluster_sums(tables.degree); ++t)
      lanes.store(cluster_term<width>(to, t, p),
                  load_pack(lanes, across + power_across(t) * row, p) * c[power_along(t)][p]);
    lanes.store(cluster_term<width>(to, cluster_own, p), load_pack(lanes, across, p) * own);
  }
}

/// M_ab = sum_k Phi_kab c_k to `to` (number, cluster_rows), of each of `count` states of the modes,
/// c(number, pack). `phi` as expand_cluster_place leaves it.
template <int degree, int count, class Lanes, int packs, class Modes>
KOKKOS_FORCEINLINE_FUNCTION void sum_at_cluster_place(const Lanes& lanes,
                                                      const SliderShapes& slider, const double* phi,
                                                      const Modes& c, double* to) {
  using Real = typename Lanes::Real;
  constexpr int width = Lanes::width, sums = cluster_sums(degree);
  Real part[sums + 1][count];
  for (int t = 0; t <= sums; ++t)
    for (int q = 0; q < count; ++q) part[t][q] = Real(0.0);
  const int modal_packs = filled<packs>(lanes);
  // with few registers half of the sums at once
  constexpr int block = count > 1 && width < 8 ? (sums + 1) / 2 : sums;
  for (int from = 0; from < sums; from += block)
    for (int p = 0; p < modal_packs; ++p) {
      Real mode[count];
      for (int q = 0; q < count; ++q) mode[q] = c(q, p);
      for (int t = from; t < from + block && t < sums; ++t) {
        const Real shape = lanes.load(cluster_term<width>(phi, t, p));
        for (int q = 0; q < count; ++q) part[t][q] = multiply_add(shape, mode[q], part[t][q]);
      }
    }
  for (int p = slider.first_lane / width; p < modal_packs; ++p) {
    const Real shape = lanes.load(cluster_term<width>(phi, cluster_own, p));
    for (int q = 0; q < count; ++q) part[sums][q] = multiply_add(shape, c(q, p), part[sums][q]);
  }
  for (int q = 0; q < count; ++q) {
    double m[sums + 2];
    for (int t = 0; t <= sums; t += 2)
      lanes.sum(part[t][q], t < sums ? part[t + 1][q] : Real(0.0), m[t], m[t + 1]);
    if (!lanes.leader()) continue;
    double* const row_of = to + q * cluster_rows;
    for (int t = 0; t < sums; ++t) row_of[t] = m[t];
    row_of[cluster_own] = m[sums];
  }
}
/// Adds sum_ab Phi_kab r_ab, and `own` times the slider's slopes, to each of `count` forces on the
/// modes: `r` (number, cluster_sums), `own` and `force` (number).
template <int degree, int count, class Lanes, int packs>
KOKKOS_FORCEINLINE_FUNCTION void add_force_at_cluster_place(
    const Lanes& lanes, const SliderShapes& slider, const double* phi,
    const double (&r)[count][cluster_sums(degree)], const double (&own)[count],
    typename Lanes::Real* const (&force)[count]) {
  using Real = typename Lanes::Real;
  constexpr int width = Lanes::width;
  const int modal_packs = filled<packs>(lanes);
  for (int p = 0; p < modal_packs; ++p) {
    Real sum[count];
    for (int q = 0; q < count; ++q) sum[q] = force[q][p];
    for (int t = 0; t < cluster_sums(degree); ++t) {
      const Real shape = lanes.load(cluster_term<width>(phi, t, p));
      for (int q = 0; q < count; ++q) sum[q] = multiply_add(r[q][t], shape, sum[q]);
    }
    for (int q = 0; q < count; ++q) force[q][p] = sum[q];
  }
  for (int p = slider.first_lane / width; p < modal_packs; ++p) {
    const Real shape = lanes.load(cluster_term<width>(phi, cluster_own, p));
    for (int q = 0; q < count; ++q) force[q][p] = multiply_add(own[q], shape, force[q][p]);
  }
}

}  // namespace ra2d
