// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/mode_step.hpp"

namespace ra2d {

/// Backward Euler, the paper's main scheme:
///
///   U1 = U0 + tau V1,   V1 = V0 + tau (F/m - 2 zeta omega V1 - omega^2 U1)
///
/// so, with s = 1 + 2 zeta omega tau + (omega tau)^2,
///
///   V1 = (V0 - tau omega^2 U0 + tau F/m) / s.
///
/// Order 1. Without contact it is stable for every step: energy m (V^2 + omega^2 U^2) / 2 never
/// grows, an undamped mode loses the share 1 - 1/s of it at each step (numerical damping ratio
/// omega tau / 2).
///
/// The paper takes the contact force at the old time, F = F(U0). Then the penalty spring brings a
/// limit of its own. With F = -sum_n k_n phi_n (phi_n . U) a period of two steps (U1 = -U0, V1 =
/// -V0) is the first to grow; for one node it does so when
///
///   sum_j k phi_j^2 tau^2 / (m_j (4 + 4 zeta_j omega_j tau + (omega_j tau)^2)) = 1,
///
/// which is omega_c tau = 2 with omega_c^2 = k sum_j phi_j^2/m_j while all omega_j tau are small.
/// Below it the pair (U, V) is advanced like symplectic Euler: the contact energy swings by
/// O(omega_c tau) within a shock and comes back to first order in tau.
///
/// Fully implicit (time.contact_force = "new"), F = F(U1), the contact is found together with the
/// step (kernels/contact/complementarity.hpp). It is then stable for every step in contact, too,
/// and the contact spring is damped like any mode: a shock, half a period of omega_c, gives back
/// exp(-pi omega_c tau) of its energy.
///
/// Multipliers: U1 = U0 + tau V1 puts a node that would penetrate on the face, and leaves it there:
/// an impact of a mass is inelastic. What comes back comes through the modes.
struct BackwardEuler {
  static constexpr int order = 1, stages = 1;
  static constexpr double place[] = {0.0};
  static constexpr double velocity_lag = 0.0;

  static ModeStep prepare(const Mode& mode, double tau) {
    const double x = mode.omega * tau;
    const double s = 1.0 + 2.0 * mode.zeta * x + x * x;
    return ModeStep::semi_implicit(1.0 / s, -tau * mode.omega * mode.omega / s,
                                   tau / (mode.mass * s), tau);
  }
};

}  // namespace ra2d
