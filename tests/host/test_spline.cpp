// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/surface/spline.hpp"
#include "tests/numbers.hpp"

namespace ra2d {
namespace {

using test::eps;

template <class F>
std::vector<double> sampled(int count, const F& f) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(f(i));
  return out;
}

/// The spline at a place between nodes i and i + 1.
double between(const std::vector<double>& h, const std::vector<double>& b, int i, double t) {
  return (1 - t) * h[i] + t * h[i + 1] - t * (1 - t) / 6 * ((2 - t) * b[i] + (1 + t) * b[i + 1]);
}

TEST(Spline, OfACubicIsTheCubic) {
  const auto cubic = [](double x) { return 0.01 * x * x * x - 0.3 * x * x + x - 2; };
  for (const int count : {4, 5, 6, 7, 30}) {
    const std::vector<double> h = sampled(count, cubic), b = spline_curvatures(h);
    for (int i = 0; i < count; ++i)
      EXPECT_NEAR(b[i], 0.06 * i - 0.6, 200 * eps * count * count) << count << " nodes, " << i;
    EXPECT_LT(count < 8 ? 0.0 : spline_miss(h), 1e-12);
  }
}

TEST(Spline, OfAParabolaThroughThreeNodesAndALineThroughTwo) {
  const std::vector<double> three = spline_curvatures({1, 4, 9});
  EXPECT_EQ(three, (std::vector<double>{2, 2, 2}));
  EXPECT_EQ(spline_curvatures({1, 4}), (std::vector<double>{0, 0}));
  EXPECT_EQ(spline_curvatures({1}), std::vector<double>{0});
  EXPECT_EQ(spline_curvatures({}), std::vector<double>{});
}

/// Its first and second derivatives go on through each node, its third at the second one.
TEST(Spline, GoesOnThroughItsNodes) {
  const std::vector<double> h{0, 3, -1, 4, 1, -5, 9, 2, -6};
  const std::vector<double> b = spline_curvatures(h);
  for (std::size_t i = 1; i + 1 < h.size(); ++i) {
    const double before = h[i] - h[i - 1] + (b[i - 1] + 2 * b[i]) / 6;
    const double after = h[i + 1] - h[i] - (2 * b[i] + b[i + 1]) / 6;
    EXPECT_NEAR(before, after, 200 * eps) << i;
  }
  EXPECT_NEAR(b[1] - b[0], b[2] - b[1], 200 * eps);
  EXPECT_NEAR(b[8] - b[7], b[7] - b[6], 200 * eps);
}

/// Off by 5/384 of h^4 times the fourth derivative, and a sixteenth of it with half the spacing.
TEST(Spline, OfAWaveIsOffByTheFourthPowerOfTheSpacing) {
  double coarser = 0;
  for (const int per_wave : {16, 32, 64}) {
    const double k = 2 * std::numbers::pi / per_wave;
    const int count = 4 * per_wave + 1;
    const auto wave = [&](double x) { return std::sin(k * x + 0.4); };
    const std::vector<double> h = sampled(count, wave), b = spline_curvatures(h);
    double off = 0;
    double everywhere = 0;
    for (int i = 0; i + 1 < count; ++i)
      everywhere = std::max(everywhere, std::abs(between(h, b, i, 0.5) - wave(i + 0.5)));
    for (int i = per_wave; i < 3 * per_wave; ++i)
      off = std::max(off, std::abs(between(h, b, i, 0.5) - wave(i + 0.5)));
    const double theory = std::pow(k, 4) / 384;  // half way, of a long wave
    EXPECT_NEAR(off, theory, 0.1 * theory);
    if (coarser > 0) {
      EXPECT_NEAR(coarser / off, 16, 2);
    }
    EXPECT_NEAR(spline_miss(h) / 16, everywhere, 0.6 * everywhere);  // most near the ends
    coarser = off;
  }
}

TEST(Spline, MissesASpikeByItsHeight) {
  std::vector<double> h(41, 0.0);
  h[21] = 1e-6;
  EXPECT_EQ(spline_miss(h), 1e-6);
}

}  // namespace
}  // namespace ra2d
