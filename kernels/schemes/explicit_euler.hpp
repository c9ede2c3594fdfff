// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/runge_kutta.hpp"

namespace ra2d {

/// Explicit Euler (paper, table 1):
///
///   U1 = U0 + tau V0,   V1 = V0 + tau (F0/m - 2 zeta omega V0 - omega^2 U0).
///
/// Order 1. With x = omega tau a free mode's amplitude is multiplied at each step by |R|,
///
///   |R|^2 = 1 - 2 zeta x + x^2:   stable for x <= 2 zeta (zeta <= 1).
///
/// Without damping it grows at every step, its energy by x^2.
///
/// The penalty spring, omega_c^2 = k sum phi^2/m, is such a mode: held in contact it is stable only
/// where the modes bring damping enough to it, omega_c tau <= 2 zeta_c. A shock, half a period of
/// omega_c, gives back exp(pi omega_c tau) of the energy that it took, to first order.
///
/// Multipliers: refused. U1 does not depend on F0, so no force of this step keeps its end free of
/// penetration.
struct ExplicitEuler {
  static constexpr int order = 1, stages = 1;
  static constexpr double place[] = {0.0};
  static constexpr double velocity_lag = 0.0;
  static constexpr double a(int, int) { return 0.0; }
  static constexpr double b(int) { return 1.0; }

  static ModeStep prepare(const Mode& mode, double tau) {
    return runge_kutta<ExplicitEuler>(mode, tau);
  }
};

}  // namespace ra2d
