// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A time scheme, as a table for the march.
///
/// A mode is linear, m (U'' + 2 zeta omega U' + omega^2 U) = F, and so is every scheme here: the
/// displacement at a stage and the state at the end of a step are sums of U0, V0 and the forces at
/// the stages so far. A scheme is told completely by the weights in these sums, one set a mode,
/// worked out once. The march sees the weights and no scheme: it evaluates the contact at each
/// stage and sums (kernels/fixed). So every scheme has the same arithmetic in free flight,
/// where the forces are constant, and pays for its stages where there is contact.
///
/// Each scheme is one struct with the same members:
///
///   order          of the error over a fixed time, for smooth forces
///   stages         evaluations of the force in a step
///   place          when each of them is taken, in steps; the first is always at the old time
///   velocity_lag   how many steps V lags behind U
///   prepare        the weights for one mode
namespace ra2d {

/// One mode of a body: angular frequency [rad/s], damping ratio, mass per length [kg/m].
struct Mode {
  double omega, zeta, mass;
};

inline constexpr int most_stages = 11;

/// The weights of one mode in one step.
struct ModeStep {
  int stages = 1;
  /// Stage i sees the displacement U0 + stage_u[i] U0 + stage_v[i] V0 + sum_{j<i} stage_f[i][j]
  /// F_j. The first sees U0.
  double stage_u[most_stages] = {}, stage_v[most_stages] = {};
  double stage_f[most_stages][most_stages] = {};
  /// U1 = U0 + u_u U0 + u_v V0 + sum_j u_f[j] F_j. What is added to U0 is small: written so, the
  /// rounding of a weight does not detune the mode.
  double u_u = 0, u_v = 0, u_f[most_stages] = {};
  /// V1 = v_u U0 + v_v V0 + sum_j v_f[j] F_j.
  double v_u = 0, v_v = 1, v_f[most_stages] = {};
  /// Where V lags behind U: the velocity at U0 is now_mean times the mean of V0 and V1 (as
  /// velocity_lag weighs them) + now_pushed (v_u U0 + v_f F0).
  double now_mean = 1, now_pushed = 0;
  /// Mean square of a free mode's velocity, over that of the scheme's V.
  double mean_square = 1;

  /// The weights of a force that is the same at every stage.
  double held_u() const {
    double sum = 0;
    for (int j = 0; j < stages; ++j) sum += u_f[j];
    return sum;
  }
  double held_v() const {
    double sum = 0;
    for (int j = 0; j < stages; ++j) sum += v_f[j];
    return sum;
  }
  double held_stage(int i) const {
    double sum = 0;
    for (int j = 0; j < i; ++j) sum += stage_f[i][j];
    return sum;
  }

  /// Of the schemes with U1 = U0 + tau V1: the rest follows from what V1 is made of.
  static ModeStep semi_implicit(double v_v, double v_u, double v_f, double tau) {
    ModeStep step;
    step.v_v = v_v;
    step.v_u = v_u;
    step.v_f[0] = v_f;
    step.u_u = tau * v_u;
    step.u_v = tau * v_v;
    step.u_f[0] = tau * v_f;
    return step;
  }
};

}  // namespace ra2d
