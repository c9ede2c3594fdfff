// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/plan/stability.hpp"

/// How fast a motion grows from step to step, measured on the march.
namespace ra2d {

/// One mode, free or held in contact at its middle by a penalty spring a thousand times as stiff as
/// it is.
struct TrialMode {
  explicit TrialMode(bool contact);
  bool contact;
  double omega;      // rad/s, of what the step is measured against: the mode, or the spring omega_c
  double stiffness;  // N/m, of the spring; 0 when free
  double omega_free;  // rad/s, of the mode
  double mass;        // kg/m
  double square;      // psi^2 at the spring, 1/m
  /// The mode and its contact as the theory has them.
  JoinedModes joined(double zeta) const;
};

/// A step to be tried: x = omega tau, with the frequency of the mode or of the contact spring.
struct GrowthTrial {
  TimeSettings choice;
  bool contact = false;
  double zeta = 0;
  double x = 0;
};

/// The natural logarithm of the factor by which a step multiplies the fastest growing motion, of
/// each trial.
///
/// Two motions are marched side by side, one from a displacement, one from a velocity. Their states
/// at the start and n steps later give the matrix of n steps, and its spectral radius is the factor
/// to the power n: what swings and comes back does not count as growth. n is the largest power of
/// two up to `steps` for which the motions are still well above the roundings and, of a mode in
/// contact, keep it closed (of a free one, stay clear of it). So growth by 1e-10 a step is
/// distinguished from none.
std::vector<double> measure_growth(const std::vector<GrowthTrial>& trials, int steps);

}  // namespace ra2d
