// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/bounds.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/beam/beam.hpp"
#include "tests/dice.hpp"
#include "tests/scenes.hpp"

/// The bounds that the march rests on, each against what it bounds.
namespace ra2d::test {
namespace {

Beam free_beam() {
  BodySpec body = plate_scene(6, 0.004, 1e-3).resonator;
  body.support = Support::free;
  body.modes = 6;
  return make_beam(body);
}

TEST(Bounds, FastestRateIsTheNormOfAModesOwnMotion) {
  for (const double zeta : {0.0, 0.02, 0.5, 1.0, 3.0}) {
    const Mode mode{.omega = 700, .zeta = zeta, .mass = 2};
    Eigen::Matrix2d motion;  // of (omega U, V)
    motion << 0, mode.omega, -mode.omega, -2 * zeta * mode.omega;
    const double norm = Eigen::JacobiSVD<Eigen::Matrix2d>(motion).singularValues()[0];
    EXPECT_NEAR(fastest_rate(mode) / norm, 1, 1e-14) << "zeta " << zeta;
  }
}

TEST(Bounds, ShapesStayBelowTheirLargest) {
  const Beam beam = free_beam();
  for (const ModeShape& mode : beam.modes) {
    double most = 0;
    for (int i = 0; i <= 1000; ++i) {
      double psi = 0;
      evaluate(mode, beam.length, i * 1e-3 * beam.length, 1, &psi);
      most = std::max(most, std::abs(psi));
    }
    const double bound = largest_shape(mode, beam.length);
    EXPECT_LE(most, bound * (1 + 1e-15));
    EXPECT_GT(most, 0.5 * bound);
  }
}

/// A free beam's wave beyond its right end, where `evaluate` does not go.
double wave_at(const ModeShape& m, double length, double x) {
  return m.sine * std::sin(m.beta * x) + m.cosine * std::cos(m.beta * x) +
         m.left * std::exp(-m.beta * x) + m.right * std::exp(m.beta * (x - length));
}

TEST(Bounds, WavesStayBelowTheirLargestBeyondTheEndToo) {
  const Beam beam = free_beam();
  for (const ModeShape& mode : beam.modes) {
    if (mode.beta == 0) continue;
    const double beyond = 2.5 / mode.beta;
    double most = 0;
    for (int i = 0; i <= 1000; ++i)
      most =
          std::max(most, std::abs(wave_at(mode, beam.length, i * 1e-3 * (beam.length + beyond))));
    const double bound = largest_wave(mode, beyond);
    EXPECT_LE(most, bound);
    EXPECT_GT(most, 0.5 * bound);
  }
}

TEST(Bounds, CubicsLeaveOutNoMoreThanTheirRemainder) {
  const Beam beam = free_beam();
  for (const ModeShape& mode : beam.modes) {
    if (mode.beta == 0) continue;
    const double radius = 0.1 / mode.beta;
    const CubicRemainder bound = cubic_remainder(mode, radius);
    double most = 0, most_slope = 0;
    for (int i = 0; i <= 1000; ++i) {
      const double centre = radius + i * 1e-3 * (beam.length - 2 * radius);
      double d[4];
      evaluate(mode, beam.length, centre, 4, d);
      for (const double away : {-radius, radius}) {
        double there[2];
        evaluate(mode, beam.length, centre + away, 2, there);
        most = std::max(
            most,
            std::abs(there[0] - (d[0] + away * (d[1] + away * (d[2] / 2 + away * d[3] / 6)))));
        most_slope =
            std::max(most_slope, std::abs(there[1] - (d[1] + away * (d[2] + away * d[3] / 2))));
      }
    }
    EXPECT_LE(most, bound.value);
    EXPECT_LE(most_slope, bound.slope);
    EXPECT_GT(most, 0.3 * bound.value);
    EXPECT_GT(most_slope, 0.3 * bound.slope);
  }
}

TEST(Bounds, FourthDerivativeOfAPassingNodeIsTheFourthPowerOfBothRates) {
  // undamped, (d/dt + b)^4 of what turns at omega: (omega + b)^4/omega
  const Mode mode{.omega = 700, .zeta = 0, .mass = 2};
  for (const double b : {0.0, 3.0, 700.0, 1e5})
    EXPECT_NEAR(fourth_derivative(mode, 5, b) / (5 * std::pow(700 + b, 4) / 700), 1, 1e-14);
}

TEST(Bounds, SteepestIsThatOfEitherWay) {
  const std::vector<double> up{0, 1, 4, 3}, down{3, 4, 1, 0};
  EXPECT_EQ(steepest_rise(up.data(), 4), 3);
  EXPECT_EQ(steepest_rise(down.data(), 4), 3);
  EXPECT_EQ(steepest_rise(up.data(), 1), 0);
}

TEST(Bounds, FacesRoundByNoMoreThanTheirRounding) {
  // h_1 - delta + h_2 + theta rise, as it is summed at a node
  Dice dice(11);
  double most = 0;
  for (int i = 0; i < 10000; ++i) {
    const double h1 = dice.uniform(-1, 1), left = dice.uniform(-1, 1), right = dice.uniform(-1, 1);
    const double theta = dice.uniform(0, 1);
    const double sum = h1 + std::fma(theta, right - left, left);
    const long double exact =
        static_cast<long double>(h1) + left +
        static_cast<long double>(theta) * (static_cast<long double>(right) - left);
    most = std::max(most, static_cast<double>(std::abs(sum - exact)));
  }
  EXPECT_LE(most, face_rounding(2));
  EXPECT_GT(most, face_rounding(2) / 100);
}

}  // namespace
}  // namespace ra2d::test
