// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/analysis.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <random>
#include <sstream>
#include <string>

#include "host/analysis/analysis_text.hpp"
#include "host/analysis/bands.hpp"
#include "host/analysis/distributions.hpp"
#include "host/analysis/means.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

namespace ra2d {
namespace {

using testing::AllOf;
using testing::DoubleEq;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<double> noise(std::size_t samples, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<double> values(samples);
  for (double& value : values) value = normal(engine);
  return values;
}

double mean_square(const std::vector<double>& x) {
  return std::inner_product(x.begin(), x.end(), x.begin(), 0.0) / static_cast<double>(x.size());
}

double sum(const std::vector<double>& x) { return std::accumulate(x.begin(), x.end(), 0.0); }

// ---- quantiles ---------------------------------------------------------------------------------

TEST(Distributions, QuantilesAreThoseOfTheTables) {
  // Abramowitz and Stegun, tables 26.8 and 26.10
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.84146, 1e-5);
  EXPECT_NEAR(chi_square_quantile(0.025, 10), 3.24697, 1e-5);
  EXPECT_NEAR(chi_square_quantile(0.995, 30), 53.6720, 1e-4);
  EXPECT_NEAR(chi_square_quantile(0.5, 100), 99.3341, 1e-4);
  EXPECT_NEAR(student_quantile(0.975, 1), 12.7062, 1e-4);
  EXPECT_NEAR(student_quantile(0.975, 4), 2.77645, 1e-5);
  EXPECT_NEAR(student_quantile(0.95, 30), 1.69726, 1e-5);
  EXPECT_NEAR(student_quantile(0.025, 4), -2.77645, 1e-5);
  // in closed form: chi-square of 2 is exponential; Student's of 1 and of 2
  EXPECT_NEAR(chi_square_quantile(0.3, 2), -2 * std::log(0.7), 1e-14);
  EXPECT_NEAR(student_quantile(0.9, 1), std::tan(M_PI * 0.4), 1e-12);
  EXPECT_NEAR(student_quantile(0.9, 2), 0.8 / std::sqrt(2 * 0.9 * 0.1), 1e-12);
}

TEST(Distributions, ManyDegreesOfFreedomComeNearTheNormalOne) {
  const double n = 1e6;  // Wilson and Hilferty
  const double cube = 1 - 2 / (9 * n) + 1.959963984540054 * std::sqrt(2 / (9 * n));
  EXPECT_NEAR(chi_square_quantile(0.975, n) / (n * cube * cube * cube), 1, 1e-9);
  EXPECT_NEAR(student_quantile(0.975, n), 1.959963984540054, 1e-5);
}

TEST(MeanOfRuns, HasTheIntervalOfStudent) {
  const MeanOfRuns m = mean_of_runs({1, 2, std::nan(""), 3, 4, 5});
  EXPECT_EQ(m.count, 5u);
  EXPECT_DOUBLE_EQ(m.mean, 3);
  EXPECT_DOUBLE_EQ(m.deviation, std::sqrt(2.5));
  EXPECT_NEAR(m.high - 3, 2.776445 * std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(3 - m.low, 2.776445 * std::sqrt(0.5), 1e-6);
  const MeanOfRuns one = mean_of_runs({7});
  EXPECT_EQ(one.mean, 7);
  EXPECT_TRUE(std::isnan(one.low));
  EXPECT_EQ(mean_of_runs({}).count, 0u);
}

// ---- spectrum ----------------------------------------------------------------------------------

TEST(Welch, OneWholeRectangularWindowHasTheMeanSquare) {
  for (const std::size_t samples : {1000, 1001}) {  // with a line at half the rate, and without
    const std::vector<double> x = noise(samples, 1);
    Welch welch({48e3, samples, samples, Window::rectangular});
    const double total = sum(welch.density(x)) * 48e3 / static_cast<double>(samples);
    EXPECT_NEAR(total / mean_square(x), 1, 1e-12) << samples;
  }
}

TEST(Welch, ASineStandsAtItsPlaceWithItsPower) {
  constexpr double rate = 1000, frequency = 125, amplitude = 3;
  std::vector<double> x(10'000);
  for (std::size_t n = 0; n < x.size(); ++n)
    x[n] = amplitude * std::sin(2 * M_PI * frequency * static_cast<double>(n) / rate + 0.3);
  const Segments segments = half_overlapping(rate, 400);  // 125 Hz is line 50
  Welch welch(segments);
  const std::vector<double> density = welch.density(x);
  EXPECT_EQ(std::max_element(density.begin(), density.end()) - density.begin(), 50);
  EXPECT_EQ(welch.frequencies()[50], frequency);
  // Hann: a line and a quarter of it on either side, 1.5 lines in all
  const double power = amplitude * amplitude / 2;
  EXPECT_NEAR(density[50], power / (1.5 * segments.resolution()), 1e-9);
  EXPECT_NEAR(density[49] / density[50], 0.25, 1e-9);
  EXPECT_NEAR(sum(density) * segments.resolution(), power, 1e-9);
}

/// Of 400 lines 95 % should hold the true density; 20 may miss it by chance, give or take 4.4.
TEST(Welch, WhiteNoiseIsWithinItsIntervals) {
  constexpr double rate = 2000;
  const std::vector<double> x = noise(40'000, 2);
  const Segments segments = half_overlapping(rate, 802);
  Welch welch(segments);
  const double truth = 2 / rate;
  const Confidence c = confidence_of_density(welch.degrees_of_freedom(x.size()));
  const std::vector<double> density = welch.density(x);
  int outside = 0;
  for (std::size_t j = 1; j + 1 < density.size(); ++j)
    outside += truth < c.low * density[j] || truth > c.high * density[j];
  EXPECT_EQ(density.size(), 402u);
  EXPECT_NEAR(outside, 20, 3.5 * 4.4);
  EXPECT_NEAR(sum(density) * segments.resolution() / mean_square(x), 1, 0.02);
}

TEST(Welch, OverlapTakesDegreesOfFreedom) {
  // without overlap 2 a segment
  EXPECT_DOUBLE_EQ(Welch({1, 64, 64, Window::hann}).degrees_of_freedom(640), 20);
  // Hann at a half: neighbours share (1/6)^2 of their variance
  const double k = 19;
  EXPECT_NEAR(Welch(half_overlapping(1, 64)).degrees_of_freedom(640),
              2 * k / (1 + 2 * (1 - 1 / k) / 36), 1e-6);
  // as many segments again as without overlap give nearly twice, a repeated one nothing
  EXPECT_NEAR(Welch({1, 64, 1, Window::rectangular}).degrees_of_freedom(65), 2, 0.05);
}

TEST(Welch, HasNothingOfLessThanASegment) {
  EXPECT_TRUE(Welch(half_overlapping(1, 64)).density(noise(63, 1)).empty());
  EXPECT_EQ(usual_segment(100'001), 8192u);
  EXPECT_EQ(usual_segment(15), 0u);
}

// ---- third octaves -----------------------------------------------------------------------------

/// A frequency of the norm's limits for octaves, brought to third octaves (its formulas 9 and 10).
double mapped(double octaves_ratio) {
  const double g = std::pow(10.0, 0.3);
  if (octaves_ratio < 1) return 1 / mapped(1 / octaves_ratio);
  return 1 + (std::pow(g, 1.0 / 6) - 1) / (std::pow(g, 0.5) - 1) * (octaves_ratio - 1);
}

TEST(ThirdOctaves, KeepTheLimitsOfClassOne) {
  const double g = std::pow(10.0, 0.3);
  const auto attenuation = [&](double exponent) {  // dB, at G^exponent
    return -10 * std::log10(
                     third_octave_share(3, third_octave_centre(3) * mapped(std::pow(g, exponent))));
  };
  struct Limit {
    double exponent, least, most;
  };
  const double inf = std::numeric_limits<double>::infinity(), just = 1e-9;
  for (const double side : {-1, 1})
    for (const Limit& limit : {Limit{0, -0.4, 0.4},
                               {1.0 / 8, -0.4, 0.5},
                               {1.0 / 4, -0.4, 0.7},
                               {3.0 / 8, -0.4, 1.4},
                               {0.5 - just, -0.4, 5.3},
                               {0.5 + just, 1.2, inf},
                               {1, 16.6, inf},
                               {2, 40.5, inf},
                               {3, 60, inf},
                               {4, 70, inf},
                               {5, 70, inf}}) {
      const double found = attenuation(side * limit.exponent);
      EXPECT_GE(found, limit.least) << side * limit.exponent;
      EXPECT_LE(found, limit.most) << side * limit.exponent;
    }
}

TEST(ThirdOctaves, PassAsMuchAsIdealOnes) {
  double passed = 0;  // integral of the share over ln f, of noise like 1/f
  constexpr double step = 1e-5;
  for (double x = -3 + step / 2; x < 3; x += step)
    passed += step * third_octave_share(0, 1000 * std::exp(x));
  EXPECT_NEAR(10 * std::log10(passed / (0.1 * std::log(10.0))), 0, 0.02);  // the norm: 0.4 dB
}

TEST(ThirdOctaves, NeighboursAddUp) {
  for (double x = -1; x <= 1; x += 1e-3) {
    double all = 0;
    for (int band = -6; band <= 6; ++band)
      all += third_octave_share(band, third_octave_centre(0) * std::pow(10.0, x / 10));
    EXPECT_GT(10 * std::log10(all), -1.8);  // the norm
    EXPECT_LT(10 * std::log10(all), 0.8);
    EXPECT_NEAR(10 * std::log10(all), 0, 0.32) << x;
  }
}

TEST(ThirdOctaves, AreNamedByTheirNominalFrequency) {
  std::vector<std::string> names;
  for (const int x : {-20, -15, -4, -1, 0, 1, 11, 13}) names.push_back(third_octave_name(x));
  EXPECT_THAT(names, ElementsAre("10", "31.5", "400", "800", "1000", "1250", "12500", "20000"));
  EXPECT_NEAR(third_octave_centre(1), 1258.9254, 1e-4);
  EXPECT_NEAR(third_octave_centre(-15), 31.622777, 1e-6);
}

TEST(ThirdOctaves, AreLeftOutWhereTheStretchCannotCarryThem) {
  // up to an edge of 0.5 kHz; 0.23 f_m cycles a second, 4 of them in two seconds
  const std::vector<int> bands = carried_bands(1000, 2);
  EXPECT_EQ(third_octave_name(bands.back()), "400");
  EXPECT_EQ(third_octave_name(bands.front()), "10");
  EXPECT_TRUE(carried_bands(1000, 1e-3).empty());
}

TEST(ThirdOctaves, ASineIsInItsBandWithItsPower) {
  constexpr double rate = 8000;
  std::vector<double> x(8003), power;  // of a length that zeros are added to
  for (std::size_t n = 0; n < x.size(); ++n)
    x[n] = std::sin(2 * M_PI * 1000 * static_cast<double>(n) / rate);
  WholeSpectrum whole(x.size(), rate);
  whole.add(x, 2.0, power);
  EXPECT_NEAR(sum(power) / (2 * mean_square(x)), 1, 1e-12);
  const std::vector<double> bands = band_powers({-1, 0, 1}, whole, power);
  EXPECT_NEAR(bands[1], 1, 0.01);
  EXPECT_LT(bands[0], 0.01);
  EXPECT_LT(bands[2], 0.01);
}

TEST(AWeighting, IsThatOfTheNorm) {
  // IEC 61672-1, table 3, which rounds to 0.1 dB; by the exact frequencies 10^(n/10)
  const std::pair<int, double> table[] = {{10, -70.4}, {13, -50.5}, {17, -30.2}, {20, -19.1},
                                          {23, -10.9}, {27, -3.2},  {30, 0},     {34, 1.3},
                                          {37, 0.5},   {40, -2.5},  {43, -9.3}};
  for (const auto& [n, weighting] : table)
    EXPECT_NEAR(a_weighting(std::pow(10.0, n / 10.0)), weighting, 0.051) << n;
  EXPECT_EQ(a_weighting(1000), 0);
}

TEST(AWeighting, WeighsALineByItsFrequency) {
  std::vector<double> x(1000), power;
  for (std::size_t n = 0; n < x.size(); ++n)
    x[n] = std::sin(2 * M_PI * static_cast<double>(n) / 10);
  WholeSpectrum whole(x.size(), 1000);  // 100 Hz
  whole.add(x, 1, power);
  EXPECT_NEAR(10 * std::log10(sum(a_weighted(whole, power)) / sum(power)), -19.1, 0.1);
}

// ---- peaks -------------------------------------------------------------------------------------

/// Density of a mode's velocity under white force.
double resonance(double f, double natural, double zeta) {
  const double x = f / natural;
  return x * x / ((1 - x * x) * (1 - x * x) + 4 * zeta * zeta * x * x);
}

Lines resonances(std::vector<double>& density, double resolution, std::vector<double> natural,
                 double zeta) {
  density.assign(2001, 0.0);
  for (std::size_t j = 0; j < density.size(); ++j)
    for (const double f : natural)
      density[j] += resonance(static_cast<double>(j) * resolution, f, zeta);
  return {resolution, density};
}

TEST(Peaks, StandAtTheHighestLineNearAMode) {
  std::vector<double> density;
  const Lines lines = resonances(density, 1.0, {1000}, 0.02);
  const auto peaks = find_peaks(lines, {0, 1003}, 0.02);  // near, not at, the natural frequency
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_EQ(peaks[0].mode, 1u);
  EXPECT_EQ(peaks[0].natural, 1003);
  EXPECT_NEAR(peaks[0].frequency, 1000, 1);
  const double top = density[1000];  // of lines that are averaged over a fifth of the width
  EXPECT_LT(peaks[0].density, top);
  EXPECT_GT(peaks[0].density, 0.97 * top);
}

TEST(Peaks, AreLeftOutWhereTheyCouldBeAnyones) {
  std::vector<double> density;
  const Lines lines = resonances(density, 1.0, {1000}, 0.02);
  EXPECT_TRUE(std::isnan(find_peaks(lines, {1500}, 0.02)[0].frequency));  // only a slope there
  EXPECT_TRUE(std::isnan(find_peaks(lines, {1000, 1002}, 0.02)[0].frequency));  // which of the two?
  EXPECT_FALSE(std::isnan(find_peaks(lines, {1000, 1010}, 0.02)[0].frequency));
  EXPECT_TRUE(find_peaks(lines, {3000}, 0.02).empty());  // beyond the spectrum
}

TEST(Peaks, OnATonesMultiplesAreTheMeshs) {
  std::vector<double> density;
  auto peaks = find_peaks(resonances(density, 1.0, {1000}, 0.02), {1000}, 0.02);
  mark_mesh(peaks, 400, 1);
  EXPECT_FALSE(peaks[0].of_mesh);
  mark_mesh(peaks, 499, 1);
  EXPECT_TRUE(peaks[0].of_mesh);
  EXPECT_EQ(peaks[0].half_power.why, NoDamping::mesh);
  EXPECT_TRUE(std::isnan(peaks[0].half_power.damping));
}

TEST(RiseAt, IsAboveTheMedianAround) {
  std::vector<double> density(100, 2.0);
  density[51] = 200;
  EXPECT_NEAR(rise_at({5, density}, 250), 20, 1e-12);
  EXPECT_NEAR(rise_at({5, density}, 300), 0, 1e-12);
  EXPECT_TRUE(std::isnan(rise_at({5, density}, 480)));
  EXPECT_TRUE(std::isnan(rise_at({5, density}, 10)));
}

// ---- half-power damping ------------------------------------------------------------------------

/// The velocity of modes under white force: each sample is the last one after the free motion of a
/// sample's time, and a normal impulse of the covariance that the force gives in that time (both
/// exact). They begin with the motion that the force has given them, so that they are stationary.
class DrivenModes {
 public:
  DrivenModes(double natural, double zeta, double rate, unsigned seed) : engine_(seed) {
    const double omega = 2 * M_PI * natural, decay = zeta * omega,
                 turn = omega * std::sqrt(1 - zeta * zeta);
    const double c = std::cos(turn / rate), s = std::sin(turn / rate) / turn,
                 e = std::exp(-decay / rate);
    step_[0] =
        e * (c + decay * s);  // displacement from displacement, from velocity; velocity from both
    step_[1] = e * s;
    step_[2] = -e * omega * omega * s;
    step_[3] = e * (c - decay * s);
    const double uu = 1 / (omega * omega),
                 vv = 1;  // stationary, where the velocity's mean square is 1
    const double q_uu = uu - (step_[0] * step_[0] * uu + step_[1] * step_[1] * vv);
    const double q_uv = -(step_[0] * step_[2] * uu + step_[1] * step_[3] * vv);
    const double q_vv = vv - (step_[2] * step_[2] * uu + step_[3] * step_[3] * vv);
    root_[0] = std::sqrt(q_uu);
    root_[1] = q_uv / root_[0];
    root_[2] = std::sqrt(q_vv - root_[1] * root_[1]);
    u_ = normal_(engine_) / omega;
    v_ = normal_(engine_);
  }
  std::vector<double> velocity(std::size_t samples) {
    std::vector<double> found(samples);
    for (double& value : found) {
      value = v_;
      const double a = normal_(engine_), b = normal_(engine_);
      const double u = step_[0] * u_ + step_[1] * v_ + root_[0] * a;
      v_ = step_[2] * u_ + step_[3] * v_ + root_[1] * a + root_[2] * b;
      u_ = u;
    }
    return found;
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  double step_[4], root_[3], u_ = 0, v_ = 0;
};

HalfPower half_power_of(const std::vector<double>& velocity, double rate, double natural,
                        double expected) {
  WholeSpectrum whole(velocity.size(), rate);
  std::vector<double> lines;
  whole.add(velocity, 1, lines);
  return half_power({whole.frequency(1), lines, whole.independent()},
                    place_of_mode(std::vector<double>{natural}, 0, expected));
}

/// Two hundred seconds of a mode, one by one: the damping comes out, and the errors are what they
/// are said to be. The mean may miss by 3.5 of its own standard errors, and by what one second
/// turns the curve (a share of 1/(pi width)). ln(found/true) over its error is normal: the mean
/// square of 200 is 1, give or take 4 sqrt(2/200).
TEST(HalfPower, IsThatOfAnOscillatorUnderWhiteNoise) {
  constexpr double rate = 16'000;
  for (const auto& [natural, zeta] : {std::pair{1000.0, 0.02}, {3000.0, 0.01}, {900.0, 0.05}}) {
    constexpr int runs = 200;
    double sum = 0, squares = 0, error = 0;
    for (unsigned run = 0; run < runs; ++run) {
      const auto velocity = DrivenModes(natural, zeta, rate, 100 + run).velocity(16'003);
      const HalfPower h = half_power_of(velocity, rate, 1.03 * natural, run % 2 ? 0.02 : NAN);
      ASSERT_EQ(h.why, NoDamping::found) << natural << ' ' << run;
      EXPECT_NEAR(h.frequency, natural, 4 * zeta * natural * h.error / h.damping) << run;
      sum += h.damping / zeta - 1;
      squares += std::pow(std::log(h.damping / zeta) * h.damping / h.error, 2);
      error += h.error / h.damping / runs;
    }
    const double width = 2 * zeta * natural;
    EXPECT_NEAR(error, 1.52 / std::sqrt(M_PI * width), 0.1 * error);
    EXPECT_NEAR(sum / runs, 0, 3.5 * error / std::sqrt(runs) + 2 / (M_PI * width)) << natural;
    EXPECT_NEAR(squares / runs, 1, 4 * std::sqrt(2.0 / runs)) << natural;
  }
}

/// Lines that chance does not move are the curve itself.
TEST(HalfPower, OfACurveWithoutChanceIsExact) {
  std::vector<double> density;
  for (const double resolution : {1.0, 0.37}) {  // single lines, and groups of them
    const Lines lines = resonances(density, resolution, {600}, 0.03);
    const HalfPower h = half_power({resolution, lines.density, 1},
                                   place_of_mode(std::vector<double>{615}, 0, 0.02));
    EXPECT_EQ(h.why, NoDamping::found);
    EXPECT_NEAR(h.damping, 0.03, 0.03 * (resolution == 1.0 ? 1e-5 : 1e-3));
    EXPECT_NEAR(h.frequency, 600, 0.01);
  }
}

TEST(HalfPower, SaysWhyItCannotBeTold) {
  constexpr double rate = 16'000, natural = 1000, zeta = 0.02;
  const auto why = [&](const std::vector<double>& velocity, double place = 1000) {
    const HalfPower h = half_power_of(velocity, rate, place, zeta);
    EXPECT_EQ(std::isnan(h.damping), h.why != NoDamping::found);
    EXPECT_EQ(std::isnan(h.error), h.why != NoDamping::found);
    return h.why;
  };
  DrivenModes mode(natural, zeta, rate, 7);
  EXPECT_EQ(why(mode.velocity(800)), NoDamping::short_run);  // 2 lines wide
  EXPECT_EQ(why(mode.velocity(16)), NoDamping::short_run);
  EXPECT_EQ(why(std::vector<double>(16'000, 0.0)), NoDamping::lost);
  EXPECT_EQ(why(mode.velocity(32'000), 2000), NoDamping::lost);  // the slope of another
  for (const double beyond : {9e3, 1e300, HUGE_VAL})
    EXPECT_EQ(why(mode.velocity(1600), beyond), NoDamping::lost);
  std::vector<double> two = mode.velocity(256'000);
  const std::vector<double> other = DrivenModes(1060, 0.01, rate, 8).velocity(two.size());
  for (std::size_t j = 0; j < two.size(); ++j) two[j] += other[j];
  EXPECT_EQ(why(two), NoDamping::shape);
  EXPECT_EQ(why(mode.velocity(64'000)), NoDamping::found);
  for (const auto& [reason, word] : {std::pair{NoDamping::short_run, "short"},
                                     {NoDamping::shape, "shape"},
                                     {NoDamping::lost, "lost"},
                                     {NoDamping::mesh, "mesh"}})
    EXPECT_STREQ(word_of(reason), word);
}

TEST(HalfPower, IsLookedForBetweenTheNeighbours) {
  const std::vector<double> natural{0, 100, 104, 300};
  const ModePlace place = place_of_mode(natural, 1, 0.02);
  EXPECT_EQ(place.natural, 100);
  EXPECT_DOUBLE_EQ(place.low, 90);
  EXPECT_DOUBLE_EQ(place.high, 102);
  EXPECT_DOUBLE_EQ(place_of_mode(natural, 3, 0.02).high, 330);
}

// ---- shocks ------------------------------------------------------------------------------------

TEST(Shocks, QuantilesGoStraightBetweenRanks) {
  const Spread s = spread_of({5, 1, 4, 2, 3});
  EXPECT_DOUBLE_EQ(s.median, 3);
  EXPECT_DOUBLE_EQ(s.p10, 1.4);
  EXPECT_DOUBLE_EQ(s.p90, 4.6);
  EXPECT_DOUBLE_EQ(s.mean, 3);
  EXPECT_DOUBLE_EQ(spread_of({1, 2}).median, 1.5);
  EXPECT_TRUE(std::isnan(spread_of({}).median));
}

TEST(Shocks, AreCountedByTheirStartsAndTogetherByTheTimesTheyLast) {
  const std::vector<Shock> shocks{
      {0, 0.5, 1.0, 1, 10, 0},  // goes on when the stretch begins
      {1, 1.0, 0.5, 2, 20, 0},  // begins with it, and ends as the next one begins
      {2, 1.5, 2.0, 3, 30, 0},   {3, 2.5, 0.25, 4, 40, 0},
      {4, 2.875, 5.0, 5, 50, 0},  // goes on when it ends
      {5, 3.5, 1.0, 6, 60, 0}};   // begins later
  const ShockStatistics s = shock_statistics(shocks, 1, 3);
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.rate, 2);
  EXPECT_DOUBLE_EQ(s.peak_force.median, 3.5);
  EXPECT_DOUBLE_EQ(s.impulse.mean, 35);
  EXPECT_DOUBLE_EQ(s.duration.p90, 2.0 + 0.7 * 3.0);
  EXPECT_DOUBLE_EQ(s.interval.mean, 1.875 / 3);
  EXPECT_DOUBLE_EQ(s.at_once_mean, (0.5 + 0.5 + 1.5 + 0.25 + 0.125) / 2);
  EXPECT_EQ(s.at_once_most, 2u);
  EXPECT_EQ(shock_statistics({}, 0, 1).rate, 0);
  EXPECT_EQ(shock_statistics({}, 0, 1).at_once_most, 0u);
}

TEST(Shocks, BinsAreTenToADecade) {
  const LogBins bins = log_bins(std::vector<double>{1e-3, 1.2e-3, 1.3e-3, 0, 9.99e-3, -1});
  ASSERT_EQ(bins.edges.size(), 11u);
  EXPECT_EQ(bins.edges.front(), 1e-3);
  EXPECT_THAT(bins.edges[1], DoubleNear(1.2589e-3, 1e-7));
  EXPECT_THAT(bins.counts, ElementsAre(2, 1, 0, 0, 0, 0, 0, 0, 0, 1));
  EXPECT_EQ(bins.not_positive, 2u);
  EXPECT_EQ(log_bins(std::vector<double>{10}).counts.size(), 1u);  // on an edge: the bin above it
  EXPECT_EQ(log_bins(std::vector<double>{10}).edges.front(), 10);
  EXPECT_TRUE(log_bins({}).edges.empty());
}

TEST(PowerBalance, IsWhatCameInLessWhatWentOut) {
  const std::vector<double> kinetic{1, 3}, elastic{0, 4}, contact{0, 2}, loss{1, 5}, slid{2, 14},
      loaded{0, -2};
  const EnergyColumns columns{kinetic, elastic, contact, loss, slid, loaded};
  const PowerBalance b = power_balance(columns, 2, ContactLaw::multiplier);
  EXPECT_EQ(b.sliding, 6);
  EXPECT_EQ(b.load, -1);
  EXPECT_EQ(b.damping, 2);
  EXPECT_EQ(b.storing, 4);
  EXPECT_EQ(b.missing, 1);
  EXPECT_EQ(b.elastic, 2);
  EXPECT_EQ(b.given, (2 + 4 + 4 - (-2)) / 2.0);  // kinetic, elastic, lost, less loads
  // of springs: less what they store, whatever the steps miss
  EXPECT_EQ(power_balance(columns, 2, ContactLaw::penalty).given, 6 - (2 - 0) / 2.0);
  EXPECT_TRUE(std::isnan(power_balance({}, 1, ContactLaw::penalty).sliding));
  EXPECT_TRUE(std::isnan(power_balance({}, 1, ContactLaw::penalty).given));
}

// ---- the program -------------------------------------------------------------------------------

class Analyze : public testing::Test {
 protected:
  test::Ended ra2d(std::vector<std::string> words) const {
    words.insert(words.begin(), test::program());
    return test::run_program(folder_.path(), words);
  }
  void run(const std::string& name, const std::vector<std::string>& sets = {}) const {
    std::vector<std::string> words{"run", test::scene_file("dang2012"), "-o", name, "--quiet"};
    for (const char* set : {"time.scheme=adaptive", "time.tolerance=1e-6", "scene.duration=0.1",
                            "output.probes=[0.15, 0.07]"})
      words.insert(words.end(), {"--set", set});
    for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
    const test::Ended ended = ra2d(words);
    ASSERT_EQ(ended.status, 0) << ended.err;
  }
  const test::Folder folder_;
};

/// numpy, scipy and h5py find the same from the file.
TEST_F(Analyze, AgreesWithScipy) {
  RA2D_SKIP_WITHOUT_PYTHON();
  run("a.h5", {"output.from=0.01"});
  run("free.h5", {"resonator.support=free", "scene.initial=rest"});  // rigid modes are no noise
  AnalysisOptions part;
  part.from = 0.02;
  part.to = 0.08;
  part.segment = 1000;
  part.a_weighting = true;
  const std::string script = test::source_folder() / "tests/host/check_analysis.py";
  for (const char* file : {"a.h5", "free.h5"})
    for (const AnalysisOptions& options : {AnalysisOptions{}, part}) {
      std::ofstream(folder_.path() / "said.json")
          << json_of({analyze(folder_.path() / file, options)});
      const test::Ended checked =
          test::run_program(folder_.path(), {test::python(), script, file, "said.json"});
      EXPECT_EQ(checked.status, 0) << file << ": " << checked.out << checked.err;
    }
}

TEST_F(Analyze, PrintsAsJsonWhatTheLibraryFinds) {
  run("a.h5");
  const test::Ended said = ra2d({"analyze", "a.h5", "--json", "--from", "0.02", "--to", "0.08",
                                 "--resolution", "100", "--a-weighting"});
  AnalysisOptions options;
  options.from = 0.02;
  options.to = 0.08;
  options.resolution = 100;
  options.a_weighting = true;
  Analysis found = analyze(folder_.path() / "a.h5", options);
  EXPECT_EQ(found.spectrum.resolution, 100);
  found.file = "a.h5";
  EXPECT_EQ(said.out, json_of({found}));
  EXPECT_EQ(said.status, 0) << said.err;
}

TEST_F(Analyze, PrintsOneScreen) {
  run("a.h5");
  const test::Ended said = ra2d({"analyze", "a.h5"});
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(said.err, "");
  EXPECT_THAT(said.out, AllOf(HasSubstr("level Lv"), HasSubstr("shocks"), HasSubstr("power"),
                              HasSubstr("mesh tone        12500 Hz"), HasSubstr("third octaves"),
                              HasSubstr("highest peaks    modes are counted from 0")));
  EXPECT_LT(std::count(said.out.begin(), said.out.end(), '\n'), 50);
  EXPECT_THAT(said.out, HasSubstr(" +- "));  // of a tenth of a second, too, at high frequencies
  EXPECT_THAT(said.out,
              AllOf(HasSubstr("(modal 0.02)"), HasSubstr("no damping: the run is too short")));
  EXPECT_THAT(ra2d({"analyze", "a.h5", "--a-weighting"}).out, HasSubstr("no sound pressure"));
}

TEST_F(Analyze, SaysWhereModesLieAboveHalfTheRate) {
  run("a.h5",
      {"output.rate=20e3"});  // of 19 modes to 18.9 kHz, 13 reach to 8.8 kHz, the 14th to 10.2
  EXPECT_EQ(analyze(folder_.path() / "a.h5", {}).aliased_modes, 6u);
  EXPECT_THAT(ra2d({"analyze", "a.h5"}).out, HasSubstr("6 modes lie above half the rate"));
}

TEST_F(Analyze, BandsAboveTheLastModeAreMarked) {
  run("a.h5", {"resonator.max_frequency=2000"});  // 6 modes, the last at 1882 Hz
  const Analysis found = analyze(folder_.path() / "a.h5", {});
  ASSERT_EQ(found.natural_frequencies.size(), 6u);  // pinned: as 1 to 36
  EXPECT_NEAR(last_mode(found.natural_frequencies), 36 * found.natural_frequencies[0], 1e-6);
  // The band of 2000 Hz begins at 1778 Hz, the next one at 2239 Hz.
  const std::vector<bool> above = bands_above_modes(found, found.bands.number);
  for (std::size_t i = 0; i < above.size(); ++i)
    EXPECT_EQ(above[i], found.bands.number[i] > 3) << third_octave_name(found.bands.number[i]);
  const std::string text = ra2d({"analyze", "a.h5"}).out;
  EXPECT_THAT(text, testing::ContainsRegex(" 2000 +-?[0-9.]+ .* 2500 +-?[0-9.]+\\*"));
  EXPECT_THAT(text,
              HasSubstr("* above the last mode that was kept, at 1.882 kHz: no information\n"));
  EXPECT_EQ(text.find(" \n"), text.npos);
  EXPECT_THAT(
      ra2d({"analyze", "a.h5", "--json"}).out,
      AllOf(HasSubstr("\"above_last_mode\":[false,"), HasSubstr(",true],\"last_mode\":188")));
  EXPECT_EQ(ra2d({"analyze", "a.h5", "--csv", "x"}).status, 0);
  const std::string table = test::read_file(folder_.path() / "x-bands.csv");
  EXPECT_THAT(table,
              AllOf(HasSubstr("_dB,above_last_mode\n"), testing::ContainsRegex("\n2000,[^\n]*,0\n"),
                    testing::ContainsRegex("\n2500,[^\n]*,1\n")));
  if (test::python().empty()) return;  // which draws what a page shows
  EXPECT_EQ(ra2d({"report", "a.h5", "-o", "a.html"}).status, 0);
  EXPECT_THAT(test::read_file(folder_.path() / "a.html"),
              HasSubstr("above the last mode that was kept"));
  // With all modes below the samples' limit some bands are above them; without any there is no
  // last.
  Analysis none = found;
  none.natural_frequencies.clear();
  EXPECT_THAT(bands_above_modes(none, none.bands.number), testing::Each(false));
}

TEST_F(Analyze, OfARunThatFailedSaysSoAndGoesAsFarAsItWent) {
  const test::Ended failed =
      ra2d({"run", test::scene_file("dang2012"), "-o", "a.h5", "--set",
            "time.scheme=explicit-euler", "--set", "time.step=1e-6", "--set", "time.force=true"});
  ASSERT_EQ(failed.status, 3);
  const test::Ended said = ra2d({"analyze", "a.h5"});
  EXPECT_EQ(said.status, 0);
  EXPECT_THAT(said.out, AllOf(HasSubstr("incomplete       the run was cut short: unstable"),
                              HasSubstr("level Lv")));
  const test::Ended json = ra2d({"analyze", "a.h5", "--json"});
  EXPECT_THAT(json.out, HasSubstr("\"complete\":false"));
  EXPECT_THAT(json.err, HasSubstr("the run was cut short"));
  const Analysis found = analyze(folder_.path() / "a.h5", {});
  EXPECT_LT(found.to, 0.01);
  EXPECT_GT(found.v_rms, 0);
}

TEST_F(Analyze, OfSeveralFilesGivesMeans) {
  run("a.h5");
  run("b.h5", {"resonator.surface.seed=7"});
  const test::Ended said = ra2d({"analyze", "a.h5", "b.h5"});
  EXPECT_EQ(said.status, 0);
  EXPECT_THAT(said.out, AllOf(HasSubstr("mean of 2 files"), HasSubstr("shocks.rate")));
  EXPECT_THAT(ra2d({"analyze", "a.h5", "b.h5", "--json"}).out,
              AllOf(HasSubstr("{\"files\":[{"), HasSubstr("\"mean\":{\"lv\":{\"mean\":")));
  EXPECT_EQ(said.err, "") << "they differ in a seed";
}

TEST_F(Analyze, MeansAreOfRunsThatDifferByTheirFaces) {
  run("a.h5");
  run("fast.h5", {"scene.speed=0.2"});
  run("sampled.h5", {"output.rate=5e4", "time.tolerance=1e-7"});
  std::filesystem::copy(folder_.path() / "a.h5", folder_.path() / "copy.h5");
  for (const char* twin : {"a.h5", "copy.h5"})
    EXPECT_THAT(ra2d({"analyze", "a.h5", twin}).err,
                testing::StartsWith(fmt::format("ra2d: a.h5 and {} are of one run: ", twin)));
  EXPECT_THAT(ra2d({"analyze", "a.h5", "copy.h5", "a.h5"}).err,
              testing::StartsWith("ra2d: a.h5, copy.h5 and 1 more are of one run: in the means "
                                  "it counts 3 times"));
  run("near.h5", {"scene.start=0.11"});
  run("far.h5", {"scene.start=0.05"});
  for (const char* shares : {"near.h5", "sampled.h5"})
    EXPECT_THAT(ra2d({"analyze", "a.h5", "far.h5", shares}).err,
                testing::AllOf(testing::StartsWith("ra2d: a.h5 and "),
                               HasSubstr(std::string(shares) + " touch a part of the same faces: "),
                               HasSubstr("Let starts lie 0.03 m apart or more")));
  EXPECT_EQ(ra2d({"analyze", "a.h5", "far.h5"}).err, "");
  EXPECT_THAT(
      ra2d({"analyze", "a.h5", "fast.h5", "--json"}).err,
      testing::StartsWith("ra2d: a.h5 and fast.h5 are of scenes that differ in more than "));
  const test::Ended quiet = ra2d({"analyze", "a.h5", "fast.h5", "--quiet", "--json"});
  EXPECT_EQ(quiet.err, "");
  EXPECT_THAT(quiet.out, HasSubstr(R"("doubts":["a.h5 and fast.h5 are of scenes that)"));
}

TEST_F(Analyze, WritesTables) {
  run("a.h5", {"output.slider_probes=[0.01]"});
  const auto& folder = folder_.path();
  std::filesystem::create_directory(folder / "tables");
  EXPECT_EQ(ra2d({"analyze", "a.h5", "--csv", "tables"}).status, 0);
  EXPECT_EQ(ra2d({"analyze", "a.h5", "--csv", "x", "--a-weighting"}).status, 0);
  EXPECT_THAT(test::read_file(folder / "tables/a-spectrum.csv"),
              testing::StartsWith("frequency_Hz,psd_mean_m2/s2/Hz,psd_force_N2/Hz,"
                                  "psd_probe1_at_0.15_m_m2/s2/Hz,psd_probe2_at_0.07_m_m2/s2/Hz,"
                                  "psd_slider_probe1_at_0.01_m_m2/s2/Hz\n0"));
  std::istringstream lines(test::read_file(folder / "tables/a-spectrum.csv"));
  for (std::string line; std::getline(lines, line);)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 5) << line;
  EXPECT_THAT(test::read_file(folder / "tables/a-bands.csv"), HasSubstr("\n1000,1000,"));
  EXPECT_THAT(test::read_file(folder / "x-bands.csv"), HasSubstr(",level_a_dB,"));
  EXPECT_THAT(test::read_file(folder / "x-shocks.csv"), HasSubstr("\npeak_force_N,"));
  // never over a result, nor one table over another
  std::filesystem::copy(folder / "a.h5", folder / "x-bands.csv",
                        std::filesystem::copy_options::overwrite_existing);
  EXPECT_EQ(ra2d({"analyze", "x-bands.csv", "--csv", "x"}).status, 2);
  std::filesystem::copy(folder / "a.h5", folder / "tables/a.h5");
  EXPECT_EQ(ra2d({"analyze", "a.h5", "tables/a.h5", "--csv", "y"}).status, 2);
}

TEST_F(Analyze, RefusesWhatTheFileDoesNotHave) {
  run("a.h5");
  std::ofstream(folder_.path() / "scene.toml") << "[scene]\n";
  std::filesystem::copy(folder_.path() / "a.h5", folder_.path() / "kept-bands.csv");
  for (const auto& [words, status, why] :
       std::vector<std::tuple<std::vector<std::string>, int, std::string>>{
           {{"scene.toml"}, 4, "it is no HDF5 file"},
           {{"nowhere.h5"}, 4, "No such file"},
           {{"a.h5", "nowhere.h5"}, 4, "nowhere.h5"},
           {{"a.h5", "--from", "0.2"}, 2, "from 0.2 s on there is nothing"},
           {{"a.h5", "--from", "0.05", "--to", "0.05"}, 2, "expected --from before --to"},
           {{"a.h5", "--to", "0.2"}, 2, "the run ends at 0.1 s"},
           {{"a.h5", "--to", "1e-9"}, 2, "there is one sample"},
           {{"a.h5", "--segment", "10002"}, 2, "expected 4 to 10001"},
           {{"a.h5", "--resolution", "1"}, 2, "expected 4 to 10001"},
           {{"a.h5", "--resolution", "nan"}, 2, "--resolution"},
           {{"a.h5", "--resolution", "9", "--segment", "9"}, 2, "excludes"},
           {{"a.h5", "--csv", ""}, 2, "--csv"},
           {{"a.h5", "--csv", "no/folder/x"}, 4, "no/folder"},
           {{"a.h5", "--csv", std::string(250, 'x')}, 4, "Choose a shorter name with --csv"},
           {{"a.h5", "--csv", "kept"}, 2, "Name another file with --csv, or remove it"},
           {{}, 2, "OUT.h5"}}) {
    std::vector<std::string> line{"analyze"};
    line.insert(line.end(), words.begin(), words.end());
    const test::Ended ended = ra2d(line);
    EXPECT_EQ(ended.status, status) << fmt::format("{}: {}", fmt::join(words, " "), ended.err);
    EXPECT_THAT(ended.err, HasSubstr(why));
    EXPECT_EQ(ended.out, "");
  }
}

TEST_F(Analyze, OfARunThatWasTooShortSaysWhatThereIsNot) {
  run("a.h5", {"scene.duration=1e-5", "resonator.support=rigid"});
  const test::Ended said = ra2d({"analyze", "a.h5"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out,
              AllOf(HasSubstr("spectrum         none"), HasSubstr("third octaves    none"),
                    HasSubstr("the resonator did not vibrate")));
  EXPECT_THAT(ra2d({"analyze", "a.h5", "--json"}).out, HasSubstr("\"lv\":null"));
  // the state at t = 0 alone
  run("one.h5", {"scene.duration=1e-6"});
  EXPECT_THAT(ra2d({"analyze", "one.h5"}).out, HasSubstr(" s, 1 sample\n"));
}

}  // namespace
}  // namespace ra2d
