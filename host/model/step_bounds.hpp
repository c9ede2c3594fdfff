// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/mode_step.hpp"

namespace ra2d {

/// What a scheme can do to a mode within a number of steps, for the guarantee in
/// kernels/candidates.hpp. In terms of the energy norm E^2 = V^2 + omega^2 U^2 of the state that
/// the steps begin with, and of a modal force |F| <= f at every stage:
///
///   |U_n - U_0 - n tau V_0| <= n (n + 1)/2 tau^2 (pull (E + n tau force f) + force f),
///
/// and the same with (n + 1)(n + 2)/2 for the displacements that the stages of step n see, against
/// the line at their own time.
///
/// Let M be the step of (omega U, V). Then E_n <= growth (E + n tau force f), growth the largest
/// norm of M^j, j <= n; and a step departs from U + tau V, and V from itself, by no more than tau
/// times pull/growth of that.
struct StepBounds {
  double growth = 1;  // at least 1
  double pull = 0;    // 1/s
  double force = 0;   // 1/mass
};

/// For steps of `tau` [s] with stages at `place`, over up to `steps` of them.
StepBounds bound_step(const Mode& mode, const ModeStep& step, const double* place, double tau,
                      int steps);

}  // namespace ra2d
