// SPDX-License-Identifier: BSD-3-Clause
#include "host/body/body.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/body/beam.hpp"
#include "host/body/block.hpp"
#include "host/body/plate.hpp"
#include "tests/dice.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

/// The promises of host/body/body.hpp, on which the march and its proofs rest, of every kind of
/// body. A new kind adds itself to `kinds`.
namespace ra2d::test {
namespace {

/// Roundings of the bounds and of psi: psi is good to an ulp of its phase, at most 100 here.
constexpr double roundings = 1 + 200 * eps;

struct Kind {
  const char* name;
  Support support;
  Body (*make)(const BodySpec&);
  int rigid, elastic;                              // modes
  double (*frequency)(const BodySpec&, int) = {};  // Hz, of an elastic mode
};
constexpr Kind kinds[] = {{"PinnedBeam", Support::pinned, make_body, 0, 25, elastic_frequency},
                          {"FreeBeam", Support::free, make_body, 2, 25, elastic_frequency},
                          {"Plate", Support::pinned, make_plate, 0, 25, plate_frequency},
                          {"Block", Support::free, make_block, 3, 0}};

class Bodies : public testing::TestWithParam<Kind> {
 protected:
  static constexpr int derivatives = 6, places = 4000;

  static constexpr double width = 0.2;  // m

  Bodies() : body_{GetParam().make(spec())} {}
  BodySpec spec() const {
    BodySpec spec = steel(0.3, 0.002, width, 0.02, GetParam().elastic);
    spec.support = GetParam().support;
    return spec;
  }
  double at(int place) const { return body_.length * place / places; }
  /// A stretch on which no shape changes much [m].
  double stretch() const {
    const double wave = highest_wave_number(body_);
    return wave > 0 ? 0.5 / wave : 0.05 * body_.length;
  }
  static std::array<double, derivatives> derive(const BodyMode& mode, double x) {
    std::array<double, derivatives> d{};
    mode.shape->evaluate(x, derivatives, d.data());
    return d;
  }

  Body body_;
};
INSTANTIATE_TEST_SUITE_P(Body, Bodies, testing::ValuesIn(kinds),
                         [](const auto& info) { return info.param.name; });

TEST_P(Bodies, RigidModesComeFirstAndCountsAgree) {
  const auto rigid = static_cast<std::size_t>(GetParam().rigid);
  ASSERT_EQ(body_.modes.size(), rigid + GetParam().elastic);
  if (GetParam().make == make_body) {
    ASSERT_EQ(body_.modes.size(), static_cast<std::size_t>(mode_count(spec(), 100)));
  }
  ASSERT_EQ(body_.load.size(), body_.modes.size());
  for (std::size_t k = 0; k < body_.modes.size(); ++k) {
    const Mode& mode = body_.modes[k];
    EXPECT_GT(mode.mass, 0);
    EXPECT_EQ(mode.zeta, spec().damping);
    const double expected =
        k < rigid ? 0 : 2 * M_PI * GetParam().frequency(spec(), static_cast<int>(k - rigid));
    EXPECT_DOUBLE_EQ(mode.omega, expected) << "mode " << k;
  }
}

TEST_P(Bodies, ModesHaveTheBodysMass) {
  // psi^2 integrates to 1 over the body: a mode's mass over the mean of psi^2 is the body's mass.
  // The mean over nodes counts both ends in full, where the trapezoidal rule takes half of each.
  for (const BodyMode& mode : body_.modes) {
    const double ends = 2 * std::pow(mode.shape->largest(), 2) * body_.length / places;
    EXPECT_NEAR(mode.mass / mode.shape->mean_square(places + 1, at(1)), body_.mass,
                ends * body_.mass);
  }
}

TEST_P(Bodies, ShapesKeepTheirBounds) {
  double highest = 0;
  for (const BodyMode& mode : body_.modes) {
    const ModeShape& shape = *mode.shape;
    double most = 0;
    for (int place = 0; place <= places; ++place) {
      const auto psi = derive(mode, at(place));
      EXPECT_EQ(shape_at(mode, at(place)), psi[0]);
      most = std::max(most, std::abs(psi[0]));
      ASSERT_LE(std::abs(psi[1]), shape.largest_slope(0) * roundings);
      ASSERT_LE(std::abs(psi[2]), shape.largest_curvature(0) * roundings);
      for (int j = 1; j < derivatives; ++j)
        ASSERT_LE(std::abs(psi[j]), std::pow(shape.change_rate(), j) * shape.size() * roundings);
      for (int j = 2; j < derivatives; ++j)
        ASSERT_LE(std::abs(psi[j]), std::pow(shape.wave_number(), j) * shape.size() * roundings);
    }
    EXPECT_LE(most, shape.largest() * roundings);
    EXPECT_GE(most, 0.95 * shape.largest());
    EXPECT_LE(shape.largest(), shape.size() * roundings);
    highest = std::max(highest, shape.wave_number());
  }
  EXPECT_EQ(highest_wave_number(body_), highest);
}

TEST_P(Bodies, ShapesKeepTheirBoundsBehindTheEnd) {
  const double beyond = stretch();
  for (const BodyMode& mode : body_.modes)
    for (int i = 0; i <= 100; ++i) {
      const ModeShape& shape = *mode.shape;
      const auto psi = derive(mode, body_.length + beyond * i / 100);
      ASSERT_LE(std::abs(psi[1]), shape.largest_slope(beyond) * roundings);
      ASSERT_LE(std::abs(psi[2]), shape.largest_curvature(beyond) * roundings);
      for (int j = 2; j < derivatives; ++j)
        ASSERT_LE(std::abs(psi[j]), std::pow(shape.wave_number(), j) * shape.size() *
                                        shape.growth(beyond) * roundings);
    }
}

TEST_P(Bodies, FourDerivativesGiveTheSeries) {
  // what the kernels do on a patch: the value and three derivatives, continued by the factor
  const double unit = stretch();
  for (const BodyMode& mode : body_.modes)
    for (int place = 100; place < places - 100; place += 37) {
      const double factor = mode.shape->fourth_derivative_factor(unit);
      std::array<double, 20> terms{};
      mode.shape->evaluate(at(place), 4, terms.data());
      for (int j = 0; j < 4; ++j) terms[j] *= std::pow(unit, j);
      for (int j = 4; j < 20; ++j) terms[j] = factor * terms[j - 4];
      for (const double share : {-1.0, -0.4, 0.7, 1.0}) {
        double sum = 0, cubic = 0, power = 1;
        for (int j = 0; j < 20; ++j) {
          sum += terms[j] * power;
          if (j == 3) cubic = sum;
          power *= share / (j + 1);
        }
        const double psi = shape_at(mode, at(place) + share * unit);
        ASSERT_NEAR(sum, psi, 400 * eps * mode.shape->size());
        ASSERT_LE(std::abs(psi - cubic), mode.shape->cubic_remainder(unit).value * (1 + 1e-9) +
                                             400 * eps * mode.shape->size());
      }
    }
}

TEST_P(Bodies, ShapesAcrossKeepTheirBounds) {
  Dice dice(1);
  for (const BodyMode& mode : body_.modes) {
    const ModeShape& shape = *mode.shape;
    const double rate = shape.across_rate(), h = rate > 0 ? 1e-2 / rate : 1e-3;
    const auto across = [&](double y) {
      std::array<double, derivatives> d{};
      shape.evaluate_across(y, derivatives, d.data());
      return d;
    };
    double most = std::max(std::abs(across(0)[0]), std::abs(across(width)[0]));
    for (int place = 0; place < 400; ++place) {
      const double x = dice.uniform(0, body_.length), y = dice.uniform(0, width);
      const auto at = across(y), below = across(y - h), above = across(y + h);
      EXPECT_EQ(shape_at(mode, x, y), shape_at(mode, x) * at[0]);
      most = std::max(most, std::abs(at[0]));
      for (int j = 1; j < derivatives; ++j) {
        const double bound = std::pow(rate, j);
        ASSERT_LE(std::abs(at[j]), bound * roundings);
        // a central difference: off by h^2/6 times the derivative two further on, and roundings
        ASSERT_NEAR(at[j], (above[j - 1] - below[j - 1]) / (2 * h), bound * (1e-4 / 6 + 1e4 * eps));
      }
    }
    EXPECT_LE(most, roundings);
    EXPECT_GE(most, 0.95);
  }
}

TEST_P(Bodies, EqualParametersMeanEqualShapes) {
  const Body same = GetParam().make(spec());
  BodySpec longer = spec();
  longer.length *= 1.5;
  const Body other = GetParam().make(longer);
  const auto parameters = [](const BodyMode& mode) {
    std::vector<double> out;
    mode.shape->append_parameters(out);
    return out;
  };
  for (std::size_t k = 0; k < body_.modes.size(); ++k) {
    EXPECT_EQ(parameters(body_.modes[k]), parameters(same.modes[k]));
    EXPECT_NE(parameters(body_.modes[k]), parameters(other.modes[k]));
    if (k > 0) {
      EXPECT_NE(parameters(body_.modes[k]), parameters(body_.modes[k - 1]));
    }
  }
}

}  // namespace
}  // namespace ra2d::test
