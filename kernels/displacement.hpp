// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <type_traits>

#include "kernels/check.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/tables.hpp"

/// The resonator's displacement as a power series on a patch (kernels/tables.hpp, "Patches").
namespace ra2d {

/// 1 / j!
KOKKOS_INLINE_FUNCTION constexpr double inverse_factorial(int j) {
  double product = 1.0;
  for (int i = 2; i <= j; ++i) product *= i;
  return 1.0 / product;
}

/// q_0 + q_1 eta + q_2 eta^2 + q_3 eta^3.
template <class Real>
KOKKOS_FORCEINLINE_FUNCTION Real cubic(const double* q, const Real& eta) {
  const Real high = multiply_add(q[3], eta, Real(q[2]));
  return multiply_add(multiply_add(high, eta, Real(q[1])), eta, Real(q[0]));
}

/// q_1 + 2 q_2 eta + 3 q_3 eta^2.
template <class Real>
KOKKOS_FORCEINLINE_FUNCTION Real cubic_slope(const double* q, const Real& eta) {
  return multiply_add(multiply_add(3.0 * q[3], eta, Real(2.0 * q[2])), eta, Real(q[1]));
}

/// The first four terms of the displacement (or velocity) over a patch, q_j = sum_k U_k radius^j
/// psi_k^(j)(centre)/j!. What they leave out is below sum_k |U_k|
/// MotionLimits::cubic_remainder_k.
template <class Lanes, int packs>
KOKKOS_FORCEINLINE_FUNCTION void series_coefficients(const Lanes& lanes, const double* rows,
                                                     const typename Lanes::Real* amplitude,
                                                     double (&q)[4]) {
  using Real = typename Lanes::Real;
  const auto part = [&](int j) {
    Real sum = lanes.load(rows + j * packs * Lanes::width) * amplitude[0];
    for (int p = 1; p < filled<packs>(lanes); ++p)
      sum = multiply_add(lanes.load(rows + (j * packs + p) * Lanes::width), amplitude[p], sum);
    return sum;
  };
  const Real parts[] = {part(0), part(1), part(2), part(3)};
  four_sums_in_pairs(lanes, parts, q);
  for (int j = 2; j < 4; ++j) q[j] *= inverse_factorial(j);
}

/// The whole series of pack p of the modes, to below the roundings: c_j = radius^j
/// psi^(j)(centre)/j! for j = 0 ... terms - 1. Four derivatives are stored, psi'''' = beta^4 psi
/// gives the others.
template <class Lanes, int packs>
KOKKOS_FORCEINLINE_FUNCTION void full_series(const Lanes& lanes, const PatchTables& patches,
                                             int terms, const double* rows, int p,
                                             typename Lanes::Real* c) {
  using Real = typename Lanes::Real;
  const Real quartic = lanes.load(patches.quartic + p * Lanes::width);
  RA2D_UNROLL
  for (int j = 0; j < 4; ++j) {
    c[j] = Real(inverse_factorial(j)) * lanes.load(rows + (j * packs + p) * Lanes::width);
    RA2D_UNROLL
    for (int i = j; i + 4 < terms; i += 4)
      c[i + 4] = c[i] * quartic * Real(1.0 / ((i + 1.0) * (i + 2.0) * (i + 3.0) * (i + 4.0)));
  }
}

/// psi_k at a place of the resonator, for all packs of modes. `position` in chi, on the beam.
template <class Lanes, int packs>
KOKKOS_INLINE_FUNCTION void mode_values(const Lanes& lanes, const PatchTables& patches,
                                        double position, typename Lanes::Real (&value)[packs]) {
  using Real = typename Lanes::Real;
  const int patch = static_cast<int>(position) / patches.nodes;
  RA2D_CHECK(patch >= 0 && patch < patches.count);
  const Real eta((position - (patch + 0.5) * patches.nodes) * patches.inverse_radius);
  const double* rows =
      patches.derivatives + static_cast<std::int64_t>(patch) * 4 * packs * Lanes::width;
  for (int p = 0; p < filled<packs>(lanes); ++p) {
    Real c[most_terms];
    full_series<Lanes, packs>(lanes, patches, patches.terms, rows, p, c);
    value[p] = c[patches.terms - 1];
    for (int j = patches.terms - 2; j >= 0; --j) value[p] = multiply_add(value[p], eta, c[j]);
  }
}

/// The cubics of all modes about a place of the resonator: shape[m][p] is the m-th derivative over
/// m!, per chi^m, of pack p of the modes. `position` in chi; `patch` one whose series holds there.
template <class Lanes, int packs>
KOKKOS_INLINE_FUNCTION void expand_modes(const Lanes& lanes, const PatchTables& patches, int patch,
                                         double position, typename Lanes::Real (&shape)[4][packs]) {
  using Real = typename Lanes::Real;
  RA2D_CHECK(patch >= 0 && patch < patches.count);
  const Real eta((position - (patch + 0.5) * patches.nodes) * patches.inverse_radius);
  const double* rows =
      patches.derivatives + static_cast<std::int64_t>(patch) * 4 * packs * Lanes::width;
  const auto expand = [&](auto terms) {
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      Real c[most_terms];
      full_series<Lanes, packs>(lanes, patches, terms, rows, p, c);
      double unit = 1.0;
      RA2D_UNROLL
      for (int m = 0; m < 4; ++m) {  // repeated synthetic division by (eta' - eta)
        RA2D_KEEP_LOOP
        RA2D_UNROLL
        for (int j = terms - 2; j >= m; --j) c[j] = multiply_add(eta, c[j + 1], c[j]);
        shape[m][p] = Real(unit) * c[m];
        unit *= patches.inverse_radius;
      }
    }
  };
  if constexpr (Lanes::on_gpu) {
    expand(patches.terms);  // a GPU waits for code: one copy of it
  } else {
    // a constant number of terms stays in registers, and what they are divided by is a factor
    static_assert(most_terms == 24);
    switch (patches.terms) {
      case 4:
        return expand(std::integral_constant<int, 4>());
      case 8:
        return expand(std::integral_constant<int, 8>());
      case 12:
        return expand(std::integral_constant<int, 12>());
      case 16:
        return expand(std::integral_constant<int, 16>());
      case 20:
        return expand(std::integral_constant<int, 20>());
      default:
        return expand(std::integral_constant<int, 24>());
    }
  }
}

}  // namespace ra2d
