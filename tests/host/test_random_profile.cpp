// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/random_profile.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/johnson.hpp"
#include "tests/numbers.hpp"

/// Random profiles against theory: over many seeds, and each by itself.
namespace ra2d {
namespace {

using testing::HasSubstr;

using test::pi;
constexpr double profile_length = 0.3, rq = 8e-6;

SurfaceSpec random_surface() {
  SurfaceSpec s;
  s.kind = SurfaceKind::gaussian;
  s.rq = rq;
  return s;
}

SurfaceSpec with_moments(SurfaceSpec s, double skewness, double kurtosis) {
  s.skewness = skewness;
  s.kurtosis = kurtosis;
  return s;
}

SurfaceSpec gaussian_wave(double l) {
  SurfaceSpec s = random_surface();
  s.correlation_length = l;
  return s;
}

SurfaceSpec exponential_wave(double l, double shortest) {
  SurfaceSpec s = gaussian_wave(l);
  s.correlation = Correlation::exponential;
  s.shortest = shortest;
  return s;
}

SurfaceSpec self_affine(double hurst, double longest, double shortest) {
  SurfaceSpec s = random_surface();
  s.correlation = Correlation::self_affine;
  s.hurst = hurst;
  s.longest = longest;
  s.shortest = shortest;
  return s;
}

std::vector<double> heights(SurfaceSpec s, std::uint64_t seed, double spacing) {
  s.seed = seed;
  return random_heights(s, profile_length,
                        static_cast<int>(std::lround(profile_length / spacing)) + 1, spacing);
}

double mean_of(const std::vector<double>& values, const std::function<double(double)>& term) {
  double sum = 0;
  for (const double value : values) sum += term(value);
  return sum / static_cast<double>(values.size());
}

/// Simpson's rule over (a, b).
double integral(double a, double b, int parts, const std::function<double(double)>& f) {
  double sum = f(a) + f(b);
  for (int i = 1; i < parts; ++i) sum += (i % 2 == 1 ? 4 : 2) * f(a + (b - a) * i / parts);
  return sum * (b - a) / parts / 3;
}

double normal_density(double g) { return std::exp(-g * g / 2) / std::sqrt(2 * pi); }

/// Mean distance of upward crossings of the mean line.
double crossing_distance(const std::vector<double>& h, double spacing) {
  double first = 0, last = 0;
  int count = 0;
  for (std::size_t i = 0; i + 1 < h.size(); ++i) {
    if (!(h[i] < 0 && h[i + 1] >= 0)) continue;
    last = (static_cast<double>(i) - h[i] / (h[i + 1] - h[i])) * spacing;
    if (count++ == 0) first = last;
  }
  return (last - first) / (count - 1);
}

// ---- heights that are not normal

struct Wanted {
  double skewness, kurtosis;
};
// on both sides of the lognormal's line, and on it (skewness 1: kurtosis 4.8289)
const std::vector<Wanted> wanted_moments{
    {0, 4},     {0, 2},     {-0.8, 4.2}, {0.5, 2.6}, {1, 3},  {1.5, 5.2}, {-2, 9.5},
    {0, 3.001}, {0.3, 2.4}, {-0.2, 3.6}, {2.5, 15},  {0, 12}, {1, 4.83},  {1, 4.8290}};

TEST(JohnsonHeights, HasTheMomentsThatAreAsked) {
  for (const Wanted& wanted : wanted_moments) {
    SCOPED_TRACE(testing::Message() << wanted.skewness << ", " << wanted.kurtosis);
    const JohnsonHeights map(wanted.skewness, wanted.kurtosis);
    const auto moment = [&](int power) {
      return integral(-13, 13, 20000,
                      [&](double g) { return normal_density(g) * std::pow(map(g), power); });
    };
    EXPECT_NEAR(moment(1), 0, 1e-9);
    EXPECT_NEAR(moment(2), 1, 1e-8);
    EXPECT_NEAR(moment(3), wanted.skewness, 1e-5);
    EXPECT_NEAR(moment(4), wanted.kurtosis, 1e-4);
    EXPECT_NEAR(map(map.at_mean_line()), 0, 1e-12);
    for (double g = -6; g < 6; g += 0.25) EXPECT_LT(map(g), map(g + 0.25));
  }
}

TEST(JohnsonHeights, OfNormalMomentsLeavesHeightsAsTheyAre) {
  for (const JohnsonHeights& map : {JohnsonHeights(), JohnsonHeights(0, 3)}) {
    EXPECT_TRUE(map.is_identity());
    EXPECT_EQ(map(1.25), 1.25);
    EXPECT_EQ(map.correlation(0.3), 0.3);
    EXPECT_EQ(map.normal_correlation(0.3), 0.3);
    EXPECT_EQ(map.at_mean_line(), 0);
  }
}

TEST(JohnsonHeights, KnowsTheCorrelationOfItsHeights) {
  // E[z(g) z(rho g + sqrt(1 - rho^2) g')] by integration over the two of them
  for (const Wanted& wanted : {Wanted{-0.8, 4.2}, Wanted{1, 3}, Wanted{0, 6}}) {
    const JohnsonHeights map(wanted.skewness, wanted.kurtosis);
    for (const double rho : {-0.9, -0.3, 0.2, 0.6, 0.95}) {
      const double by_integration = integral(-9, 9, 400, [&](double a) {
        return normal_density(a) * map(a) * integral(-9, 9, 400, [&](double b) {
                 return normal_density(b) * map(rho * a + std::sqrt(1 - rho * rho) * b);
               });
      });
      EXPECT_NEAR(map.correlation(rho), by_integration, 1e-7) << rho;
      EXPECT_NEAR(map.normal_correlation(map.correlation(rho)), rho, 1e-9);
    }
    EXPECT_EQ(map.normal_correlation(1), 1);
    EXPECT_EQ(map.normal_correlation(-1), -1);
  }
}

TEST(JohnsonHeights, RefusesMomentsThatNoSurfaceHas) {
  for (const Wanted& wanted : {Wanted{0, 1}, Wanted{1, 2.3}, Wanted{0, 100}, Wanted{3, 5},
                               Wanted{std::nan(""), 3}, Wanted{0, std::nan("")}})
    EXPECT_THROW(JohnsonHeights(wanted.skewness, wanted.kurtosis), RequestError)
        << wanted.skewness << ", " << wanted.kurtosis;
}

// ---- profiles, over many seeds

struct Kind {
  std::string name;
  SurfaceSpec surface;
  std::function<double(double)> correlation;  // at a distance [m]
};

/// Of waves with this density in wave number: int S cos(k x) dk/int S dk.
std::function<double(double)> of_waves(double least, double most,
                                       const std::function<double(double)>& density) {
  constexpr int parts = 20000;
  const double all = integral(least, most, parts, density);
  return [=](double x) {
    return integral(least, most, parts, [&](double k) { return density(k) * std::cos(k * x); }) /
           all;
  };
}

std::vector<Kind> kinds() {
  const double l = 4e-4, shortest = 4e-5, longest = 4e-3, hurst = 0.7;
  const auto bell = [=](double x) { return std::exp(-x * x / l / l); };
  return {{"gaussian", gaussian_wave(l), bell},
          {"gaussian, skewed", with_moments(gaussian_wave(l), -0.8, 4.5), bell},
          {"gaussian, flat", with_moments(gaussian_wave(l), 0.2, 2.3), bell},
          {"exponential", exponential_wave(l, shortest),
           of_waves(0, 2 * pi / shortest, [=](double k) { return 1 / (1 + k * k * l * l); })},
          {"self-affine", self_affine(hurst, longest, shortest),
           of_waves(2 * pi / longest, 2 * pi / shortest,
                    [=](double k) { return std::pow(k, -1 - 2 * hurst); })}};
}

TEST(RandomProfile, HasTheCorrelationThatIsAskedOverManySeeds) {
  // With `exact` nothing the mean line alone is exact: it takes the variance of the mean, below
  // 2 memory/length = 1 % here, from every lag. The rest is scatter, which the seeds show
  // themselves.
  constexpr int seeds = 60;
  constexpr double spacing = 2e-5;
  for (const Kind& kind : kinds()) {
    SCOPED_TRACE(kind.name);
    SurfaceSpec surface = kind.surface;
    surface.exact = Exactly::nothing;
    const std::vector<int> lags{0, 5, 10, 20, 40, 100};
    std::vector<double> sum(lags.size()), squares(lags.size());
    for (int seed = 0; seed < seeds; ++seed) {
      const std::vector<double> h = heights(surface, static_cast<std::uint64_t>(seed), spacing);
      for (std::size_t k = 0; k < lags.size(); ++k) {
        const auto lag = static_cast<std::size_t>(lags[k]);
        double product = 0;
        for (std::size_t i = 0; i + lag < h.size(); ++i) product += h[i] * h[i + lag];
        product /= rq * rq * static_cast<double>(h.size() - lag);
        sum[k] += product;
        squares[k] += product * product;
      }
    }
    for (std::size_t k = 0; k < lags.size(); ++k) {
      const double mean = sum[k] / seeds;
      const double scatter = std::sqrt((squares[k] / seeds - mean * mean) / (seeds - 1));
      EXPECT_NEAR(mean, kind.correlation(lags[k] * spacing), 4 * scatter + 0.01)
          << "lag " << lags[k];
      EXPECT_LT(scatter, 0.02);  // or the test would say nothing
    }
  }
}

TEST(RandomProfile, CrossesItsMeanLineAsOftenAsRiceSays) {
  constexpr int seeds = 20;
  std::vector<SurfaceSpec> surfaces;
  for (const Kind& kind : kinds()) surfaces.push_back(kind.surface);
  for (SurfaceSpec s :
       {exponential_wave(4e-4, 4e-5), with_moments(gaussian_wave(4e-4), 1.2, 5.0)}) {
    s.correlation_length.reset();
    s.rsm = 1.2e-3;
    surfaces.push_back(s);
  }
  SurfaceSpec by_longest = self_affine(0.7, 4e-3, 4e-5);
  by_longest.shortest.reset();
  by_longest.rsm = 7e-4;
  surfaces.push_back(by_longest);
  for (const SurfaceSpec& surface : surfaces) {
    const RandomProfile profile = resolve_random(surface, profile_length);
    SCOPED_TRACE(testing::Message()
                 << static_cast<int>(surface.correlation) << ", rsm " << profile.rsm);
    if (surface.rsm) {
      EXPECT_NEAR(profile.rsm, *surface.rsm, 1e-9 * profile.rsm);
    }
    const double spacing = std::min(2e-5, profile.shortest / 16);
    double sum = 0, squares = 0;
    for (int seed = 0; seed < seeds; ++seed) {
      const double rate =
          1 / crossing_distance(heights(surface, 100 + static_cast<std::uint64_t>(seed), spacing),
                                spacing);
      sum += rate;
      squares += rate * rate;
    }
    const double mean = sum / seeds;
    const double scatter = std::sqrt((squares / seeds - mean * mean) / (seeds - 1));
    // nodes miss pairs of crossings between them: a share of (k chi)^2/24 of the shortest waves
    EXPECT_NEAR(mean * profile.rsm, 1, 4 * scatter * profile.rsm + 0.01);
    EXPECT_LT(scatter * profile.rsm, 0.03);
  }
}

TEST(RandomProfile, OfLognormalHeightsHasItsSpacingInClosedForm) {
  // Heights exp(s g), w = exp(s^2), of a correlation C = exp(-(x/l)^2) = (w^rho - 1)/(w - 1): the
  // normal ones have -rho''(0) = 2/l^2 (1 - 1/w)/ln w, and the mean line is at g = s/2. Two things
  // are left out. What no normal heights have, a variance below 0: where a/2 sqrt(1/2) exp(-k^2/8)
  // is above exp(-k^2/4), a = w - 1, in units of l beyond k = 5.7, 0.22 % of the curvature. And the
  // wave without end, sqrt(pi) l/period of the variance. Of the spacing it is half of either.
  const double w = 1.05, l = 1e-4, left_out = 0.0022 + std::sqrt(pi) * l / profile_length;
  const double skewness = (w + 2) * std::sqrt(w - 1), kurtosis = ((w + 2) * w + 3) * w * w - 3;
  for (const int side : {-1, 1}) {
    const RandomProfile profile =
        resolve_random(with_moments(gaussian_wave(l), side * skewness, kurtosis), profile_length);
    const double exact =
        2 * pi * l / std::sqrt(2 * (1 - 1 / w) / std::log(w)) * std::pow(w, 1.0 / 8);
    EXPECT_NEAR(profile.rsm, exact, 0.5 * left_out * exact);
  }
}

TEST(RandomProfile, HasTheHeightsThatAreAsked) {
  // Kolmogorov-Smirnov over places that have nothing to do with each other: P(z <= map(g)) =
  // Phi(g).
  const SurfaceSpec spec = with_moments(gaussian_wave(4e-4), -0.8, 4.5);
  SurfaceSpec surface = spec;
  surface.exact = Exactly::nothing;
  const JohnsonHeights map(*spec.skewness, *spec.kurtosis);
  std::vector<double> all;
  for (int seed = 0; seed < 40; ++seed)
    for (const double h : heights(surface, 1000 + static_cast<std::uint64_t>(seed), 2.5e-3))
      all.push_back(h / rq);
  std::sort(all.begin(), all.end());
  double worst = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    double low = -10, high = 10;  // the normal number of this height
    while (high - low > 1e-9) (map(0.5 * (low + high)) < all[i] ? low : high) = 0.5 * (low + high);
    const double f = std::erfc(-low / std::sqrt(2)) / 2, n = static_cast<double>(all.size());
    worst = std::max({worst, std::abs(f - static_cast<double>(i) / n),
                      std::abs(f - static_cast<double>(i + 1) / n)});
  }
  EXPECT_GT(all.size(), 4000u);
  EXPECT_LT(worst * std::sqrt(static_cast<double>(all.size())), 1.95);
}

// ---- profiles, each of them

TEST(RandomProfile, IsTheSameAtAnySpacing) {
  for (const Kind& kind : kinds()) {
    SCOPED_TRACE(kind.name);
    const std::vector<double> coarse = heights(kind.surface, 7, 4e-5),
                              fine = heights(kind.surface, 7, 1e-5);
    for (std::size_t i = 0; i < coarse.size(); ++i) ASSERT_NEAR(coarse[i], fine[4 * i], 1e-12 * rq);
  }
}

TEST(RandomProfile, OfAnotherSeedIsAnother) {
  for (const Kind& kind : kinds())
    EXPECT_GT(std::abs(heights(kind.surface, 7, 1e-4)[100] - heights(kind.surface, 8, 1e-4)[100]),
              1e-3 * rq);
}

TEST(RandomProfile, HasItsRqExactly) {
  // the trapezoidal rule over the nodes is off by what the two ends have, h^2 chi/length
  for (const Kind& kind : kinds())
    for (const std::uint64_t seed : {1, 2, 3}) {
      const std::vector<double> h = heights(kind.surface, seed, 5e-6);
      EXPECT_NEAR(mean_of(h, [](double v) { return v; }), 0, 1e-4 * rq);
      EXPECT_NEAR(std::sqrt(mean_of(h, [](double v) { return v * v; })), rq, 1e-4 * rq);
    }
}

TEST(RandomProfile, HasItsRqInExpectationAlone) {
  SurfaceSpec surface = gaussian_wave(4e-4);
  surface.exact = Exactly::nothing;
  double least = 1, most = 1;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const double found =
        std::sqrt(mean_of(heights(surface, seed, 2e-5), [](double v) { return v * v; })) / rq;
    least = std::min(least, found);
    most = std::max(most, found);
  }
  // its spread is sqrt(l sqrt(pi/2)/2/length) = 2.9 %
  EXPECT_GT(least, 0.85);
  EXPECT_LT(least, 0.99);
  EXPECT_GT(most, 1.01);
  EXPECT_LT(most, 1.15);
}

TEST(RandomProfile, HasItsSpacingOfElementsExactly) {
  for (SurfaceSpec surface : {random_surface(), with_moments(random_surface(), 1, 5)})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      surface.rsm = 1.55e-3;
      const auto found = [&] {
        return crossing_distance(heights(surface, seed, 2e-6), 2e-6) / 1.55e-3;
      };
      EXPECT_GT(std::abs(found() - 1), 1e-4);
      surface.exact = Exactly::rq_and_rsm;
      EXPECT_NEAR(found(), 1, 1e-5);
      const std::vector<double> h = heights(surface, seed, 5e-6);
      EXPECT_NEAR(std::sqrt(mean_of(h, [](double v) { return v * v; })), rq, 1e-4 * rq);
      surface.exact = Exactly::rq;
    }
}

double slope(const std::vector<double>& h, double spacing) {
  double rises = 0;
  for (std::size_t i = 1; i < h.size(); ++i) rises += (h[i] - h[i - 1]) * (h[i] - h[i - 1]);
  return std::sqrt(rises / static_cast<double>(h.size() - 1)) / spacing;
}

/// The doubt names the share of the slope that nodes lose against far finer nodes, within the
/// scatter of one profile and the rounding to a per cent.
TEST(RandomProfile, SaysHowMuchSlopeNodesLose) {
  for (SurfaceSpec surface :
       {exponential_wave(4e-4, 4e-5), self_affine(0.8, 1e-3, 4e-5), gaussian_wave(6e-5)}) {
    const double fine = slope(heights(surface, 3, 1e-6), 1e-6);
    bool silent = false;
    for (const double spacing : {4e-5, 3.2e-5, 2e-5, 1e-5, 5e-6}) {
      std::vector<std::string> doubts;
      surface.seed = 3;
      const int nodes = static_cast<int>(std::lround(profile_length / spacing)) + 1;
      const std::vector<double> h =
          random_heights(surface, profile_length, nodes, spacing, &doubts);
      const double lost = 100 * (1 - slope(h, spacing) / fine);
      silent = doubts.empty();
      if (silent) {
        EXPECT_LT(lost, 5 + 1.5) << spacing;
      } else {
        ASSERT_EQ(doubts.size(), 1u);
        const std::size_t at = doubts[0].find(" lose ");
        ASSERT_NE(at, std::string::npos) << doubts[0];
        EXPECT_NEAR(std::stod(doubts[0].substr(at + 6)), lost, 1.5) << doubts[0];
        EXPECT_GT(lost, 5 - 1.5);
      }
    }
    EXPECT_TRUE(silent);  // at the finest
  }
}

/// The case of the issue: waves down to 5 um on nodes 4 um apart. Splines may go through them, too:
/// the doubt speaks of no straight lines.
TEST(RandomProfile, NamesTheSpacingThatWouldDo) {
  std::vector<std::string> doubts;
  const SurfaceSpec surface = exponential_wave(4e-4, 5e-6);
  random_heights(surface, 0.02, 5001, 4e-6, &doubts);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_THAT(doubts[0], testing::AllOf(testing::StartsWith("nodes 4e-06 m apart lose"),
                                        HasSubstr("shortest wave 5e-06 m")));
  const double would_do = std::stod(doubts[0].substr(doubts[0].find("A spacing of ") + 13));
  doubts.clear();
  random_heights(surface, 0.02, static_cast<int>(0.02 / would_do), would_do, &doubts);
  EXPECT_TRUE(doubts.empty());
}

TEST(RandomProfile, RefusesWhatDoesNotFitTogether) {
  const auto refusal = [](SurfaceSpec s) -> std::string {
    try {
      resolve_random(s, profile_length);
    } catch (const RequestError& fault) {
      return fault.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal(gaussian_wave(4e-4)), "accepted");
  EXPECT_THAT(refusal(random_surface()), HasSubstr("rsm or correlation_length"));
  EXPECT_THAT(refusal(exponential_wave(4e-4, 5e-4)),
              HasSubstr("not shorter than the correlation length"));
  EXPECT_THAT(refusal(exponential_wave(4e-4, 1e-11)), HasSubstr("too many"));
  EXPECT_THAT(refusal(self_affine(0.7, 1e-4, 1e-3)), HasSubstr("not shorter than the longest"));
  EXPECT_THAT(refusal(self_affine(1.2, 1e-3, 1e-4)), HasSubstr("between 0 and 1"));
  SurfaceSpec three = self_affine(0.7, 1e-3, 1e-4);
  three.rsm = 5e-4;
  EXPECT_THAT(refusal(three), HasSubstr("two of longest, shortest and rsm"));
  SurfaceSpec out_of_reach = self_affine(0.7, 1e-3, 1e-4);
  out_of_reach.longest.reset();
  out_of_reach.rsm = 5e-5;  // shorter than the shortest wave
  EXPECT_THAT(refusal(out_of_reach), HasSubstr("has an rsm of 5e-05 m"));
  SurfaceSpec too_fine = exponential_wave(4e-4, 1e-4);
  too_fine.correlation_length.reset();
  too_fine.rsm = 3e-4;  // with l = 1.01e-4 it is 3.4e-4
  EXPECT_THAT(refusal(too_fine), HasSubstr("has an rsm of 0.0003 m"));
  EXPECT_THAT(refusal(with_moments(gaussian_wave(4e-4), 2, 3)), HasSubstr("skewness"));
}

}  // namespace
}  // namespace ra2d
