// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/step_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace ra2d {
namespace {

constexpr double most_growth = 1e100;  // products of such numbers are finite

struct Matrix {
  double a, b, c, d;
};
Matrix square(const Matrix& m) {
  return {m.a * m.a + m.b * m.c, m.b * (m.a + m.d), m.c * (m.a + m.d), m.b * m.c + m.d * m.d};
}
/// Largest singular value.
double norm(const Matrix& m) {
  return 0.5 * (std::hypot(m.a + m.d, m.b - m.c) + std::hypot(m.a - m.d, m.b + m.c));
}

/// Bound on the norm of all powers up to `steps`. With s_j that of the powers below 2^j, s_(j+1) <=
/// s_j max(1, |M^(2^j)|).
double growth_of(Matrix m, int steps) {
  double bound = 1.0;
  for (int power = 1; power <= steps && bound < most_growth; power *= 2) {
    bound *= std::max(1.0, norm(m));
    m = square(m);
  }
  // a product of matrices has a few dozen roundings
  return bound < most_growth ? bound * (1.0 + 1e-14) : most_growth;
}

}  // namespace

StepBounds bound_step(const Mode& mode, const ModeStep& step, const double* place, double tau,
                      int steps) {
  const double omega = mode.omega;
  // norm of a functional of (omega U, V); U of a mode without stiffness acts on nothing
  const auto size = [&](double of_u, double of_v) {
    return std::hypot(omega > 0 ? of_u / omega : 0.0, of_v);
  };
  StepBounds b;
  if (omega > 0)
    b.growth = growth_of({1.0 + step.u_u, omega * step.u_v, step.v_u / omega, step.v_v}, steps);
  double acceleration =
      std::max(size(step.v_u, step.v_v - 1.0) / tau, size(step.u_u, step.u_v - tau) / (tau * tau));
  for (int i = 1; i < step.stages; ++i)
    acceleration = std::max(acceleration,
                            size(step.stage_u[i], step.stage_v[i] - place[i] * tau) / (tau * tau));
  b.acceleration_per_energy_norm = b.growth * acceleration;

  double v = 0, u = 0, energy = 0;
  for (int j = 0; j < step.stages; ++j) {
    v += std::abs(step.v_f[j]);
    u += std::abs(step.u_f[j]);
    energy += std::hypot(omega * step.u_f[j], step.v_f[j]);
  }
  double force = std::max({v / tau, u / (tau * tau), energy / tau});
  for (int i = 1; i < step.stages; ++i) {
    double stage = 0;
    for (int j = 0; j < i; ++j) stage += std::abs(step.stage_f[i][j]);
    force = std::max(force, stage / (tau * tau));
  }
  b.acceleration_per_force = b.growth * force;
  return b;
}

}  // namespace ra2d
