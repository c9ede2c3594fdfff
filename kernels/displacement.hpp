// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/lanes.hpp"
#include "kernels/model.hpp"

/// The resonator's displacement on a patch, as a polynomial of 4 Q terms (kernels/model.hpp, "Patches").
namespace ra2d {

/// j! / (j + 4 s)!: term 4 s + j of the series over the stored derivative j.
KOKKOS_INLINE_FUNCTION constexpr double series_factor(int s, int j) {
  double product = 1.0;
  for (int i = j + 1; i <= j + 4 * s; ++i) product *= i;
  return 1.0 / product;
}

/// sum_j q_j eta^j: by pairs, so that the chain of dependent operations is short.
template <int Q, class Real>
KOKKOS_FORCEINLINE_FUNCTION Real series_value(const double* q, const Real& eta) {
  const Real eta2 = eta * eta, eta4 = eta2 * eta2;
  const auto quad = [&](const double* c) {
    const Real high = multiply_add(c[3], eta, Real(c[2])), low = multiply_add(c[1], eta, Real(c[0]));
    return multiply_add(high, eta2, low);
  };
  Real value = quad(q + 4 * (Q - 1));
  for (int s = Q - 2; s >= 0; --s) value = multiply_add(value, eta4, quad(q + 4 * s));
  return value;
}

/// sum_j j q_j eta^(j-1).
template <int Q, class Real>
KOKKOS_FORCEINLINE_FUNCTION Real series_slope(const double* q, const Real& eta) {
  Real value((4 * Q - 1) * q[4 * Q - 1]);
  for (int j = 4 * Q - 2; j >= 1; --j) value = multiply_add(value, eta, Real(j * q[j]));
  return value;
}

/// Modal amplitudes times the powers of (beta radius)^4 that the later terms of the series need.
template <class Lanes, int K, int Q>
struct ModalPowers {
  using Real = typename Lanes::Real;
  Real u[Q][K];

  KOKKOS_FORCEINLINE_FUNCTION ModalPowers(const Real* amplitude, const Real* quartic) {
    for (int p = 0; p < K; ++p) u[0][p] = amplitude[p];
    for (int s = 1; s < Q; ++s)
      for (int p = 0; p < K; ++p) u[s][p] = u[s - 1][p] * quartic[p];
  }
};

/// q_j = sum_k U_k radius^j psi_k^(j)(centre) / j!, j = 0 .. 4 Q - 1. `rows` is (4, lane) of the patch.
template <class Lanes, int K, int Q>
KOKKOS_FORCEINLINE_FUNCTION void series_coefficients(const Lanes& lanes, const double* rows,
                                                     const ModalPowers<Lanes, K, Q>& modal, double* q) {
  using Real = typename Lanes::Real;
  for (int j = 0; j < 4; ++j) {
    Real row[K];
    for (int p = 0; p < K; ++p) row[p] = lanes.load(rows + (j * K + p) * Lanes::width);
    for (int s = 0; s < Q; ++s) {
      Real part = row[0] * modal.u[s][0];
      for (int p = 1; p < K; ++p) part = multiply_add(row[p], modal.u[s][p], part);
      q[4 * s + j] = series_factor(s, j) * lanes.sum(part);
    }
  }
}

/// psi_k at a place of the resonator, for all packs of modes. `position` in chi, on the beam.
template <class Lanes, int K, int Q>
KOKKOS_INLINE_FUNCTION void mode_values(const Lanes& lanes, const SceneTables& t, double position,
                                        typename Lanes::Real (&value)[K]) {
  using Real = typename Lanes::Real;
  const int patch = static_cast<int>(position) / t.patch_nodes;
  const double eta = (position - (patch + 0.5) * t.patch_nodes) * t.inverse_radius;
  const Real eta4((eta * eta) * (eta * eta));
  const double* rows = t.patch + static_cast<std::int64_t>(patch) * 4 * K * Lanes::width;
  for (int p = 0; p < K; ++p) {
    const Real ratio = lanes.load(t.quartic + p * Lanes::width) * eta4;
    double power = 1.0;
    value[p] = Real(0.0);
    for (int j = 0; j < 4; ++j) {
      Real tail(series_factor(Q - 1, j));
      for (int s = Q - 2; s >= 0; --s) tail = multiply_add(ratio, tail, Real(series_factor(s, j)));
      value[p] = multiply_add(Real(power) * lanes.load(rows + (j * K + p) * Lanes::width), tail, value[p]);
      power *= eta;
    }
  }
}

/// The polynomials of all modes about a place of the resonator: shape[m][p] is the m-th derivative over m!,
/// per chi^m, of pack p of the modes, m = 0 .. 3. `position` in chi; `patch` one whose series holds there.
template <class Lanes, int K, int Q>
KOKKOS_INLINE_FUNCTION void expand_modes(const Lanes& lanes, const SceneTables& t, int patch,
                                         double position, typename Lanes::Real (&shape)[4][K]) {
  using Real = typename Lanes::Real;
  constexpr int terms = 4 * Q;
  const Real eta((position - (patch + 0.5) * t.patch_nodes) * t.inverse_radius);
  const double* rows = t.patch + static_cast<std::int64_t>(patch) * 4 * K * Lanes::width;
  for (int p = 0; p < K; ++p) {
    const Real quartic = lanes.load(t.quartic + p * Lanes::width);
    Real c[terms];
    for (int j = 0; j < 4; ++j) {
      Real row = lanes.load(rows + (j * K + p) * Lanes::width);
      for (int s = 0; s < Q; ++s) {
        c[4 * s + j] = Real(series_factor(s, j)) * row;
        row = row * quartic;
      }
    }
    double unit = 1.0;
    for (int m = 0; m < 4; ++m) {  // repeated synthetic division by (eta' - eta)
      for (int j = terms - 2; j >= m; --j) c[j] = multiply_add(eta, c[j + 1], c[j]);
      shape[m][p] = Real(unit) * c[m];
      unit *= t.inverse_radius;
    }
  }
}

}  // namespace ra2d
