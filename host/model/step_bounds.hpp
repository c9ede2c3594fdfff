// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/mode_step.hpp"

namespace ra2d {

/// Bounds on the motion of a mode within a number of steps of a scheme. The proof of
/// kernels/candidates.hpp rests on them. In terms of the energy norm E^2 = V^2 + omega^2 U^2 of the
/// state that the steps begin with, and of a modal force |F| <= f at every stage:
///
///   |U_n - U_0 - n tau V_0| <= n (n + 1)/2 tau^2 (a (E + n tau b f) + b f),
///
/// with a = acceleration_per_energy_norm and b = acceleration_per_force. The displacements that the
/// stages of step n see keep the bound with (n + 1)(n + 2)/2, against the line at their own time.
///
/// Let M be the step of (omega U, V). Then E_n <= growth (E + n tau b f), growth the largest norm
/// of M^j, j <= n. A step departs from U + tau V, and V from itself, by no more than tau a/growth
/// of that.
struct StepBounds {
  double growth = 1;                        // at least 1
  double acceleration_per_energy_norm = 0;  // 1/s
  double acceleration_per_force = 0;        // 1/mass
};

/// Bounds over up to `steps` steps of `tau` [s] with stages at `place`.
StepBounds bound_step(const Mode& mode, const ModeStep& step, const double* place, double tau,
                      int steps);

}  // namespace ra2d
