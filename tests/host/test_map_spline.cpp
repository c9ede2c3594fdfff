// SPDX-License-Identifier: BSD-3-Clause
// Heights between the points of a map.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

#include "host/surface/map_spline.hpp"
#include "host/surface/random_map.hpp"
#include "tests/numbers.hpp"

namespace ra2d {
namespace {

using test::eps;

HeightMap map_of(std::size_t nx, std::size_t ny, const std::function<double(double, double)>& f) {
  HeightMap map{nx, ny, 1e-5, 2e-5, {}};
  for (std::size_t j = 0; j < ny; ++j)
    for (std::size_t i = 0; i < nx; ++i)
      map.heights.push_back(f(static_cast<double>(i), static_cast<double>(j)));
  return map;
}
double odd_height(double x, double y) { return std::sin(1.7 * x + 0.3 * x * y + 2.9 * y); }

TEST(MapSpline, HasTheBitsOfThePoints) {
  const HeightMap map = map_of(30, 100, odd_height);
  const HeightMap part = map_on_spline(map, {3, 2, 5}, {71, 3, 7});
  ASSERT_EQ(part.nx, 5);
  ASSERT_EQ(part.ny, 7);
  EXPECT_DOUBLE_EQ(part.spacing, 2e-5);
  EXPECT_DOUBLE_EQ(part.spacing_y, 6e-5);
  for (std::size_t j = 0; j < 7; ++j)
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(part.at(i, j), map.at(3 + 2 * i, 71 + 3 * j));
}

TEST(MapSpline, OfACubicIsTheCubic) {
  const auto cubic = [](double x, double y) {
    return 0.01 * x * x * x - 0.02 * x * x * y + 0.03 * x * y * y * y - 0.4 * y * y + x - 2 * y;
  };
  const PlacesOnLine x{0.3, 0.37, 20}, y{0, 0.55, 15};
  const HeightMap made = map_on_spline(map_of(9, 10, cubic), x, y);
  for (std::size_t j = 0; j < y.count; ++j)
    for (std::size_t i = 0; i < x.count; ++i)
      EXPECT_NEAR(made.at(i, j), cubic(x[i], y[j]), 200 * eps * cubic(8, 9)) << i << ' ' << j;
}

/// Straight for half a distance, then level; along both directions.
TEST(MapSpline, GoesOnStraightAndThenLevel) {
  const HeightMap map = map_of(6, 7, [](double x, double y) { return x * x - y * y * y; });
  const PlacesOnLine x{-1, 0.25, 30}, y{-1, 0.25, 34};
  const HeightMap made = map_on_spline(map, x, y);
  const auto along = [](double at, double last, double slope) {
    return slope * (std::clamp(at, -0.5, last + 0.5) - last);
  };
  for (std::size_t j = 0; j < y.count; ++j)
    for (std::size_t i = 0; i < x.count; ++i) {
      const double of_x = x[i] < 0 ? 0 : x[i] > 5 ? 25 + along(x[i], 5, 10) : x[i] * x[i];
      const double of_y = y[j] < 0 ? 0 : y[j] > 6 ? 216 + along(y[j], 6, 108) : y[j] * y[j] * y[j];
      EXPECT_NEAR(made.at(i, j), of_x - of_y, 200 * eps * 300) << x[i] << ' ' << y[j];
    }
}

/// Rows that are further away than a spline reaches are not needed.
TEST(MapSpline, OfAPartIsThatOfTheWhole) {
  const HeightMap map = map_of(12, 400, odd_height);
  const PlacesOnLine x{0.2, 0.7, 15};
  const HeightMap all = map_on_spline(map, x, {0.4, 1, 398}),
                  part = map_on_spline(map, x, {200.4, 1, 20});
  for (std::size_t j = 0; j < part.ny; ++j)
    for (std::size_t i = 0; i < part.nx; ++i)
      EXPECT_NEAR(part.at(i, j), all.at(i, j + 200), 600 * eps);  // places up to 400
}

/// A random map stored with fewer points comes back. Its error falls with the fourth power of their
/// distance; so does what the spline through every other point misses, which is some sixteen times
/// as large.
TEST(MapSpline, ReturnsARandomMapThatIsStoredCoarsely) {
  const RandomMap random{1e-6, 8e-4, 8e-4, false, 6};
  const double side = 4e-3, l = 8e-4 / (std::sqrt(2.0) * M_PI);
  const auto map = [&](double spacing) { return random_map(random, side, side, spacing, spacing); };
  const auto error = [&](double spacing) {
    const HeightMap coarse = map(spacing), fine = map(spacing / 3);
    // rows are the middles of strips: each stored one is the second of three
    const PlacesOnLine x{0, 1.0 / 3, 3 * coarse.nx - 2}, y{0, 1.0 / 3, 3 * coarse.ny - 2};
    const HeightMap made = map_on_spline(coarse, x, y);
    double squares = 0;
    int count = 0;
    const std::size_t ends = 30;  // where splines are less accurate
    for (std::size_t j = ends; j + ends < y.count; ++j)
      for (std::size_t i = ends; i + ends < x.count; ++i, ++count)
        squares += std::pow(made.at(i, j) - fine.at(i, j + 1), 2);
    return std::sqrt(squares / count);
  };
  const double at_20 = error(2e-5), at_10 = error(1e-5);
  EXPECT_NEAR(std::log2(at_20 / at_10), 4, 0.1);
  // Far from its ends a spline is off by h^4 f'''' t^2 (1 - t)^2/24: by nothing at t = 0, and by
  // h^4 f''''/486 in both thirds. In units of rq/l^4 the mean square of both fourth derivatives is
  // 8!/4! = 1680, and that of their product (4!/2!)^2 = 144. One map differs from the mean.
  const double mean_square = 2 * 2 / 3.0 * 1680 + 2 * 4 / 9.0 * 144;
  EXPECT_NEAR(at_10 / (1e-6 * std::pow(1e-5 / l, 4) * std::sqrt(mean_square) / 486), 1, 0.2);
  // 16, but as the ends go, where splines miss most, of points that are twice as many, 16 sqrt(2)
  const double ratio = map_spline_miss(map(1e-5)) / map_spline_miss(map(5e-6));
  EXPECT_GT(ratio, 15.5);
  EXPECT_LT(ratio, 23.1);
}

}  // namespace
}  // namespace ra2d
