// SPDX-License-Identifier: BSD-3-Clause
#include "host/body/plate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/body/areal_shape.hpp"
#include "host/body/block.hpp"
#include "tests/dice.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

/// Plates and blocks against theory. The promises of their shapes to the march are in
/// test_body.cpp.
namespace ra2d::test {
namespace {

BodySpec steel_plate(int modes) {
  BodySpec spec = steel(0.3, 0.002, 0.2, 0.02, modes);
  spec.poisson = 0.3;
  return spec;
}
double bending_stiffness(const BodySpec& spec) {
  return spec.young * std::pow(spec.thickness, 3) / (12 * (1 - std::pow(*spec.poisson, 2)));
}
BodySpec steel_block() {
  BodySpec spec = steel(0.02, 0.015, 0.012, 0, 0);
  spec.support = Support::free;
  return spec;
}

/// The largest distance of the modes' products from the unit matrix, integrated over the area by a
/// rule of points and weights on [0, 1] along each side.
double worst_product(const Body& body, double width, const std::vector<std::array<double, 2>>& x,
                     const std::vector<std::array<double, 2>>& y) {
  const std::size_t modes = body.modes.size();
  std::vector<double> sum(modes * modes, 0.0), psi(modes);
  for (const auto& [px, wx] : x)
    for (const auto& [py, wy] : y) {
      for (std::size_t k = 0; k < modes; ++k)
        psi[k] = shape_at(body.modes[k], px * body.length, py * width);
      for (std::size_t k = 0; k < modes; ++k)
        for (std::size_t l = 0; l < modes; ++l)
          sum[k * modes + l] += wx * wy * body.length * width * psi[k] * psi[l];
    }
  double worst = 0;
  for (std::size_t k = 0; k < modes; ++k)
    for (std::size_t l = 0; l < modes; ++l)
      worst = std::max(worst, std::abs(sum[k * modes + l] - (k == l ? 1 : 0)));
  return worst;
}

TEST(Plate, ModesAreOrthonormal) {
  const Body plate = make_plate(steel_plate(60));
  // The midpoint rule is exact for products of sines with m + m' < 2 points: m is at most 13 here.
  const auto midpoints = [](int points) {
    std::vector<std::array<double, 2>> rule;
    for (int i = 0; i < points; ++i) rule.push_back({(i + 0.5) / points, 1.0 / points});
    return rule;
  };
  // 500 products of up to 4/(a b), whose roundings (of the phase: up to 13 pi) are at random
  EXPECT_LT(worst_product(plate, 0.2, midpoints(25), midpoints(20)), 4 * 13 * pi * eps);
}

TEST(Block, ModesAreOrthonormal) {
  const double third = 0.5 / std::sqrt(3.0);
  const std::vector<std::array<double, 2>> gauss{{0.5 - third, 0.5}, {0.5 + third, 0.5}};
  EXPECT_LT(worst_product(make_block(steel_block()), 0.012, gauss, gauss), 16 * eps);
}

TEST(Plate, SteelPlateHas174ModesBelow20kHz) {
  BodySpec spec = steel_plate(0);
  spec.modes.reset();
  spec.max_frequency = 20e3;
  EXPECT_EQ(make_plate(spec).modes.size(), 174);
  spec.poisson.reset();  // 0.3
  EXPECT_EQ(make_plate(spec).modes.size(), 174);
}

TEST(Plate, ModesComeByFrequencyThenByM) {
  // 300 x 200 mm: omega is in proportion to 4 m^2 + 9 n^2, whole numbers, of which several are
  // equal.
  struct Expected {
    int square, m, n;
  };
  std::vector<Expected> expected;
  for (int m = 1; m < 100; ++m)
    for (int n = 1; n < 100; ++n) expected.push_back({4 * m * m + 9 * n * n, m, n});
  std::sort(expected.begin(), expected.end(), [](const Expected& a, const Expected& b) {
    return std::pair(a.square, a.m) < std::pair(b.square, b.m);
  });
  const BodySpec spec = steel_plate(400);
  const std::vector<PinnedPlateMode> modes = plate_modes(spec, 1000);
  ASSERT_EQ(modes.size(), 400);
  const double wave = std::sqrt(bending_stiffness(spec) / (7800 * 0.002)) * pi * pi / 0.36;
  int equal = 0;
  for (int k = 0; k < 400; ++k) {
    EXPECT_EQ(modes[k].m, expected[k].m) << k;
    EXPECT_EQ(modes[k].n, expected[k].n) << k;
    EXPECT_NEAR(modes[k].omega, wave * expected[k].square, 8 * eps * modes[k].omega);
    equal += k > 0 && expected[k].square == expected[k - 1].square;
    // the first so many, even where the next is as high
    const std::vector<PinnedPlateMode> fewer = plate_modes(steel_plate(k + 1), 1000);
    ASSERT_EQ(fewer.size(), k + 1);
    EXPECT_EQ(fewer.back().m, expected[k].m);
  }
  EXPECT_GE(equal, 10);
  EXPECT_EQ(plate_modes(spec, 30).size(), 30);
}

TEST(Plate, MaxFrequencyKeepsAModeAtTheLimit) {
  BodySpec spec = steel_plate(0);
  spec.modes.reset();
  spec.max_frequency = plate_frequency(spec, 7);
  EXPECT_EQ(plate_modes(spec, 100).size(), 8);
  spec.max_frequency = std::nextafter(*spec.max_frequency, 0);
  EXPECT_EQ(plate_modes(spec, 100).size(), 7);
}

TEST(Plate, BiharmonicEquationHolds) {
  // D (d^2/dx^2 + d^2/dy^2)^2 psi = mu omega^2 psi, by differences of five points a direction
  const BodySpec spec = steel_plate(60);
  const Body plate = make_plate(spec);
  Dice dice(1);
  for (const BodyMode& mode : plate.modes) {
    const ArealShape& shape = areal_shape(mode);
    const double h = 0.02 / std::hypot(shape.along.beta, shape.wave);
    const std::function<double(double, double)> psi = [&](double x, double y) {
      return shape_at(mode, x, y);
    };
    const auto laplace = [h](const auto& f, double x, double y) {
      return (f(x + h, y) + f(x - h, y) + f(x, y + h) + f(x, y - h) - 4 * f(x, y)) / (h * h);
    };
    for (int place = 0; place < 10; ++place) {
      const double x = dice.uniform(0.01, 0.29), y = dice.uniform(0.01, 0.19);
      const double bent = laplace([&](double x1, double y1) { return laplace(psi, x1, y1); }, x, y);
      const double expected = mode.mass * mode.omega * mode.omega * psi(x, y);
      // the difference is short by (wave h)^2/12 in each of two Laplacians; 64 roundings of psi,
      // some 13 pi ulp each, over h^4
      const double largest = bending_stiffness(spec) * shape.largest();
      const double rounding = largest * 64 * 40 * eps / std::pow(h, 4);
      EXPECT_NEAR(bending_stiffness(spec) * bent, expected,
                  0.02 * 0.02 / 6 * std::abs(expected) + rounding);
    }
  }
}

TEST(Plate, EdgesArePinned) {
  const Body plate = make_plate(steel_plate(60));
  for (const BodyMode& mode : plate.modes) {
    const ArealShape& shape = areal_shape(mode);
    for (const double y : {0.0, 0.2}) {
      std::array<double, 3> d{};
      shape.evaluate_across(y, 3, d.data());
      EXPECT_EQ(d[0], 0);  // no displacement
      EXPECT_EQ(d[2], 0);  // no moment
      EXPECT_EQ(std::abs(d[1]), shape.wave);
    }
    EXPECT_EQ(shape_at(mode, 0, 0.07), 0);
    EXPECT_EQ(shape_at(mode, 0.3, 0.07), 0);
  }
}

TEST(Plate, PointForceBendsASquareAsLevySays) {
  // At the force P in the middle of a square of side a:
  //   w = P a^2/(2 pi^3 D) sum over odd m of (tanh c - c/cosh^2 c)/m^3, c = m pi/2.
  BodySpec spec = steel_plate(3000);
  spec.length = spec.width = 0.25;
  const Body plate = make_plate(spec);
  double compliance = 0, levy = 0;
  for (const BodyMode& mode : plate.modes)
    compliance += std::pow(shape_at(mode, 0.125, 0.125) / mode.omega, 2) / mode.mass;
  for (int m = 1; m < 2000; m += 2) {
    const double c = m * pi / 2, sech = 1 / std::cosh(c);
    levy += (std::tanh(c) - c * sech * sech) / std::pow(m, 3);
  }
  levy *= 0.25 * 0.25 / (2 * std::pow(pi, 3) * bending_stiffness(spec));
  // What the modes leave out: of 1/(m^2 + n^2)^2 over odd m, n, which add up to 0.28, that beyond
  // the circle of 3000 modes, m^2 + n^2 > 4/pi 3000: pi/16 over that, give or take what a circle
  // cuts.
  const double left_out = pi / 16 / (4 / pi * 3000) / 0.28;
  EXPECT_NEAR(compliance, levy * (1 - left_out), 0.2 * left_out * levy);
}

TEST(Plate, LoadIsTheIntegralOfTheModes) {
  BodySpec spec = steel_plate(40);
  spec.load = 7.5;
  const Body plate = make_plate(spec);
  ASSERT_EQ(plate.load.size(), 40);
  // Simpson's rule on 2000 parts: off by (wave h)^4/180, with waves up to 13 pi over the length
  const auto integral = [](double length, const auto& f) {
    constexpr int parts = 2000;
    double sum = 0;
    for (int i = 0; i <= parts; ++i)
      sum += (i == 0 || i == parts ? 1 : i % 2 == 0 ? 2 : 4) * f(length * i / parts);
    return sum * length / (3 * parts);
  };
  for (int k = 0; k < 40; ++k) {
    const BodyMode& mode = plate.modes[k];
    const double along = integral(0.3, [&](double x) { return shape_at(mode, x); });
    const double across = integral(0.2, [&](double y) {
      double out = 0;
      mode.shape->evaluate_across(y, 1, &out);
      return out;
    });
    const double most = 7.5 * mode.shape->largest();
    EXPECT_NEAR(plate.load[k], 7.5 / 0.06 * along * across,
                most * 2 * std::pow(13 * pi / 2000, 4) / 180)
        << k;
  }
}

TEST(Plate, RefusesWhatItCannotBe) {
  BodySpec spec = steel_plate(3);
  for (const double poisson : {-1.0, -1.5, 0.5, 0.7}) {
    spec.poisson = poisson;
    EXPECT_THROW(make_plate(spec), RequestError) << poisson;
  }
  for (const double poisson : {-0.999, 0.0, 0.499}) {
    spec.poisson = poisson;
    EXPECT_EQ(make_plate(spec).modes.size(), 3) << poisson;
  }
  spec.support = Support::free;
  EXPECT_THROW(make_plate(spec), RequestError);
  spec.support = Support::rigid;
  EXPECT_TRUE(make_plate(spec).modes.empty());
  EXPECT_TRUE(std::isinf(plate_frequency(spec, 0)));
  spec = steel_plate(0);
  spec.modes.reset();
  spec.max_frequency = std::numeric_limits<double>::infinity();
  EXPECT_THROW(make_plate(spec), RequestError);
}

TEST(Block, MovesAsARigidBody) {
  const Body block = make_block(steel_block());
  ASSERT_EQ(block.modes.size(), 3);
  const double mass = 7800 * 0.02 * 0.015 * 0.012;
  EXPECT_DOUBLE_EQ(block.mass, mass);
  for (const BodyMode& mode : block.modes) {
    EXPECT_EQ(mode.omega, 0);
    EXPECT_DOUBLE_EQ(mode.mass, 7800 * 0.015);
  }
  // A force on a corner: it accelerates the corner by 1/M, 3/M of the pitch and 3/M of the roll.
  for (const double x : {0.0, 0.02})
    for (const double y : {0.0, 0.012})
      for (int k = 0; k < 3; ++k) {
        const double psi = shape_at(block.modes[k], x, y);
        EXPECT_NEAR(psi * psi / block.modes[k].mass, (k == 0 ? 1 : 3) / mass, 16 * eps * 3 / mass);
      }
  EXPECT_LT(shape_at(block.modes[1], 0, 0.003), 0);  // positive at the far end, positive far edge
  EXPECT_LT(shape_at(block.modes[2], 0.005, 0), 0);
}

TEST(Block, LoadDrivesHeaveAlone) {
  BodySpec spec = steel_block();
  spec.load_is_weight = true;
  const Body block = make_block(spec);
  EXPECT_DOUBLE_EQ(block.load_force, block.mass * 9.80665);
  EXPECT_DOUBLE_EQ(block.load[0], block.load_force / std::sqrt(0.02 * 0.012));
  EXPECT_EQ(block.load[1], 0);
  EXPECT_EQ(block.load[2], 0);
}

TEST(Block, RefusesWhatItCannotBe) {
  BodySpec spec = steel_block();
  spec.modes = 2;
  EXPECT_THROW(make_block(spec), RequestError);
  spec.modes = 0;
  spec.support = Support::pinned;
  EXPECT_THROW(make_block(spec), RequestError);
  spec.support = Support::rigid;
  EXPECT_TRUE(make_block(spec).modes.empty());
  EXPECT_GT(make_block(spec).mass, 0);
}

}  // namespace
}  // namespace ra2d::test
