// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/mode_step.hpp"

namespace ra2d {

/// Midpoint scheme: central differences, the velocity staggered by half a step (paper, table 1;
/// docs/paper.md). With V0 at t - tau/2 and V1 at t + tau/2,
///
///   (V1 - V0)/tau = F0/m - 2 zeta omega (V0 + V1)/2 - omega^2 U0,   U1 = U0 + tau V1
///
/// so, damping being centred,
///
///   V1 = ((1 - zeta omega tau) V0 - tau omega^2 U0 + tau F0/m) / (1 + zeta omega tau).
///
/// Order 2: the velocity at t is (V0 + V1)/2, and that is what samples hold. With x = omega tau the
/// two-step form U+ (1 + zeta x) - U (2 - x^2) + U- (1 - zeta x) = 0 has its roots within the unit
/// circle for
///
///   x < 2, whatever zeta.
///
/// Without damping both roots are on the circle: no energy is lost or gained, it swings by O(x).
/// The period is too short by x^2/24 of itself.
///
/// The penalty spring is one of the forces at the old displacement. In contact at one node a period
/// of two steps is the first to grow, when
///
///   sum_j k phi_j^2 tau^2 / (m_j (4 - (omega_j tau)^2)) = 1,
///
/// omega_c tau = 2 while the omega_j tau are small. A shock gives back its energy up to the error
/// that onset and release within a step bring, O((omega_c tau)^2).
///
/// Multipliers: U1 = U0 + tau V1 as for backward Euler, so an impact of a mass is inelastic
/// (Carpenter, Taylor and Katona, Int. J. Numer. Meth. Eng. 32, 1991). While a node touches,
/// samples hold the velocity half a step before.
struct Midpoint {
  static constexpr int order = 2, stages = 1;
  static constexpr double place[] = {0.0};
  static constexpr double velocity_lag = 0.5;

  static ModeStep prepare(const Mode& mode, double tau) {
    const double damping = mode.zeta * mode.omega * tau;
    return ModeStep::semi_implicit((1.0 - damping) / (1.0 + damping),
                                   -tau * mode.omega * mode.omega / (1.0 + damping),
                                   tau / (mode.mass * (1.0 + damping)), tau);
  }
};

}  // namespace ra2d
