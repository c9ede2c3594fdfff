// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/gaussian.hpp"
#include "host/surface/portable.hpp"
#include "host/surface/surface.hpp"
#include "tests/numbers.hpp"

namespace {

using namespace ra2d;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

using test::eps;
using test::pi;

SurfaceSpec gaussian(double rq, double correlation_length, std::uint64_t seed) {
  SurfaceSpec spec;
  spec.kind = SurfaceKind::gaussian;
  spec.rq = rq;
  spec.correlation_length = correlation_length;
  spec.seed = seed;
  return spec;
}

std::vector<double> make(const SurfaceSpec& spec, double length, double spacing) {
  return make_surface(spec, length, spacing, "scene.toml");
}

/// FNV-1a of the bytes of the heights, lowest byte first.
std::uint64_t hash(const std::vector<double>& heights) {
  std::uint64_t h = 0xcbf29ce484222325;
  for (const double height : heights) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &height, sizeof bits);
    for (int i = 0; i < 8; ++i) h = (h ^ (bits >> 8 * i & 0xff)) * 0x100000001b3;
  }
  return h;
}

double mean_product(const std::vector<double>& a, const std::vector<double>& b, std::size_t lag) {
  long double sum = 0;
  for (std::size_t n = 0; n + lag < a.size(); ++n) sum += a[n] * b[n + lag];
  return static_cast<double>(sum / static_cast<long double>(a.size() - lag));
}

double ulp(double value) {
  return std::abs(value) - std::nextafter(std::abs(value), 0.0);  // the smaller neighbour's
}

// ---- node_count

TEST(NodeCount, CountsTheNodesUpToTheEnd) {
  EXPECT_EQ(node_count(0.3, 8e-6), 37501);  // 0.3/8e-6 rounds to just below 37500
  EXPECT_EQ(node_count(0.02, 8e-6), 2501);
  EXPECT_EQ(node_count(1.0, 0.3), 4);
  EXPECT_EQ(node_count(1.0, 2.0), 1);
  EXPECT_EQ(node_count(10 * (1 - 0.9e-10), 1.0), 11);
  EXPECT_EQ(node_count(10 * (1 - 1.1e-10), 1.0), 10);
}

TEST(NodeCount, RefusesMoreNodesThanItCanCount) {
  EXPECT_THROW(node_count(1.0, 1e-12), RequestError);
  EXPECT_THROW(node_count(1.0, 0.0), RequestError);
}

// ---- portable functions

TEST(Portable, CompiledWithoutContraction) {
  // 1 + 2^-29 + 2^-60 rounds to 1 + 2^-29: a fused multiply-add would leave 2^-60.
  volatile double x = 1 + 0x1p-30;
  const double a = x, product = x * x;
  EXPECT_EQ(a * a - product, 0) << "compile with -ffp-contract=off";
}

TEST(Portable, DividesAsIeeeDoes) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-900, 990);
  for (int n = 1; n <= portable::most_divisor; ++n) {
    EXPECT_EQ(portable::divide_by(n, 0.0), 0.0);
    for (int i = 0; i < 200'000; ++i) {
      // any mantissa; those next to a power of two; and where the quotient is one
      const double mantissa = 1 + 0x1p-52 * static_cast<double>(random() >> 12);
      const double near_one = 1 + 0x1p-52 * static_cast<double>(random() % 64);
      for (const double x : {mantissa, near_one, 2 - near_one, n * near_one, n * mantissa,
                             -std::exp2(exponent(random)) * mantissa})
        ASSERT_EQ(portable::divide_by(n, x), x / n) << x << " by " << n;
    }
  }
}

TEST(Portable, ExpIsWithinOneUlp) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1'000'000; ++i) {
    const double x = -700 + 1400 * 0x1p-64 * static_cast<double>(random());
    for (const double argument : {x, x / 16, x / 1024}) {
      const auto exact = std::exp(static_cast<long double>(argument));
      // The correctly rounded value is half an ulp off at most.
      EXPECT_NEAR(portable::exp(argument), static_cast<double>(exact),
                  ulp(static_cast<double>(exact)));
    }
  }
  EXPECT_EQ(portable::exp(0), 1);
}

TEST(Portable, LogIsWithinOneUlp) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 1'000'000; ++i) {
    const double x = 0x1p-64 * static_cast<double>(random());  // (0, 1), and both sides of 1
    for (const double argument : {x, 1 - x / 64, 1 + x, std::ldexp(x, i % 2000 - 1000)}) {
      if (!(argument > 0)) continue;
      const auto exact = std::log(static_cast<long double>(argument));
      EXPECT_NEAR(portable::log(argument), static_cast<double>(exact),
                  ulp(static_cast<double>(exact)))
          << argument;
    }
  }
  EXPECT_EQ(portable::log(1), 0);
}

// ---- gaussian

TEST(WhiteNoise, IsStandardNormal) {
  // Kolmogorov-Smirnov: sup |F_n - F| sqrt(n) exceeds 1.95 once in a thousand seeds.
  const int n = 1'000'000;
  std::vector<double> noise;
  noise.reserve(n);
  for (int i = 0; i < n; ++i) noise.push_back(white_noise(3, i - n / 2));
  std::sort(noise.begin(), noise.end());
  double worst = 0;
  for (int i = 0; i < n; ++i) {
    const double f = std::erfc(-noise[i] / std::sqrt(2)) / 2;
    worst = std::max({worst, std::abs(f - i * 1.0 / n), std::abs(f - (i + 1.0) / n)});
  }
  EXPECT_LT(worst * std::sqrt(n), 1.95);
  EXPECT_EQ(std::unique(noise.begin(), noise.end()), noise.end());
}

TEST(Gaussian, ASeedGivesTheSameBitsEverywhere) {
  // Regression: stored on x86-64 (the noise from the first version of this generator, the heights
  // from the first that has places of its own). They must never change, on any platform, compiler
  // or optimisation level: results name their surfaces by the seed.
  EXPECT_EQ(white_noise(1, 0), -0x1.9bd3bf48bade4p-3);
  EXPECT_EQ(white_noise(1, -1), -0x1.19d1d2410220ep+0);
  EXPECT_EQ(white_noise(0xfedcba9876543210, 1234567890123), 0x1.45ab8e97816dbp+0);
  SurfaceSpec spec = gaussian(8e-6, 0, 2);
  spec.correlation_length.reset();
  spec.rsm = 1.55e-3;
  const auto heights = make(spec, 0.3, 8e-6);
  ASSERT_EQ(heights.size(), 37501);
  EXPECT_EQ(heights[0], 0x1.f7b7d2cad54d6p-17);
  EXPECT_EQ(heights[12345], -0x1.7cb75d0fc665fp-17);
  EXPECT_EQ(heights[37500], 0x1.d7bc6d47377ebp-17);
  EXPECT_EQ(hash(heights), 0xe88d870cfb306499) << std::hex << hash(heights);
}

TEST(Gaussian, RqIsTheOneAskedForAndTheMeanIsZero) {
  // Of the profile, not of its nodes: Simpson's rule, off by the fourth derivative of the square,
  // (h/l)^4 16 * 105/180 at l/32: 1e-5; and Gauss's own 1e-11.
  const double l = 3.5e-4;
  for (const double length : {0.3, 0.02, 0.0021, 0.5 * l}) {
    const int panels = 2 * static_cast<int>(std::ceil(length / l * 32));
    const auto h = make(gaussian(8e-6, l, 5), length, length / panels);
    ASSERT_EQ(h.size(), panels + 1);
    long double mean = 0, square = 0;
    for (int n = 0; n <= panels; ++n) {
      const double weight = (n == 0 || n == panels ? 1 : n % 2 == 1 ? 4 : 2) / (3.0 * panels);
      mean += weight * h[n];
      square += weight * h[n] * h[n];
    }
    EXPECT_NEAR(static_cast<double>(mean), 0, 1e-5 * 8e-6) << length;
    EXPECT_NEAR(std::sqrt(static_cast<double>(square)), 8e-6, 1e-5 * 8e-6) << length;
  }
}

TEST(Gaussian, HeightsScaleExactlyWithPowersOfTwo) {
  const auto one = make(gaussian(1e-6, 3.5e-4, 5), 0.02, 8e-6);
  const auto eight = make(gaussian(8 * 1e-6, 3.5e-4, 5), 0.02, 8e-6);
  const auto none = make(gaussian(0, 3.5e-4, 5), 0.02, 8e-6);
  for (std::size_t n = 0; n < one.size(); ++n) {
    ASSERT_EQ(eight[n], 8 * one[n]);
    ASSERT_EQ(none[n], 0);
  }
}

TEST(Gaussian, LengthActsThroughTheNormalisationAlone) {
  const auto shorter = make(gaussian(1e-6, 1e-4, 5), 0.004, 8e-6);
  const auto longer = make(gaussian(1e-6, 1e-4, 5), 0.02, 8e-6);
  const double factor = (longer[400] - longer[0]) / (shorter[400] - shorter[0]);
  for (std::size_t n = 0; n < shorter.size();
       ++n)  // roundings of heights up to 4 Rq, and of factor
    EXPECT_NEAR(longer[n] - longer[0], factor * (shorter[n] - shorter[0]), 64 * eps * 1e-6);
}

TEST(Gaussian, ASeedMeansOneProfileWhateverTheSpacing) {
  const SurfaceSpec spec = gaussian(8e-6, 3.5e-4, 5);
  const std::vector<double> own = make(spec, 0.02, 8e-6);
  for (const int ratio : {2, 4, 16}) {  // powers of two: the same places to the last bit
    const std::vector<double> coarse = make(spec, 0.02, ratio * 8e-6);
    ASSERT_EQ(coarse.size(), 1 + (own.size() - 1) / ratio);
    for (std::size_t n = 0; n < coarse.size(); ++n) EXPECT_EQ(coarse[n], own[ratio * n]);
  }
  // a rounding of the place moves a height by the slope, sqrt(2) rq/l and less than six times that
  const double slope = 6 * std::sqrt(2) * 8e-6 / 3.5e-4;
  const std::vector<double> third = make(spec, 0.02, 8e-6 / 3);
  for (std::size_t n = 0; n < own.size(); ++n)
    EXPECT_NEAR(third[3 * n], own[n], 4 * eps * 0.02 * slope + 64 * eps * 8e-6);
  // in no simple ratio, too: a polygon is off by chi^2/8 of the curvature, sqrt(12) rq/l^2
  const std::vector<double> odd = make(spec, 0.02, 1.7e-5);
  const double sagitta = 6 * std::sqrt(12) * 8e-6 * std::pow(8e-6 / 3.5e-4, 2) / 8;
  for (std::size_t n = 0; n < odd.size(); ++n) {
    const double at = static_cast<double>(n) * 1.7e-5 / 8e-6;
    const auto i = std::min(static_cast<std::size_t>(at), own.size() - 2);
    EXPECT_NEAR(odd[n], std::lerp(own[i], own[i + 1], at - static_cast<double>(i)), sagitta);
  }
}

TEST(Gaussian, IsTheSumOfItsBells) {
  // The definition, evaluated in long double with libm: white noise every l/4, a bell about each.
  const double l = 3.5e-4, place = l / 4, length = 0.003;
  const auto heights = make(gaussian(8e-6, l, 5), length, 8e-6);
  std::vector<long double> sums;
  for (std::size_t n = 0; n < heights.size(); ++n) {
    long double sum = 0;
    const double x = static_cast<double>(n) * 8e-6;
    for (int i = -40; i <= static_cast<int>(length / place) + 40; ++i)
      sum += white_noise(5, i) *
             std::exp(-2 * std::pow((x - i * static_cast<long double>(place)) / l, 2));
    sums.push_back(sum);
  }
  const long double factor = (heights.back() - heights[0]) / (sums.back() - sums[0]);
  for (std::size_t n = 0; n < heights.size(); ++n)  // 37 terms, 18 powers: a hundred roundings
    EXPECT_NEAR(heights[n] - heights[0], static_cast<double>(factor * (sums[n] - sums[0])),
                200 * eps * 8e-6);
}

/// A long profile and its statistics: l is 20 nodes, the profile 20 000 l.
struct LongProfile : testing::Test {
  static constexpr int nodes = 400'000;
  static constexpr double ratio = 20;  // l/chi
  static const std::vector<double>& heights(std::uint64_t seed) {
    static const std::vector<double> one = gaussian_heights(1, ratio, 1, nodes - 1, nodes, 1);
    static const std::vector<double> two = gaussian_heights(1, ratio, 2, nodes - 1, nodes, 1);
    return seed == 1 ? one : two;
  }
  /// Number of independent samples for a mean of the power p of the correlation: the nodes over
  /// the sum of exp(-p (i chi/l)^2).
  static double independent(double p) { return nodes / (ratio * std::sqrt(pi / p)); }
};

TEST_F(LongProfile, AutocorrelationIsTheFormula) {
  // Variance of an estimate of C (Bartlett): sum of C(i)^2 + C(i + lag) C(i - lag), over the nodes:
  // at most 2 over the samples independent for the square of C. Four standard errors.
  const double bound = 4 * std::sqrt(2 / independent(2));
  for (const int lag : {1, 5, 10, 20, 30, 40, 60, 100, 500})
    EXPECT_NEAR(mean_product(heights(1), heights(1), lag), std::exp(-std::pow(lag / ratio, 2)),
                bound)
        << "lag " << lag;
}

TEST_F(LongProfile, SeedsAreUncorrelated) {
  // Variance of the estimate: sum of C(i)^2 over the nodes. Four standard errors.
  for (const int lag : {0, 1, 20, 1000})
    EXPECT_NEAR(mean_product(heights(1), heights(2), lag), 0, 4 / std::sqrt(independent(2)));
}

TEST_F(LongProfile, HeightsAreNormal) {
  double third_moment = 0, fourth_moment = 0;
  for (const double h : heights(1)) third_moment += h * h * h, fourth_moment += h * h * h * h;
  // Variances 6 and 24 over the samples independent for the third_moment and fourth power of C.
  EXPECT_NEAR(third_moment / nodes, 0, 4 * std::sqrt(6 / independent(3)));
  EXPECT_NEAR(fourth_moment / nodes, 3, 4 * std::sqrt(24 / independent(4)));
}

TEST_F(LongProfile, MeanSpacingIsRsm) {
  // Up-crossings of the mean line, block by block; the blocks' scatter gives the standard error.
  const double rsm = std::sqrt(2.0) * pi * ratio;
  constexpr int blocks = 100, block = nodes / blocks;
  double sum = 0, squares = 0;
  for (int b = 0; b < blocks; ++b) {
    int crossings = 0;
    for (int n = b * block; n < (b + 1) * block && n + 1 < nodes; ++n)
      crossings += heights(1)[n] < 0 && heights(1)[n + 1] >= 0;
    sum += crossings;
    squares += crossings * crossings;
  }
  const double mean = sum / blocks;
  const double error = std::sqrt((squares / blocks - mean * mean) / (blocks - 1));
  // Between two nodes with correlation r, an up-crossing is seen with probability acos(r)/(2 pi).
  const double seen = std::acos(std::exp(-1 / (ratio * ratio))) / (2 * pi);
  EXPECT_NEAR(seen * rsm, 1, 0.001);  // nodes are close enough: chi/RSm of the crossings, nearly
  EXPECT_NEAR(mean, block * seen, 3 * error);
}

TEST(Gaussian, RsmSetsTheCorrelationLength) {
  SurfaceSpec by_rsm = gaussian(1e-6, 0, 4);
  by_rsm.correlation_length.reset();
  by_rsm.rsm = 1.55e-3;
  const double l = 1.55e-3 / (std::sqrt(2.0) * pi);
  EXPECT_EQ(make(by_rsm, 0.02, 8e-6), make(gaussian(1e-6, l, 4), 0.02, 8e-6));
}

TEST(Gaussian, RefusesWhatHasNoMeaning) {
  EXPECT_THROW(make(gaussian(1e-6, 0, 1), 0.02, 8e-6), RequestError);
  EXPECT_THROW(make(gaussian(1e-6, 2.1, 1), 0.02, 8e-6), RequestError);  // l far beyond the beam
  EXPECT_THROW(make(gaussian(1e-6, 1e-10, 1), 0.02, 8e-6), RequestError);
  EXPECT_THROW(make(gaussian(1e-6, 1e-4, 1), 5e-6, 8e-6), RequestError);  // one node
}

// ---- flat and peaks

TEST(Surface, FlatIsZero) { EXPECT_EQ(make({}, 1.0, 0.25), std::vector<double>(5, 0.0)); }

TEST(Surface, PeaksAreRaisedCosines) {
  SurfaceSpec spec;
  spec.kind = SurfaceKind::peaks;
  spec.peaks = {{.at = 1, .height = 8, .half_width = 0.5},
                {.at = 1.5, .height = 4, .half_width = 1}};
  const auto heights = make(spec, 3, 0.25);
  // A raised cosine at a quarter, half and three quarters of the way up its flank.
  const double quarter = 2 * (1 - std::sqrt(0.5)), rest = 2 * (1 + std::sqrt(0.5));
  const std::vector<double> expected = {0,    0, 0,       4 + quarter, 8 + 2, 4 + rest, 4,
                                        rest, 2, quarter, 0,           0,     0};
  ASSERT_EQ(heights.size(), expected.size());
  for (std::size_t n = 0; n < heights.size(); ++n)
    EXPECT_NEAR(heights[n], expected[n], 8 * eps * 8) << "node " << n;
}

// ---- file

struct ProfileFile : testing::Test {
  // A folder a test: tests may run at the same time.
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) /
      (std::string("ra2d_profile_") +
       testing::UnitTest::GetInstance()->current_test_info()->name());
  void SetUp() override { std::filesystem::create_directories(folder); }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::vector<double> read(const std::string& text, double length = 3, double spacing = 1) const {
    std::ofstream(folder / "profile.csv", std::ios::binary) << text;
    return read_existing("profile.csv", length, spacing);
  }
  std::vector<double> read_existing(const std::filesystem::path& path, double length = 3,
                                    double spacing = 1) const {
    SurfaceSpec spec;
    spec.kind = SurfaceKind::file;
    spec.path = path;
    return make_surface(spec, length, spacing, folder / "scene.toml");
  }
  std::string fault(const std::string& text, double length = 3, double spacing = 1) const {
    std::ofstream(folder / "profile.csv", std::ios::binary) << text;
    return fault_of_file(length, spacing);
  }
  std::string fault_of_file(double length = 3, double spacing = 1) const {
    try {
      read_existing("profile.csv", length, spacing);
    } catch (const RequestError& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST_F(ProfileFile, ReadsEveryFormOfTwoColumns) {
  const std::vector<double> expected = {-1.5, -0.5, 0.5, 1.5};
  EXPECT_EQ(read("0 1\n1 2\n2 3\n3 4\n"), expected);
  EXPECT_EQ(read("0,1\n1,2\n2,3\n3,4"), expected);
  EXPECT_EQ(read("x, z\r\n0, 1\r\n1 ,2\r\n2\t,\t3\r\n  3\t4  \r\n"), expected);
  EXPECT_EQ(read("# a comment\n\n  \nx [m] z [m]\n+0 +1 # unit\n1e0 +.2e+1\n2. 3\n3.0E0 4\n"),
            expected);
  EXPECT_EQ(read("\xef\xbb\xbf"
                 "0 1\n1 2\n2 3\n3 4\n"),
            expected);
  EXPECT_EQ(read("5 1\n6 2\n7 3\n8 4\n9 1e9\n"), expected);  // its first point is the beam's end
}

TEST_F(ProfileFile, CopiesHeightsOfTheSameSpacingExactly) {
  std::string text;
  std::vector<double> z;
  for (int n = 0; n <= 1000; ++n) {
    z.push_back(n == 1000 ? 0 : (n % 2 == 0 ? 1 : -1) * (1 + n / 2));  // in pairs: mean 0
    text += std::to_string(n * 8) + "e2 " + std::to_string(z.back()) + "\n";
  }
  const auto heights = read(text, 8e5, 8e2);
  ASSERT_EQ(heights.size(), z.size());
  for (std::size_t n = 0; n < z.size(); ++n) EXPECT_EQ(heights[n], z[n]) << n;
}

TEST_F(ProfileFile, InterpolatesLinearlyBetweenPoints) {
  // z at 0, 0.5, ... 3 of points (0, 0), (1, 1), (2, 0), (3, 1): 0 0.5 1 0.5 0 0.5 1, mean 0.5.
  const std::vector<double> finer = {-0.5, 0, 0.5, 0, -0.5, 0, 0.5};
  EXPECT_EQ(read("0 0\n1 1\n2 0\n3 1\n", 3, 0.5), finer);
  // and at 0, 1.5, 3: 0 0.5 1.
  EXPECT_EQ(read("0 0\n1 1\n2 0\n3 1\n", 3, 1.5), (std::vector<double>{-0.5, 0, 0.5}));
}

TEST_F(ProfileFile, AllowsTheRoundingOfPrintedDigits) {
  // Steps of 1/7 mm with 6 decimals of a metre, or with 6 significant digits.
  std::string decimals, digits;
  char line[64];
  for (int n = 0; n <= 700; ++n) {
    std::snprintf(line, sizeof line, "%.6f %de-6\n", n * 1e-3 / 7, n % 2);
    decimals += line;
    std::snprintf(line, sizeof line, "%g %de-6\n", n * 1e-3 / 7, n % 2);
    digits += line;
  }
  EXPECT_EQ(read(decimals, 0.1, 1e-3 / 7).size(), 701);
  EXPECT_EQ(read(digits, 0.1, 1e-3 / 7), read(decimals, 0.1, 1e-3 / 7));
}

TEST_F(ProfileFile, AbsolutePathsStandAndRelativeOnesStartAtTheScene) {
  std::ofstream(folder / "two.txt") << "0 1\n3 1\n";
  EXPECT_EQ(read_existing("two.txt").size(), 4);
  EXPECT_EQ(read_existing(folder / "two.txt").size(), 4);
}

TEST_F(ProfileFile, NamesWhatCannotBeRead) {
  for (const char* path : {"missing.csv", "."}) {
    try {
      read_existing(path);
      ADD_FAILURE() << path;
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr((folder / path).string()));
    }
  }
}

TEST_F(ProfileFile, RefusesAFileOfMoreThanAGibibyte) {
  std::ofstream text(folder / "large.csv");
  for (int i = 0; i < 2000; ++i) text << i << " 1\n";
  text.close();
  std::filesystem::resize_file(folder / "large.csv", (1u << 30) + 1);  // sparse
  try {
    read_existing("large.csv");
    ADD_FAILURE();
  } catch (const RequestError& error) {
    EXPECT_THAT(error.what(), HasSubstr("1 GiB"));
  }
}

TEST_F(ProfileFile, SaysWhichLineIsWrongAndWhy) {
  EXPECT_THAT(fault("0 1\n1 two\n2 3\n3 4\n"), HasSubstr("profile.csv:2: \"two\" is not a number"));
  EXPECT_THAT(fault("0 1\n1 2\n\n2 0x3\n3 4\n"), HasSubstr(":4: \"0x3\" is not a number"));
  EXPECT_THAT(fault("0;1\n1;2\n2;3\n"), HasSubstr("x runs over 2 in steps of 1, without a unit"));
  EXPECT_THAT(fault("0 1\n1 +-2\n2 3\n3 4\n"), HasSubstr(":2: \"+-2\" is not a number"));
  EXPECT_THAT(fault("0 1\n1 nan\n2 3\n3 4\n"), HasSubstr(":2: a height is missing: fill = "));
  EXPECT_THAT(fault("0 1\n1 NA\n2 3\n3 4\n"), HasSubstr(":2: a height is missing: fill = "));
  EXPECT_THAT(fault("0 1\nnan 2\n2 3\n3 4\n"), HasSubstr(":2: \"nan\" is not a finite number"));
  EXPECT_THAT(fault("0 1\n1 1e999\n2 3\n3 4\n"), HasSubstr(":2: \"1e999\" is not a finite number"));
  EXPECT_THAT(fault("0 1\n1 2 3\n2 3\n3 4\n"), HasSubstr(":2: 3 columns, expected 2"));
  EXPECT_THAT(fault("0 1\n1,2,\n2 3\n3 4\n"), HasSubstr(":2: 3 columns, expected 2"));
  EXPECT_THAT(fault("0 1\n1,,2\n2 3\n3 4\n"), HasSubstr(":2: 3 columns, expected 2"));
  EXPECT_THAT(fault("0 1\n1 2\n1 3\n2 4\n"), HasSubstr(":3: x = 1 m does not increase"));
  EXPECT_THAT(fault("0 1\n1 2\n3 3\n4 4\n"),
              HasSubstr(":3: x steps by 2 m, expected an even spacing of 1 m"));
  EXPECT_THAT(fault("0 1\n1e-3 2\n2.1e-3 3\n3.2e-3 4\n4.3e-3 1\n"),
              HasSubstr(":2: x steps by 0.001 m, expected an even spacing of 0.0011 m"));
  EXPECT_THAT(fault("0.0000000 1\n1.0000000 2\n2.0000021 3\n3.0000021 4\n"), HasSubstr(":3: "));
  EXPECT_THAT(fault("x z\n1 2\n"), HasSubstr("1 points, expected at least 2"));
  EXPECT_THAT(fault(""), HasSubstr("no line of numbers, expected columns x and z"));
  EXPECT_THAT(fault("0 1 2\n1 2 3\n"),
              HasSubstr(":1: 3 columns, expected x and z; say with column"));
  EXPECT_THAT(fault("0 1\n1 2\n2 3\n"), HasSubstr("the profile is 2 m long and the beam 3 m"));
}

TEST_F(ProfileFile, AcceptsSpacingsWithinTheTolerance) {
  EXPECT_EQ(fault("0.0000000 1\n1.0000000 2\n2.0000009 3\n3.0000000 4\n"), "no error");
}

TEST_F(ProfileFile, NamesTheFirstTenFaultsInOrder) {
  std::string text = "0 1\n1 2\n1 2\n3 bad\n";
  for (int i = 0; i < 20; ++i) text += "oops 1\n";
  const std::string message = fault(text);
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 10) << message;
  EXPECT_LT(message.find(":3: x = 1 m does not increase"), message.find(":4: \"bad\""));
  EXPECT_THAT(message, HasSubstr(":11: \"oops\""));
  EXPECT_THAT(message, Not(HasSubstr(":12:")));
  EXPECT_THAT(message, HasSubstr("more faults"));
}

/// A rough face as a stylus writes it, in these units [m].
struct MeasuredProfile : ProfileFile {
  static std::string text(double x_unit, double z_unit, double rq = 8e-6, double length = 0.02) {
    std::mt19937_64 random(7);
    std::string text;
    double z = 0;
    for (int n = 0; n * 8e-6 <= length * 1.01; ++n) {
      const double noise = 0x1p-63 * static_cast<double>(random()) - 1;  // of variance 1/3
      z = 0.95 * z + 0.54 * rq * noise;
      text += fmt::format("{:.9e},{:.4e}\n", n * 8e-6 / x_unit, z / z_unit);
    }
    return text;
  }
  /// Read for a cube of 20 mm, or as given.
  std::string said(const std::string& text, double thickness = 0.02, double length = 0.02) {
    std::ofstream(folder / "profile.csv", std::ios::binary) << text;
    SurfaceSpec spec;
    spec.kind = SurfaceKind::file;
    spec.path = "profile.csv";
    doubts.clear();
    try {
      make_surface(spec, length, 8e-6, folder / "scene.toml", thickness, &doubts);
    } catch (const RequestError& error) {
      return error.what();
    }
    return "fine";
  }
  std::vector<std::string> doubts;
};

TEST_F(MeasuredProfile, InMetresIsReadWithoutAWord) {
  for (const double rq : {1e-8, 1e-6, 4e-6}) {
    EXPECT_EQ(said(text(1, 1, rq)), "fine");
    EXPECT_THAT(doubts, testing::IsEmpty());
  }
  // of a whole plate for a small pin, which is rigid; and a flat face of two points
  EXPECT_EQ(said(text(1, 1, 4e-6, 0.3), 0, 0.001), "fine");
  EXPECT_EQ(said("0 0\n1 0\n", 0.002, 0.3), "fine");
  // a bowed sheet
  EXPECT_EQ(said("0 0\n0.15 5e-5\n0.3 0\n", 0.002, 0.3), "fine");
  EXPECT_THAT(doubts, testing::IsEmpty());
}

TEST_F(MeasuredProfile, ThatIsRareIsDoubted) {
  // z in mm of a smooth face on a plate, in waves of 1.6 mm: an Rq of 0.1 um reads as 0.1 mm
  const auto waves = [](double amplitude, double x_unit = 1) {
    std::string text;
    for (int n = 0; n <= 2600; ++n) {
      const double x = n * 8e-6;
      text += fmt::format("{:.9e},{:.4e}\n", x / x_unit, amplitude * std::sin(4000 * x));
    }
    return text;
  };
  EXPECT_EQ(said(waves(1.4e-4), 0.002), "fine");
  EXPECT_THAT(doubts, testing::ElementsAre(AllOf(
                          HasSubstr("profile.csv:"),
                          HasSubstr("the heights span 0.00028 m, 14 % of the beam's thickness: "
                                    "are they in metres?"))));
  // a root mean square slope of 1.4e-4 * 4000 / sqrt(2)
  EXPECT_EQ(said(waves(1.4e-4), 0.02), "fine");
  EXPECT_THAT(doubts, testing::ElementsAre(
                          HasSubstr("the slopes have a root mean square of 0.4, and few")));
  EXPECT_THAT(said(waves(4e-4), 0.02),
              AllOf(HasSubstr("root mean square of 1.13, steeper than any face"),
                    HasSubstr("is z in mm?")));
  EXPECT_THAT(said(waves(1.1e-4, 1), 4e-4), HasSubstr("is z in mm?"));  // through half of it
  EXPECT_EQ(said(waves(1e-6, 0.0254)), "fine");
  EXPECT_THAT(doubts, testing::Contains(HasSubstr("times as long: is it in inches?")));
  EXPECT_THAT(said(waves(1e-6, 2.54e-5)), HasSubstr("is it in mils?"));
  // one spike, 60 times as high as the rest, is no unit
  EXPECT_THAT(said("0 0\n5e-3 5e-5\n1e-2 3e-3\n1.5e-2 0\n2e-2 4e-5\n", 0.002),
              AllOf(HasSubstr(":3: a height of 0.003 m"), HasSubstr("is there a digit missing?")));
}

TEST_F(MeasuredProfile, InAnotherUnitIsRefusedWithThatUnit) {
  constexpr double mm = 1e-3, um = 1e-6;
  EXPECT_THAT(said(text(mm, mm)),
              AllOf(HasSubstr("profile.csv:2526: x runs over 20.2 for a beam of "
                              "0.02 m: is it in mm?"),
                    HasSubstr("multiply x by 1e-3")));
  EXPECT_THAT(said(text(mm, um)), HasSubstr("is it in mm?"));
  EXPECT_THAT(said(text(mm, 1)), HasSubstr("is it in mm?"));
  EXPECT_THAT(said(text(um, um)),
              AllOf(HasSubstr("is it in um?"), HasSubstr("multiply x by 1e-6")));
  EXPECT_THAT(
      said(text(1, mm)),
      HasSubstr("is z in mm? Heights are read in metres: set z_unit = \"mm\", or multiply z "
                "by 1e-3"));
  EXPECT_THAT(said(text(1, um)),
              AllOf(HasSubstr("on a beam 0.02 m thick"), HasSubstr("is z in um?")));
  // a rigid body may have no thickness
  EXPECT_THAT(said(text(1, um), 0),
              AllOf(HasSubstr("on a beam 0.02 m long"), HasSubstr("is z in um?")));
  // too short in truth, but not as it is read
  EXPECT_THAT(said(text(mm, mm, 8e-6, 0.01)), HasSubstr("is z in mm?"));
  EXPECT_THAT(said(text(mm, um, 8e-6, 0.01)), HasSubstr("is z in um?"));
  // a lapped face: its heights are not out of all proportion, but it is said how coarse it is
  EXPECT_EQ(said(text(mm, mm, 1e-8, 0.01)), "fine");
  EXPECT_THAT(doubts, testing::ElementsAre(HasSubstr("1000 nodes of the scene")));
}

TEST_F(MeasuredProfile, CutOffInItsLastNumberIsRefusedOrSaid) {
  const auto cut = [](std::size_t bytes) {
    return text(1, 1, 4e-6) + "2.020800000e-02," + std::string("-3.1234e-07").substr(0, bytes);
  };
  for (const std::size_t bytes : {2, 5, 7, 10})  // -3, -3.12, -3.1234, -3.1234e-0
    EXPECT_THAT(
        said(cut(bytes)),
        AllOf(HasSubstr(":2527: the line has no end, and its height of -3"),
              HasSubstr("is far from all others"), HasSubstr("Complete the line, or drop it")));
  for (const std::size_t bytes : {0, 1, 8, 9})  // no number
    EXPECT_THAT(said(cut(bytes)),
                AllOf(HasSubstr(":2527: "), HasSubstr("was the file cut off here?")));
  for (const char* end : {"", "\n"}) {
    EXPECT_EQ(said(cut(11) + end), "fine");
    EXPECT_THAT(doubts, testing::IsEmpty()) << "it has as many digits as all others";
  }
  // on an otherwise flat face nothing but the beam tells what is far
  const std::string flat = "0 0e-00\n1e-2 0e-00\n2e-2 0e-00\n3e-2 0e-00\n4e-2 -3e-0";
  EXPECT_THAT(said(flat), HasSubstr(":5: the line has no end, and its height of -3 m is far"));
  EXPECT_EQ(said(flat + "7"), "fine");
  EXPECT_THAT(doubts, testing::ElementsAre(HasSubstr("smoother than faces are")));
  // a slip anywhere else is no unit
  EXPECT_THAT(said("1e-2 0\n2e-2 1e-6\n3e-2 3\n4e-2 2e-6\n", 0.02, 0.03),
              AllOf(HasSubstr(":3: a height of 3 m"), HasSubstr("is there a digit missing?")));
}

TEST_F(MeasuredProfile, IsReadLineByLine) {
  // hundreds of megabytes, were the file or the words of a line held
  const auto peak = [] {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("VmHWM:")) return std::stol(line.substr(6));
    return 0L;
  };
  const auto write = [&](const std::string& part, int count, const std::string& end) {
    std::ofstream out(folder / "profile.csv", std::ios::binary);
    for (int i = 0; i < count; ++i) out << part;
    out << end;
  };
  const long before = peak();
  write(std::string(1 << 20, ','), 64, "");
  EXPECT_THAT(fault_of_file(), HasSubstr("profile.csv:1: a line of more than 65536 bytes"));
  std::string comment(60'000, '#');
  comment.back() = '\n';
  write(comment, 1000, "0 0\n3 0\n");
  EXPECT_EQ(fault_of_file(), "no error");
  EXPECT_LT(peak() - before, 20'000) << "kB";
}

TEST_F(ProfileFile, ShowsNoRawBytes) {
  EXPECT_THAT(fault("0 1\n1 \x1b[2J\n2 3\n3 4\n"), HasSubstr("\"?[2J\" is not a number"));
}

}  // namespace
