// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/height_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/map_roughness.hpp"
#include "tests/numbers.hpp"

/// Filling, form removal, extension and roughness of maps.
namespace ra2d {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using test::eps;
using test::nan;

template <class Height>
HeightMap map_of(std::size_t nx, std::size_t ny, const Height& height) {
  HeightMap map{nx, ny, 2e-6, 5e-6, {}};
  for (std::size_t j = 0; j < ny; ++j)
    for (std::size_t i = 0; i < nx; ++i)
      map.heights.push_back(height(static_cast<double>(i), static_cast<double>(j)));
  return map;
}

std::string refused(const std::function<void()>& call) {
  try {
    call();
  } catch (const RequestError& error) {
    return error.what();
  }
  return "no error";
}

TEST(HeightMap, SizesThatAreNoMapAreRefused) {
  const auto fault = [](double nx, double ny) {
    return refused([&] { require_map_size("m", nx, ny); });
  };
  EXPECT_EQ(fault(2, 2), "no error");
  EXPECT_THAT(fault(10, 1), HasSubstr("one row is a profile"));
  EXPECT_THAT(fault(1, 10), HasSubstr("at least two rows"));
  EXPECT_THAT(fault(31623, 31623), HasSubstr("expected at most 1e+08"));  // 1e9 points
  EXPECT_THAT(fault(1e300, 1e300), HasSubstr("expected at most"));
  EXPECT_THAT(fault(nan, 5), HasSubstr("at least two rows"));
  // 1 GB of memory: maps of up to 400 MB, 5e7 heights
  const auto fault_in_1_gb = [](double nx, double ny) {
    return refused([&] { require_map_size("m", nx, ny, 1'000'000'000); });
  };
  EXPECT_EQ(fault_in_1_gb(5000, 10000), "no error");
  EXPECT_THAT(fault_in_1_gb(5001, 10000),
              AllOf(HasSubstr("0.4 GB"), HasSubstr("this machine has 1 GB")));
}

TEST(HeightMap, StraightLinesThroughGapsGiveAPlaneBack) {
  const auto plane = [](double i, double j) { return 3 * i - 7 * j + 2; };
  const HeightMap whole = map_of(8, 6, plane);
  HeightMap map = whole;
  for (const std::size_t at : {8 * 2 + 3, 8 * 2 + 4, 8 * 3 + 3, 8 * 4, 6}) map.heights[at] = nan;
  EXPECT_EQ(map.missing(), 5U);
  fill_map_gaps(map, 5e-6, "m");  // two points along x, one along y
  for (std::size_t k = 0; k < map.heights.size(); ++k)
    EXPECT_NEAR(map.heights[k], whole.heights[k], 50 * eps) << k;
}

TEST(HeightMap, FillsFromMeasuredPointsAlone) {
  HeightMap map = map_of(5, 3, [](double i, double j) { return j == 1 ? 10 * i : 1.0; });
  map.heights[5 + 1] = map.heights[5 + 2] = nan;  // 0 _ _ 30 40 between rows of 1
  HeightMap narrow = map;
  fill_map_gaps(narrow, 5e-6, "m");
  EXPECT_EQ(narrow.at(1, 1), 10);  // 4e-6 along x is narrower than 5e-6 along y
  EXPECT_EQ(narrow.at(2, 1), 20);
  map.spacing = 3e-6;
  fill_map_gaps(map, 5e-6, "m");
  EXPECT_EQ(map.at(1, 1), 1);  // now y is
  EXPECT_EQ(map.at(2, 1), 1);
}

TEST(HeightMap, AGapAtAnEdgeIsFilledAlongTheEdgeOrRefused) {
  HeightMap map = map_of(4, 4, [](double i, double j) { return i + j; });
  map.heights[2] = nan;  // in the first row, between points
  fill_map_gaps(map, 1e-5, "m");
  EXPECT_EQ(map.at(2, 0), 2);
  map.heights[0] = nan;  // a corner
  EXPECT_THAT(refused([&] { fill_map_gaps(map, 1e-5, "m"); }),
              AllOf(HasSubstr("m: row 1, point 1"), HasSubstr("edges")));
  map.heights[0] = 0;
  map.heights[5] = map.heights[6] = map.heights[9] = map.heights[10] = nan;
  EXPECT_THAT(refused([&] { fill_map_gaps(map, 3.9e-6, "m"); }),
              AllOf(HasSubstr("4e-06 m wide"), HasSubstr("3.9e-06")));
  EXPECT_THAT(refused([&] { fill_map_gaps(map, 0, "m"); }),
              AllOf(HasSubstr("row 2, point 2"), HasSubstr("--fill linear:WIDTH")));
  fill_map_gaps(map, 4e-6, "m");
  EXPECT_EQ(map.missing(), 0U);
}

TEST(HeightMap, APolynomialOfTheDegreeIsTakenOffWhole) {
  for (const int degree : {0, 1, 2, 5}) {
    HeightMap map = map_of(40, 23, [&](double i, double j) {
      const double x = i / 20 - 1, y = j / 11 - 1;
      double z = 0;
      for (int a = 0; a <= degree; ++a)
        for (int b = 0; a + b <= degree; ++b)
          z += (1 + a - 2 * b) * std::pow(x, a) * std::pow(y, b);
      return z;
    });
    double most = 0;
    for (const double z : map.heights) most = std::max(most, std::abs(z));
    HeightMap less = map;
    remove_map_form(map, {degree});
    // products of 40 + 23 points for each of at most 21 terms
    for (const double z : map.heights) ASSERT_NEAR(z, 0, 63 * 21 * eps * most) << degree;
    if (degree == 0) continue;
    remove_map_form(less, {degree - 1});
    double left = 0;
    for (const double z : less.heights) left = std::max(left, std::abs(z));
    EXPECT_GT(left, 0.05) << degree;  // and of one less it is not
  }
}

TEST(HeightMap, WhatIsLeftIsOrthogonalToEveryTermOfTheForm) {
  HeightMap map =
      map_of(31, 17, [](double i, double j) { return std::sin(i * 0.7 + j * j * 0.3); });
  remove_map_form(map, {3});
  for (int a = 0; a <= 3; ++a)
    for (int b = 0; a + b <= 3; ++b) {
      double product = 0;
      for (std::size_t j = 0; j < 17; ++j)
        for (std::size_t i = 0; i < 31; ++i)
          product += map.at(i, j) * std::pow(static_cast<double>(i) / 15 - 1, a) *
                     std::pow(static_cast<double>(j) / 8 - 1, b);
      EXPECT_NEAR(product, 0, 31 * 17 * 50 * eps) << a << ", " << b;
    }
}

TEST(HeightMap, WordsForForms) {
  EXPECT_EQ(understand_map_form("none")->degree, -1);
  EXPECT_EQ(understand_map_form("mean")->degree, 0);
  EXPECT_EQ(understand_map_form("plane")->degree, 1);
  EXPECT_EQ(understand_map_form("poly:10")->degree, 10);
  for (const char* wrong : {"poly:11", "poly:-1", "poly:", "poly:2x", "line", ""})
    EXPECT_FALSE(understand_map_form(wrong)) << wrong;
}

TEST(HeightMap, AMirroredMapGoesBackAndForth) {
  const HeightMap map = map_of(4, 3, [](double i, double j) { return 10 * j + i; });
  const HeightMap made = extended_map(map, MapExtension::mirror, 11, 8, "m");
  const std::vector<double> x{0, 1, 2, 3, 2, 1, 0, 1, 2, 3, 2}, y{0, 1, 2, 1, 0, 1, 2, 1};
  ASSERT_EQ(made.nx, 11U);
  ASSERT_EQ(made.ny, 8U);
  for (std::size_t j = 0; j < 8; ++j)
    for (std::size_t i = 0; i < 11; ++i)
      EXPECT_EQ(made.at(i, j), 10 * y[j] + x[i]) << i << ", " << j;
  EXPECT_THAT(refused([&] { extended_map(map, MapExtension::mirror, 40000, 40000, "m"); }),
              HasSubstr("expected at most"));
}

/// Along each direction the seams are those of a repeated profile: of a map of steps apart, a tenth
/// of it, in which cosine and sine weigh the mirrored ends.
TEST(HeightMap, ARepeatedMapFadesFromCopyToCopy) {
  const auto wave = [](double i, double j) { return std::sin(0.3 * i) + 0.5 * j; };
  const HeightMap map = map_of(41, 31, wave);
  const HeightMap made = extended_map(map, MapExtension::repeat, 100, 80, "m");
  for (std::size_t j = 0; j < 31; ++j)
    for (std::size_t i = 0; i < 41; ++i) ASSERT_EQ(made.at(i, j), map.at(i, j));
  // a seam of 4 steps along x, of 3 along y: the second copy begins there
  for (std::size_t j = 0; j < 31; ++j)
    for (std::size_t i = 0; i < 41; ++i) ASSERT_EQ(made.at(i + 44, j + 33), map.at(i, j));
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(made.at(42, 5), half * (wave(38, 5) + wave(2, 5)), 8 * eps);
  EXPECT_NEAR(made.at(7, 31), std::cos(std::numbers::pi / 6) * wave(7, 29) + 0.5 * wave(7, 2),
              40 * eps);
}

TEST(MapRoughness, OfAWaveInBothDirections) {
  // whole waves: 20 points along x, 10 rows along y
  const double a = 3e-6;
  const HeightMap map = map_of(400, 200, [&](double i, double j) {
    return a * std::sin(2 * std::numbers::pi * (i + 0.25) / 20) *
           std::cos(2 * std::numbers::pi * (j + 0.25) / 10);
  });
  const MapRoughness r = map_roughness(map);
  EXPECT_NEAR(r.sq, a / 2, 1e-12 * a);
  EXPECT_NEAR(r.ssk, 0, 1e-12);
  EXPECT_NEAR(r.sku, 9.0 / 4, 1e-12);  // (3/8)^2/(1/4)^2
  EXPECT_NEAR(r.rsm, 20 * 2e-6, 1e-12);
  EXPECT_NEAR(r.rsm_y, 10 * 5e-6, 1e-12);
}

TEST(MapRoughness, OfAFlatMapIsNotDefined) {
  const MapRoughness r = map_roughness(map_of(5, 4, [](double, double) { return 2.5; }));
  EXPECT_EQ(r.sq, 0);
  for (const double value : {r.ssk, r.sku, r.rsm, r.rsm_y}) EXPECT_TRUE(std::isnan(value));
}

TEST(HeightMap, IsPreparedToMeanZeroAndTiltIsDoubted) {
  HeightMap map =
      map_of(30, 20, [](double i, double j) { return 1e-6 * i + 1e-7 * std::sin(i * j); });
  HeightMap level = map;
  std::vector<std::string> doubts;
  prepare_map(map, {}, "m", &doubts);
  ASSERT_EQ(doubts.size(), 1U);
  EXPECT_THAT(doubts[0], HasSubstr("try --form plane"));
  double sum = 0;
  for (const double z : map.heights) sum += z;
  EXPECT_NEAR(sum, 0, 600 * eps * 3e-5);
  doubts.clear();
  prepare_map(level, {0, {1}}, "m", &doubts);
  EXPECT_TRUE(doubts.empty());
}

}  // namespace
}  // namespace ra2d
