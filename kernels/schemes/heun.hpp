// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/runge_kutta.hpp"

namespace ra2d {

/// Heun's scheme, the explicit trapezoidal rule, RK2 (paper, table 1):
///
///   k1 = f(t, y0),   k2 = f(t + tau, y0 + tau k1),   y1 = y0 + tau (k1 + k2)/2.
///
/// Order 2. With x = omega tau, R = 1 + z + z^2/2,
///
///   |R|^2 = 1 - 2 zeta x + 2 zeta^2 x^2 - zeta x^3 + x^4/4:
///
/// stable up to the root of x^3/4 - zeta x^2 + 2 zeta^2 x - 2 zeta = 0: 2 zeta^(1/3) + 4 zeta/3,
/// less 4/9 zeta^(5/3) and so on. Without damping it is unstable at every step (the paper's table
/// says sqrt(2)/omega): its energy grows by x^4/4.
///
/// The penalty spring is such a mode with omega_c^2 = k sum phi^2/m and the little damping that the
/// modes bring to it. A shock, half a period, gives back exp(pi (omega_c tau)^3/4) of its energy;
/// what onset and release within a step add is larger, O((omega_c tau)^2).
///
/// Multipliers: the force is the same at both stages. U1 - U0 of a force is then half of tau (V1 -
/// V0), and a mass that hits at a share theta of a step leaves at -(1 - 2 theta) of its speed
/// (kernels/contact/complementarity.hpp). A node that is held to a face turns its velocity at every
/// step, and with it grows by the mean of x^2/2 - 2 zeta x over the modes, weighted with phi^2/m:
/// stiff modes need x < 4 zeta, or contact that should last chatters, at velocities of the load's
/// tau/m.
struct Heun {
  static constexpr int order = 2, stages = 2;
  static constexpr double place[] = {0.0, 1.0};
  static constexpr double velocity_lag = 0.0;
  static constexpr double a(int, int) { return 1.0; }
  static constexpr double b(int) { return 0.5; }

  static ModeStep prepare(const Mode& mode, double tau) { return runge_kutta<Heun>(mode, tau); }
};

}  // namespace ra2d
