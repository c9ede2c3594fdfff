// SPDX-License-Identifier: BSD-3-Clause
// Roughness parameters, form and filter against closed forms. Where a profile is sampled at n
// points a period, a tolerance of its sums is that of the rectangle rule: what is said at each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/form.hpp"
#include "host/surface/profile_filter.hpp"
#include "host/surface/roughness.hpp"
#include "tests/numbers.hpp"

namespace {

using namespace ra2d;

using test::eps;
using test::pi;

/// `periods` periods of a wave of amplitude 1, `points` points each, which lie half a step off.
template <class Wave>
std::vector<double> sampled(std::size_t periods, std::size_t points, const Wave& wave) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < periods * points; ++i)
    heights.push_back(wave((static_cast<double>(i % points) + 0.5) / static_cast<double>(points)));
  return heights;
}
double sine_wave(double x) { return std::sin(2 * pi * x); }
double square(double x) { return x < 0.5 ? 1 : -1; }
double triangle(double x) { return x < 0.5 ? 4 * x - 1 : 3 - 4 * x; }
double sawtooth(double x) { return 2 * x - 1; }

std::vector<double> random_profile(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  std::vector<double> heights(count);
  double slow = 0, fast = 0, sum = 0;
  for (double& z : heights) {
    const double u = static_cast<double>(bits() >> 11) * 0x1p-53 - 0.5;
    fast = 0.7 * fast + u;
    slow = 0.95 * slow + u;
    z = fast + 0.3 * slow - 0.1 * fast * fast;
    sum += z;
  }
  for (double& z : heights) z -= sum / static_cast<double>(count);
  return heights;
}

// ---- closed forms: 25 periods in 5 sampling lengths, steps of 1/1000 period

TEST(RoughnessOf, ASine) {
  const auto z = sampled(25, 1000, sine_wave);
  const double step = 1e-3;
  const Roughness r = roughness(z, step, 5);
  // Powers of a sine are trigonometric polynomials, which the sum gets exactly; |sin| has a kink at
  // a zero between two points: relative error (pi/1000)^2/6.
  EXPECT_NEAR(r.ra, 2 / pi, 2 / pi * 1.7e-6);
  EXPECT_NEAR(r.rq, std::sqrt(0.5), 20 * eps);
  EXPECT_NEAR(r.rsk, 0, 20 * eps);
  EXPECT_NEAR(r.rku, 1.5, 50 * eps);
  const double peak = std::cos(pi / 1000);  // the points next to it
  EXPECT_NEAR(r.rp, peak, 4 * eps);
  EXPECT_NEAR(r.rv, peak, 4 * eps);
  EXPECT_NEAR(r.rz, 2 * peak, 8 * eps);
  EXPECT_NEAR(r.rt, 2 * peak, 8 * eps);
  EXPECT_NEAR(r.rsm, 1, 1e-12);
  // Six neighbours: relative error of a slope (2 pi/1000)^6/140 inside, (2 pi/1000)^6/7 at six
  // points.
  EXPECT_NEAR(r.rdq, 2 * pi * std::sqrt(0.5), 2e-14 / step);
  // The material ratio curve is cos(pi p), its flattest 40 % are the first. Least squares of it
  // over 0 ... w: with s = sin(pi w), c = cos(pi w), its mean is s/(pi w) and its slope 12/w^3 int
  // (x - w/2) cos(pi x) dx = 12/w^3 (w s/(2 pi) + (c - 1)/pi^2).
  const double w = 0.4, s = std::sin(pi * w), c = std::cos(pi * w);
  const double slope = 12 / (w * w * w) * (w * s / (2 * pi) + (c - 1) / (pi * pi));
  const double top = s / (pi * w) - slope * w / 2, bottom = top + slope;
  const double p1 = std::acos(std::min(1.0, top)) / pi, p2 = std::acos(bottom) / pi;
  EXPECT_GT(top, 1);  // no height is there: no peaks
  EXPECT_EQ(p1, 0);
  // The points are 50 equal heights each: the 40 % end within a step of 1/500 of the curve, and the
  // slope changes with their ends by (pi w)^2/10 of their relative shift, roughly.
  EXPECT_NEAR(r.rk, -slope, 2e-3 * 0.16 * -slope);
  EXPECT_EQ(r.rpk, 0);
  // Area below the core: int from p2 to 1 of bottom - cos(pi p).
  const double area = bottom * (1 - p2) + std::sin(pi * p2) / pi;
  EXPECT_NEAR(r.rvk, 2 * area / (1 - p2), 4e-3);  // its share is whole points: 1/1000 of about 0.4
}

TEST(RoughnessOf, ASquareWave) {
  const Roughness r = roughness(sampled(25, 1000, square), 1e-3, 5);
  for (const double one : {r.ra, r.rq, r.rp, r.rv, r.rku}) EXPECT_NEAR(one, 1, 4 * eps);
  EXPECT_NEAR(r.rz, 2, 8 * eps);
  EXPECT_EQ(r.rt, 2);
  EXPECT_NEAR(r.rsk, 0, 4 * eps);
  EXPECT_NEAR(r.rsm, 1, 1e-12);
  // The curve is flat over its first half: a core of no height at the top, and half of it below.
  EXPECT_NEAR(r.rk, 0, 4 * eps);
  EXPECT_NEAR(r.rpk, 0, 4 * eps);
  EXPECT_NEAR(r.rvk, 2 * 2, 8 * eps);  // twice the mean depth
}

TEST(RoughnessOf, ATriangleWave) {
  const Roughness r = roughness(sampled(25, 1000, triangle), 1e-3, 5);
  // Uniform heights -1 + (2 k + 1)/500: <|z|> = 1/2, <z^2> = (1 - 1/500^2)/3.
  EXPECT_NEAR(r.ra, 0.5, 10 * eps);
  EXPECT_NEAR(r.rq, std::sqrt((1 - 4e-6) / 3), 10 * eps);
  EXPECT_NEAR(r.rsk, 0, 20 * eps);
  // <z^4> = (1 - 10 h/3 + 7 h^2/3)/5, h = 1/500^2
  EXPECT_NEAR(r.rku, (1 - 10 * 4e-6 / 3 + 7 * 16e-12 / 3) / 5 * 9 / std::pow(1 - 4e-6, 2),
              50 * eps);
  EXPECT_NEAR(r.rz, 2 - 4e-3, 10 * eps);
  EXPECT_NEAR(r.rsm, 1, 1e-12);
  // Slopes are 4 but for the six points about each of the two corners.
  EXPECT_NEAR(r.rdq, 4, 4 * 6e-3);
  EXPECT_NEAR(r.rk, 2, 1e-4);  // the curve is a line from 1 to -1, in steps of 25 equal heights
  EXPECT_NEAR(r.rpk, 0, 1e-3);
  EXPECT_NEAR(r.rvk, 0, 1e-3);
}

TEST(RoughnessOf, ASawtooth) {
  const Roughness r = roughness(sampled(25, 1000, sawtooth), 1e-3, 5);
  EXPECT_NEAR(r.ra, 0.5, 10 * eps);
  EXPECT_NEAR(r.rq, std::sqrt((1 - 1e-6) / 3), 10 * eps);
  EXPECT_NEAR(r.rsk, 0, 30 * eps);
  EXPECT_NEAR(r.rku, 1.8, 1e-5);
  EXPECT_NEAR(r.rt, 2 - 2e-3, 10 * eps);
  EXPECT_NEAR(r.rsm, 1, 1e-12);
  EXPECT_NEAR(r.rk, 2, 1e-4);
}

TEST(RoughnessOf, ASinglePit) {
  // 999 points at height h, one at -1 + h, mean 0: h = 1/1000.
  std::vector<double> z(1000, 1e-3);
  z[500] = -0.999;
  const double p = 1e-3;
  const Roughness r = roughness(z, 1, 1);
  EXPECT_NEAR(r.ra, 2 * p * (1 - p), 10 * eps);
  EXPECT_NEAR(r.rq, std::sqrt(p * (1 - p)), 10 * eps);
  EXPECT_NEAR(r.rsk, -(1 - 2 * p) / std::sqrt(p * (1 - p)), 1e-11);  // Bernoulli's
  EXPECT_NEAR(r.rku, 3 + (1 - 6 * p * (1 - p)) / (p * (1 - p)), 1e-9);
  EXPECT_NEAR(r.rk, 0, 4 * eps);
  EXPECT_NEAR(r.rvk, 2, 20 * eps);  // a triangle of twice the depth on 1/1000 of the length
  EXPECT_TRUE(std::isnan(r.rsm));   // two crossings are no element: the plain ends are cut off
  // A slope of one point at -1: +-45/60, +-9/60, +-1/60 about it.
  EXPECT_NEAR(r.rdq, std::sqrt(2 * (45 * 45 + 81 + 1) / 3600.0 / 1000), 20 * eps);
}

TEST(RoughnessOf, AFlatProfileHasNoShape) {
  const Roughness r = roughness(std::vector<double>(100, 0.0), 1, 5);
  EXPECT_EQ(r.ra, 0);
  EXPECT_EQ(r.rz, 0);
  EXPECT_EQ(r.rdq, 0);
  EXPECT_EQ(r.rk, 0);
  for (const double none : {r.rsk, r.rku, r.rsm}) EXPECT_TRUE(std::isnan(none));
}

TEST(RoughnessOf, SamplingLengthsOfTheirOwnHeights) {
  // Two sampling lengths, of amplitude 1 and 3.
  std::vector<double> z = {1, -1, 1, -1, 3, -3, 3, -3};
  const Roughness r = roughness(z, 1, 2);
  EXPECT_EQ(r.rp, 2);  // means
  EXPECT_EQ(r.rv, 2);
  EXPECT_EQ(r.rz, 4);
  EXPECT_EQ(r.rt, 6);  // over all
  EXPECT_EQ(r.ra, 2);
  EXPECT_EQ(r.rq, std::sqrt(5.0));  // over all: the mean of the lengths' own would be 2
}

TEST(RoughnessByIso4287, TakesTheMeanOfTheSamplingLengthsOwn) {
  // Heights of mean 0 and skewness 2/2^1.5, and three times as high: each sampling length has its
  // own Rq.
  std::vector<double> z = {2, -1, -1, 2, -1, -1};
  for (int i = 0; i < 6; ++i) z.push_back(3 * z[i]);
  const Roughness r = roughness(z, 1, 2, RoughnessStandard::iso4287);
  EXPECT_NEAR(r.ra, (4.0 / 3 + 4) / 2, 4 * eps);
  EXPECT_NEAR(r.rq, 2 * std::sqrt(2.0), 4 * eps);
  EXPECT_NEAR(r.rsk, std::sqrt(0.5), 4 * eps);
  EXPECT_NEAR(r.rku, 1.5, 4 * eps);  // (16 + 1 + 1)/3 over 2^2
  EXPECT_EQ(r.rt, 9);                // of all
  EXPECT_EQ(r.rz, 6);
  const Roughness whole = roughness(z, 1, 2);
  EXPECT_NEAR(whole.ra, r.ra, 4 * eps);  // of equal sampling lengths the same
  EXPECT_NEAR(whole.rq, std::sqrt(10.0), 4 * eps);
  EXPECT_NEAR(whole.rsk, 28 / std::pow(10, 1.5), 8 * eps);
  EXPECT_NEAR(whole.rku, 246.0 / 100, 8 * eps);  // (6 + 486)/2 over 10^2
  // One sampling length is the evaluation length.
  const Roughness a = roughness(z, 1, 1), b = roughness(z, 1, 1, RoughnessStandard::iso4287);
  EXPECT_EQ(a.rq, b.rq);
  EXPECT_EQ(a.rsk, b.rsk);
  EXPECT_EQ(a.rku, b.rku);
  EXPECT_EQ(a.rdq, b.rdq);
}

TEST(RoughnessByIso4287, CountsFromTheFiltersMeanLineInEachSamplingLength) {
  // Means of 1 and -1 in the sampling lengths: with a mean line of their own Rq and Rp would be 1.
  const Roughness r =
      roughness(std::vector<double>{2, 0, 2, 0, -2, 0, -2, 0}, 1, 2, RoughnessStandard::iso4287);
  EXPECT_NEAR(r.rq, std::sqrt(2.0), 4 * eps);
  EXPECT_EQ(r.rp, 1);  // 2 and 0
  EXPECT_EQ(r.rsk, 0);
}

TEST(RoughnessByIso4287, TakesTheMeanOfSines) {
  // Ten periods of amplitude 1, then ten of 3: sums over whole periods are exact but for roundings.
  const std::size_t n = 1000;
  std::vector<double> z = sampled(10, n, sine_wave);
  for (const double height : sampled(10, n, sine_wave)) z.push_back(3 * height);
  const Roughness r = roughness(z, 1e-3, 2, RoughnessStandard::iso4287);
  const Roughness whole = roughness(z, 1e-3, 2);
  EXPECT_NEAR(r.rq, 2 * std::sqrt(0.5), 40 * eps);
  EXPECT_NEAR(whole.rq, std::sqrt(2.5), 40 * eps);
  EXPECT_NEAR(r.rku, 1.5, 100 * eps);
  EXPECT_NEAR(whole.rku, 0.375 * 41 / 6.25, 100 * eps);
  // The slope breaks between the two: six of 20 000 slopes are other ones, by at most four times.
  const double one = 2 * pi * std::sqrt(0.5);
  EXPECT_NEAR(r.rdq, 2 * one, 2 * one * 16 * 6 / 20'000);
  EXPECT_NEAR(whole.rdq, std::sqrt(5) * one, 2 * one * 16 * 6 / 20'000);
}

// ---- profile elements

double spacing_of(const std::vector<double>& z, double up, double down, bool both = true,
                  double width = 0) {
  return mean_spacing(z, 1, {up, down, width}, both);
}

TEST(MeanSpacing, NeedsAWholeElement) {
  EXPECT_TRUE(std::isnan(spacing_of({1, 1, 1}, 0.1, 0.1)));
  EXPECT_TRUE(std::isnan(spacing_of({1, -1, 1}, 0.1, 0.1)));  // crossings at 0.5 and 1.5
  EXPECT_EQ(spacing_of({1, -1, 1, -1}, 0.1, 0.1), 2);
  EXPECT_EQ(spacing_of({-1, 1, -1, 1}, 0.1, 0.1), 2);
  EXPECT_TRUE(std::isnan(spacing_of({}, 0.1, 0.1)));
}

TEST(MeanSpacing, OpenElementsAtTheEndsDoNotCount) {
  // Crossings at 4.5, 6.5, 8.5: whatever lies before the first and after the last.
  const std::vector<double> z = {1, 1, 1, 1, 1, -1, -1, 1, 1, -1, -1, -1, -1};
  EXPECT_EQ(spacing_of(z, 0.1, 0.1), 4);
}

TEST(MeanSpacing, BothWaysSeeWhatOneLeavesOver) {
  // Crossings at 0.5, 2.5, 5.5, 10.5: from the left 0.5 to 5.5, from the right 2.5 to 10.5.
  const std::vector<double> z = {-1, 1, 1, -1, -1, -1, 1, 1, 1, 1, 1, -1};
  EXPECT_EQ(spacing_of(z, 0.1, 0.1, false), 5);
  EXPECT_EQ(spacing_of(z, 0.1, 0.1, true), 6.5);
}

TEST(MeanSpacing, AHeightAtItsThresholdCountsAndOneBelowDoesNot) {
  // A hill in the middle of a dale, and a dale in a hill. Crossings about 1.5, 3.5, 5.5, 7.5, 9.5.
  const auto spacing = [](double hill, double sign) {
    std::vector<double> z = {1, 1, -1, -1, hill, hill, -1, -1, 1, 1, -1, -1};
    for (double& height : z) height *= sign;
    return spacing_of(z, 0.5, 0.5);
  };
  for (const double sign : {1.0, -1.0}) {
    EXPECT_DOUBLE_EQ(spacing(0.5, sign), 4);  // two elements of four
    EXPECT_EQ(spacing(std::nextafter(0.5, 0.0), sign), 8);
  }
}

TEST(MeanSpacing, WhatDoesNotCountBelongsToWhatCameBefore) {
  // A low hill between dale and hill: from the left it belongs to the dale, whose end is at 8.5,
  // from the right it belongs to the hill, whose end is at 4.5.
  const double low = 0.05;
  const std::vector<double> z = {1, 1, -1, -1, -1, low, low, -low, -low, 1, 1, 1, -1, -1, 1, 1};
  const double in = 4 + 1 / (1 + low),
               out = 8 + low / (1 + low);  // of the part that does not count
  EXPECT_DOUBLE_EQ(spacing_of(z, 0.1, 0.1, false), 11.5 - 1.5);
  // from the right: 13.5 (-), 11.5 (+), in (-), 1.5: elements 13.5 to `in`
  EXPECT_DOUBLE_EQ(spacing_of(z, 0.1, 0.1, true), (10 + 13.5 - in) / 2);
  EXPECT_LT(in, out);
}

TEST(MeanSpacing, ACrossingOfSeveralZerosIsInTheirMiddle) {
  // Crossings at 2, 4.5 and 6.5.
  EXPECT_EQ(spacing_of({-1, 0, 0, 0, 1, -1, -1, 1}, 0.1, 0.1), 4.5);
  EXPECT_EQ(spacing_of({1, 0, 0, 0, -1, 1, 1, -1}, 0.1, 0.1), 4.5);
  // Zeros that the profile only touches are no crossing.
  EXPECT_EQ(spacing_of({-1, 0, 1, 0, 1, -1, -1, 1}, 0.1, 0.1), 5.5);
}

TEST(MeanSpacing, PartsThatAreTooNarrowDoNotCount) {
  // Widths 2 but for one hill of width 1.
  const std::vector<double> z = {1, 1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, 1};
  EXPECT_EQ(spacing_of(z, 0.1, 0.1, false, 0), 3.5);  // 1.5 to 4.5, 4.5 to 8.5; 10.5 is left over
  EXPECT_EQ(spacing_of(z, 0.1, 0.1, false, 1.5), 7);  // 1.5 to 8.5
}

TEST(MeanSpacing, OlderRuleOfAHundredthOfTheSamplingLength) {
  // Peaks of 0.15 Rz and pits of 0.85: the older rule asks 0.1 Rz of both, and takes them as well.
  std::vector<double> z;
  for (int i = 0; i < 40; ++i) z.insert(z.end(), {0.3, 0.3, 0.3, 0.3, -1.2});
  EXPECT_NEAR(roughness(z, 1, 1, RoughnessStandard::iso21920).rsm, 5, 1e-12);
  EXPECT_TRUE(
      std::isnan(roughness(z, 1, 1, RoughnessStandard::iso4287).rsm));        // pits of 1.6 in 200
  EXPECT_NEAR(roughness(z, 1, 2, RoughnessStandard::iso4287).rsm, 5, 1e-12);  // and in 100
  // Peaks of 0.05 Rz are 10 % of Rp and more, and not 10 % of Rz.
  for (double& height : z) height = height > 0 ? 0.05 : -0.95;
  EXPECT_NEAR(roughness(z, 1, 4, RoughnessStandard::iso21920).rsm, 5, 1e-12);
  EXPECT_TRUE(std::isnan(roughness(z, 1, 4, RoughnessStandard::iso4287).rsm));
}

// ---- slopes, core, material ratio

TEST(RmsSlope, IsExactForPolynomialsOfDegreeSix) {
  // (x/10)^6 - x at 0 ... 12: every slope is the derivative, at the ends as well.
  std::vector<double> z;
  double squares = 0;
  for (int i = 0; i <= 12; ++i) {
    z.push_back(std::pow(i / 10.0, 6) - i);
    squares += std::pow(0.6 * std::pow(i / 10.0, 5) - 1, 2);
  }
  EXPECT_NEAR(rms_slope(z, 1), std::sqrt(squares / 13), 1e-13);
  EXPECT_NEAR(rms_slope(z, 0.5), 2 * std::sqrt(squares / 13), 2e-13);
  std::reverse(z.begin(), z.end());
  EXPECT_NEAR(rms_slope(z, 1), std::sqrt(squares / 13), 1e-13);
  EXPECT_TRUE(std::isnan(rms_slope(std::vector<double>(6, 1.0), 1)));
}

TEST(Core, OfACurveOfThreeLines) {
  // From the top: 10 % of slope -10, 70 % of slope -1, 20 % of slope -5. Shuffled: order is no
  // matter.
  const std::size_t n = 10000;
  std::vector<double> z;
  for (std::size_t i = 0; i < n; ++i) {
    const double p = (static_cast<double>(i) + 0.5) / n;
    z.push_back(p < 0.1 ? 1 - 10 * p : p < 0.8 ? 0.1 - p : -0.7 - 5 * (p - 0.8));
  }
  std::shuffle(z.begin(), z.end(), std::mt19937(1));
  const Core c = core(z);
  EXPECT_NEAR(c.rk, 1, 1e-12);  // the line 0.1 - p from 0 to 1
  // Above it 1 - 10 p - 0.1, where p < 0.09: a triangle, 0.9 high. Below: -0.7 - 5 q under -0.9,
  // from q = 0.04 to 0.2, 0.8 deep.
  EXPECT_NEAR(c.rpk, 0.9, 1e-12);
  EXPECT_NEAR(c.peaks, 0.09, 1e-12);
  EXPECT_NEAR(c.rvk, 0.8, 1e-12);
  EXPECT_NEAR(c.valleys, 0.16, 1e-12);
  EXPECT_TRUE(std::isnan(core(std::vector<double>(9, 1.0)).rk));
}

TEST(Core, SecantsThatEndAtAPointAreTried) {
  // 11 heights: 40 % are 4.4 points. Secants from point 5 fall by 7 - 0.6, from 4 by more; the one
  // that ends at the last begins at 5.6 and falls by 5.2.
  const std::vector<double> z = {90, 80, 70, 60, 50, 7, 4, 3, 2, 1, 0};
  // Points 6 ... 10 lie in it: slope -1 a point, -11 over all.
  EXPECT_NEAR(core(z).rk, 11, 1e-12);
}

TEST(MaterialRatio, IsTheShareAtOrAbove) {
  const std::vector<double> z = {-1, 0, 1, 2};
  EXPECT_EQ(material_ratio(z, 3), 0);
  EXPECT_EQ(material_ratio(z, 2), 0.25);
  EXPECT_EQ(material_ratio(z, 0.5), 0.5);
  EXPECT_EQ(material_ratio(z, -1), 1);
}

TEST(MeanLineAboveValleys, IsLoweredByTheSquareOfTheirShare) {
  // Grooves on a tenth of the length, 1 deep, far narrower than the cut-off: the first mean line is
  // at -1/10, and with the grooves filled up to it the second at -1/100. 80 periods of a bell of
  // 160: what it lets through of a period is 2^-(160^2).
  std::vector<double> z;
  for (int i = 0; i < 100'000; ++i) z.push_back(i % 100 < 10 ? -1 : 0);
  const auto line = mean_line_above_valleys(z, 1, 16'000);
  const auto plain = gaussian_mean_line(z, 1, 16'000);
  for (std::size_t i = 30'000; i < 70'000; i += 1000) {  // two reaches of 1.6 from the ends' own
    ASSERT_NEAR(plain[i], -0.1, 1e-12) << i;
    ASSERT_NEAR(line[i], -0.01, 2e-4)
        << i;  // the ends of the first line, which sees no whole periods
  }
  // Where there are no valleys but the mean line's own, as of a line, nothing is lifted.
  std::vector<double> slope;
  for (int i = 0; i < 1000; ++i) slope.push_back(0.25 * i);
  const auto same = mean_line_above_valleys(slope, 1, 100);
  for (std::size_t i = 0; i < slope.size(); ++i) ASSERT_NEAR(same[i], slope[i], 1e-10) << i;
}

// ---- what must not matter

struct Invariance : testing::Test {
  const std::vector<double> z = random_profile(20000, 7);
  const Roughness r = roughness(z, 0.5, 5);
};

void expect_near(const Roughness& a, const Roughness& b, double tolerance) {
  EXPECT_NEAR(a.ra, b.ra, tolerance * b.ra);
  EXPECT_NEAR(a.rq, b.rq, tolerance * b.rq);
  EXPECT_NEAR(a.rz, b.rz, tolerance * b.rz);
  EXPECT_NEAR(a.rt, b.rt, tolerance * b.rt);
  EXPECT_NEAR(a.rp, b.rp, tolerance * b.rp);
  EXPECT_NEAR(a.rv, b.rv, tolerance * b.rv);
  EXPECT_NEAR(a.rsk, b.rsk, tolerance);
  EXPECT_NEAR(a.rku, b.rku, tolerance * b.rku);
  EXPECT_NEAR(a.rsm, b.rsm, tolerance * b.rsm);
  EXPECT_NEAR(a.rdq, b.rdq, tolerance * b.rdq);
  EXPECT_NEAR(a.rk, b.rk, tolerance * b.rk);
  EXPECT_NEAR(a.rpk, b.rpk, tolerance * b.rk);
  EXPECT_NEAR(a.rvk, b.rvk, tolerance * b.rk);
}

TEST_F(Invariance, HeightsInAnotherUnit) {
  std::vector<double> scaled = z;
  for (double& height : scaled) height *= 0x1p-20;
  Roughness s = roughness(scaled, 0.5, 5);
  for (double* const height :
       {&s.ra, &s.rq, &s.rz, &s.rt, &s.rp, &s.rv, &s.rdq, &s.rk, &s.rpk, &s.rvk})
    *height *= 0x1p20;
  expect_near(s, r, 0);  // powers of two
}

TEST_F(Invariance, LengthsInAnotherUnit) {
  Roughness s = roughness(z, 2, 5);
  s.rsm /= 4;
  s.rdq *= 4;
  expect_near(s, r, 0);
}

TEST_F(Invariance, UpsideDown) {
  std::vector<double> mirrored = z;
  for (double& height : mirrored) height = -height;
  Roughness s = roughness(mirrored, 0.5, 5);
  std::swap(s.rp, s.rv);
  std::swap(s.rpk, s.rvk);
  s.rsk = -s.rsk;
  expect_near(s, r, 1e-12);
  EXPECT_GT(std::abs(r.rsk), 0.01);  // or nothing was shown
  EXPECT_GT(std::abs(r.rp - r.rv), 0.01 * r.rp);
}

TEST_F(Invariance, BackToFront) {
  std::vector<double> mirrored(z.rbegin(), z.rend());
  expect_near(roughness(mirrored, 0.5, 5), r, 1e-12);
}

TEST_F(Invariance, TwiceTheSamePeriods) {
  std::vector<double> once =
      sampled(20, 250, [](double x) { return sine_wave(x) + 0.4 * sine_wave(3 * x); });
  std::vector<double> twice = once;
  twice.insert(twice.end(), once.begin(), once.end());
  Roughness a = roughness(once, 1, 5), b = roughness(twice, 1, 10);
  // Slopes: 12 points at the ends are of another formula, and now as many among twice the points.
  EXPECT_NEAR(a.rdq, b.rdq, 1e-8 * b.rdq);
  EXPECT_NEAR(a.rk, b.rk, 2e-4 * b.rk);  // the 40 % end within a point of 5000
  EXPECT_NEAR(a.rvk, b.rvk, 1e-3 * b.rk);
  EXPECT_NEAR(a.rpk, b.rpk, 1e-3 * b.rk);
  a.rdq = b.rdq, a.rk = b.rk, a.rvk = b.rvk, a.rpk = b.rpk;
  expect_near(a, b, 1e-12);
}

// ---- filter

/// Largest height of the mean line of a sine within `inside` of the profile, against its own.
double transmission(double wavelength, double cutoff, double spacing, std::size_t count) {
  std::vector<double> z;
  for (std::size_t i = 0; i < count; ++i)
    z.push_back(std::cos(2 * pi * static_cast<double>(i) * spacing / wavelength));
  const auto line = gaussian_mean_line(z, spacing, cutoff);
  // Points three cutoffs from the ends see none of them. By projection on the sine, over whole
  // periods.
  const auto margin = static_cast<std::size_t>(std::ceil(3 * cutoff / spacing));
  const auto period = static_cast<std::size_t>(std::lround(wavelength / spacing));
  const std::size_t whole = (count - 2 * margin) / period * period;
  double share = 0;
  for (std::size_t i = margin; i < margin + whole; ++i) share += line[i] * z[i];
  return 2 * share / static_cast<double>(whole);
}

TEST(GaussianFilter, LetsThroughWhatItsFormulaSays) {
  // pi alpha^2 = ln 2: 2^-(cutoff/wavelength)^2. Both ways of summing, and cutoffs between points.
  for (const double cutoff : {8.0, 19.99, 25.0, 80.0, 333.3, 1024.0, 5000.3})
    for (const double ratio : {0.5, 1.0, 2.0, 5.0}) {
      const double wavelength = std::round(cutoff * ratio);
      const double exact = std::exp2(-std::pow(cutoff / wavelength, 2));
      const auto count = static_cast<std::size_t>(12 * (cutoff + wavelength));
      // between points the sine may as well be one of 1 - 1/wavelength periods a step
      const double alias = std::exp2(-std::pow(cutoff * (1 - 1 / wavelength), 2));
      EXPECT_NEAR(transmission(wavelength, cutoff, 1, count), exact, 1e-13 + 2 * alias)
          << cutoff << ' ' << wavelength;
    }
  EXPECT_NEAR(transmission(80, 80, 1, 2000), 0.5, 1e-14);
  EXPECT_NEAR(transmission(80e-6, 80e-6, 1e-6, 2000), 0.5, 1e-14);
}

TEST(GaussianFilter, IsTheSumOfItsWeights) {
  const auto z = random_profile(700, 3);
  for (const double cutoff : {7.0, 70.0, 300.0, 2000.0}) {
    const auto line = gaussian_mean_line(z, 1, cutoff);
    for (const int i : {0, 1, 30, 350, 650, 699}) {
      // A line by least squares of weight s(x) about the point, its value there.
      double s0 = 0, s1 = 0, s2 = 0, m0 = 0, m1 = 0;
      for (int k = 0; k < 700; ++k) {
        const double x = k - i;
        const double s = std::exp(-pi * pi / std::log(2) * std::pow(x / cutoff, 2));
        s0 += s, s1 += s * x, s2 += s * x * x, m0 += s * z[k], m1 += s * x * z[k];
      }
      EXPECT_NEAR(line[i], (s2 * m0 - s1 * m1) / (s0 * s2 - s1 * s1), 1e-13) << cutoff << ' ' << i;
    }
  }
}

TEST(GaussianFilter, OfLongCutoffsIsTheSumOfItsWeights) {
  // From 1024 points on the sum goes in strides. Short profiles, whose ends it sees everywhere,
  // too.
  const long double bell =
      std::pow(std::numbers::pi_v<long double>, 2) / std::numbers::ln2_v<long double>;
  for (const std::size_t count : {300u, 5000u, 30000u}) {
    auto z = random_profile(count, 4);
    for (double& height : z) height += 3;
    for (const double cutoff : {1023.0, 1024.0, 3001.7, 20000.0, 1e7}) {
      const auto line = gaussian_mean_line(z, 1, cutoff);
      for (const std::size_t i :
           {std::size_t{0}, std::size_t{1}, count / 7, count / 2, count - 1}) {
        long double s0 = 0, s1 = 0, s2 = 0, m0 = 0, m1 = 0;
        for (std::size_t k = 0; k < count; ++k) {
          const long double x =
              (static_cast<long double>(k) - static_cast<long double>(i)) / cutoff;
          const long double s = std::exp(-bell * x * x);
          s0 += s, s1 += s * x, s2 += s * x * x, m0 += s * z[k], m1 += s * x * z[k];
        }
        EXPECT_NEAR(line[i], static_cast<double>((s2 * m0 - s1 * m1) / (s0 * s2 - s1 * s1)), 2e-14)
            << count << ' ' << cutoff << ' ' << i;
      }
    }
  }
}

TEST(GaussianFilter, KeepsConstantsAndLinesToTheEnds) {
  for (const double cutoff : {0.01, 0.5, 3.0, 30.0, 400.0, 2100.0, 5000.0, 1e6, 1e300}) {
    std::vector<double> z;
    for (int i = 0; i < 1000; ++i) z.push_back(5 - 0.01 * i);
    const auto line = gaussian_mean_line(z, 1, cutoff);
    for (std::size_t i = 0; i < z.size(); ++i) ASSERT_NEAR(line[i], z[i], 2e-13) << cutoff << i;
    const auto constant = gaussian_mean_line(std::vector<double>(1000, 1e-3), 1, cutoff);
    for (const double height : constant) ASSERT_NEAR(height, 1e-3, 4 * eps * 1e-3);
  }
  EXPECT_TRUE(gaussian_mean_line({}, 1, 1).empty());
  EXPECT_EQ(gaussian_mean_line({3}, 1, 1), std::vector<double>{3});
}

// ---- form

TEST(Form, WordsAreReadOrRefused) {
  EXPECT_EQ(to_form("none").degree, ProfileForm::none);
  EXPECT_EQ(to_form("mean").degree, 0);
  EXPECT_EQ(to_form("line").degree, 1);
  EXPECT_EQ(to_form("poly:4").degree, 4);
  for (const char* word :
       {"", "poly", "poly:", "poly:11", "poly:-1", "poly:2.0", "poly: 2", "Line"})
    EXPECT_THROW(to_form(word), RequestError) << word;
}

TEST(Form, APolynomialOfItsDegreeIsGone) {
  for (int degree = 0; degree <= ProfileForm::highest; ++degree) {
    std::vector<double> z;
    for (int i = 0; i < 5000; ++i) {
      const double x = i / 2499.5 - 1;
      double height = 0;
      for (int k = degree; k >= 0; --k) height = height * x + 1.0 / (k + 1) - 0.3;
      z.push_back(1e3 + height);  // and a far offset, whose roundings stay
    }
    std::vector<double> left = z;
    remove_form(left, {degree});
    for (const double height : left) ASSERT_NEAR(height, 0, 2 * 1e3 * eps) << degree;
    if (degree == 0) continue;
    remove_form(z, {degree - 1});
    EXPECT_GT(*std::max_element(z.begin(), z.end()), 1e-4) << degree;  // it takes no more than that
  }
}

TEST(Form, WhatIsLeftIsOrthogonalToIt) {
  std::vector<double> z = random_profile(3000, 5);
  remove_form(z, {3});
  for (int power = 0; power <= 3; ++power) {
    double sum = 0;
    for (int i = 0; i < 3000; ++i) sum += z[i] * std::pow(i / 1499.5 - 1, power);
    EXPECT_NEAR(sum / 3000, 0, 1e-15) << power;
  }
}

TEST(Form, OfFewerPointsThanItsDegreeIsAllOfThem) {
  std::vector<double> z = {1, 5, -2};
  remove_form(z, {10});
  for (const double height : z) EXPECT_NEAR(height, 0, 8 * eps);
  std::vector<double> one = {4}, none;
  remove_form(one, {2});
  EXPECT_EQ(one[0], 0);
  remove_form(none, {2});
  std::vector<double> kept = {1, 2};
  remove_form(kept, {ProfileForm::none});
  EXPECT_EQ(kept, (std::vector<double>{1, 2}));
}

}  // namespace
