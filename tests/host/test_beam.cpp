// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/body/beam.hpp"
#include "host/run/v_rms.hpp"
#include "tests/numbers.hpp"

namespace {

using namespace ra2d;

using test::eps;
using test::pi;

/// Body of the paper's resonator, 300 x 200 x 2 mm of steel.
BodySpec plate(Support support) {
  BodySpec body;
  body.support = support;
  body.length = 0.3;
  body.thickness = 0.002;
  body.width = 0.2;
  body.young = 210e9;
  body.density = 7800;
  body.damping = 0.02;
  return body;
}

Body plate_with_modes(Support support, int modes) {
  BodySpec body = plate(support);
  body.modes = modes;
  return make_beam(body);
}

std::array<double, 6> derivatives_at(const BodyMode& mode, double x) {
  std::array<double, 6> out{};
  mode.shape->evaluate(x, 6, out.data());
  return out;
}

/// Nodes and weights of Gauss-Legendre quadrature on [-1, 1]: Newton on P_n by its recurrence.
struct GaussLegendre {
  static constexpr int order = 16;
  std::array<double, order> node{}, weight{};

  GaussLegendre() {
    for (int i = 0; i < order; ++i) {
      double x = std::cos(pi * (i + 0.75) / (order + 0.5)), slope = 0;
      for (int iteration = 0; iteration < 10; ++iteration) {
        double before = 1, p = x;
        for (int n = 2; n <= order; ++n)
          before = std::exchange(p, ((2 * n - 1) * x * p - (n - 1) * before) / n);
        slope = order * (x * p - before) / (x * x - 1);
        x -= p / slope;
      }
      node[i] = x;
      weight[i] = 2 / ((1 - x * x) * slope * slope);
    }
  }
};

/// Integral over [0, length] on 80 panels. With modes up to number 60 the integrand turns by less
/// than 5 rad a panel: the rule's error (2.5^32/32!) is far below a rounding.
template <class Function>
double integrate(double length, Function f) {
  static const GaussLegendre rule;
  constexpr int panels = 80;
  const double half = length / (2 * panels);
  double sum = 0;
  for (int panel = 0; panel < panels; ++panel)
    for (int i = 0; i < GaussLegendre::order; ++i)
      sum += rule.weight[i] * f((2 * panel + 1 + rule.node[i]) * half);
  return sum * half;
}

/// Roundings in psi, as a multiple of `largest`: those of beta x, from the nearer end, and a few
/// more.
double psi_error(const BodyMode& mode, double length) {
  return eps * (4 + mode.shape->wave_number() * length);
}

class Supports : public testing::TestWithParam<Support> {};
INSTANTIATE_TEST_SUITE_P(Beam, Supports, testing::Values(Support::pinned, Support::free),
                         [](const auto& info) {
                           return info.param == Support::pinned ? "Pinned" : "Free";
                         });

TEST_P(Supports, ModesAreOrthonormal) {
  const Body beam = plate_with_modes(GetParam(), 60);
  for (std::size_t k = 0; k < beam.modes.size(); ++k)
    for (std::size_t l = 0; l <= k; ++l) {
      const BodyMode &one = beam.modes[k], &other = beam.modes[l];
      const double product =
          integrate(beam.length, [&](double x) { return shape_at(one, x) * shape_at(other, x); });
      // |psi_k psi_l| integrates to 1 at most; the sum's 1280 roundings grow as a random walk.
      const double tolerance =
          2 * (psi_error(one, beam.length) + psi_error(other, beam.length)) + 40 * eps;
      EXPECT_NEAR(product, k == l ? 1 : 0, tolerance) << "modes " << k << " and " << l;
    }
}

TEST_P(Supports, EquationAndDerivativesHold) {
  const Body beam = plate_with_modes(GetParam(), 60);
  for (const BodyMode& mode : beam.modes) {
    const double beta = mode.shape->wave_number(), largest = mode.shape->largest();
    if (beta == 0) continue;
    const double h = 1.0 / 256 / beta;
    for (int i = 0; i <= 40; ++i) {
      const double x = beam.length * i / 40;
      const auto psi = derivatives_at(mode, x);
      EXPECT_NEAR(psi[4], std::pow(beta, 4) * psi[0], 8 * eps * std::pow(beta, 4) * largest);
      const double factor = mode.shape->fourth_derivative_factor(h);  // lengths in units of h
      for (const int j : {0, 1})
        EXPECT_NEAR(std::pow(h, 4) * psi[j + 4], factor * psi[j],
                    8 * eps * factor * std::pow(beta, j) * largest);

      // Fourth-order central difference: its error is h^4/30 times the fifth derivative further on.
      const auto at = [&](double steps, int j) { return derivatives_at(mode, x + steps * h)[j]; };
      for (int j = 0; j < 5; ++j) {
        const double slope = (8 * (at(1, j) - at(-1, j)) - (at(2, j) - at(-2, j))) / (12 * h);
        const double scale = std::pow(beta, j + 1) * largest * 1.25;
        const double truncation = std::pow(1.0 / 256, 4) / 30 * scale * std::exp(3.0 / 256);
        const double rounding = 1.5 * psi_error(mode, beam.length) * 256 * scale;
        EXPECT_NEAR(psi[j + 1], slope, truncation + rounding) << "derivative " << j + 1;
      }
    }
  }
}

TEST_P(Supports, EndsAreAsTheSupportSaysAndEquallyExact) {
  const Body beam = plate_with_modes(GetParam(), 200);
  const int first_zero = GetParam() == Support::pinned ? 0 : 2;
  const int second_zero = GetParam() == Support::pinned ? 2 : 3;
  for (const BodyMode& mode : beam.modes) {
    const double beta =
        mode.shape->wave_number() == 0 ? 1 / beam.length : mode.shape->wave_number();
    for (const double x : {0.0, beam.length}) {
      const auto psi = derivatives_at(mode, x);
      for (const int j : {first_zero, second_zero})
        EXPECT_NEAR(psi[j], 0, 4 * eps * std::pow(beta, j) * mode.shape->largest())
            << "derivative " << j;
    }
  }
}

TEST_P(Supports, LargestBoundsTheShapeTightly) {
  const Body beam = plate_with_modes(GetParam(), 60);
  for (const BodyMode& mode : beam.modes) {
    double most = 0;
    for (int i = 0; i <= 20000; ++i)
      most = std::max(most, std::abs(derivatives_at(mode, beam.length * i / 20000)[0]));
    EXPECT_LE(most, mode.shape->largest());
    EXPECT_GE(most, 0.95 * mode.shape->largest());
  }
}

TEST_P(Supports, LoadIsTheIntegralOfTheModes) {
  BodySpec body = plate(GetParam());
  body.modes = 30;
  body.load = 7.5;
  const Body beam = make_beam(body);
  ASSERT_EQ(beam.load.size(), beam.modes.size());
  EXPECT_EQ(beam.load_force, 7.5);
  for (std::size_t k = 0; k < beam.modes.size(); ++k) {
    const double integral =
        integrate(beam.length, [&](double x) { return derivatives_at(beam.modes[k], x)[0]; });
    const double tolerance =
        7.5 * beam.modes[k].shape->largest() * (psi_error(beam.modes[k], beam.length) + 40 * eps);
    EXPECT_NEAR(beam.load[k], 7.5 / beam.length * integral, tolerance) << "mode " << k;
  }
}

TEST(Beam, FreeBeamIsLoadedOnItsTranslationAlone) {
  BodySpec body = plate(Support::free);
  body.modes = 5;
  body.load_is_weight = true;
  const Body beam = make_beam(body);
  EXPECT_DOUBLE_EQ(beam.load_force, 7800 * 0.3 * 0.002 * 0.2 * 9.80665);
  EXPECT_DOUBLE_EQ(beam.load[0], beam.load_force / std::sqrt(0.3));
  for (std::size_t k = 1; k < beam.load.size(); ++k) EXPECT_EQ(beam.load[k], 0) << "mode " << k;
}

TEST(Beam, PinnedModesAreSines) {
  const Body beam = plate_with_modes(Support::pinned, 40);
  const double stiffness = 210e9 * 0.2 * std::pow(0.002, 3) / 12, mass = 7800 * 0.002 * 0.2;
  for (int k = 0; k < 40; ++k) {
    const BodyMode& mode = beam.modes[k];
    EXPECT_DOUBLE_EQ(mode.omega,
                     std::sqrt(stiffness / mass) * std::pow((k + 1) * pi / beam.length, 2));
    const double x = 0.1 * beam.length;
    EXPECT_NEAR(derivatives_at(mode, x)[0],
                std::sqrt(2 / beam.length) * std::sin((k + 1) * pi * 0.1),
                psi_error(mode, beam.length) * mode.shape->largest());
  }
}

TEST(Beam, FreeRigidModesTranslateAndRotate) {
  const Body beam = plate_with_modes(Support::free, 0);
  ASSERT_EQ(beam.modes.size(), 2);
  for (const double x : {0.0, 0.07, 0.3}) {
    const auto translation = derivatives_at(beam.modes[0], x);
    const auto rotation = derivatives_at(beam.modes[1], x);
    const double slope = std::sqrt(12 / std::pow(0.3, 3));
    EXPECT_DOUBLE_EQ(translation[0], 1 / std::sqrt(0.3));
    EXPECT_EQ(translation[1], 0);
    EXPECT_NEAR(rotation[0], slope * (x - 0.15), 4 * eps * slope * 0.15);
    EXPECT_DOUBLE_EQ(rotation[1], slope);
    EXPECT_EQ(rotation[2], 0);
  }
  EXPECT_EQ(beam.modes[0].omega, 0);
  EXPECT_EQ(beam.modes[1].omega, 0);
}

TEST(Beam, FreeRootsAreExact) {
  // Roots of cosh z cos z = 1, rounded from 25 digits: a beam of 1 m has them as its beta.
  const double roots[] = {4.730040744862704026024048, 7.853204624095837556477067,
                          10.99560783800167090666903, 14.13716549125746417710592,
                          17.27875965739948143809107};
  BodySpec body = plate(Support::free);
  body.length = 1;
  body.modes = 1000;
  const Body beam = make_beam(body);
  for (int k = 0; k < 5; ++k)
    EXPECT_NEAR(beam.modes[k + 2].shape->wave_number(), roots[k], eps * roots[k]) << "root " << k;
  for (int k = 12; k < 1000; ++k)  // 1/cosh z < 1e-17 from here on; three roundings
    EXPECT_NEAR(beam.modes[k + 2].shape->wave_number(), (k + 1.5) * pi,
                3 * eps / 2 * (k + 1.5) * pi);
}

TEST(Beam, FreeElasticModesEndAtTwoOverRootLength) {
  const Body beam = plate_with_modes(Support::free, 60);
  for (int k = 0; k < 60; ++k) {
    const BodyMode& mode = beam.modes[k + 2];
    const double end = 2 / std::sqrt(0.3);
    EXPECT_NEAR(derivatives_at(mode, 0)[0], end, 2 * eps * end);
    EXPECT_NEAR(derivatives_at(mode, 0.3)[0], k % 2 == 0 ? end : -end, 2 * eps * end);
  }
}

TEST(Beam, PapersBodiesHaveTheirModes) {
  BodySpec resonator = plate(Support::pinned);
  resonator.max_frequency = 20e3;
  EXPECT_EQ(make_beam(resonator).modes.size(), 19);

  BodySpec slider = plate(Support::free);
  slider.length = slider.thickness = slider.width = 0.02;
  slider.max_frequency = 20e3;
  EXPECT_EQ(make_beam(slider).modes.size(), 2);
  // First elastic mode of a free steel cube of 20 mm: z^2/(2 pi L^2) sqrt(E a^2/(12 rho)).
  const double root = 4.730040744862704;
  EXPECT_DOUBLE_EQ(elastic_frequency(slider, 0),
                   root * root / (2 * pi * 4e-4) * std::sqrt(210e9 * 4e-4 / (12 * 7800)));
}

TEST(Beam, MaxFrequencyKeepsAModeAtTheLimit) {
  for (const Support support : {Support::pinned, Support::free}) {
    BodySpec body = plate(support);
    const std::size_t rigid = support == Support::free ? 2 : 0;
    body.max_frequency = elastic_frequency(body, 7);
    EXPECT_EQ(make_beam(body).modes.size(), rigid + 8);
    body.max_frequency = std::nextafter(*body.max_frequency, 0);
    EXPECT_EQ(make_beam(body).modes.size(), rigid + 7);
  }
}

TEST(Beam, ElasticFrequencyIsTheKeptModes) {
  for (const Support support : {Support::pinned, Support::free}) {
    const Body beam = plate_with_modes(support, 10);
    for (int k = 0; k < 10; ++k)
      EXPECT_EQ(elastic_frequency(plate(support), k),
                beam.modes[beam.modes.size() - 10 + k].omega / (2 * pi));
  }
}

TEST(Beam, RigidSupportHasNoModesButItsLoad) {
  BodySpec body = plate(Support::rigid);
  body.max_frequency = 20e3;
  body.load = 3;
  const Body beam = make_beam(body);
  EXPECT_TRUE(beam.modes.empty());
  EXPECT_TRUE(beam.load.empty());
  EXPECT_EQ(beam.load_force, 3);
  EXPECT_TRUE(std::isinf(elastic_frequency(body, 0)));
}

TEST(Beam, RefusesAnAbsurdNumberOfModes) {
  BodySpec body = plate(Support::pinned);
  body.max_frequency = std::numeric_limits<double>::infinity();
  EXPECT_THROW(make_beam(body), RequestError);
}

TEST(MeanSquares, AreThoseOfTheShapesAtAllNodes) {
  for (const Support support : {Support::pinned, Support::free})
    for (const int nodes : {3, 2001}) {  // few: computed at get(); many: on a thread
      const Body beam = plate_with_modes(support, 20);
      const double spacing = beam.length / (nodes - 1);
      const MeanSquares found = mean_squares(beam, nodes, spacing), copy = found;
      std::vector<double> expected;
      for (const BodyMode& mode : beam.modes) {
        double sum = 0;
        for (int n = 0; n < nodes && mode.omega > 0; ++n)
          sum += shape_at(mode, n * spacing) * shape_at(mode, n * spacing);
        expected.push_back(sum / nodes);
      }
      EXPECT_EQ(found.get(), expected);
      EXPECT_EQ(copy.get(), expected);
    }
  EXPECT_TRUE(MeanSquares().get().empty());
  {
    const MeanSquares nobody_asked_for =
        mean_squares(plate_with_modes(Support::free, 20), 9999, 3e-5);
  }
}

}  // namespace
