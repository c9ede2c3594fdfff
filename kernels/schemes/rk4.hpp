// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/runge_kutta.hpp"

namespace ra2d {

/// The classical Runge-Kutta scheme (paper, table 1):
///
///   k1 = f(t, y0),                      k2 = f(t + tau/2, y0 + tau/2 k1),
///   k3 = f(t + tau/2, y0 + tau/2 k2),   k4 = f(t + tau, y0 + tau k3),
///   y1 = y0 + tau (k1 + 2 k2 + 2 k3 + k4)/6.
///
/// Order 4. R = 1 + z + z^2/2 + z^3/6 + z^4/24. Without damping, x = omega tau,
///
///   |R|^2 = 1 - x^6/72 + x^8/576:   stable for x <= 2 sqrt(2) = 2.828,
///
/// and an undamped mode's energy falls by x^6/72 a step. With damping the limit, the smallest root
/// of |R(x (-zeta + i sqrt(1 - zeta^2)))| = 1, lies between 2.62 (zeta = 0.53) and 2.96 (zeta =
/// 0.15); it is 2.785 on the real axis (zeta = 1).
///
/// The penalty spring adds omega_c^2 = k sum phi^2/m to the stiffest modes': omega_c tau <= 2.828.
/// A smooth shock would lose pi (omega_c tau)^5/72 of its energy; onset and release within a step
/// are kinks of the force and bring an error of O((omega_c tau)^2) of either sign.
///
/// Multipliers: as for Heun.
struct Rk4 {
  static constexpr int order = 4, stages = 4;
  static constexpr double place[] = {0.0, 0.5, 0.5, 1.0};
  static constexpr double velocity_lag = 0.0;
  static constexpr double a(int i, int j) { return j != i - 1 ? 0.0 : i == 3 ? 1.0 : 0.5; }
  static constexpr double b(int i) { return i == 0 || i == 3 ? 1.0 / 6.0 : 1.0 / 3.0; }

  static ModeStep prepare(const Mode& mode, double tau) { return runge_kutta<Rk4>(mode, tau); }
};

}  // namespace ra2d
