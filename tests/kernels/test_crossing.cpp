// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "kernels/adaptive/crossing.hpp"
#include "kernels/lanes.hpp"
#include "tests/dice.hpp"

namespace {

using namespace ra2d;
using test::Dice;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;  // one rounding
constexpr int highest_degree = overlap_terms - 1;
using Coefficients = std::vector<double>;

const HostLanes lanes;

int degree(const Coefficients& c) { return static_cast<int>(c.size()) - 1; }

/// The d-th derivative, in long double.
long double exactly(const Coefficients& c, long double x, int d = 0) {
  long double value = 0;
  for (int j = degree(c); j >= d; --j) {
    long double term = c[j];
    for (int i = 0; i < d; ++i) term *= j - i;
    value = value * x + term;
  }
  return value;
}
/// sum |c_j| x^j of the d-th derivative: what roundings are relative to, and a bound.
double size(const Coefficients& c, double x, int d = 0) {
  Coefficients positive(c);
  for (double& each : positive) each = std::abs(each);
  return static_cast<double>(exactly(positive, x, d));
}
/// Horner in fused multiply-adds, over even and odd powers apart: no term goes through more
/// roundings than there are terms.
double rounding(const Coefficients& c, double x) { return (degree(c) + 1) * u * size(c, x); }

Coefficients times(const Coefficients& a, const Coefficients& b) {
  Coefficients c(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) c[i + j] += a[i] * b[j];
  return c;
}
Coefficients random_polynomial(Dice& dice, int n) {
  Coefficients c(n + 1);
  const double fall = dice.ratio(0.1, 1.5);  // of a series that converges, or hardly
  for (int j = 0; j <= n; ++j) c[j] = dice.uniform(-1, 1) * std::pow(fall, j);
  return c;
}

// ---- values -----------------------------------------------------------------------------------

TEST(Polynomial, EachTermIsAPower) {
  for (int j = 0; j <= 5; ++j) {
    Coefficients c(6, 0.0);
    c[j] = 3;
    for (const double x : {0.0, 0.5, 2.0, -1.0}) {  // whose powers are exact
      EXPECT_EQ(polynomial(c.data(), 5, x), 3 * std::pow(x, j));
      const ValueAndSlope p = polynomial_and_slope(c.data(), 5, x);
      EXPECT_EQ(p.value, 3 * std::pow(x, j));
      EXPECT_EQ(p.slope, j == 0 ? 0.0 : 3 * j * std::pow(x, j - 1));
    }
  }
}

TEST(Polynomial, AgreesWithLongDouble) {
  Dice dice(1);
  for (int trial = 0; trial < 5000; ++trial) {
    const int n = dice.pick(highest_degree + 1);
    const Coefficients c = random_polynomial(dice, n);
    const double x = dice.uniform(-1.5, 1.5), ax = std::abs(x);
    const ValueAndSlope p = polynomial_and_slope(c.data(), n, x);
    ASSERT_EQ(polynomial(c.data(), n, x), p.value);
    ASSERT_NEAR(p.value, static_cast<double>(exactly(c, x)), rounding(c, ax));
    // a term of the slope is a sum of up to n values, each with as many roundings again
    ASSERT_NEAR(p.slope, static_cast<double>(exactly(c, x, 1)), 2 * (n + 1) * u * size(c, ax, 1));
  }
}

// ---- the first crossing -----------------------------------------------------------------------

constexpr double none = std::numeric_limits<double>::infinity();

/// The first crossing of `level` from below (sign 1) or of -level from above (-1).
double first(const Coefficients& c, double level, double noise, double end, double sign = 1.0) {
  const double x = first_crossing(c.data(), degree(c), sign, level, noise, end, size(c, end, 2));
  return x <= end ? x : none;
}

TEST(FirstCrossing, OfALine) {
  EXPECT_EQ(first({-3, 4}, 0, 0, 1), 0.75);
  EXPECT_EQ(first({-3, 4}, 1, 0, 1), 1.0);  // at the very end
  EXPECT_EQ(first({-3, 4}, 1, 0, 0.999), none);
  EXPECT_EQ(first({-3, -4}, 1, 0, 1e6), none);
  EXPECT_EQ(first({3, -4}, 1, 0, 2, -1), 1.0);
  EXPECT_EQ(first({3, 4}, 1, 0, 2, -1), none);
}

TEST(FirstCrossing, NowhereOnAConstant) {
  EXPECT_EQ(first({-1}, 0, 0, 1), none);
  EXPECT_EQ(first({-1, 0, 0}, 0, 0.5, 1), none);
}

TEST(FirstCrossing, AtTheBeginning) {
  EXPECT_EQ(first({0, -1}, 0, 0, 1), 0.0);
  EXPECT_EQ(first({-1e-9, -1}, 0, 1e-9, 1), 0.0);  // within the noise
  EXPECT_EQ(first({5, -1}, 0, 0, 1), 0.0);         // above from the start
  EXPECT_EQ(first({-1e-9, -1, 0.5}, 0, 1e-10, 1), none);
}

TEST(FirstCrossing, AnArcThatGrazes) {
  // 1 - (x - 1/2)^2, times a height
  for (const double height : {1.0, 1e-6, 1e9}) {
    const Coefficients arc{height * 0.75, height, -height};
    for (const double miss : {1e-3, 1e-6, 1e-9, 1e-12}) {
      SCOPED_TRACE(miss);
      const double noise = 0.25 * miss * height;
      EXPECT_EQ(first(arc, height * (1 + miss), noise, 1), none);
      // between where it comes to within the noise, 1 - d^2 = 1 - 3/4 miss, and where it crosses; a
      // value is wrong by 4 u height, its place by as much over the slope 2 d
      const double x = first(arc, height * (1 - 0.5 * miss), noise, 1), d = std::sqrt(miss);
      EXPECT_GE(x, 0.5 - std::sqrt(0.75) * d - 4 * u / d);
      EXPECT_LE(x, 0.5 - std::sqrt(0.5) * d + 4 * u / d);
    }
    const double top = first(arc, height, 1e-12 * height, 1);
    EXPECT_NEAR(top, 0.5, 1.01e-6);  // 1 - d^2 > 1 - 1e-12
  }
}

TEST(FirstCrossing, OfManyRootsTheFirst) {
  // Chebyshev's polynomials, from before their last root backwards: T_n(cos a) = cos(n a)
  Coefficients before{1}, now{0, 1};
  for (int n = 2; n <= 16; ++n) {
    Coefficients next = times({0, 2}, now);
    for (std::size_t j = 0; j < before.size(); ++j) next[j] -= before[j];
    before = std::exchange(now, next);
    for (const double level : {0.3, -0.3, 0.99}) {
      // the smallest x >= 0 with T_n(x) = level, if T_n(0) is below it
      if (polynomial(now.data(), n, 0.0) >= level) continue;
      double expected = none;
      for (int k = -n; k <= n; ++k)
        for (const double a : {std::acos(level), -std::acos(level)}) {
          const double x = std::cos((a + 2 * std::numbers::pi * k) / n);
          if (x >= 0) expected = std::min(expected, x);
        }
      const double noise = rounding(now, 1.0), slope = n * std::sqrt(1 - level * level);
      const double x = first(now, level, noise, 1);
      // it stops within noise, which is a bound on roundings, of the level
      EXPECT_NEAR(x, expected, 4 * noise / slope + 4 * u) << "T_" << n << ", level " << level;
    }
  }
}

TEST(FirstCrossing, StepsOverNothing) {
  // with roots that are known, alone, in pairs a hair apart, and double
  Dice dice(2);
  int found = 0, beyond = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    Coefficients c{dice.one_in(2) ? 1.0 : -1.0};
    const int roots = 1 + dice.pick(6);
    for (int i = 0; i < roots; ++i) {
      const double r = dice.uniform(-0.5, 1.5);
      c = times(c, {-r, 1});
      if (dice.one_in(3)) c = times(c, {-r - dice.ratio(1e-9, 1e-2) * dice.pick(2), 1});
    }
    const double end = dice.uniform(0.3, 1.2), sign = dice.one_in(2) ? 1 : -1;
    const double noise = rounding(c, end), level = dice.pick(2) * dice.uniform(-1e-3, 1e-3);
    const double x = first(c, level, noise, end, sign);
    const auto above = [&](double at) {  // by more than roundings can hide
      return static_cast<double>(sign * exactly(c, at)) - level;
    };
    const double until = std::min(x, end);
    constexpr int points = 300;
    for (int i = 0; i < points; ++i) {
      const double at = until * i / points;
      ASSERT_LE(above(at), at == x ? none : 0.0)
          << "at " << at << " of " << x << ", trial " << trial;
    }
    if (x <= end) {
      ASSERT_GE(above(x), -2 * noise) << "trial " << trial;
      ++found;
    } else {
      ASSERT_LE(above(end), 0.0);
      ++beyond;
    }
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(beyond, 300);
}

TEST(FirstCrossing, FindsATouchThatAGridWouldMiss) {
  // a bump a millionth wide and high above what is around it: (x - a)^2 = 1e-12 at its sides
  Dice dice(3);
  for (int trial = 0; trial < 200; ++trial) {
    const double a = dice.uniform(0.1, 0.9), half = dice.ratio(1e-7, 1e-5);
    // half^2 - (x - a)^2, times something that stays positive
    Coefficients c = times({half * half - a * a, 2 * a, -1},
                           {dice.uniform(1, 2), dice.uniform(-0.5, 0.5), dice.uniform(0, 0.5)});
    const double noise = rounding(c, 1.0);
    if (noise > 0.1 * half * half) continue;
    const double x = first(c, 0, noise, 1);
    // the coefficients are rounded, too
    EXPECT_NEAR(x, a - half, 8 * noise / half);
  }
}

// ---- the highest value ------------------------------------------------------------------------

TEST(HighestValue, OfALineAndAConstant) {
  const double up[] = {1, 2}, down[] = {1, -2};
  EXPECT_EQ(highest_value(up, 1, 3.0), 7.0);
  EXPECT_EQ(highest_value(down, 1, 3.0), 1.0);
  EXPECT_EQ(highest_value(up, 0, 3.0), 1.0);
}

TEST(HighestValue, IsTheTopWhereverItIs) {
  Dice dice(4);
  for (int trial = 0; trial < 4000; ++trial) {
    const double end = dice.ratio(1e-3, 1e3), height = dice.ratio(1e-9, 1e3);
    const double top = end * (dice.one_in(8) ? dice.pick(4) / 3.0 : dice.uniform(-0.2, 1.2));
    // height (1 - a y^2 - b y^3 - c y^4), y = (x - top)/end: the slope changes its sign at the top
    // alone
    const double a = dice.ratio(1e-3, 10), b = 0.3 * a * dice.uniform(-1, 1),
                 c = a * dice.uniform(0, 1);
    const double r = top / end;
    Coefficients p = times({-r, 1}, {-r, 1});
    p = times(p, times({a - b * r + c * r * r, b - 2 * c * r, c}, {1}));
    for (double& each : p) each *= -height;
    p[0] += height;
    for (int j = 0; j <= 4; ++j) p[j] /= std::pow(end, j);
    const double found = highest_value(p.data(), 4, end);
    const double best = std::clamp(top, 0.0, end);
    // the search leaves slope^2/(2 curvature) of 1e-16, or eight times that where the ends of the
    // bracket have been halved three times
    ASSERT_NEAR(found, static_cast<double>(exactly(p, best)), 4 * rounding(p, end) + 1e-15 * height)
        << trial << ": top at " << r << " of the end";
  }
}

TEST(HighestValue, OfTwoTopsTheHigher) {
  // tops at 1/6 and 5/6, a hollow between them: in three thirds
  for (const double tilt : {-0.05, 0.05}) {
    Coefficients p{0, tilt};
    const Coefficients y{-0.5, 1}, square = times(y, y), quartic = times(square, square);
    p.resize(5, 0.0);
    for (int j = 0; j <= 4; ++j) p[j] -= 9 * quartic[j];
    for (int j = 0; j <= 2; ++j) p[j] += 2 * square[j];
    double highest = -none;
    for (int i = 0; i <= 100000; ++i)
      highest = std::max(highest, static_cast<double>(exactly(p, i * 1e-5L)));
    // a grid point is 5e-6 from the top at most, |p''| < 14 there
    EXPECT_NEAR(highest_value(p.data(), 4, 1.0), highest, 0.5 * 14 * 25e-12);
    EXPECT_GE(highest_value(p.data(), 4, 1.0), highest - rounding(p, 1.0));
  }
}

// ---- hulls ------------------------------------------------------------------------------------

/// C(i, j)/C(n, j) and the two masks, as SeriesTables::hull has them.
std::vector<double> hull_table(int n) {
  std::vector<double> table((overlap_terms + 2) * overlap_terms, 0.0);
  const auto choose = [](int a, int b) {
    long double product = 1;
    for (int i = 0; i < b; ++i) product = product * (a - i) / (i + 1);
    return product;
  };
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i < overlap_terms; ++i)
      table[j * overlap_terms + i] = static_cast<double>(choose(std::min(i, n), j) / choose(n, j));
  for (int i = 0; i < overlap_terms; ++i) {
    table[overlap_terms * overlap_terms + i] = i < n;
    table[(overlap_terms + 1) * overlap_terms + i] = i < n - 1;
  }
  return table;
}

Hull hull(const Coefficients& c, double x) {
  const std::vector<double> table = hull_table(degree(c));
  // what a longer series left behind must not count
  std::vector<double> room(2 * overlap_terms, 1e30);
  return hull_of(lanes, table.data(), c.data(), degree(c), x, room.data());
}

TEST(HullOf, OfALineAndAParabola) {
  const Hull line = hull({1, -2, 0, 0, 0, 0, 0, 0}, 0.5);
  // coefficients 1 - i/7, their roundings times the degree
  EXPECT_EQ(line.most, 1);
  EXPECT_NEAR(line.least, 0, 2 * u);
  EXPECT_NEAR(line.falling, -2, 4 * 7 * 2 * u);
  EXPECT_NEAR(line.rising, -2, 4 * 7 * 2 * u);
  EXPECT_NEAR(line.curvature, 0, 42 / 0.25 * 8 * u);
  const Hull arc = hull({0, 0, 3, 0, 0, 0, 0, 0}, 2);
  EXPECT_EQ(arc.least, 0);
  EXPECT_NEAR(arc.most, 12, 12 * 4 * u);
  EXPECT_NEAR(arc.falling, 0, 7 / 2.0 * 12 * 8 * u);
  EXPECT_NEAR(arc.rising, 12, 7 / 2.0 * 12 * 8 * u);
  EXPECT_NEAR(arc.curvature, 6, 42 / 4.0 * 12 * 16 * u);
}

TEST(HullOf, IsExactForBernsteinsOwn) {
  // B_k = C(n, k) y^k (1 - y)^(n - k), y = x/2, has the coefficients 0, ..., 1, ..., 0
  for (const int n : {4, 11, 15})
    for (int k = 0; k <= n; ++k) {
      Coefficients c{1};
      double choose = 1;
      for (int i = 0; i < k; ++i) choose = choose * (n - i) / (i + 1);
      for (int i = 0; i < n; ++i)
        c = times(c, i < k ? Coefficients{0, 0.5} : Coefficients{1, -0.5});
      for (double& each : c) each *= choose;
      // sums of up to n terms as large as size()
      const double off = 4 * (n + 1) * u * size(c, 2.0), second = k == 0 || k == n ? 1 : 2;
      const Hull h = hull(c, 2.0);
      EXPECT_NEAR(h.least, 0, off);
      EXPECT_NEAR(h.most, 1, off);
      EXPECT_NEAR(h.rising, k == 0 ? 0.0 : n / 2.0, n / 2.0 * 2 * off);
      EXPECT_NEAR(h.falling, k == n ? 0.0 : -n / 2.0, n / 2.0 * 2 * off);
      EXPECT_NEAR(h.curvature, n * (n - 1) / 4.0 * second, n * (n - 1) / 4.0 * 4 * off);
    }
}

TEST(HullOf, Holds) {
  Dice dice(5);
  double loosest = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const int n = 2 + dice.pick(highest_degree - 1);
    const Coefficients c = random_polynomial(dice, n);
    const double x = dice.ratio(1e-3, 2.0);
    const Hull h = hull(c, x);
    const double off = 4 * (n + 1) * u * size(c, x);
    double least = none, most = -none, falling = none, rising = -none, curve = 0;
    for (int i = 0; i <= 200; ++i) {
      const long double at = static_cast<long double>(x) * i / 200;
      least = std::min(least, static_cast<double>(exactly(c, at)));
      most = std::max(most, static_cast<double>(exactly(c, at)));
      falling = std::min(falling, static_cast<double>(exactly(c, at, 1)));
      rising = std::max(rising, static_cast<double>(exactly(c, at, 1)));
      curve = std::max(curve, static_cast<double>(std::abs(exactly(c, at, 2))));
    }
    ASSERT_LE(h.least, least + off);
    ASSERT_GE(h.most, most - off);
    ASSERT_LE(h.falling, falling + 2 * off * n / x);
    ASSERT_GE(h.rising, rising - 2 * off * n / x);
    ASSERT_GE(h.curvature, curve - 4 * off * n * n / (x * x));
    // and says something: no looser than the sums of sizes would be
    ASSERT_LE(h.most, size(c, x) + off);
    ASSERT_LE(h.rising, size(c, x, 1) + 2 * off * n / x);
    loosest = std::max(loosest, (h.most - h.least) / (most - least));
  }
  EXPECT_GT(loosest, 1.0);
}

}  // namespace
