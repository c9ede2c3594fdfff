// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "kernels/schemes/exact.hpp"
#include "kernels/schemes/mode_step.hpp"

namespace ra2d {

/// Gautschi's scheme: the midpoint scheme with each mode in closed form (W. Gautschi, Numer. Math.
/// 3, 1961; M. Hochbruck and C. Lubich, Numer. Math. 83, 1999). With x = omega tau, e = exp(-zeta
/// x), c = cos(sqrt(1 - zeta^2) x) and w = 1 - 2 e c + e^2, the two-step form
///
///   U+ - 2 e c U + e^2 U- = w F/(m omega^2)
///
/// is exact for free modes, and for forces that do not change. With V = (U+ - U)/tau, half a step
/// behind as in the midpoint scheme,
///
///   V1 = e^2 V0 - w U0/tau + w F0/(m omega^2 tau),   U1 = U0 + tau V1.
///
/// Order 2 for forces that change. The velocity at U0 is, with p of `exact`,
///
///   x/(2 p) (V1 + e^2 V0) + omega ((1 - e^2)/(2 p) - zeta) (U0 - F0/(m omega^2)),
///
/// also exact for free modes; samples hold it. At x = pi a step is half a period, and there is no
/// such velocity.
///
/// In contact at one node a period of two steps is the first to grow, when
///
///   sum_j k phi_j^2 w_j / (m_j omega_j^2 (2 (1 + e_j^2) - w_j)) = 1:
///
/// z^2 - z B + D, with D of all e_j^2 and B of all 2 e_j c_j less the spring, has its roots within
/// the unit circle where 1 + D - B and 1 + D + B are positive. Without damping the summand is k
/// phi^2 tan^2(x/2)/(m omega^2), and the limit omega_c tau = 2 while the x_j are small. A shock
/// gives back its energy as with the midpoint scheme.
///
/// Multipliers: as for the midpoint scheme.
struct Gautschi {
  static constexpr int order = 2, stages = 1;
  static constexpr double place[] = {0.0};
  static constexpr double velocity_lag = 0.5;

  static ModeStep prepare(const Mode& mode, double tau) {
    const double omega = mode.omega, zeta = mode.zeta, x = omega * tau;
    if (omega == 0.0) return ModeStep::semi_implicit(1.0, 0.0, tau / mode.mass, tau);
    const double decay = std::exp(-zeta * x), square = decay * decay, w = turned(x, zeta);
    ModeStep step =
        ModeStep::semi_implicit(square, -w / tau, w / (mode.mass * omega * omega * tau), tau);
    double p, q;
    Exact::answers(x, zeta, p, q);
    // in V0 and what the step adds to it, v_u U0 + v_f F0
    const double lost = -std::expm1(-2.0 * zeta * x) / (2.0 * p);
    step.now_mean = 2.0 * x * square / (p * (1.0 + square));
    step.now_pushed = x * lost / (1.0 + square) - x * (lost - zeta) / w;
    // of a free mode V has |exp(lambda tau) - 1|/tau times the amplitude of U, its velocity omega
    if (zeta < 1.0) step.mean_square = x * x * decay / w;
    return step;
  }

 private:
  /// w, without the cancellation of its terms.
  static double turned(double x, double zeta) {
    const double root = std::sqrt(std::abs(1.0 - zeta * zeta));
    if (zeta >= 1.0) return std::expm1(-(zeta + root) * x) * std::expm1(-x / (zeta + root));
    const double fall = std::expm1(-zeta * x), half = std::sin(0.5 * root * x);
    return fall * fall + 4.0 * std::exp(-zeta * x) * half * half;
  }
};

}  // namespace ra2d
