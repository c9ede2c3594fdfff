// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "kernels/fixed/advance.hpp"
#include "kernels/lanes.hpp"
#include "kernels/schemes/backward_euler.hpp"
#include "tests/numbers.hpp"
#include "tests/schemes.hpp"
#include "tests/step_matrices.hpp"

/// The paper's main scheme: its step is the implicit system's solution, and what it does to energy
/// and contact.
namespace ra2d::test {
namespace {

struct State {
  double u, v;
};

State step(const Mode& mode, double tau, State y, double force) {
  const ModeStep c = BackwardEuler::prepare(mode, tau);
  advance_semi_implicit(y.u, y.v, c.v_v, c.v_u, c.v_f[0] * force, tau);
  return y;
}

TEST(BackwardEuler, EachTermAlone) {
  // omega tau = 1, zeta = 1/2: s = 1 + 1 + 1 = 3, tau = 1/4, m = 2.
  const Mode mode{4, 0.5, 2};
  EXPECT_DOUBLE_EQ(step(mode, 0.25, {0, 3}, 0).v, 1);       // V0/s
  EXPECT_DOUBLE_EQ(step(mode, 0.25, {0, 3}, 0).u, 0.25);    // tau V1
  EXPECT_DOUBLE_EQ(step(mode, 0.25, {0.75, 0}, 0).v, -1);   // -tau omega^2 U0/s = -4 U0/3
  EXPECT_DOUBLE_EQ(step(mode, 0.25, {0.75, 0}, 0).u, 0.5);  // U0 + tau V1
  EXPECT_DOUBLE_EQ(step(mode, 0.25, {0, 0}, 24).v, 1);      // tau F0/(m s)
}

TEST(BackwardEuler, OneStepSolvesTheImplicitSystem) {
  // Roundings: s has 4 in front of its inverse, c1 four more, F0's way through c2 four; then two
  // sums.
  RandomModes draw;
  for (int trial = 0; trial < 10000; ++trial) {
    const double tau = draw.tau();
    const Mode mode = draw.mode(tau);
    const State y{draw.uniform(-1, 1), mode.omega * draw.uniform(-1, 1)};
    const double force = mode.mass * mode.omega * mode.omega * draw.uniform(-1, 1);

    using Matrix = Eigen::Matrix<long double, 2, 2>;
    using Vector = Eigen::Matrix<long double, 2, 1>;
    const long double w = mode.omega, t = tau;
    Matrix left;  // U1 - tau V1 = U0,   tau omega^2 U1 + (1 + 2 zeta omega tau) V1 = V0 + tau F0/m
    left << 1, -t, t * w * w, 1 + 2 * mode.zeta * w * t;
    const Vector exact = left.inverse() * Vector(y.u, y.v + t * force / mode.mass);

    const State now = step(mode, tau, y, force);
    const double s = 1 + 2 * mode.zeta * mode.omega * tau + std::pow(mode.omega * tau, 2);
    const double terms = (std::abs(y.v) + tau * mode.omega * mode.omega * std::abs(y.u) +
                          tau * std::abs(force) / mode.mass) /
                         s;
    ASSERT_NEAR(now.v, static_cast<double>(exact[1]), 6 * eps * terms);
    ASSERT_NEAR(now.u, static_cast<double>(exact[0]), eps * (std::abs(y.u) + 7 * tau * terms));
  }
}

TEST(BackwardEuler, UndampedEnergyShrinksByTheExactFactor) {
  // U1 = U0 + tau V1 with V1 = (V0 - tau omega^2 U0)/s is U1 = (U0 + tau V0)/s, s = 1 + (omega
  // tau)^2:
  //   V1^2 + omega^2 U1^2 = (V0^2 + omega^2 U0^2)(1 + omega^2 tau^2)/s^2 = (V0^2 + omega^2 U0^2)/s.
  // Roundings are counted on the energy norm: U1's own and, through V1 = small difference, those of
  // V1.
  RandomModes draw;
  for (int trial = 0; trial < 10000; ++trial) {
    const double tau = draw.tau();
    Mode mode = draw.mode(tau);
    mode.zeta = 0;
    const State y{draw.uniform(-1, 1), mode.omega * draw.uniform(-1, 1)};
    const State now = step(mode, tau, y, 0);
    const auto energy = [&](State x) { return x.v * x.v + std::pow(mode.omega * x.u, 2); };
    const double wt = mode.omega * tau, s = 1 + wt * wt;
    // U1 is s times smaller than the U0 and tau V1 it is the difference of
    const double lost = 8 * eps * std::max(1.0, wt) * (1 + wt);
    ASSERT_NEAR(energy(now) / energy(y) * s, 1, 4 * lost) << "omega tau = " << wt;
  }
}

TEST(BackwardEuler, DampedEnergyNeverGrows) {
  RandomModes draw;
  for (int trial = 0; trial < 10000; ++trial) {
    const double tau = draw.tau();
    const Mode mode = draw.mode(tau);
    const State y{draw.uniform(-1, 1), mode.omega * draw.uniform(-1, 1)};
    const State now = step(mode, tau, y, 0);
    const double before = std::hypot(y.v, mode.omega * y.u);
    const double after = std::hypot(now.v, mode.omega * now.u);
    ASSERT_LE(after, before * (1 + 16 * eps));  // roundings of a step
  }
}

const Scheme backward_euler{{{SchemeKind::backward_euler}}, "BackwardEuler"};

TEST(BackwardEuler, ContactIsStableUpToTheSpringThatTheHeaderNames) {
  // sum_j k phi_j^2 tau^2/(m_j (4 + 4 zeta_j omega_j tau + (omega_j tau)^2)) = 1 at the limit.
  RandomModes draw;
  constexpr double tau = 1;
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + trial % 4;
    Joined j{{}, Eigen::MatrixXd(1, n), 0};
    double sum = 0;
    for (int k = 0; k < n; ++k) {
      j.modes.push_back({draw.uniform(0.01, 1), draw.uniform(0.001, 0.5), draw.uniform(0.5, 2)});
      j.phi(0, k) = draw.uniform(0.5, 2);
      const double wt = j.modes[k].omega * tau;
      sum += j.phi(0, k) * j.phi(0, k) * tau * tau /
             (j.modes[k].mass * (4 + 4 * j.modes[k].zeta * wt + wt * wt));
    }
    const double limit = 1 / sum;
    const auto radius_at = [&](double spring) {
      j.spring = spring;
      return radius(backward_euler, j, tau);
    };
    // U1 = -U0: an eigenvalue of -1, to the accuracy of a 2 n matrix with entries up to ~10
    j.spring = limit;
    const Eigen::MatrixXd map = lagged_step(backward_euler, j, tau);
    const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner> svd(
        map + Eigen::MatrixXd::Identity(2 * n, 2 * n));
    EXPECT_LE(svd.singularValues().minCoeff(), 64 * n * eps * map.norm());
    EXPECT_LT(radius_at(0.999 * limit), 1);
    EXPECT_GT(radius_at(1.001 * limit), 1);
  }
}

}  // namespace
}  // namespace ra2d::test
