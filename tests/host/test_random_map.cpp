// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/random_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/hash.hpp"
#include "host/surface/gaussian.hpp"
#include "host/surface/random_profile.hpp"
#include "tests/numbers.hpp"

/// Random maps against theory: over many seeds, and each by itself.
namespace ra2d {
namespace {

using testing::HasSubstr;

constexpr double rsm_per_l = std::numbers::sqrt2 * std::numbers::pi;
using test::eps;

/// Dyadic lengths: places of points are exact, also on a finer grid.
constexpr double step = 0x1p-17, step_y = 3 * 0x1p-17;  // m
constexpr double length = 128 * step, width = 48 * step_y;

RandomMap rough(std::uint64_t seed, double rsm = 0x1p-12, double rsm_y = 0x1p-11) {
  return {8e-6, rsm, rsm_y, true, seed};
}

double noise_at(std::uint64_t seed, int i, int j) {
  double value = 0;
  white_noise_row(seed, i, j, {&value, 1});
  return value;
}

TEST(RandomMap, APlacesNoiseIsThatOfEveryRowThatReachesIt) {
  for (const int first : {-5, -4, 0, 3})
    for (const std::size_t count : {1U, 2U, 7U}) {
      std::vector<double> row(count);
      white_noise_row(6, first, -3, row);
      for (std::size_t n = 0; n < count; ++n)
        EXPECT_EQ(row[n], noise_at(6, first + static_cast<int>(n), -3)) << first << ", " << n;
    }
}

TEST(RandomMap, AFinerGridSeesTheSameMap) {
  const HeightMap coarse = random_map(rough(3), length, width, step, step_y);
  const HeightMap fine = random_map(rough(3), length, width, step / 2, step_y / 3);
  ASSERT_EQ(coarse.nx, 129U);
  ASSERT_EQ(coarse.ny, 48U);
  ASSERT_EQ(fine.nx, 257U);
  ASSERT_EQ(fine.ny, 144U);
  std::size_t other = 0;
  for (std::size_t j = 0; j < coarse.ny; ++j)
    for (std::size_t i = 0; i < coarse.nx; ++i)
      other += coarse.at(i, j) != fine.at(2 * i, 3 * j + 1);
  EXPECT_EQ(other, 0U);
}

TEST(RandomMap, APointsBitsAreThoseOfItsPlaceWhateverTheTile) {
  // beyond one tile of 512 by 512 points in both directions, from one grid to another
  RandomMap map = rough(5, 600 * step, 700 * step_y);
  const HeightMap wide = random_map(map, 1200 * step, 600 * step_y, step, step_y);
  const HeightMap thin = random_map(map, 1200 * step, 600 * step_y, 8 * step, 3 * step_y);
  for (std::size_t j = 0; j < thin.ny; ++j)
    for (std::size_t i = 0; i < thin.nx; ++i)
      ASSERT_EQ(thin.at(i, j), wide.at(8 * i, 3 * j + 1)) << i << ", " << j;
}

/// With spacings that are no dyadic numbers the shared points stand up to 3 roundings of x/place
/// apart; a height moves by that times its slope, at most 6 rq/l here (six times the rms slope),
/// and by the roundings of its two sums of 37.
TEST(RandomMap, OnAnyGridTheSameMapButForRoundings) {
  const RandomMap map = rough(7, 0.7e-3, 0.5e-3);
  const double l = map.rsm / rsm_per_l, l_y = map.rsm_y / rsm_per_l;
  const HeightMap coarse = random_map(map, 3e-3, 2.1e-3, 3e-5, 3e-5);
  const HeightMap fine = random_map(map, 3e-3, 2.1e-3, 1e-5, 1e-5);
  const double places = 3 * eps * (3e-3 / l + 2.1e-3 / l_y) * 6 * std::sqrt(2);
  const double bound = map.rq * (places + 6 * 2 * 37 * eps);
  for (std::size_t j = 0; j < coarse.ny; ++j)
    for (std::size_t i = 0; i < coarse.nx; ++i)
      ASSERT_NEAR(coarse.at(i, j), fine.at(3 * i, 3 * j + 1), bound) << i << ", " << j;
}

TEST(RandomMap, TheSumOfBellsByHand) {
  const RandomMap map{1, 0x1p-12, 0x1p-11, false, 11};
  const HeightMap made = random_map(map, length, width, step, step_y);
  const double place = map.rsm / rsm_per_l / 4, place_y = map.rsm_y / rsm_per_l / 4;
  const auto by_hand = [&](std::size_t i, std::size_t j) {
    const double x = static_cast<double>(i) * step / place;
    const double y = (static_cast<double>(j) + 0.5) * step_y / place_y;
    double sum = 0;
    for (int p = -40; p < 200; ++p)
      for (int q = -40; q < 200; ++q) {
        const double away = (x - p) * (x - p) + (y - q) * (y - q);
        if (away < 8 * 50) sum += noise_at(map.seed, p, q) * std::exp(-away / 8);
      }
    return sum / std::sqrt(4 * std::numbers::pi);
  };
  // the same function but for the mean that is taken off: terms of 1, each in error by some eps
  const double mean = by_hand(0, 0) - made.at(0, 0);
  for (const auto& [i, j] : {std::pair{5, 7}, {128, 0}, {0, 47}, {64, 31}, {77, 12}})
    EXPECT_NEAR(made.at(static_cast<std::size_t>(i), static_cast<std::size_t>(j)),
                by_hand(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) - mean,
                1400 * eps);  // 37^2 terms
}

/// Trapezoids along x and middles of strips along y over a fine grid: off by a share
/// (pi step/l)^2/12 or so of the end's part.
TEST(RandomMap, MeanAndRqHoldOverTheArea) {
  for (const double rsm_y : {0x1p-12, 0x1p-9, 1.0}) {
    const RandomMap map = rough(2, 0x1p-11, rsm_y);
    const HeightMap made = random_map(map, length, width, step / 8, step_y / 8);
    double sum = 0, squares = 0, weight = 0;
    for (std::size_t j = 0; j < made.ny; ++j)
      for (std::size_t i = 0; i < made.nx; ++i) {
        const double share = i == 0 || i + 1 == made.nx ? 0.5 : 1.0, z = made.at(i, j) / map.rq;
        sum += share * z;
        squares += share * z * z;
        weight += share;
      }
    EXPECT_NEAR(sum / weight, 0, 1e-4) << rsm_y;
    EXPECT_NEAR(std::sqrt(squares / weight), 1, 1e-4) << rsm_y;
  }
}

TEST(RandomMap, MeanAndRqOfAnAreaOfManyBlocks) {
  // over 2048 places along x and over 256 along y
  const double l = 0x1p-14;
  const RandomMap map = rough(4, l * rsm_per_l, l * rsm_per_l);
  const double along = 600 * l, across = 80 * l;
  const HeightMap made = random_map(map, along, across, l / 4, l / 4);
  double sum = 0, squares = 0, weight = 0;
  for (std::size_t j = 0; j < made.ny; ++j)
    for (std::size_t i = 0; i < made.nx; ++i) {
      const double share = i == 0 || i + 1 == made.nx ? 0.5 : 1.0, z = made.at(i, j) / map.rq;
      sum += share * z;
      squares += share * z * z;
      weight += share;
    }
  // the ends' error, h^2/12 times the slope at the end, about one of 600 l long
  EXPECT_NEAR(sum / weight, 0, 1e-3);
  EXPECT_NEAR(std::sqrt(squares / weight), 1, 1e-3);
}

/// In expectation E[z(0) z(d)] = rq^2 C(d). Over n independent areas of m correlation areas each
/// the mean of products has the deviation sqrt((1 + C^2)/(n m)) or less, here some 0.9 %; five of
/// them are allowed.
TEST(RandomMap, AutocorrelationIsTheGaussianOfBothDirections) {
  const double l = 16 * step, l_y = 8 * step_y;
  const double along = 20 * l, across = 20 * l_y;
  struct Lag {
    std::size_t i, j;
    double sum = 0, count = 0;
  };
  std::vector<Lag> lags{{0, 0}, {8, 0},  {16, 0}, {24, 0}, {0, 4},
                        {0, 8}, {0, 12}, {12, 6}, {64, 0}};
  const int seeds = 200;
  for (int seed = 0; seed < seeds; ++seed) {
    const RandomMap map{1, l * rsm_per_l, l_y * rsm_per_l, false, static_cast<std::uint64_t>(seed)};
    const HeightMap made = random_map(map, along, across, 4 * step, step_y);
    for (Lag& lag : lags) {
      const std::size_t di = lag.i / 4;
      for (std::size_t j = 0; j + lag.j < made.ny; j += 2)
        for (std::size_t i = 0; i + di < made.nx; i += 2) {
          lag.sum += made.at(i, j) * made.at(i + di, j + lag.j);
          lag.count += 1;
        }
    }
  }
  // the area's mean is taken off, of a variance that is a product of both directions' (1/L) int C
  // (1 - |x|/L): exactly
  const auto of_side = [](double n) {  // n = L/l
    return std::sqrt(std::numbers::pi) / n * std::erf(n) + (std::exp(-n * n) - 1) / (n * n);
  };
  const double of_mean = of_side(20) * of_side(20);
  const double areas = seeds * (20 * 20 / std::numbers::pi);
  for (const Lag& lag : lags) {
    const double x = static_cast<double>(lag.i) * step / l,
                 y = static_cast<double>(lag.j) * step_y / l_y;
    const double c = std::exp(-x * x - y * y);
    EXPECT_NEAR(lag.sum / lag.count, c - of_mean, 5 * std::sqrt((1 + c * c) / areas))
        << lag.i << ", " << lag.j;
  }
}

/// Two normal heights of correlation c have different signs with the probability arccos(c)/pi,
/// which between near points is Rice's rsm. 100 elements in each of some 250 independent rows: were
/// they all independent, the share of signs would be off by 1/sqrt(2 * 25 000) of itself, and
/// crossings that repel each other are off by less. Five of that are allowed.
TEST(RandomMap, CrossesItsMeanAsOftenAsItsRsmSays) {
  const double rsm = 0x1p-12, rsm_y = 0x1p-10;
  const RandomMap map{1, rsm, rsm_y, false, 8};
  const HeightMap made = random_map(map, 100 * rsm, 100 * rsm_y, rsm / 16, rsm_y / 16);
  double along = 0, across = 0;
  for (std::size_t j = 0; j < made.ny; ++j)
    for (std::size_t i = 0; i < made.nx; ++i) {
      if (i > 0) along += (made.at(i, j) > 0) != (made.at(i - 1, j) > 0);
      if (j > 0) across += (made.at(i, j) > 0) != (made.at(i, j - 1) > 0);
    }
  const double steps = static_cast<double>(made.nx - 1) * static_cast<double>(made.ny);
  const double steps_y = static_cast<double>(made.nx) * static_cast<double>(made.ny - 1);
  const double share = std::acos(std::exp(-std::pow(rsm_per_l / 16, 2))) / std::numbers::pi;
  EXPECT_NEAR(share, 2.0 / 16, 0.03 / 16);  // two crossings to an element
  const double bound = 5 / std::sqrt(2 * 25000.0) * share;
  EXPECT_NEAR(along / steps, share, bound);
  EXPECT_NEAR(across / steps_y, share, bound);
}

TEST(RandomMap, OfALongWaveAcrossIsConstantInY) {
  // h(y) - h(0) <= y * slope: 6 rq sqrt(2) width/l_y
  const RandomMap map = rough(9, 0x1p-12, 1e9);
  const HeightMap made = random_map(map, length, width, step, step_y);
  const double bound = 6 * std::sqrt(2) * map.rq * width / (1e9 / rsm_per_l) + 100 * eps * map.rq;
  for (std::size_t j = 1; j < made.ny; ++j)
    for (std::size_t i = 0; i < made.nx; ++i) ASSERT_NEAR(made.at(i, j), made.at(i, 0), bound);
}

TEST(RandomMap, OfAnInfiniteWaveAcrossIsTheProfile) {
  RandomMap map = rough(9, 0x1p-12, std::numeric_limits<double>::infinity());
  const HeightMap made = random_map(map, length, width, step, step_y);
  SurfaceSpec profile;
  profile.kind = SurfaceKind::gaussian;
  profile.rq = map.rq;
  profile.rsm = map.rsm;
  profile.seed = map.seed;
  const std::vector<double> row = random_heights(profile, length, 129, step);
  for (std::size_t j = 0; j < made.ny; ++j)
    for (std::size_t i = 0; i < made.nx; ++i) ASSERT_EQ(made.at(i, j), row[i]);
}

TEST(RandomMap, TheSameBitsOnEveryPlatform) {
  const HeightMap made = random_map(rough(1), length, width, step, step_y);
  Hash hash;
  hash.add(
      {reinterpret_cast<const char*>(made.heights.data()), made.heights.size() * sizeof(double)});
  EXPECT_EQ(hash.text(), "750238035f1657508d7ca6b3be30d267");
}

TEST(RandomMap, TwoSeedsAreTwoMapsAndNotTheProfilesNoise) {
  const HeightMap one = random_map(rough(1), length, width, step, step_y);
  const HeightMap two = random_map(rough(2), length, width, step, step_y);
  EXPECT_NE(one.heights, two.heights);
  std::vector<double> all;
  for (int j = -2; j <= 2; ++j) {
    for (int i = -2; i <= 2; ++i) all.push_back(noise_at(1, i, j));
    all.push_back(white_noise(1, j));
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(std::adjacent_find(all.begin(), all.end()), all.end());
}

std::string fault(const RandomMap& map, double l, double w, double d, double d_y) {
  try {
    random_map(map, l, w, d, d_y);
  } catch (const RequestError& error) {
    return error.what();
  }
  return "no error";
}

TEST(RandomMap, RefusesWhatIsNoMap) {
  EXPECT_THAT(fault(rough(1), length, width, 0x1p-13, step_y), HasSubstr("not resolved"));
  EXPECT_THAT(fault(rough(1), length, width, step, 0x1p-12), HasSubstr("rsm_y"));
  EXPECT_THAT(fault(rough(1), length, step_y, step, step_y), HasSubstr("one row is a profile"));
  EXPECT_THAT(fault(rough(1), 1, 1, 1e-5, 1e-5), HasSubstr("expected at most 1e+08"));
  EXPECT_THAT(fault(rough(1, 1), 1e-4, width, 1e-6, step_y), HasSubstr("bent"));
  EXPECT_THAT(fault(rough(1, -1), length, width, step, step_y), HasSubstr("> 0"));
  EXPECT_THAT(fault(rough(1, std::nan("")), length, width, step, step_y), HasSubstr("> 0"));
  EXPECT_THAT(fault(rough(1), length, width, step, std::nan("")), HasSubstr("> 0"));
  EXPECT_THAT(fault(rough(1), 1e300, width, step, step_y), HasSubstr("too short"));
}

TEST(RandomMap, DoubtsSpacingsThatLoseTheSlope) {
  std::vector<std::string> doubts;
  random_map(rough(1), length, width, step, step_y, &doubts);
  EXPECT_TRUE(doubts.empty());
  random_map(rough(1, 5 * step), length, width, step, step_y, &doubts);
  ASSERT_EQ(doubts.size(), 1U);
  EXPECT_THAT(doubts[0], HasSubstr("rsm "));
}

}  // namespace
}  // namespace ra2d
