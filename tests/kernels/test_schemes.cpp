// SPDX-License-Identifier: BSD-3-Clause
#include "tests/schemes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <vector>

#include "kernels/schemes/backward_euler.hpp"
#include "kernels/schemes/exact.hpp"
#include "kernels/schemes/explicit_euler.hpp"
#include "kernels/schemes/gautschi.hpp"
#include "kernels/schemes/heun.hpp"
#include "kernels/schemes/midpoint.hpp"
#include "kernels/schemes/rk4.hpp"
#include "kernels/schemes/rk8.hpp"
#include "tests/numbers.hpp"

/// The schemes against the claims in their headers.
namespace ra2d::test {
namespace {

/// A number with a bound on what becomes of it in double precision: every operation adds half an
/// ulp.
struct Bounded {
  long double value = 0, error = 0;
};
Bounded rounded(long double value, long double error) {
  return {value, error + 0.5L * eps * std::abs(value)};
}
Bounded operator+(const Bounded& a, const Bounded& b) {
  return rounded(a.value + b.value, a.error + b.error);
}
Bounded operator-(const Bounded& a, const Bounded& b) {
  return rounded(a.value - b.value, a.error + b.error);
}
Bounded operator*(const Bounded& a, const Bounded& b) {
  return rounded(a.value * b.value, a.error * std::abs(b.value) + std::abs(a.value) * b.error);
}
Bounded operator/(const Bounded& a, const Bounded& b) {
  return rounded(a.value / b.value,
                 (a.error + std::abs(a.value / b.value) * b.error) / std::abs(b.value));
}

// ---- order conditions of Runge-Kutta schemes

template <class Tableau>
struct RungeKutta : testing::Test {};
using Tableaus = testing::Types<ExplicitEuler, Heun, Rk4, Rk8>;
TYPED_TEST_SUITE(RungeKutta, Tableaus);

/// A rooted tree, by the trees that hang from its root.
struct Tree {
  int order;
  long double gamma;  // density: the order times the branches' densities
  std::vector<std::size_t> branches;
};

/// All rooted trees of up to `most` vertices, by order: to each its branches, in falling order.
std::vector<Tree> rooted_trees(int most) {
  std::vector<Tree> trees;
  for (int order = 1; order <= most; ++order) {
    std::vector<Tree> found;
    std::vector<std::size_t> branches;
    const std::function<void(int, std::size_t)> grow = [&](int left, std::size_t last) {
      if (left == 0) {
        long double gamma = order;
        for (const std::size_t b : branches) gamma *= trees[b].gamma;
        found.push_back({order, gamma, branches});
        return;
      }
      for (std::size_t b = 0; b < last; ++b) {
        if (trees[b].order > left) break;
        branches.push_back(b);
        grow(left - trees[b].order, b + 1);
        branches.pop_back();
      }
    };
    grow(order - 1, trees.size());
    trees.insert(trees.end(), found.begin(), found.end());
  }
  return trees;
}

/// A coefficient as it is written: of parts below 11, none of them with more than three roundings.
Bounded written(double a) { return {a, a != 0 ? 16.0L * eps : 0.0L}; }

/// sum_i b_i Phi_i(tree) for every tree, with Phi_i = prod over the branches of sum_j a_ij Phi_j.
template <class Tableau>
std::vector<Bounded> elementary_weights(const std::vector<Tree>& trees) {
  constexpr int s = Tableau::stages;
  std::vector<std::vector<Bounded>> below(trees.size());  // sum_j a_ij Phi_j, for the trees above
  std::vector<Bounded> weights;
  for (std::size_t t = 0; t < trees.size(); ++t) {
    std::vector<Bounded> phi(s, {1, 0});
    for (const std::size_t b : trees[t].branches)
      for (int i = 0; i < s; ++i) phi[i] = phi[i] * below[b][i];
    Bounded weight;
    for (int i = 0; i < s; ++i) {
      weight = weight + written(Tableau::b(i)) * phi[i];
      Bounded sum;
      for (int j = 0; j < i; ++j) sum = sum + written(Tableau::a(i, j)) * phi[j];
      below[t].push_back(sum);
    }
    weights.push_back(weight);
  }
  return weights;
}

TEST(RootedTrees, AreAsManyAsTheyShould) {
  // 1, 1, 2, 4, 9, 20, 48, 115, 286 (Hairer, Norsett, Wanner, Solving ODEs I, table II.2.1)
  std::vector<int> count(10, 0);
  for (const Tree& tree : rooted_trees(9)) ++count[tree.order];
  EXPECT_EQ(count, (std::vector<int>{0, 1, 1, 2, 4, 9, 20, 48, 115, 286}));
}

TYPED_TEST(RungeKutta, MeetsTheConditionsOfItsOrderAndNotOfTheNext) {
  const std::vector<Tree> trees = rooted_trees(TypeParam::order + 1);
  const std::vector<Bounded> weights = elementary_weights<TypeParam>(trees);
  int met = 0;
  bool next = true;
  for (std::size_t t = 0; t < trees.size(); ++t) {
    const long double missing = std::abs(weights[t].value - 1 / trees[t].gamma);
    if (trees[t].order <= TypeParam::order) {
      EXPECT_LE(missing, weights[t].error) << "tree " << t;
      EXPECT_LE(weights[t].error, 1e-3 / trees[t].gamma) << "the bound says nothing";
      ++met;
    } else if (missing > 100 * weights[t].error) {
      next = false;
    }
  }
  if (TypeParam::order == 8) {
    EXPECT_EQ(met, 200);
  }
  EXPECT_FALSE(next);
}

TYPED_TEST(RungeKutta, StagesStandWhereTheirWeightsSay) {
  for (int i = 0; i < TypeParam::stages; ++i) {
    Bounded sum;
    for (int j = 0; j < i; ++j) sum = sum + written(TypeParam::a(i, j));
    EXPECT_NEAR(TypeParam::place[i], static_cast<double>(sum.value),
                static_cast<double>(sum.error));
  }
}

// ---- weights against the schemes' definitions

/// U1, V1 and the displacements of the stages.
template <int stages>
struct Answers {
  Bounded u, v, at[stages];
};
/// y' = f(t, y) taken literally: k_i = f(y0 + tau sum a_ij k_j), y1 = y0 + tau sum b_i k_i.
template <class Tableau>
Answers<Tableau::stages> by_definition(const Mode& mode, double tau, double u0, double v0,
                                       const std::vector<double>& force) {
  constexpr int s = Tableau::stages;
  const Bounded t{tau}, omega{mode.omega}, zeta{mode.zeta}, mass{mode.mass}, two{2};
  Bounded rate_u[s], rate_v[s];
  Answers<s> y{{u0}, {v0}, {}};
  for (int i = 0; i < s; ++i) {
    Bounded u{u0}, v{v0};
    for (int j = 0; j < i; ++j) {
      u = u + t * Bounded{Tableau::a(i, j)} * rate_u[j];
      v = v + t * Bounded{Tableau::a(i, j)} * rate_v[j];
    }
    rate_u[i] = v;
    rate_v[i] = Bounded{force[i]} / mass - two * zeta * omega * v - omega * omega * u;
    y.at[i] = u;
    y.u = y.u + t * Bounded{Tableau::b(i)} * rate_u[i];
    y.v = y.v + t * Bounded{Tableau::b(i)} * rate_v[i];
  }
  return y;
}

TYPED_TEST(RungeKutta, WeightsAreTheSchemesDefinition) {
  constexpr int s = TypeParam::stages;
  RandomModes draw;
  for (int trial = 0; trial < 1000; ++trial) {
    const double tau = draw.tau();
    const Mode mode = draw.mode(tau, 4.0);
    const double u0 = draw.uniform(-1, 1) / mode.omega, v0 = draw.uniform(-1, 1);
    std::vector<double> force;
    for (int i = 0; i < s; ++i) force.push_back(mode.mass / tau * draw.uniform(-1, 1));
    const Answers<s> exact = by_definition<TypeParam>(mode, tau, u0, v0, force);
    // What is rounded: every input's way through the step. The weights are rounded likewise, as the
    // answers to a one each, so twice that; and twice for another order of the operations.
    Answers<s> rounded{};
    const auto add = [&](double u, double v, const std::vector<double>& f) {
      const Answers<s> one = by_definition<TypeParam>(mode, tau, u, v, f);
      rounded.u.error += 4 * one.u.error;
      rounded.v.error += 4 * one.v.error;
      for (int i = 0; i < s; ++i) rounded.at[i].error += 4 * one.at[i].error;
    };
    add(u0, 0, std::vector<double>(s, 0));
    add(0, v0, std::vector<double>(s, 0));
    for (int i = 0; i < s; ++i) {
      std::vector<double> f(s, 0);
      f[i] = force[i];
      add(0, 0, f);
    }

    const ModeStep w = TypeParam::prepare(mode, tau);
    ASSERT_EQ(w.stages, s);
    long double u = u0 + static_cast<long double>(w.u_u) * u0 + w.u_v * v0;
    long double v = static_cast<long double>(w.v_u) * u0 + w.v_v * v0;
    for (int i = 0; i < s; ++i) {
      u += static_cast<long double>(w.u_f[i]) * force[i];
      v += static_cast<long double>(w.v_f[i]) * force[i];
      long double at = u0 + static_cast<long double>(w.stage_u[i]) * u0 + w.stage_v[i] * v0;
      for (int j = 0; j < s; ++j) at += static_cast<long double>(w.stage_f[i][j]) * force[j];
      ASSERT_LE(std::abs(at - exact.at[i].value), rounded.at[i].error) << "stage " << i;
    }
    ASSERT_LE(std::abs(u - exact.u.value), rounded.u.error);
    ASSERT_LE(std::abs(v - exact.v.value), rounded.v.error);
  }
}

using Matrix = Eigen::Matrix<long double, 3, 3>;

/// exp(M) - 1 to the last digits of small increments, too: a series for a part of M, then (1 + E)^2
/// - 1 = 2 E + E^2.
Matrix exponential_less_one(const Matrix& m) {
  int halvings = 0;
  for (long double norm = m.cwiseAbs().rowwise().sum().maxCoeff(); norm > 0.25L; norm /= 2)
    ++halvings;
  const Matrix part = m / std::pow(2.0L, halvings);
  Matrix term = part, sum = part;
  for (int n = 2; n < 30; ++n) {
    term = term * part / n;
    sum += term;
  }
  for (int i = 0; i < halvings; ++i) sum = 2 * sum + sum * sum;
  return sum;
}
/// Of one step of (omega U, V, F/(m omega)), the force held; with omega = 0, of (U/tau, V, F
/// tau/m).
Matrix increments(double zeta, long double x) {
  Matrix m = Matrix::Zero();
  m.row(0) << 0, x, 0;
  m.row(1) << -x, -2 * x * zeta, x;
  return exponential_less_one(m);
}

TEST(ExactScheme, IsTheMatrixExponential) {
  constexpr double tau = 0.25, mass = 3;
  for (const double zeta : {0.0, 1e-3, 0.02, 0.3, 0.7, 0.9, 0.99, 1.0, 1.01, 2.0, 20.0})
    for (double x = 1e-6; x < 101; x *= 1.2589254117941673) {
      SCOPED_TRACE(testing::Message() << "zeta " << zeta << ", x " << x);
      const double omega = x / tau;
      const ModeStep w = Exact::prepare({omega, zeta, mass}, tau);
      const Matrix e = increments(zeta, static_cast<long double>(omega) * tau);
      // Small increments to a few of their own roundings: a series of positive and negative terms
      // whose sum is no less than half of the first, two roundings a term. Beyond, sin, cos and exp
      // of an angle: x eps/2 of it, twice that for the root in w x, and where w is a small
      // difference that much more; all of it decays with exp(-(zeta - w) x).
      const double root = std::max(std::abs(1 - zeta * zeta), 1e-3);
      const double slow = zeta > 1 ? 1 / (zeta + std::sqrt(zeta * zeta - 1)) : zeta;
      const double angle = (1 + x * (1 + zeta) / root) * std::exp(-slow * x) * (1 + zeta);
      const auto expect_near = [&](double weight, long double exact, const char* which) {
        const double tolerance = x < 0.5
                                     ? 16 * eps * static_cast<double>(std::abs(exact))
                                     : 4 * eps * (static_cast<double>(std::abs(exact)) + 1 + angle);
        EXPECT_NEAR(weight, static_cast<double>(exact), tolerance) << which;
      };
      expect_near(w.u_u, e(0, 0), "u_u");
      expect_near(w.u_v * omega, e(0, 1), "u_v");
      expect_near(w.u_f[0] * mass * omega * omega, e(0, 2), "u_f");
      expect_near(w.v_u / omega, e(1, 0), "v_u");
      EXPECT_NEAR(w.v_v, static_cast<double>(1 + e(1, 1)), 4 * eps * (2 + angle)) << "v_v";
      expect_near(w.v_f[0] * mass * omega, e(1, 2), "v_f");
    }
}

/// Displacement and velocity a step of a free mode later (`x`) or earlier (-x), of (U, V/omega).
struct Free {
  long double u, v;
};
Free free_motion(double zeta, long double x, const Free& y) {
  const Matrix e = increments(zeta, x);
  return {y.u + e(0, 0) * y.u + e(0, 1) * y.v, y.v + e(1, 0) * y.u + e(1, 1) * y.v};
}

TEST(GautschiScheme, FreeModesAreExact) {
  RandomModes draw;
  constexpr double tau = 0.25, mass = 3;
  for (const double zeta : {0.0, 1e-3, 0.02, 0.3, 0.9, 1.0, 1.5})
    for (double x = 1e-5; x < 3; x *= 1.2589254117941673) {
      SCOPED_TRACE(testing::Message() << "zeta " << zeta << ", x " << x);
      const double omega = x / tau;
      const ModeStep w = Gautschi::prepare({omega, zeta, mass}, tau);
      const Free now{draw.uniform(-1, 1), draw.uniform(-1, 1)};
      const long double angle = static_cast<long double>(omega) * tau;
      const Free before = free_motion(zeta, -angle, now), next = free_motion(zeta, angle, now);
      // about a rest position that a force of 1 holds, too
      const long double rest = 1 / (mass * static_cast<long double>(omega) * omega);
      const long double v0 = (now.u - before.u) / tau;
      const long double pulled = w.v_u * (now.u + rest) + w.v_f[0], v1 = w.v_v * v0 + pulled;
      const long double u1 = now.u + tau * v1;
      // each weight has up to four roundings, and those of the angle and of exp
      const auto near = [&](long double found, long double exact, long double size) {
        EXPECT_LE(std::abs(found - exact), 16 * eps * size);
      };
      const long double pushed = tau * (std::abs(w.v_u) * (std::abs(now.u) + 2 * rest));
      near(u1, next.u, std::abs(now.u) + tau * std::abs(w.v_v * v0) + pushed);
      EXPECT_EQ(w.u_f[0], tau * w.v_f[0]);

      // its closed form: roundings of p, which is small near half a period
      const long double mean = w.now_mean * (0.5L * (v0 + v1)), own = w.now_pushed * pulled;
      const double of_p = 1 + x / std::max(0.1, std::abs(std::sin(x)));
      near(mean + own, omega * now.v,
           of_p * (1 + zeta) *
               (std::abs(w.now_mean) * (std::abs(v0) + std::abs(v1)) +
                (2 * std::abs(w.now_mean) + std::abs(w.now_pushed) + zeta / x) * pushed / tau));
    }
}

TEST(GautschiScheme, SquaresCountAsMuchAsThoseOfTheVelocity) {
  // of an undamped mode at 64 phases of its period
  constexpr double tau = 0.25;
  for (const double x : {1e-3, 0.1, 1.0, 2.5}) {
    const double omega = x / tau;
    double squares = 0;
    for (int i = 0; i < 64; ++i) {
      const double phase = i * M_PI / 32;
      squares += std::pow((std::cos(phase + x) - std::cos(phase)) / tau, 2) / 64;
    }
    EXPECT_NEAR(Gautschi::prepare({omega, 0, 1}, tau).mean_square * squares, 0.5 * omega * omega,
                0.5 * omega * omega * (16 * eps + 4 * eps / x));
    EXPECT_EQ(Midpoint::prepare({omega, 0, 1}, tau).mean_square, 1);
  }
}

TEST(GautschiScheme, ARigidModeIsTheLimitOfASoftOne) {
  const ModeStep w = Gautschi::prepare({0, 0.3, 4}, 0.125);
  EXPECT_EQ(w.v_u, 0);
  EXPECT_EQ(w.v_v, 1);
  EXPECT_EQ(w.v_f[0], 1.0 / 32);  // tau/m
  EXPECT_EQ(w.now_mean, 1);
  EXPECT_EQ(w.now_pushed, 0);
  EXPECT_EQ(w.mean_square, 1);
  const ModeStep soft = Gautschi::prepare({1e-14, 0.3, 4}, 0.125);
  EXPECT_NEAR(soft.v_f[0] / w.v_f[0], 1, 16 * eps);
  EXPECT_NEAR(soft.now_mean, 1, 16 * eps);
  EXPECT_NEAR(soft.mean_square, 1, 1e-12);
}

TEST(ExactScheme, ARigidModeIsTheLimitOfASoftOne) {
  const ModeStep w = Exact::prepare({0, 0.3, 4}, 0.125);
  EXPECT_EQ(w.u_u, 0);
  EXPECT_EQ(w.v_u, 0);
  EXPECT_EQ(w.v_v, 1);
  EXPECT_EQ(w.u_v, 0.125);
  EXPECT_EQ(w.u_f[0], 1.0 / 512);  // tau^2/(2 m)
  EXPECT_EQ(w.v_f[0], 1.0 / 32);   // tau/m
  const ModeStep soft = Exact::prepare({1e-14, 0.3, 4}, 0.125);
  EXPECT_NEAR(soft.u_f[0] / w.u_f[0], 1, 16 * eps);
  EXPECT_NEAR(soft.v_f[0] / w.v_f[0], 1, 16 * eps);
}

TEST(ExactScheme, TwoHalfStepsAreOne) {
  RandomModes draw;
  for (int trial = 0; trial < 10000; ++trial) {
    const double tau = draw.tau();
    Mode mode = draw.mode(tau);
    if (trial % 10 == 0) mode.omega = 0;
    const ModeStep half = Exact::prepare(mode, tau / 2), whole = Exact::prepare(mode, tau);
    const double size = mode.omega > 0 ? 1 / mode.omega : tau;
    const double u0 = size * draw.uniform(-1, 1), v0 = draw.uniform(-1, 1);
    const double force = mode.mass / size * draw.uniform(-1, 1);
    const auto step = [&](const ModeStep& w, long double& u, long double& v) {
      const long double u1 = u + w.u_u * u + w.u_v * v + w.u_f[0] * force;
      v = w.v_u * u + w.v_v * v + w.v_f[0] * force;
      u = u1;
    };
    long double u = u0, v = v0, u_whole = u0, v_whole = v0;
    step(half, u, v);
    step(half, u, v);
    step(whole, u_whole, v_whole);
    // the weights' own roundings, as above, of three steps
    const double x = mode.omega * tau, root = std::max(std::abs(1 - mode.zeta * mode.zeta), 1e-3);
    const double tolerance = 16 * eps * (4 + x * (1 + mode.zeta) / root * (1 + mode.zeta));
    ASSERT_NEAR(static_cast<double>((u - u_whole) / size), 0, tolerance) << "x " << x;
    ASSERT_NEAR(static_cast<double>(v - v_whole), 0, tolerance) << "x " << x;
  }
}

TEST(MidpointScheme, IsTheTwoStepRecurrenceOfCentralDifferences) {
  // U+ (1 + zeta x) - U (2 - x^2) + U- (1 - zeta x) = tau^2 F/m
  RandomModes draw;
  for (int trial = 0; trial < 10000; ++trial) {
    const double tau = draw.tau();
    const Mode mode = draw.mode(tau, 4.0);
    const double x = mode.omega * tau, damping = mode.zeta * x;
    const ModeStep w = Midpoint::prepare(mode, tau);
    const double force[2] = {draw.uniform(-1, 1), draw.uniform(-1, 1)};
    long double u[3] = {draw.uniform(-1, 1), 0, 0}, v = draw.uniform(-1, 1) / tau;
    long double size = 0;
    for (int n = 0; n < 2; ++n) {
      const double f = force[n] * mode.mass / (tau * tau);
      u[n + 1] = u[n] + w.u_u * u[n] + w.u_v * v + w.u_f[0] * f;
      const long double parts =
          std::abs(u[n]) * (1 + x * x) + std::abs(tau * v) + std::abs(force[n]);
      v = w.v_u * u[n] + w.v_v * v + w.v_f[0] * f;
      EXPECT_LE(std::abs(u[n + 1] - u[n] - tau * v), 8 * eps * parts);
      size += std::abs(u[n]) + std::abs(tau * v) + std::abs(force[n]);
    }
    // each weight has at the most eight roundings
    const long double left =
        u[2] * (1 + damping) - u[1] * (2 - static_cast<long double>(x) * x) + u[0] * (1 - damping);
    ASSERT_NEAR(static_cast<double>(left), force[1],
                static_cast<double>(16 * eps * (1 + x * x) * (1 + damping) * size));
  }
}

// ---- what all have in common

template <class Any>
struct AnyScheme : testing::Test {};
using Schemes = testing::Types<ExplicitEuler, Midpoint, BackwardEuler, Heun, Rk4, Rk8, Exact>;
TYPED_TEST_SUITE(AnyScheme, Schemes);

TYPED_TEST(AnyScheme, FirstStageIsTheOldState) {
  EXPECT_EQ(TypeParam::place[0], 0);
  EXPECT_EQ(std::size(TypeParam::place), static_cast<std::size_t>(TypeParam::stages));
  const ModeStep w = TypeParam::prepare({3, 0.1, 2}, 0.1);
  EXPECT_EQ(w.stages, TypeParam::stages);
  EXPECT_EQ(w.stage_u[0], 0);
  EXPECT_EQ(w.stage_v[0], 0);
}

TYPED_TEST(AnyScheme, RigidModeDriftsAndIsPushed) {
  // V1 = V0 + tau F/m, and U1 = U0 + tau V0 + c tau^2 F/m: c = 0 with the old velocity, 1 with the
  // new one, and otherwise 1/2, which is exact
  constexpr double tau = 0.125, mass = 2;
  const ModeStep w = TypeParam::prepare({0, 0, mass}, tau);
  EXPECT_EQ(w.u_u, 0);
  EXPECT_EQ(w.v_u, 0);
  EXPECT_EQ(w.v_v, 1);
  const double c = std::is_same_v<TypeParam, ExplicitEuler> ? 0
                   : std::is_same_v<TypeParam, Midpoint> || std::is_same_v<TypeParam, BackwardEuler>
                       ? 1
                       : 0.5;
  // the conditions of order 1 and 2, to their roundings (above): below 1e3 eps
  EXPECT_NEAR(w.u_v, tau, 1e3 * eps * tau);
  EXPECT_NEAR(w.held_v(), tau / mass, 1e3 * eps * tau / mass);
  EXPECT_NEAR(w.held_u(), c * tau * tau / mass, 1e3 * eps * tau * tau / mass);
}

TYPED_TEST(AnyScheme, StaticDeflectionStays) {
  // U = F/(m omega^2), V = 0 under F at every stage: consistent schemes leave it alone
  RandomModes draw;
  for (int trial = 0; trial < 1000; ++trial) {
    const double tau = draw.tau();
    const Mode mode = draw.mode(tau, 3.0);
    const ModeStep w = TypeParam::prepare(mode, tau);
    const double force = mode.mass * mode.omega * mode.omega;
    // through eleven stages that multiply by up to x (1 + 2 zeta) and a's below 8: for one mode
    // alone, roundings of the largest of the weights' parts
    double parts = 1;
    for (int j = 0; j < w.stages; ++j) parts += std::abs(w.u_f[j]) * force;
    EXPECT_NEAR(w.u_u + w.held_u() * force, 0, 1e3 * eps * parts);
    parts = 1;
    for (int j = 0; j < w.stages; ++j) parts += std::abs(w.v_f[j]) * force / mode.omega;
    EXPECT_NEAR((w.v_u + w.held_v() * force) / mode.omega, 0, 1e3 * eps * parts);
    for (int i = 1; i < w.stages; ++i) {
      parts = 1;
      for (int j = 0; j < i; ++j) parts += std::abs(w.stage_f[i][j]) * force;
      EXPECT_NEAR(w.stage_u[i] + w.held_stage(i) * force, 0, 1e3 * eps * parts) << "stage " << i;
    }
  }
}

/// Product of the two factors by which a step multiplies a free mode's amplitudes: |R|^2 while the
/// mode swings.
template <class Any>
double squared(double zeta, double x) {
  const ModeStep w = Any::prepare({x, zeta, 1}, 1);
  return (1 + w.u_u) * w.v_v - w.u_v * w.v_u;
}

TEST(Amplification, IsWhatTheHeadersSay) {
  for (const double z : {0.0, 0.02, 0.3, 0.9})
    for (double x = 1e-3; x < 3; x *= 1.3) {
      SCOPED_TRACE(testing::Message() << "zeta " << z << ", x " << x);
      const double roundings = 1e2 * eps * std::pow(1 + x, 4);
      EXPECT_NEAR(squared<ExplicitEuler>(z, x), 1 - 2 * z * x + x * x, roundings);
      EXPECT_NEAR(squared<Heun>(z, x),
                  1 - 2 * z * x + 2 * z * z * x * x - z * x * x * x + std::pow(x, 4) / 4,
                  roundings);
      EXPECT_NEAR(squared<BackwardEuler>(z, x), 1 / (1 + 2 * z * x + x * x), roundings);
      EXPECT_NEAR(squared<Midpoint>(z, x), (1 - z * x) / (1 + z * x), roundings);
      EXPECT_NEAR(squared<Exact>(z, x), std::exp(-2 * z * x), roundings);
      const std::complex<double> turn = x * std::complex<double>(-z, std::sqrt(1 - z * z));
      const auto r4 = 1.0 + turn * (1.0 + turn / 2.0 * (1.0 + turn / 3.0 * (1.0 + turn / 4.0)));
      EXPECT_NEAR(squared<Rk4>(z, x), std::norm(r4), roundings);
      if (z == 0) {
        EXPECT_NEAR(squared<Rk4>(z, x), 1 - std::pow(x, 6) / 72 + std::pow(x, 8) / 576, roundings);
      }
    }
  // the first term of RK8's loss, to the next: x^2 of it
  for (const double x : {0.3, 0.2, 0.1})
    EXPECT_NEAR((1 - squared<Rk8>(0, x)) / (4.26e-5 * std::pow(x, 10)), 1,
                0.002 + x * x + 1e3 * eps / (4.26e-5 * std::pow(x, 10)))
        << x;
}

}  // namespace
}  // namespace ra2d::test
