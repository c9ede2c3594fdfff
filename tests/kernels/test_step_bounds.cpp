// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/step_bounds.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/numbers.hpp"
#include "tests/schemes.hpp"

/// The bounds on what steps can do, which the proof in kernels/candidates.hpp stands on, against
/// steps.
namespace ra2d::test {
namespace {

class BoundsOf : public testing::TestWithParam<Scheme> {
 protected:
  const SchemeTable& table = GetParam().table();
};
INSTANTIATE_TEST_SUITE_P(Schemes, BoundsOf, testing::ValuesIn(schemes),
                         [](const auto& info) { return info.param.name; });

/// Beyond this the bounds do not count (host/model/step_bounds.cpp).
constexpr double most_growth = 1e99;

/// A sequence of steps against its bounds: the largest shares of them that are reached.
struct Shares {
  double displacement = 0, stage = 0, energy = 0;
};

/// Follows `steps` steps from (u0, v0); `choose(n, i, w)` gives the force at stage i of step n, of
/// size f at the most.
template <class Choose>
Shares follow(const Mode& mode, const SchemeTable& table, double tau, int steps, double u0,
              double v0, double f, const Choose& choose) {
  const ModeStep w = table.prepare(mode, tau);
  const StepBounds b = bound_step(mode, w, table.place, tau, steps);
  EXPECT_GE(b.growth, 1);
  if (b.growth > most_growth) return {};
  const double energy = std::hypot(v0, mode.omega * u0);
  Shares most;
  // in long double: what is bounded is the steps' exact answer
  long double u = u0, v = v0;
  for (int n = 0; n < steps; ++n) {
    const double bound =
        tau * tau *
        (b.acceleration_per_energy_norm * (energy + n * tau * b.acceleration_per_force * f) +
         b.acceleration_per_force * f);
    const double grown = b.growth * (energy + n * tau * b.acceleration_per_force * f);
    // of the sums here, in long double; and of the stages' places, in double
    const long double rounding = (n + 1.0L) * (8 * std::numeric_limits<long double>::epsilon() *
                                                   (std::abs(u0) + (n + 1) * tau * std::abs(v0)) +
                                               eps * tau * std::abs(v0));
    const auto share = [&](long double distance, double of) {
      const long double left = std::abs(distance) - rounding;
      return left <= 0 ? 0.0 : of > 0 ? static_cast<double>(left) / of : 1e300;
    };
    if (n > 0)
      most.displacement = std::max(
          most.displacement,
          share(u - u0 - static_cast<long double>(n) * tau * v0, 0.5 * n * (n + 1.0) * bound));
    most.energy = std::max(most.energy, share(std::hypot(v, mode.omega * u), grown));
    long double force[most_stages];
    for (int i = 0; i < w.stages; ++i) {
      long double at = u;
      if (i > 0) at += w.stage_u[i] * u + w.stage_v[i] * v;
      for (int j = 0; j < i; ++j) at += w.stage_f[i][j] * force[j];
      const long double line = u0 + (n + static_cast<long double>(table.place[i])) * tau * v0;
      if (i > 0)
        most.stage = std::max(most.stage, share(at - line, 0.5 * (n + 1.0) * (n + 2.0) * bound));
      force[i] = choose(n, i, w);
    }
    long double u1 = u + w.u_u * u + w.u_v * v, v1 = w.v_u * u + w.v_v * v;
    for (int i = 0; i < w.stages; ++i) {
      u1 += w.u_f[i] * force[i];
      v1 += w.v_f[i] * force[i];
    }
    u = u1;
    v = v1;
  }
  return most;
}

TEST_P(BoundsOf, HoldForWhateverTheForcesDo) {
  RandomModes draw;
  double tightest = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const double tau = draw.tau();
    Mode mode = draw.mode(tau);
    // a third far below, a third near the limits (0.3 to 4), a third anywhere up to 100
    if (trial % 3 == 0) mode.omega = draw.uniform(1e-3, 0.1) / tau;
    if (trial % 3 == 1) mode.omega = draw.uniform(0.3, 4) / tau;
    if (trial % 50 == 0) mode.omega = 0;
    const int steps = 1 + static_cast<int>(std::pow(10.0, draw.uniform(0, 2.5)));
    const double turn = draw.uniform(0, 6.3);
    const double u0 = mode.omega > 0 ? std::sin(turn) / mode.omega : tau, v0 = std::cos(turn);
    const double f = trial % 2 == 0 ? 0.0 : mode.mass / tau * std::pow(10.0, draw.uniform(-3, 1));
    const int kind = static_cast<int>(draw.uniform(0, 3));
    const Shares most =
        follow(mode, table, tau, steps, u0, v0, f, [&](int, int i, const ModeStep& w) {
          if (kind == 0) return f;
          if (kind == 1) return w.u_f[i] < 0 ? -f : f;
          return draw.uniform(-1, 1) < 0 ? -f : f;
        });
    // of the bound's own arithmetic a few roundings
    ASSERT_LE(most.displacement, 1 + 1e-12) << "x " << mode.omega * tau << ", zeta " << mode.zeta;
    ASSERT_LE(most.stage, 1 + 1e-12) << "x " << mode.omega * tau << ", zeta " << mode.zeta;
    ASSERT_LE(most.energy, 1 + 1e-12) << "x " << mode.omega * tau << ", zeta " << mode.zeta;
    tightest = std::max({tightest, most.displacement, most.stage});
  }
  EXPECT_GT(tightest, 0.9);
}

TEST_P(BoundsOf, GrowthBoundsThePowersOfTheStep) {
  RandomModes draw;
  for (int trial = 0; trial < 500; ++trial) {
    const double tau = draw.tau();
    Mode mode = draw.mode(tau, 5.0);
    if (trial % 2 == 0) mode.omega = draw.uniform(0.3, 4) / tau;
    const ModeStep w = table.prepare(mode, tau);
    Eigen::Matrix2d one;  // of (omega U, V)
    one << 1 + w.u_u, mode.omega * w.u_v, w.v_u / mode.omega, w.v_v;
    Eigen::Matrix2d power = Eigen::Matrix2d::Identity();
    for (int n = 1; n <= 200; ++n) {
      power = one * power;
      const double norm =
          Eigen::JacobiSVD<Eigen::Matrix2d, Eigen::NoQRPreconditioner>(power).singularValues()[0];
      // a product of n matrices has 4 n roundings
      if (norm > most_growth) break;
      ASSERT_LE(norm, bound_step(mode, w, table.place, tau, n).growth * (1 + 4 * n * eps))
          << n << " steps, x " << mode.omega * tau << ", zeta " << mode.zeta;
    }
  }
}

TEST_P(BoundsOf, AreNotMuchMoreThanWhatHappensForSmallSteps) {
  // A slow mode without damping: to first order in x, U leaves its line with the acceleration
  // -omega^2 U
  // + F/m, and the bound is that, but for two things. The growth, 1 + O(x), and for steps beyond a
  // scheme's limit (1 + x^2)^(n/2). And stages inside a step, which may depart by more than the end
  // does: their weights of both signs count with their sizes.
  constexpr double tau = 1, mass = 1;
  for (const double x : {1e-4, 1e-3}) {
    const Mode mode{x / tau, 0, mass};
    const int steps = 10;  // few enough that the mode turns by little
    const ModeStep w = table.prepare(mode, tau);
    const StepBounds b = bound_step(mode, w, table.place, tau, steps);
    EXPECT_LE(b.growth, 1 + 8 * x);
    EXPECT_GE(b.acceleration_per_energy_norm, mode.omega * (1 - x));
    EXPECT_LE(b.acceleration_per_energy_norm, mode.omega * (1 + 8 * x));
    EXPECT_GE(b.acceleration_per_force, 1 / mass * (1 - x));
    // a force adds 1/m; but RK8's stages take differences of forces that its end does not, with
    // weights that add up to 14
    EXPECT_LE(b.acceleration_per_force * mass,
              GetParam().time.scheme == SchemeKind::rk8 ? 15 : 1 + 8 * x);
    const Shares free =
        follow(mode, table, tau, steps, 1, 0, 0, [](int, int, auto&) { return 0.0; });
    // n (n - 1)/2 or n^2/2 or n (n + 1)/2, over n (n + 1)/2
    EXPECT_GE(std::max(free.displacement, free.stage), 0.75);
  }
}

}  // namespace
}  // namespace ra2d::test
