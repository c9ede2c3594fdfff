// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "host/device/collocation_tables.hpp"
#include "kernels/adaptive/brent.hpp"
#include "kernels/adaptive/pace.hpp"
#include "kernels/contact/moving_cell.hpp"
#include "tests/dice.hpp"
#include "tests/numbers.hpp"

/// The parts of adaptive steps between smooth faces: the weights of their points, the highest
/// place of a cell, and the highest value of a force.
namespace ra2d::test {
namespace {

/// The numbers of one pace.
struct Points {
  std::vector<double> table = std::vector<double>(paces * pace_numbers, 0.0);
  Pace pace;

  explicit Points(Pace pace) : pace{pace} { fill_collocation(table.data()); }
  const double* row(int first) const {
    return table.data() + static_cast<int>(pace) * pace_numbers + first;
  }
  double x(int point) const { return row(point_places)[point]; }
  double share(int point) const { return pace_share(pace, x(point)); }
  struct Sum {
    double value = 0, size = 0;  // and that of its terms' sizes: roundings are relative to it
  };
  /// The sum of a power of the time at the points, with the weights that `weight` gives.
  template <class Weight>
  Sum sum(int power, const Weight& weight) const {
    Sum sum;
    for (int j = 0; j < collocation_points; ++j) {
      const double term = weight(j) * std::pow(share(j), power);
      sum.value += term;
      sum.size += std::abs(term);
    }
    return sum;
  }
  Sum sum(int power, const double* weights) const {
    return sum(power, [&](int j) { return weights[j]; });
  }
  /// The highest power k of the time so that t^k dt/dx is no more than this power of x.
  int power_of(int of_x) const { return pace == Pace::even ? of_x : (of_x - 1) / 2; }
};

class PointsAtAPace : public testing::TestWithParam<Pace> {};
INSTANTIATE_TEST_SUITE_P(Paces, PointsAtAPace,
                         testing::Values(Pace::even, Pace::from_onset, Pace::to_release),
                         [](const auto& pace) {
                           return pace.param == Pace::even         ? "Even"
                                  : pace.param == Pace::from_onset ? "FromOnset"
                                                                   : "ToRelease";
                         });

TEST_P(PointsAtAPace, StandAlikeOnBothSidesAndAtBothEnds) {
  const Points p(GetParam());
  EXPECT_EQ(p.x(0), 0);
  EXPECT_EQ(p.x(last_point), 1);
  for (int i = 0; i < collocation_points; ++i) {
    EXPECT_NEAR(p.x(i) + p.x(last_point - i), 1, 2 * eps);
    if (i > 0) {
      EXPECT_GT(p.x(i), p.x(i - 1));
      EXPECT_EQ(p.row(point_shares)[i - 1], p.share(i));
    }
  }
}

/// Between two points a parabola rises above both by interval^2/8 of its second derivative.
TEST_P(PointsAtAPace, BoundAParabolaBesideThem) {
  const Points p(GetParam());
  for (int i = 1; i < collocation_points; ++i) {
    const auto rise = [&](int left) {
      const double middle = 0.5 * (p.x(left) + p.x(left + 1));
      return 0.5 * (middle - p.x(left)) * (p.x(left + 1) - middle);
    };
    const double most = i < last_point ? std::max(rise(i - 1), rise(i)) : rise(i - 1);
    const double interval = std::sqrt(8 * most);  // off by the roundings of two places
    EXPECT_NEAR(p.row(point_sags)[i - 1], most, eps * interval) << i;
  }
}

/// Lobatto's rule is of order 16: exact for x^15 and below, and for no more.
TEST_P(PointsAtAPace, IntegratePowersOfTheTimeExactly) {
  const Points p(GetParam());
  for (int k = 0; k <= p.power_of(15); ++k) {
    const auto [value, size] = p.sum(k, p.row(end_weights));
    EXPECT_NEAR(value, 1.0 / (k + 1), 16 * eps * size) << k;
  }
  const int beyond = p.power_of(15) + 1;
  EXPECT_GT(std::abs(p.sum(beyond, p.row(end_weights)).value - 1.0 / (beyond + 1)), 1e-10);
}

/// A polynomial through nine points is exact up to x^8, and so are its integral to each point and,
/// where the integral is one of x^8, too, the integral of that.
TEST_P(PointsAtAPace, LeadFromTheBeginningToEachPoint) {
  const Points p(GetParam());
  const auto column = [&](int columns, int i) {
    return [=, &p](int j) { return p.row(columns)[j * point_row + i - 1]; };
  };
  for (int i = 1; i < collocation_points; ++i)
    for (int k = 0; k <= p.power_of(8); ++k) {
      const auto [value, size] = p.sum(k, column(velocity_columns, i));
      EXPECT_NEAR(value, std::pow(p.share(i), k + 1) / (k + 1), 16 * eps * (1 + size))
          << i << " " << k;
      if (k + 1 > p.power_of(8)) continue;
      const auto [twice, of] = p.sum(k, column(displacement_columns, i));
      EXPECT_NEAR(twice, std::pow(p.share(i), k + 2) / ((k + 1) * (k + 2)), 16 * eps * (1 + of))
          << i << " " << k;
    }
}

/// The polynomial between the points, and the motion, of which it is the rate.
TEST_P(PointsAtAPace, AreThoseOfOnePolynomial) {
  const Points p(GetParam());
  for (const double x : {0.01, 0.07, 0.47, 0.83, 0.997}) {
    const auto weight = [&](int j) { return p.row(barycentric_weights)[j] / (x - p.x(j)); };
    const double weights = p.sum(0, weight).value;
    for (int k = 0; k <= (p.pace == Pace::even ? 8 : 4); ++k) {
      const auto [value, size] = p.sum(k, weight);
      EXPECT_NEAR(value / weights, std::pow(pace_share(p.pace, x), k),
                  64 * eps * size / std::abs(weights))
          << x << " " << k;
    }
    for (int k = 0; k <= p.power_of(8); ++k) {
      double most = 0;
      const auto motion = [&](int j) {
        double sum = 0;
        for (int m = motion_terms - 1; m >= 0; --m) {
          const double weight = p.row(motion_weights + m * collocation_points)[j];
          most = std::max(most, std::abs(weight));
          sum = sum * x + weight;
        }
        return sum;
      };
      const double value = p.sum(k, motion).value;
      EXPECT_NEAR(value, std::pow(pace_share(p.pace, x), k + 1) / (k + 1), 64 * eps * most)
          << x << " " << k;
    }
  }
}

/// Each row tells one Legendre polynomial from all others; at a pace, of what goes with dt/dx.
TEST_P(PointsAtAPace, TellLegendreCoefficients) {
  const Points p(GetParam());
  const std::array rows{std::pair{legendre_3, 3u}, std::pair{legendre_4, 4u},
                        std::pair{legendre_7, 7u}, std::pair{legendre_8, 8u}};
  for (const auto& [row, degree] : rows)
    for (unsigned k = 0; k <= 8; ++k) {
      double sum = 0;
      for (int j = 0; j < collocation_points; ++j) {
        const double rate = pace_rate(p.pace, p.x(j));
        if (rate > 0) sum += p.row(row)[j] * std::legendre(k, 2 * p.x(j) - 1) / rate;
      }
      // where the time has no rate, that point is missing
      const int missing = p.pace == Pace::from_onset ? 0 : last_point;
      if (p.pace != Pace::even) {
        const Points even(Pace::even);
        sum += even.row(row)[missing] * std::legendre(k, 2 * p.x(missing) - 1);
      }
      EXPECT_NEAR(sum, k == degree ? 1 : 0, 64 * eps) << k << " " << degree;
    }
}

/// A force that grows as t^1.5 from the onset of a contact is a power of x there.
TEST(PointsAtPaces, IntegrateTheForceOfAContactThatBegins) {
  const auto error = [](Pace pace) {
    const Points p(pace);
    double sum = 0;
    for (int j = 0; j < collocation_points; ++j) {
      const double after = pace == Pace::to_release ? 1 - p.share(j) : p.share(j);
      sum += p.row(end_weights)[j] * std::pow(std::max(after, 0.0), 1.5);
    }
    return std::abs(sum - 0.4);
  };
  EXPECT_LT(error(Pace::from_onset), 1e-14);
  EXPECT_LT(error(Pace::to_release), 1e-14);
  EXPECT_GT(error(Pace::even), 1e-6);
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
    const double inside = dice.uniform(from, to);
    const Highest highest = highest_between({f(from), from}, {f(inside), inside}, {f(to), to}, f);
    const double found = highest.value;
    EXPECT_EQ(f(highest.place), found);
    const double exact = std::max({top >= from && top <= to ? 3.0 : -1e300, f(from), f(to)});
    // the place is right to 1e-4 of the interval; an end is no place of it
    EXPECT_LE(found, exact);
    EXPECT_GE(found, exact - (top >= from && top <= to ? 1e-7 : 3e-4));
  }
}

}  // namespace
}  // namespace ra2d::test
