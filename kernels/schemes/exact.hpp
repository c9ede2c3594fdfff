// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "kernels/schemes/mode_step.hpp"

namespace ra2d {

/// Each mode in closed form, the force held over the step (zero-order hold):
///
///   U1 = U0 + (F0/(m omega^2) - U0) q + V0 p/omega,   V1 = V0 (1 - q - 2 zeta p) + (F0/(m omega) -
///   omega U0) p
///
/// where, at x = omega tau, p and q solve p'' + 2 zeta p' + p = 0 with p(0) = 0, p'(0) = 1 and q''
/// + 2 zeta q' + q = 1 with q(0) = q'(0) = 0: with zeta < 1, w = sqrt(1 - zeta^2), e = exp(-zeta
/// x),
///
///   p = e sin(w x)/w,   q = 1 - e (cos(w x) + zeta sin(w x)/w).
///
/// Exact for free modes and for forces that are constant over a step; of order 1 for others, since
/// the force is that of the beginning. Free modes are stable at every step, with the energy that
/// they should have.
///
/// The penalty spring, held, lags by half a step on average and so pushes harder on the way out
/// than on the way in: held in contact its energy grows by (omega_c tau)^2/2 a step, omega_c^2 = k
/// sum phi^2/m, unless the modes damp it more. A shock, half a period, gives back exp(pi omega_c
/// tau/2) of its energy.
///
/// Multipliers: as for Heun; the force that is held over the step is the multiplier.
struct Exact {
  static constexpr int order = 1, stages = 1;
  static constexpr double place[] = {0.0};
  static constexpr double velocity_lag = 0.0;

  static ModeStep prepare(const Mode& mode, double tau) {
    const double omega = mode.omega, zeta = mode.zeta;
    ModeStep step;
    if (omega == 0.0) {
      step.u_v = tau;
      step.u_f[0] = tau * tau / (2.0 * mode.mass);
      step.v_f[0] = tau / mode.mass;
      return step;
    }
    double p, q;
    answers(omega * tau, zeta, p, q);
    step.u_u = -q;
    step.u_v = p / omega;
    step.u_f[0] = q / (mode.mass * omega * omega);
    step.v_u = -omega * p;
    step.v_v = 1.0 - q - 2.0 * zeta * p;
    step.v_f[0] = p / (mode.mass * omega);
    return step;
  }

  /// p and q.
  static void answers(double x, double zeta, double& p, double& q) {
    if (x < 0.5 && zeta * x < 0.5) {  // the closed form of q loses its digits: q is about x^2/2
      double now = x, before = 0.0;   // terms of p's series, p_n = -(2 zeta x p_(n-1) + x^2
      p = x;                          // p_(n-2)/(n - 1))/n
      q = 0.0;
      for (int n = 2; n < 40; ++n) {
        const double next = -(2.0 * zeta * x * now + x * x * before / (n - 1)) / n;
        q += now * x / n;  // q' = p
        before = now;
        now = next;
        p += now;
      }
    } else if (zeta < 1.0) {
      const double w = std::sqrt(1.0 - zeta * zeta), e = std::exp(-zeta * x);
      p = e * std::sin(w * x) / w;
      q = 1.0 - e * std::cos(w * x) - zeta * p;
    } else if (zeta == 1.0) {
      p = x * std::exp(-x);
      q = 1.0 - std::exp(-x) - p;
    } else {  // two decays, of rates zeta + w and its inverse
      const double w = std::sqrt(zeta * zeta - 1.0), fast = zeta + w, slow = 1.0 / fast;
      p = -std::exp(-slow * x) * std::expm1(-2.0 * w * x) / (2.0 * w);
      q = (slow * std::expm1(-fast * x) - fast * std::expm1(-slow * x)) / (2.0 * w);
    }
  }
};

}  // namespace ra2d
