// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

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

/// Writes Phi_kab of a place over a window, and the slider's slopes, to `to` (cluster_rows, lane).
/// The place has an even row.
template <class Lanes, int packs>
RA2D_FUNCTION void expand_cluster_place(const Lanes& lanes, const SliderMotion& motion,
                                        const FaceTables& faces, const SliderShapes& slider,
                                        const PatchTables& patches, const ClusterTables& tables,
                                        const Place& place, int node, int row_number, double* to) {
  using Real = typename Lanes::Real;
  constexpr int width = Lanes::width, row = packs * width;
  const int at = place.base + node;
  Real c[4][packs];
  expand_modes<Lanes, packs>(lanes, patches, at / patches.nodes,
                             at + (place.part + 0.5) * motion.window_width, c);
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
      lanes.store(to + t * row + p * width,
                  load_pack(lanes, across + power_across(t) * row, p) * c[power_along(t)][p]);
    lanes.store(to + cluster_own * row + p * width, load_pack(lanes, across, p) * own);
  }
}

}  // namespace ra2d
