// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/mode_step.hpp"

namespace ra2d {

/// An explicit Runge-Kutta scheme on y = (U, V), y' = f(t, y) (paper, section 4):
///
///   k_i = f(t + c_i tau, y0 + tau sum_{j<i} a_ij k_j),   y1 = y0 + tau sum_i b_i k_i,
///
/// `Tableau` has stages, place[i] = c_i, a(i, j) and b(i). A force F_i that stays fixed while stage
/// i is taken enters k_i alone: so a step is linear in U0, V0 and the F_i, and its weights are its
/// answers to a one in each of them.
template <class Tableau>
ModeStep runge_kutta(const Mode& mode, double tau) {
  constexpr int s = Tableau::stages;
  ModeStep step;
  step.stages = s;
  // input 0: U0 = 1; 1: V0 = 1; 2 + j: F_j = 1
  for (int input = 0; input < 2 + s; ++input) {
    const double u0 = input == 0, v0 = input == 1;
    double rate_u[s], rate_v[s];
    double end_u = 0, end_v = 0;  // increments
    for (int i = 0; i < s; ++i) {
      double du = 0, dv = 0;
      for (int j = 0; j < i; ++j) {
        du += tau * Tableau::a(i, j) * rate_u[j];
        dv += tau * Tableau::a(i, j) * rate_v[j];
      }
      const double force = input == 2 + i ? 1.0 : 0.0;
      rate_u[i] = v0 + dv;
      rate_v[i] = force / mode.mass - 2.0 * mode.zeta * mode.omega * (v0 + dv) -
                  mode.omega * mode.omega * (u0 + du);
      end_u += tau * Tableau::b(i) * rate_u[i];
      end_v += tau * Tableau::b(i) * rate_v[i];
      if (input == 0)
        step.stage_u[i] = du;
      else if (input == 1)
        step.stage_v[i] = du;
      else
        step.stage_f[i][input - 2] = du;
    }
    if (input == 0) {
      step.u_u = end_u;
      step.v_u = end_v;
    } else if (input == 1) {
      step.u_v = end_u;
      step.v_v = 1.0 + end_v;
    } else {
      step.u_f[input - 2] = end_u;
      step.v_f[input - 2] = end_v;
    }
  }
  return step;
}

}  // namespace ra2d
