// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/lanes.hpp"
#include "kernels/model.hpp"

/// The resonator's displacement on a patch, as a polynomial of 4 Q terms (kernels/model.hpp, "Patches"),
/// and its transpose, the projection of nodal forces on the modes.
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

/// F_k -= sum_j radius^j psi_k^(j)(centre)/j! moment_j, with moment_j = sum_n f_n eta_n^j: the modal force
/// of all the nodes of a patch (paper, the line under equation 6).
template <class Lanes, int K, int Q>
KOKKOS_FORCEINLINE_FUNCTION void project(const Lanes& lanes, const double* rows,
                                         const typename Lanes::Real* quartic, const double* moment,
                                         typename Lanes::Real* force) {
  using Real = typename Lanes::Real;
  for (int p = 0; p < K; ++p) {
    Real pair[2] = {Real(0.0), Real(0.0)};
    for (int j = 0; j < 4; ++j) {
      Real weight(series_factor(Q - 1, j) * moment[4 * (Q - 1) + j]);
      for (int s = Q - 2; s >= 0; --s)
        weight = multiply_add(quartic[p], weight, Real(series_factor(s, j) * moment[4 * s + j]));
      pair[j % 2] = multiply_add(lanes.load(rows + (j * K + p) * Lanes::width), weight, pair[j % 2]);
    }
    force[p] = force[p] - (pair[0] + pair[1]);
  }
}

/// psi_k at a place of the resonator, `position` in chi: one pack of modes at a time.
template <class Lanes, int K, int Q>
KOKKOS_FORCEINLINE_FUNCTION void mode_shapes(const Lanes& lanes, const SceneTables& t,
                                             const typename Lanes::Real* quartic, double position,
                                             typename Lanes::Real* shape) {
  using Real = typename Lanes::Real;
  int patch = static_cast<int>(position) / t.patch_nodes;
  patch = patch < t.patches ? patch : t.patches - 1;
  const double eta = (position - (patch + 0.5) * t.patch_nodes) * t.inverse_radius;
  const double eta4 = (eta * eta) * (eta * eta);
  const double* rows = t.patch + static_cast<std::int64_t>(patch) * 4 * K * Lanes::width;
  for (int p = 0; p < K; ++p) {
    Real value(0.0);
    double power = 1.0;
    for (int j = 0; j < 4; ++j) {
      Real weight(series_factor(Q - 1, j));
      for (int s = Q - 2; s >= 0; --s)
        weight = multiply_add(quartic[p] * Real(eta4), weight, Real(series_factor(s, j)));
      value = multiply_add(lanes.load(rows + (j * K + p) * Lanes::width) * Real(power), weight, value);
      power *= eta;
    }
    shape[p] = value;
  }
}

}  // namespace ra2d
