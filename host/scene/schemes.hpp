// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "kernels/schemes/mode_step.hpp"

/// The schemes by the names that a scene gives them.
namespace ra2d {

/// A scheme of kernels/schemes/, to be chosen at run time.
struct SchemeTable {
  int order, stages;
  const double* place;  // (stages)
  double velocity_lag;
  ModeStep (*prepare)(const Mode&, double tau);
  /// Coefficients of the stability polynomial R(z), y1 = R(tau lambda) y0 for y' = lambda y, from
  /// the constant on: Runge-Kutta schemes; empty for the others.
  std::vector<double> polynomial;
};

/// Whether the steps are found during the march, to a tolerance. There is no fixed step and no
/// scheme_table() then.
bool is_adaptive(const TimeSettings& time);
bool is_adaptive(const Scene& scene);

/// Of a scheme of fixed steps.
const SchemeTable& scheme_table(SchemeKind scheme);

/// Mean square of a free mode's velocity, over that of the scheme's V at its steps.
double mean_square(const TimeSettings& time, const Mode& mode, double tau);

/// Whether U1 = U0 + tau V1: with the force of the old time the shortest form of a step.
bool is_semi_implicit(SchemeKind scheme);

/// Whether multipliers can keep the end of a step free of penetration: not where the force of a
/// step does not move it (kernels/schemes/explicit_euler.hpp), nor where there is no step to decide
/// what an impact gives back (adaptive).
bool takes_multipliers(SchemeKind scheme);

/// Whether the scene's contact forces are found together with the end of the step
/// (kernels/contact/complementarity.hpp).
bool holds_forces(const Scene& scene);

}  // namespace ra2d
