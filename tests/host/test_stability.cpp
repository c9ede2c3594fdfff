// SPDX-License-Identifier: BSD-3-Clause
// Every limit of stability is checked from both sides against the step itself, which is built from
// the weights that the march takes.
#include "host/plan/stability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

namespace ra2d::test {
namespace {

const std::vector<SchemeKind> all_schemes{
    SchemeKind::explicit_euler, SchemeKind::midpoint, SchemeKind::backward_euler,
    SchemeKind::heun,           SchemeKind::rk4,      SchemeKind::rk8,
    SchemeKind::exact,          SchemeKind::gautschi};
const std::vector<double> dampings{0.0, 1e-3, 0.02, 0.2, 0.5, 0.7, 0.99, 1.0, 2.5};

TEST(Amplification, IsWhatTheSchemesSay) {
  for (const double zeta : {0.0, 0.02, 0.6})
    for (const double x : {1e-4, 0.1, 1.0}) {
      SCOPED_TRACE(testing::Message() << "zeta " << zeta << ", x " << x);
      const auto near = [&](SchemeKind scheme, double square) {
        EXPECT_NEAR(amplification(scheme, zeta, x), std::sqrt(square), 8 * eps);
      };
      near(SchemeKind::explicit_euler, 1 - 2 * zeta * x + x * x);
      near(SchemeKind::backward_euler, 1 / (1 + 2 * zeta * x + x * x));
      near(SchemeKind::exact, std::exp(-2 * zeta * x));
      near(SchemeKind::gautschi, std::exp(-2 * zeta * x));
      near(SchemeKind::midpoint, (1 - zeta * x) / (1 + zeta * x));
      near(SchemeKind::heun,
           1 - 2 * zeta * x + 2 * zeta * zeta * x * x - zeta * x * x * x + std::pow(x, 4) / 4);
      if (zeta == 0) near(SchemeKind::rk4, 1 - std::pow(x, 6) / 72 + std::pow(x, 8) / 576);
    }
  // two real eigenvalues: 1 - x (zeta -+ sqrt(zeta^2 - 1))
  EXPECT_NEAR(amplification(SchemeKind::explicit_euler, 1.25, 0.5), 0.75, 4 * eps);
  EXPECT_NEAR(amplification(SchemeKind::explicit_euler, 1.25, 1.5), 2.0, 8 * eps);
}

TEST(Amplification, OfRk8FallsWithTheTenthPower) {
  // sum_{j+l=10} (-1)^((j-l)/2) alpha_j alpha_l = -4.26e-5; the next term is some x^2 of it
  const double x = 0.5;
  const double lost = -2 * std::log(amplification(SchemeKind::rk8, 0, x)) / std::pow(x, 10);
  EXPECT_NEAR(lost, 4.26e-5, 0.1 * 4.26e-5);
}

TEST(ModeLimit, AgreesWithTheClosedForms) {
  for (const double zeta : {1e-6, 1e-3, 0.02, 0.2, 0.7, 1.0}) {
    SCOPED_TRACE(zeta);
    EXPECT_NEAR(mode_limit(SchemeKind::explicit_euler, zeta), 2 * zeta, 16 * eps * 2 * zeta);
    // Heun: the residue of its cubic at the root is roundings of its terms
    const double x = mode_limit(SchemeKind::heun, zeta);
    EXPECT_NEAR(x * x * x / 4 - zeta * x * x + 2 * zeta * zeta * x - 2 * zeta, 0, 64 * eps * zeta);
  }
  EXPECT_NEAR(mode_limit(SchemeKind::heun, 1.0), 2.0, 16 * eps);
  EXPECT_NEAR(mode_limit(SchemeKind::heun, 0.02), 0.56884, 5e-6);
  for (const double zeta : {1e-9, 1e-6, 1e-4, 1e-3}) {
    // x = 2 y (1 + 2/3 y^2 - 2/9 y^4 + O(y^6)) solves the cubic, y = zeta^(1/3)
    const double y = std::cbrt(zeta), series = 2 * y * (1 + y * y / 1.5 - y * y * y * y / 4.5);
    EXPECT_NEAR(mode_limit(SchemeKind::heun, zeta), series, series * std::pow(y, 6) + 16 * eps)
        << zeta;
  }
  EXPECT_NEAR(mode_limit(SchemeKind::rk4, 0), 2 * std::sqrt(2.0), 16 * eps);
  EXPECT_NEAR(mode_limit(SchemeKind::rk4, 1), 2.785293563405, 1e-12);  // Hairer and Wanner
  EXPECT_EQ(mode_limit(SchemeKind::explicit_euler, 0), 0);
  EXPECT_EQ(mode_limit(SchemeKind::heun, 0), 0);
  EXPECT_EQ(mode_limit(SchemeKind::midpoint, 0.3), 2);
  EXPECT_EQ(mode_limit(SchemeKind::backward_euler, 0), infinity);
  EXPECT_EQ(mode_limit(SchemeKind::exact, 0), infinity);
  EXPECT_EQ(mode_limit(SchemeKind::gautschi, 0), infinity);
}

TEST(ModeLimit, OfRungeKuttaIsWhatTheirCommentsSay) {
  EXPECT_NEAR(mode_limit(SchemeKind::rk8, 0), 3.0018, 5e-5);
  EXPECT_NEAR(mode_limit(SchemeKind::rk8, 0.02), 3.09, 5e-3);
  EXPECT_NEAR(mode_limit(SchemeKind::rk8, 0.2), 3.19, 5e-3);
  EXPECT_NEAR(mode_limit(SchemeKind::rk8, 0.7), 3.22, 5e-3);
  EXPECT_NEAR(mode_limit(SchemeKind::rk8, 1), 3.72, 5e-3);
  EXPECT_NEAR(mode_limit(SchemeKind::rk4, 0.53), 2.62, 5e-3);
  EXPECT_NEAR(mode_limit(SchemeKind::rk4, 0.15), 2.96, 5e-3);
  for (int i = 0; i <= 200; ++i) {
    EXPECT_GT(mode_limit(SchemeKind::rk8, i / 200.0), 2.99);
    EXPECT_GT(mode_limit(SchemeKind::rk4, i / 200.0), 2.615);
    EXPECT_LT(mode_limit(SchemeKind::rk4, i / 200.0), 2.965);
  }
}

TEST(ModeLimit, HoldsOnBothSides) {
  for (const SchemeKind scheme : all_schemes)
    for (const double zeta : dampings) {
      SCOPED_TRACE(testing::Message()
                   << "scheme " << static_cast<int>(scheme) << ", zeta " << zeta);
      const double limit = mode_limit(scheme, zeta);
      const double last = std::isinf(limit) ? 1e2 : limit;
      for (int i = 1; i < 2000; ++i)
        ASSERT_LE(amplification(scheme, zeta, last * i / 2000), 1 + 16 * eps) << i;
      if (std::isinf(limit)) continue;
      if (limit == 0) {
        for (const double x : {1e-2, 0.1, 1.0}) EXPECT_GT(amplification(scheme, zeta, x), 1);
        continue;
      }
      EXPECT_LE(amplification(scheme, zeta, (1 - 1e-6) * limit), 1);
      EXPECT_GT(amplification(scheme, zeta, (1 + 1e-6) * limit), 1);
    }
}

TEST(StepError, IsTheNumericalDampingAndTheShiftOfThePeriod) {
  const double x = 1e-2;
  const auto damping = [&](SchemeKind scheme, double zeta) {
    return step_error(scheme, zeta, x).damping;
  };
  const auto period = [&](SchemeKind scheme) { return step_error(scheme, 0, x).period; };
  // to the next order, x^2 of each
  EXPECT_NEAR(damping(SchemeKind::backward_euler, 0), x / 2, x * x * x);
  EXPECT_NEAR(damping(SchemeKind::explicit_euler, 0), -x / 2, x * x * x);
  EXPECT_NEAR(damping(SchemeKind::heun, 0), -x * x * x / 8, x * x * x * x);
  EXPECT_NEAR(damping(SchemeKind::rk4, 0), std::pow(x, 5) / 144, eps / x);
  EXPECT_NEAR(damping(SchemeKind::midpoint, 0), 0, eps / x);
  for (const double zeta : {0.0, 0.02, 0.5})
    for (const SchemeKind scheme : {SchemeKind::exact, SchemeKind::gautschi})
      EXPECT_NEAR(damping(scheme, zeta), 0, 4 * eps / x);
  EXPECT_NEAR(period(SchemeKind::midpoint), -x * x / 24, x * x * x * x);
  EXPECT_NEAR(period(SchemeKind::backward_euler), x * x / 3, x * x * x * x);
  for (const SchemeKind scheme : {SchemeKind::exact, SchemeKind::gautschi})
    EXPECT_NEAR(period(scheme), 0, 4 * eps / x);
}

/// Modes as of two beams that touch, their frequencies over three decades.
JoinedModes some_modes(double zeta1, double zeta2, bool drifts, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.05, 1.0);
  JoinedModes joined;
  for (int k = 1; k <= 8; ++k) {
    joined.modes.push_back({.omega = 300.0 * k * k, .zeta = zeta1, .mass = 3.1});
    joined.square.push_back(6.7 * share(random));
  }
  for (int k = 1; k <= 3; ++k) {
    joined.modes.push_back({.omega = 4e4 * k * k, .zeta = zeta2, .mass = 31.0});
    joined.square.push_back(100 * share(random));
  }
  if (drifts) {
    joined.modes.push_back({.omega = 0, .zeta = zeta2, .mass = 31.0});
    joined.square.push_back(200.0);
  }
  return joined;
}

TEST(ContactLimit, HoldsOnBothSides) {
  unsigned seed = 0;
  for (const auto& [zeta1, zeta2] :
       {std::pair{0.0, 0.0}, std::pair{0.02, 0.02}, std::pair{0.02, 1e-3}, std::pair{0.7, 0.3}})
    for (const bool drifts : {false, true})
      for (const double stiffness : {1e4, 1e8, 1e12}) {
        const JoinedModes joined = some_modes(zeta1, zeta2, drifts, ++seed);
        double omega_c = 0;
        for (std::size_t j = 0; j < joined.modes.size(); ++j)
          omega_c += stiffness * joined.square[j] / joined.modes[j].mass;
        omega_c = std::sqrt(omega_c);
        for (const SchemeKind scheme : all_schemes) {
          const TimeSettings choice{scheme};
          SCOPED_TRACE(testing::Message()
                       << "scheme " << static_cast<int>(choice.scheme) << ", zeta " << zeta1 << " "
                       << zeta2 << (drifts ? ", drifts" : "") << ", stiffness " << stiffness);
          const double limit = contact_limit(choice, joined, stiffness);
          const auto factor = [&](double tau) {
            return amplification(choice, joined, stiffness, tau);
          };
          // roundings of the eigenvalues: some ten times their number
          const double roundings = 1e-12;
          if (limit == 0) {
            EXPECT_GT(factor(1e-2 / omega_c), 1 + roundings);
            continue;
          }
          const double last = std::isinf(limit) ? 1e3 / omega_c : limit;
          for (const double share : {1e-3, 0.1, 0.5, 0.9, 0.999})
            EXPECT_LE(factor(share * last), 1 + roundings) << share;
          if (std::isinf(limit)) continue;
          // explicit Euler beyond a limit of omega_c tau = 2 zeta_c = 2e-5 grows at 1.001 of it by
          // 2e-13 a step, which is not seen
          const double beyond = omega_c * limit > 1e-3 || stiffness < 1e12 ? 1.001 : 1.1;
          if (choice.scheme == SchemeKind::exact) {
            // promises no more than half a period of what is faster than every motion
            double fastest = omega_c;
            for (const Mode& mode : joined.modes)
              fastest = std::max(fastest, std::hypot(omega_c, mode.omega));
            ASSERT_LE(limit, M_PI / fastest * (1 + 1e-12));
            if (limit > 0.999 * M_PI / fastest) continue;
          }
          if (choice.scheme ==
              SchemeKind::gautschi) {  // the same of what is faster than every mode
            double fastest = 0;
            for (const Mode& mode : joined.modes) fastest = std::max(fastest, mode.omega);
            ASSERT_LE(limit, M_PI / fastest * (1 + 1e-12));
            if (limit > 0.999 * M_PI / fastest) continue;
          }
          EXPECT_GT(factor(beyond * limit), 1 + roundings);
        }
      }
}

TEST(ContactLimit, OfTheImplicitForceIsNone) {
  for (const double zeta : {0.0, 0.02})
    for (const double stiffness : {1e4, 1e8, 1e12}) {
      const JoinedModes joined = some_modes(zeta, zeta, true, 7);
      const TimeSettings choice{SchemeKind::backward_euler, ForceTime::new_time};
      EXPECT_EQ(contact_limit(choice, joined, stiffness), infinity);
      for (double tau = 1e-9; tau < 1; tau *= 3)
        EXPECT_LE(amplification(choice, joined, stiffness, tau), 1 + 1e-12) << tau;
    }
}

TEST(ContactLimit, OfOneFreeMassIsTheSchemesOwn) {
  // a mass on the spring: omega_c^2 = k square/mass, and no damping
  const JoinedModes mass{{{.omega = 0, .zeta = 0.02, .mass = 2.0}}, {3.0}};
  const double omega_c = std::sqrt(1e6 * 3.0 / 2.0);
  const auto limit = [&](SchemeKind scheme) {
    return omega_c * contact_limit({scheme}, mass, 1e6);
  };
  EXPECT_NEAR(limit(SchemeKind::backward_euler), 2, 16 * eps);
  EXPECT_NEAR(limit(SchemeKind::midpoint), 2, 16 * eps);
  EXPECT_NEAR(limit(SchemeKind::gautschi), 2, 16 * eps);
  EXPECT_NEAR(limit(SchemeKind::rk4), 2 * std::sqrt(2.0), 16 * eps);
  EXPECT_NEAR(limit(SchemeKind::rk8), mode_limit(SchemeKind::rk8, 0), 16 * eps);
  for (const SchemeKind grows : {SchemeKind::explicit_euler, SchemeKind::heun, SchemeKind::exact})
    EXPECT_EQ(limit(grows), 0);
  // the held force feeds (omega_c tau)^2/2 of the energy a step (kernels/schemes/exact.hpp)
  const double x = 1e-3;
  EXPECT_NEAR(amplification({SchemeKind::exact}, mass, 1e6, x / omega_c) - 1, x * x / 4, x * x * x);
}

TEST(ContactLimit, OfExactIsTwiceTheDampingThatReachesTheSpring) {
  // a stiff spring grows by (omega_c tau)^2/4 and is damped by zeta_c omega_c tau a step;
  // 2 zeta_c omega_c = sum_j 2 zeta_j omega_j k psi_j^2/m_j / omega_c^2
  const JoinedModes joined = some_modes(0.02, 0.02, false, 3);
  const double stiffness = 1e14;
  double square = 0, damping = 0;
  for (std::size_t j = 0; j < joined.modes.size(); ++j) {
    const double part = stiffness * joined.square[j] / joined.modes[j].mass;
    square += part;
    damping += part * joined.modes[j].zeta * joined.modes[j].omega;
  }
  const double omega_c = std::sqrt(square), zeta_c = damping / square / omega_c;
  // the stiffest mode, omega = 3.6e5, is (omega/omega_c)^2 = 1e-5 of it; the search ends at 1e-4
  EXPECT_NEAR(omega_c * contact_limit({SchemeKind::exact}, joined, stiffness), 4 * zeta_c,
              3e-3 * 4 * zeta_c);
}

/// A plate under a free slider.
Scene plate_and_slider() {
  Scene s = plate_scene(6, 0.01, 2e-3);
  s.slider.support = Support::free;
  s.slider.modes = 2;
  s.slider.damping = 0.01;
  s.contact.stiffness = 1e15;
  return s;
}

TEST(MostYielding, JoinsTheModesWithoutWhatDrifts) {
  const Model model = make_model(plate_and_slider());
  const JoinedModes joined = most_compliant(model);
  ASSERT_EQ(joined.modes.size(), 6 + 2 + 1);
  ASSERT_EQ(joined.square.size(), 9);
  // a free beam yields most at its ends: translation 1/L, rotation 3/L, two elastic modes 4/L each
  const double length = model.slider.length;
  EXPECT_EQ(joined.modes[8].omega, 0);
  EXPECT_NEAR(joined.square[8], 4 / length, 16 * eps * 4 / length);
  EXPECT_NEAR(joined.square[6], 4 / length, 1e-12 * 4 / length);
  EXPECT_EQ(joined.modes[8].mass, model.slider.modes[0].mass);
  EXPECT_EQ(joined.modes[0].zeta, 0.02);
  EXPECT_EQ(joined.modes[6].zeta, 0.01);
  double sum = 0;
  for (int k = 0; k < 6; ++k) sum += joined.square[k];
  for (double x = 0; x < model.resonator.length; x += 1e-4) {
    double here = 0;
    for (const BodyMode& mode : model.resonator.modes) here += std::pow(shape_at(mode, x), 2);
    EXPECT_LE(here, sum * (1 + 1e-3));  // 40 places a mode
  }
}

TEST(StepLimits, TakeTheStiffestModeAndTheSpring) {
  Model model = make_model(plate_and_slider());
  const double fastest = model.slider.modes[3].omega;
  ASSERT_GT(fastest, model.resonator.modes[5].omega);
  const TimeSettings midpoint{SchemeKind::midpoint};
  StepLimits limits = step_limits(model, midpoint);
  EXPECT_EQ(limits.modes, 2 / fastest);
  EXPECT_EQ(limits.binding_frequency, fastest / (2 * M_PI));
  EXPECT_LT(limits.contact_many, limits.contact_one);
  EXPECT_LT(limits.contact_one, limits.modes);
  EXPECT_EQ(limits.holds(), limits.contact_one);
  EXPECT_FALSE(limits.modes_bind());
  EXPECT_EQ(limits.contact_many,
            contact_limit(midpoint, most_compliant(model), 16 * model.node_stiffness));

  // heavier damped modes may bind before faster ones: explicit Euler, 2 zeta/omega
  for (Mode& mode : model.resonator.modes) mode.zeta = 1e-4;
  limits = step_limits(model, {SchemeKind::explicit_euler});
  EXPECT_EQ(limits.binding_frequency, model.resonator.modes[5].omega / (2 * M_PI));

  model.scene.contact.law = ContactLaw::multiplier;
  limits = step_limits(model, midpoint);
  EXPECT_EQ(limits.contact_one, infinity);
  EXPECT_EQ(limits.contact_many, infinity);
  EXPECT_EQ(limits.holds(), 2 / fastest);
  EXPECT_TRUE(limits.modes_bind());
  EXPECT_EQ(step_limits(model, {SchemeKind::exact}).holds(), infinity);
}

TEST(Growth, IsTheFastestOfAny) {
  const Model model = make_model(plate_and_slider());
  const double tau = 1e-6;
  double most = -infinity;
  for (const Body* body : {&model.resonator, &model.slider})
    for (const Mode& mode : body->modes)
      if (mode.omega > 0)
        most = std::max(
            most,
            std::log(amplification(SchemeKind::explicit_euler, mode.zeta, mode.omega * tau)) / tau);
  EXPECT_NEAR(mode_growth(model, SchemeKind::explicit_euler, tau), most, 16 * eps / tau);
  EXPECT_GT(most, 0);
  // nothing decays slower than the slowest mode
  EXPECT_NEAR(mode_growth(model, SchemeKind::exact, tau), -0.02 * model.resonator.modes[0].omega,
              16 * eps / tau);
}

}  // namespace
}  // namespace ra2d::test
