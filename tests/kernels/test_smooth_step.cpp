// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/device/stage_tables.hpp"
#include "kernels/adaptive/brent.hpp"
#include "kernels/adaptive/pace.hpp"
#include "kernels/contact/moving_cell.hpp"
#include "tests/dice.hpp"
#include "tests/numbers.hpp"

/// The parts of adaptive steps between smooth faces: the weights of their stages, the highest
/// place of a cell, and the highest value of a force.
namespace ra2d::test {
namespace {

/// The rows of one pace.
struct Stages {
  std::vector<double> table = std::vector<double>(paces * pace_numbers, 0.0);
  Pace pace;

  explicit Stages(Pace pace) : pace{pace} { fill_stages(table.data()); }
  const double* row(int r) const {
    return table.data() + static_cast<int>(pace) * pace_numbers + r * formula_stages;
  }
  double share(int stage) const { return pace_share(pace, row(stage_places)[stage]); }
  struct Integral {
    double value = 0,
           size = 0;  // the sum, and that of its terms' sizes: roundings are relative to it
  };
  /// Of a power of the time, by the weights of the first `count` stages.
  Integral integral(int r, int count, int power) const {
    Integral sum;
    for (int j = 0; j < count; ++j) {
      const double term = row(r)[j] * std::pow(share(j), power);
      sum.value += term;
      sum.size += std::abs(term);
    }
    return sum;
  }
};

class StagesAtAPace : public testing::TestWithParam<Pace> {};
INSTANTIATE_TEST_SUITE_P(Paces, StagesAtAPace,
                         testing::Values(Pace::even, Pace::from_onset, Pace::to_release),
                         [](const auto& pace) {
                           return pace.param == Pace::even         ? "Even"
                                  : pace.param == Pace::from_onset ? "FromOnset"
                                                                   : "ToRelease";
                         });

/// From the third stage on they are of second order at least: the time is exact where it goes with
/// x^2, too.
TEST_P(StagesAtAPace, StandWhereTheirWeightsTakeThem) {
  const Stages s(GetParam());
  for (int i = s.pace == Pace::even ? 1 : 2; i < formula_stages; ++i) {
    const auto [value, size] = s.integral(stage_weights + i, i, 0);
    EXPECT_NEAR(value, s.share(i), 32 * eps * (1 + size)) << i;
  }
}

/// Of order 8 in x: t^k is exact up to t^7, where t goes with x; with x^2 up to t^3.
TEST_P(StagesAtAPace, IntegratePowersOfTheTimeExactly) {
  const Stages s(GetParam());
  const int highest = s.pace == Pace::even ? 7 : 3;
  for (int k = 0; k <= highest; ++k) {
    const auto [value, size] = s.integral(stage_weights + last_stage, last_stage, k);
    EXPECT_NEAR(value, 1.0 / (k + 1), 32 * eps * size) << k;
    // and their errors are none
    for (const int row : {stage_fifth_order_error, stage_third_order_error}) {
      const int order = row == stage_fifth_order_error ? 4 : 2;
      if ((s.pace == Pace::even ? k : 2 * k + 1) > order) continue;
      const auto [error, of] = s.integral(row, last_stage, k);
      EXPECT_NEAR(error, 0.0, 32 * eps * of) << k;
    }
  }
}

/// A force that grows as t^1.5 from the onset of a contact is a power of x there.
TEST(StagesAtPaces, IntegrateTheForceOfAContactThatBegins) {
  const auto error = [](Pace pace) {
    const Stages s(pace);
    double sum = 0;
    for (int j = 0; j < last_stage; ++j) {
      const double after = pace == Pace::to_release ? 1 - s.share(j) : s.share(j);
      sum += s.row(stage_weights + last_stage)[j] * std::pow(std::max(after, 0.0), 1.5);
    }
    return std::abs(sum - 0.4);
  };
  EXPECT_LT(error(Pace::from_onset), 1e-13);
  EXPECT_LT(error(Pace::to_release), 1e-13);
  EXPECT_GT(error(Pace::even), 1e-6);
}

/// The motion that a step finds: at its end that of the step, and exact for powers of the time.
TEST_P(StagesAtAPace, TheMotionBetweenIsExactForPowersOfTheTime) {
  const Stages s(GetParam());
  const int highest = s.pace == Pace::even ? 5 : 2;
  for (const double x : {0.0, 0.07, 0.5, 0.83, 1.0})
    for (int k = 0; k <= highest; ++k) {
      double sum = 0, size = 0;
      for (int j = 0; j < formula_stages; ++j) {
        double weight = 0;
        for (int m = motion_terms - 1; m >= 0; --m) {
          weight = weight * x + s.row(stage_output + m)[j];
          size = std::max(size, std::abs(s.row(stage_output + m)[j]));
        }
        sum += weight * std::pow(s.share(j), k);
      }
      EXPECT_NEAR(sum, std::pow(pace_share(s.pace, x), k + 1) / (k + 1), 64 * eps * size)
          << x << " " << k;
    }
}

TEST(Paces, GiveTheXOfAShare) {
  for (const Pace pace : {Pace::even, Pace::from_onset, Pace::to_release})
    for (const double x : {0.0, 1e-9, 0.3, 0.999, 1.0}) {
      EXPECT_NEAR(pace_x(pace, pace_share(pace, x)), x, 1e-7);
      const double h = 1e-6;
      EXPECT_NEAR((pace_share(pace, x + h) - pace_share(pace, x - h)) / (2 * h), pace_rate(pace, x),
                  1e-8);
    }
}

// ---- the highest place ------------------------------------------------------------------------

Cubic random_cubic(Dice& dice) {
  Cubic c;
  for (double& each : c.c) each = dice.uniform(-1, 1) * std::pow(10.0, dice.uniform(-3, 0));
  if (dice.one_in(4)) c.c[3] = 0;
  if (dice.one_in(8)) c.c[2] = 0;
  return c;
}

TEST(HighestOn, IsWhereNoPlaceIsHigher) {
  Dice dice(11);
  for (int i = 0; i < 2000; ++i) {
    const Cubic c = random_cubic(dice);
    const double from = dice.uniform(-0.5, 0.4), to = dice.uniform(from, 0.5);
    const Highest found = highest_on(c, from, to);
    EXPECT_GE(found.place, from);
    EXPECT_LE(found.place, to);
    EXPECT_EQ(found.value, c(found.place));
    double size = 0;
    for (const double each : c.c) size += std::abs(each);
    for (int k = 0; k <= 200; ++k)
      EXPECT_LE(c(from + (to - from) * (k / 200.0)), found.value + 8 * eps * size);
  }
}

TEST(MovingCells, AreHighestAfterATimeWhereTheirRatesTakeThem) {
  Dice dice(12);
  for (int i = 0; i < 500; ++i) {
    MovingCell cell;
    cell.knot = dice.uniform(-0.5, 0.5);
    for (int side = 0; side < 2; ++side) {
      cell.overlap[side] = random_cubic(dice);
      cell.rate[side] = random_cubic(dice);
    }
    const double s = dice.uniform(0, 2), found = cell.highest_after(s);
    double rate_there = 0;
    EXPECT_EQ(cell.highest(rate_there), cell.highest_after(0.0));
    double sampled = -1e300;
    for (int k = 0; k <= 1000; ++k) {
      const double eta = -0.5 + k / 1000.0;
      const int side = eta > cell.knot;
      sampled = std::max(sampled, cell.overlap[side](eta) + s * cell.rate[side](eta));
    }
    EXPECT_GE(found, sampled - 1e-14);
    EXPECT_LE(found, sampled + 1e-2);
  }
}

TEST(HighestBetween, IsThatOfASmoothPeak) {
  Dice dice(13);
  for (int i = 0; i < 200; ++i) {
    const double from = dice.uniform(0, 0.4), to = dice.uniform(0.6, 1), top = dice.uniform(0, 1),
                 skew = dice.uniform(0, 0.5);
    const auto f = [&](double x) {
      const double d = x - top;
      return 3 - d * d * (1 + skew * d);
    };
    const double found = highest_between(from, to, f);
    const double exact = std::max({top >= from && top <= to ? 3.0 : -1e300, f(from), f(to)});
    // the place is right to 1e-4 of the interval; an end is no place of it
    EXPECT_LE(found, exact);
    EXPECT_GE(found, exact - (top >= from && top <= to ? 1e-7 : 3e-4));
  }
}

}  // namespace
}  // namespace ra2d::test
