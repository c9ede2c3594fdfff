// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/lanes.hpp"

namespace ra2d {

/// Backward Euler, the paper's main scheme, with the contact force taken at the old time:
///
///   U1 = U0 + tau V1,   V1 = V0 + tau (F0/m - 2 zeta omega V1 - omega^2 U1)
///
/// so, with s = 1 + 2 zeta omega tau + (omega tau)^2,
///
///   V1 = (V0 - tau omega^2 U0 + tau F0/m) / s.
///
/// Order 1. Without contact it is stable for every step: energy m (V^2 + omega^2 U^2) / 2 never
/// grows, an undamped mode loses the share 1 - 1/s of it at each step (numerical damping omega tau
/// / 2).
///
/// The penalty spring, explicit, brings a limit of its own. With F = -sum_n k_n phi_n (phi_n . U) a
/// period of two steps (U1 = -U0, V1 = -V0) is the first to grow; for one node it does so when
///
///   sum_j k phi_j^2 tau^2 / (m_j (4 + 4 zeta_j omega_j tau + (omega_j tau)^2)) = 1,
///
/// which is omega_c tau = 2 with omega_c^2 = k sum_j phi_j^2/m_j while all omega_j tau are small.
/// Below it the pair (U, V) is advanced like symplectic Euler: the contact energy swings by
/// O(omega_c tau) within a shock and comes back to first order in tau.
struct BackwardEuler {
  static constexpr int order = 1;
  static constexpr int coefficients = 3;

  /// The coefficients of one mode: V1 = c[0] V0 + c[1] U0 + c[2] F0.
  static void prepare(double omega, double zeta, double mass, double tau, double* c) {
    const double s = 1.0 + 2.0 * zeta * omega * tau + (omega * tau) * (omega * tau);
    c[0] = 1.0 / s;
    c[1] = -tau * omega * omega / s;
    c[2] = tau / (mass * s);
  }

  /// Bound on a free mode's |V1 - V0|/tau over its energy norm sqrt(V^2 + omega^2 U^2), which never
  /// grows.
  static double pull(double omega, double zeta) { return (1.0 + 2.0 * zeta) * omega; }

  /// One step. `kick` is c[2] F0.
  template <class Real>
  KOKKOS_FORCEINLINE_FUNCTION static void advance(Real& u, Real& v, const Real& c0, const Real& c1,
                                                  const Real& kick, const Real& tau) {
    v = multiply_add(c0, v, multiply_add(c1, u, kick));
    u = multiply_add(tau, v, u);
  }
};

}  // namespace ra2d
