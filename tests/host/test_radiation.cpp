// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

#include "host/body/beam.hpp"
#include "host/radiation/pressure.hpp"
#include "host/radiation/resistance.hpp"
#include "host/radiation/transfer.hpp"

namespace ra2d {
namespace {

using Complex = std::complex<double>;

const Air air = air_of(20, 101'325);

/// A face that moves as a whole.
Radiator piston(double length, double width) {
  Radiator radiator;
  radiator.length = length;
  radiator.width = width;
  radiator.modes.push_back({[](double) { return 1.0; }, 0});
  radiator.across.emplace_back([](double) { return 1.0; });
  return radiator;
}

/// The paper's plate, with modes up to 20 kHz.
BodySpec plate_spec() {
  BodySpec spec;
  spec.length = 0.3;
  spec.thickness = 0.002;
  spec.width = 0.2;
  spec.young = 210e9;
  spec.density = 7800;
  spec.damping = 0.02;
  spec.max_frequency = 20e3;
  return spec;
}

/// The largest difference, over the largest value.
double difference(const std::vector<Complex>& a, const std::vector<Complex>& b) {
  double apart = 0, size = 0;
  for (std::size_t k = 0; k < b.size(); ++k) {
    apart = std::max(apart, std::abs(a[k] - b[k]));
    size = std::max(size, std::abs(b[k]));
  }
  return apart / size;
}

// ---- air ---------------------------------------------------------------------------------------

TEST(Air, IsThatOfTheTables) {
  // ISO 9613-1 and the International Standard Atmosphere
  EXPECT_NEAR(air.sound_speed, 343.2, 0.05);
  EXPECT_NEAR(air.density, 1.204, 0.001);
  EXPECT_NEAR(air_of(15, 101'325).density, 1.225, 1e-3);
  EXPECT_NEAR(air_of(15, 101'325).sound_speed, 340.29, 0.02);
  EXPECT_THROW(air_of(-300, 101'325), std::invalid_argument);
  EXPECT_THROW(air_of(20, 0), std::invalid_argument);
}

// ---- quadrature --------------------------------------------------------------------------------

TEST(Quadrature, GaussIntegratesPolynomials) {
  const Points rule = gauss_rule(16);
  for (int power = 0; power < 32; ++power) {
    double sum = 0;
    for (std::size_t i = 0; i < rule.size(); ++i)
      sum += rule.weight[i] * std::pow(rule.at[i], power);
    EXPECT_NEAR(sum, power % 2 == 0 ? 2.0 / (power + 1) : 0, 4e-15) << power;
  }
}

TEST(Quadrature, PanelsFollowAPoleAndAWave) {
  // integral of 1/hypot(x - 0.1, d) from 0 to 1
  for (const double distance : {1e-5, 1e-3, 0.1, 10.0}) {
    const Points points = graded_points(0, 1, 0, {0.1, distance});
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      sum += points.weight[i] / std::hypot(points.at[i] - 0.1, distance);
    EXPECT_NEAR(sum / (std::asinh(0.9 / distance) + std::asinh(0.1 / distance)), 1, 1e-12)
        << distance;
  }
  const Points points = even_points(0, 1, 900);
  Complex sum;
  for (std::size_t i = 0; i < points.size(); ++i)
    sum += points.weight[i] * std::polar(1.0, 900 * points.at[i]);
  EXPECT_LT(std::abs(sum - (std::polar(1.0, 900.0) - 1.0) / Complex(0, 900)), 1e-12);
}

// ---- transfer ----------------------------------------------------------------------------------

/// In polar coordinates about the foot of the axis the integral over the radius is closed:
///   c density/(i omega 2 pi) integral (exp(-i k z) - exp(-i k hypot(z, edge(angle)))) d angle.
TEST(Transfer, OfAPistonOnItsAxisIsTheClosedForm) {
  constexpr double length = 0.3, width = 0.2;
  const Radiator face = piston(length, width);
  for (const double z : {0.001, 0.02, 0.5, 20.0})
    for (const double frequency : {50.0, 1000.0, 20e3}) {
      const double k = 2 * M_PI * frequency / air.sound_speed;
      const double corner = std::atan2(width, length);
      Complex sum;  // of a quarter
      for (const auto& [low, high, across] :
           {std::tuple{0.0, corner, true}, std::tuple{corner, M_PI / 2, false}}) {
        const Points points = even_points(low, high, 2 * k * length);
        for (std::size_t i = 0; i < points.size(); ++i) {
          const double edge =
              across ? length / 2 / std::cos(points.at[i]) : width / 2 / std::sin(points.at[i]);
          sum += points.weight[i] *
                 (std::polar(1.0, -k * z) - std::polar(1.0, -k * std::hypot(z, edge)));
        }
      }
      const Complex closed = 4.0 * sum * air.density / (2 * M_PI) / Complex(0, k);
      const Complex found = transfer(face, air, {length / 2, width / 2, z}, frequency).front();
      EXPECT_LT(std::abs(found - closed) / std::abs(closed), 1e-10) << z << " " << frequency;
    }
}

/// A disk of narrow strips, each by the rectangle's quadrature, against the textbooks' closed form
/// on the axis, |p| = 2 density c |v| |sin(k/2 (hypot(z, radius) - z))|. At 1 mm and 20 kHz the
/// disk is 12 wavelengths wide; at z = 0.2 m it has zeros on the axis.
TEST(Transfer, OfACircularPistonOnItsAxisIsTheTextbooks) {
  constexpr double radius = 0.1, narrow = 1e-7;
  for (const double z : {0.001, 0.05, 0.2, 3.0}) {
    const Points turns = graded_points(0, M_PI / 2, 80, {0, z / radius});  // x = radius sin(turn)
    for (const double frequency : {50.0, 1000.0, 20e3}) {
      Complex h;
      for (std::size_t i = 0; i < turns.size(); ++i) {
        const double x = radius * std::sin(turns.at[i]), half = radius * std::cos(turns.at[i]);
        const Radiator chord = piston(narrow, 2 * half);
        h += 2 * turns.weight[i] * half / narrow *
             transfer(chord, air, {narrow / 2 - x, half, z}, frequency).front();
      }
      const double k = 2 * M_PI * frequency / air.sound_speed;
      const double closed = 2 * air.density * air.sound_speed / (2 * M_PI * frequency) *
                            std::abs(std::sin(k / 2 * (std::hypot(z, radius) - z)));
      const double largest = 2 * air.density * air.sound_speed / (2 * M_PI * frequency);
      EXPECT_NEAR(std::abs(h) / largest, closed / largest, 1e-9) << z << " " << frequency;
    }
  }
}

TEST(Transfer, OfASmallFaceIsAPointSource) {
  const Radiator face = piston(1e-5, 1e-5);
  const Complex found = transfer(face, air, {1.0, 2.0, 2.0}, 1000).front();
  const double r = std::hypot(1.0 - 5e-6, 2.0 - 5e-6, 2.0), k = 2 * M_PI * 1000 / air.sound_speed;
  const Complex closed = std::polar(air.density * 1e-10 / (2 * M_PI * r), -k * r);
  EXPECT_LT(std::abs(found / closed - 1.0), 1e-8);
}

TEST(Transfer, BelowTheFaceHasTheOtherSign) {
  const Radiator face = strip(make_beam(plate_spec()), 0.2);
  std::vector<Complex> below = transfer(face, air, {0.1, 0.05, -0.3}, 3000);
  for (Complex& value : below) value = -value;
  EXPECT_EQ(difference(below, transfer(face, air, {0.1, 0.05, 0.3}, 3000)), 0);
}

/// The mean pressure of one face over another is the same the other way round.
TEST(Transfer, IsReciprocal) {
  const Radiator large = piston(0.3, 0.2), small = piston(0.1, 0.05);
  constexpr double x = 0.15, y = -0.02, z = 0.04, frequency = 6000;  // of small's corner
  const auto mean_over = [&](const Radiator& from, const Radiator& to, double sign) {
    const Points along = even_points(0, to.length, 200), across = even_points(0, to.width, 200);
    Complex sum;
    for (std::size_t i = 0; i < along.size(); ++i)
      for (std::size_t j = 0; j < across.size(); ++j)
        sum += along.weight[i] * across.weight[j] *
               transfer(from, air, {along.at[i] + sign * x, across.at[j] + sign * y, z}, frequency)
                   .front();
    return sum;
  };
  const Complex forth = mean_over(large, small, 1), back = mean_over(small, large, -1);
  EXPECT_LT(std::abs(forth - back) / std::abs(forth), 1e-9);
}

TEST(Transfer, DoesNotDependOnItsPanels) {
  const Radiator face = strip(make_beam(plate_spec()), 0.2);
  const Fineness finer{24, 8, 0.5};
  for (const Position& at :
       {Position{0.15, 0.1, 0.5}, Position{0.3, 0.2, 0.001}, Position{0.077, 0.13, 0.001},
        Position{-0.5, 0.4, 0.1}, Position{10, 10, 50}})
    for (const double frequency : {100.0, 5e3, 50e3})
      EXPECT_LT(
          difference(transfer(face, air, at, frequency), transfer(face, air, at, frequency, finer)),
          2e-10)
          << at[0] << " " << frequency;
}

TEST(Transfer, LinesAreThoseOfSingleFrequencies) {
  const Radiator face = strip(make_beam(plate_spec()), 0.2);
  constexpr double rate = 100e3;
  constexpr std::size_t length = 2048;
  for (const Position& at :
       {Position{0.15, 0.1, 0.5}, Position{0.077, 0.13, 0.001}, Position{-0.5, 0.4, -3}}) {
    const TransferLines lines = transfer_lines(face, air, at, rate, length);
    for (const std::size_t line : {0, 1, 100, 500, 1000, 1024}) {
      const double frequency = static_cast<double>(line) * rate / length;
      std::vector<Complex> found;
      for (const auto& mode : lines.modes)
        found.push_back(mode[line] * std::polar(1.0, -2 * M_PI * frequency *
                                                         static_cast<double>(lines.lead) / rate));
      EXPECT_LT(difference(found, transfer(face, air, at, frequency)), 1e-9)
          << at[2] << " " << line;
    }
  }
}

// ---- pressure in time --------------------------------------------------------------------------

/// A burst without jumps: acceleration and velocity of a mode.
struct Burst {
  double at, wide, frequency;  // s, s, Hz

  double displacement(double t) const {
    const double s = (t - at) / wide;
    return std::exp(-s * s) * std::sin(2 * M_PI * frequency * (t - at));
  }
  double velocity(double t) const { return derivative(t, 1); }
  double acceleration(double t) const { return derivative(t, 2); }

 private:
  /// In closed form: of exp(-s^2) sin(w t), with the derivatives of both.
  double derivative(double t, int order) const {
    const double s = (t - at) / wide, w = 2 * M_PI * frequency;
    const double bell = std::exp(-s * s), bell1 = -2 * s / wide * bell;
    const double bell2 = (4 * s * s - 2) / (wide * wide) * bell;
    const double sine = std::sin(w * (t - at)), cosine = std::cos(w * (t - at));
    return order == 1 ? bell1 * sine + bell * w * cosine
                      : bell2 * sine + 2 * bell1 * w * cosine - bell * w * w * sine;
  }
};

/// Against Simpson's double sum over a fine grid of the face, each point with its own delay, of the
/// acceleration in closed form: without modes, transforms or filters.
TEST(Pressure, IsTheRetardedDoubleSumInTime) {
  constexpr double rate = 50e3;
  constexpr std::size_t samples = 1500;
  BodySpec spec = plate_spec();
  spec.max_frequency = 3e3;
  const Body body = make_beam(spec);
  const Radiator face = strip(body, spec.width);
  std::vector<Burst> bursts;
  for (std::size_t k = 0; k < body.modes.size(); ++k)
    bursts.push_back(
        {0.012 + 3e-4 * static_cast<double>(k), 1.5e-3, 500.0 * static_cast<double>(k + 1)});
  ASSERT_GE(bursts.size(), 4u);
  const VelocityRecord record{
      samples, true, [&](std::size_t first, std::size_t count) {
        std::vector<std::vector<double>> found;
        for (const Burst& burst : bursts) {
          found.emplace_back();
          for (std::size_t n = 0; n < count; ++n)
            found.back().push_back(burst.velocity(static_cast<double>(first + n) / rate));
        }
        return found;
      }};
  const std::vector<Position> places{{0.15, 0.1, 0.5}, {0.05, 0.02, 0.02}, {-0.4, 0.5, -1}};
  const PressureFilters filters(face, air, places, rate);
  std::vector<PressureFilters::Range> ranges;
  for (std::size_t i = 0; i < places.size(); ++i) ranges.push_back(filters.carried(i, record));
  const auto found = filters.pressures(record, ranges);

  const auto simpson = [](int i, int steps) {
    return i == 0 || i == steps ? 1.0 / 3 : i % 2 == 1 ? 4.0 / 3 : 2.0 / 3;
  };
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& [x0, y0, z0] = places[i];
    const int along = i == 1 ? 600 : 240, across = i == 1 ? 400 : 160;  // near: finer
    const double dx = face.length / along, dy = face.width / across;
    std::vector<double> shapes;
    for (int n = 0; n <= along; ++n)
      for (const BodyMode& mode : body.modes)
        shapes.push_back(shape_at(mode, std::min(face.length, n * dx)));
    const double peak = *std::max_element(found[i].begin(), found[i].end());
    ASSERT_GT(peak, 0);
    for (const double time : {0.0105, 0.0138, 0.0152, 0.0171}) {
      const auto sample = static_cast<std::size_t>(std::llround(time * rate));
      double sum = 0;
      for (int n = 0; n <= along; ++n)
        for (int m = 0; m <= across; ++m) {
          const double r = std::hypot(n * dx - x0, m * dy - y0, z0);
          const double t = static_cast<double>(sample) / rate - r / air.sound_speed;
          double acceleration = 0;
          for (std::size_t k = 0; k < bursts.size(); ++k)
            acceleration +=
                shapes[static_cast<std::size_t>(n) * bursts.size() + k] * bursts[k].acceleration(t);
          sum += simpson(n, along) * simpson(m, across) * dx * dy * acceleration / r;
        }
      sum *= air.density / (2 * M_PI) * (z0 < 0 ? -1 : 1);
      EXPECT_NEAR(found[i][sample - ranges[i].begin] / peak, sum / peak, 1e-6) << i << " " << time;
    }
  }
}

/// Blocks, reading in parts and a late beginning change nothing.
TEST(Pressure, DoesNotDependOnWhereTheRecordBegins) {
  constexpr double rate = 50e3;
  constexpr std::size_t samples = 9000, skipped = 3000;
  const Radiator face = strip(make_beam(plate_spec()), 0.2);
  const auto velocity = [&](std::size_t k, std::size_t n) {
    const double t = static_cast<double>(n) / rate;
    return std::sin(2 * M_PI * (150.0 + 700 * static_cast<double>(k)) * t) *
           std::min(1.0, t / 0.01);
  };
  const auto read_from = [&](std::size_t offset) {
    return [&, offset](std::size_t first, std::size_t count) {
      std::vector<std::vector<double>> found(face.modes.size());
      for (std::size_t k = 0; k < found.size(); ++k)
        for (std::size_t n = 0; n < count; ++n) found[k].push_back(velocity(k, offset + first + n));
      return found;
    };
  };
  const PressureFilters filters(face, air, {{0.1, 0.1, 1.5}}, rate);
  const VelocityRecord whole{samples, true, read_from(0)};
  const VelocityRecord late{samples - skipped, false, read_from(skipped)};
  const PressureFilters::Range all = filters.carried(0, whole), part = filters.carried(0, late);
  EXPECT_EQ(all.begin, 0u);
  EXPECT_EQ(all.end, part.end + skipped);
  const auto of_all = filters.pressures(whole, {all}), of_part = filters.pressures(late, {part});
  double peak = 0, apart = 0;
  for (const double p : of_all.front()) peak = std::max(peak, std::abs(p));
  for (std::size_t n = part.begin; n < part.end; ++n)
    apart = std::max(apart, std::abs(of_part[0][n - part.begin] - of_all[0][n + skipped]));
  EXPECT_LT(apart / peak, 1e-8);
  // before the sound has come over the least distance there is none
  const auto lead = static_cast<std::size_t>(1.5 / air.sound_speed * rate);
  for (std::size_t n = 0; n + filter_half_length < lead; ++n)
    ASSERT_LT(std::abs(of_all[0][n]), 1e-9 * peak) << n;
}

// ---- power -------------------------------------------------------------------------------------

/// sigma = R/(density c integral psi^2): Wallace (1972), a plate of a by b, waves long against it.
TEST(Resistance, OfASupportedPlateIsWallaces) {
  constexpr double a = 0.3, b = 0.2;
  const std::vector<PlateMode> numbers{{1, 1}, {3, 1}, {1, 2}, {2, 1}, {2, 2}, {3, 3}};
  const Radiator plate = supported_plate(a, b, numbers);
  const RadiationResistance resistance(plate, air, 20e3);
  const std::vector<double> squares = squared_shapes(plate);
  EXPECT_NEAR(squares[0], a * b / 4, 1e-14);
  const double pi5 = std::pow(M_PI, 5);
  for (const double k : {0.02, 0.2, 1.0}) {  // rad/m
    const double frequency = k * air.sound_speed / (2 * M_PI);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto [m, n] = numbers[i];
      const double both = pi5 * m * m * n * n;
      double closed = 0;
      if (m % 2 == 1 && n % 2 == 1) {
        const auto part = [](int number) { return 1 - 8 / (M_PI * M_PI * number * number); };
        closed = 32 * k * a * k * b / both *
                 (1 - k * k * a * b / 12 * (part(m) * a / b + part(n) * b / a));
      } else if (m % 2 == 1) {
        closed = 8 * k * a * std::pow(k * b, 3) / (3 * both);
      } else if (n % 2 == 1) {
        closed = 8 * k * b * std::pow(k * a, 3) / (3 * both);
      } else {
        closed = 2 * std::pow(k * a * k * b, 3) / (15 * both);
      }
      const double efficiency =
          resistance.of_mode(i, frequency) / (air.density * air.sound_speed * squares[i]);
      const bool corrected = m % 2 == 1 && n % 2 == 1;
      const double rest = k * a * k * a;  // of the next term
      EXPECT_NEAR(efficiency / closed, 1, corrected ? rest * rest / 50 + 1e-7 : rest / 10 + 1e-7)
          << m << n << " " << k;
    }
  }
}

/// The modes of a plate have the integral 1 of their squares.
TEST(Resistance, OfAPlateIsThatOfItsModes) {
  BodySpec spec = plate_spec();
  spec.kind = BodyKind::plate;
  const Body body = make_body(spec);
  const Radiator face = face_of(body, spec);
  ASSERT_GT(face.modes.size(), 3);
  for (const double square : squared_shapes(face)) EXPECT_NEAR(square, 1, 1e-12);
  for (std::size_t k = 0; k < face.modes.size(); ++k)
    EXPECT_NEAR(face.modes[k].along(0.07) * face.across[face.modes[k].across](0.11),
                shape_at(body.modes[k], 0.07, 0.11), 1e-11);
}

TEST(Resistance, OfAShortWaveIsThatOfAPlaneWave) {
  // a face of many wavelengths that moves as a whole: sigma -> 1
  const Radiator face = piston(0.3, 0.2);
  const RadiationResistance resistance(face, air, 50e3);
  EXPECT_NEAR(resistance.of_mode(0, 50e3) / (air.density * air.sound_speed * face.area()), 1, 1e-2);
}

/// The power through a large hemisphere, of two modes that move together: cross terms count.
void expect_power_far_away(const Radiator& plate, const std::vector<double>& frequencies) {
  const RadiationResistance resistance(plate, air, 5e3);
  const std::vector<double> v{1.0, -0.7, 0.4};
  constexpr double far = 3e4;  // m
  for (const double frequency : frequencies) {
    const std::vector<double> half = resistance.lower_half(frequency);
    double power = 0, alone = 0;
    for (std::size_t k = 0, at = 0; k < v.size(); ++k)
      for (std::size_t l = 0; l <= k; ++l, ++at) {
        power += (k == l ? 1 : 2) * half[at] * v[k] * v[l] / 2;
        if (k == l) alone += half[at] * v[k] * v[l] / 2;
      }
    const Points polar = even_points(0, M_PI / 2, 20);
    constexpr int around = 48;
    double arrived = 0;
    for (std::size_t i = 0; i < polar.size(); ++i)
      for (int j = 0; j < around; ++j) {
        const double angle = 2 * M_PI * j / around, s = std::sin(polar.at[i]);
        const Position at{0.15 + far * s * std::cos(angle), 0.1 + far * s * std::sin(angle),
                          far * std::cos(polar.at[i])};
        const auto h = transfer(plate, air, at, frequency);
        Complex pressure;
        for (std::size_t k = 0; k < v.size(); ++k)
          pressure += h[k] * v[k] * Complex(0, 2 * M_PI * frequency);
        arrived += polar.weight[i] * 2 * M_PI / around * far * far * s * std::norm(pressure) / 2 /
                   (air.density * air.sound_speed);
      }
    EXPECT_NEAR(arrived / power, 1, 1e-6) << frequency;
    if (frequency < 1000) {  // below coincidence neighbours radiate together
      EXPECT_GT(std::abs(alone / power - 1), 0.1) << "the modes' cross terms do not show";
    }
  }
}

TEST(Resistance, IsThePowerThatArrivesFarAway) {
  expect_power_far_away(supported_plate(0.3, 0.2, {{1, 1}, {3, 1}, {2, 2}}), {200, 3000});
  BodySpec spec = plate_spec();
  spec.max_frequency.reset();
  spec.modes = 3;
  expect_power_far_away(strip(make_beam(spec), spec.width), {200});
}

TEST(Resistance, DoesNotDependOnItsPanels) {
  const Radiator face = strip(make_beam(plate_spec()), 0.2);
  const RadiationResistance usual(face, air, 45e3), finer(face, air, 45e3, {24, 7, 0.5});
  for (const double frequency : {30.0, 777.0, 12e3, 45e3}) {
    const auto a = usual.lower_half(frequency), b = finer.lower_half(frequency);
    double apart = 0;
    for (std::size_t i = 0; i < a.size(); ++i) apart = std::max(apart, std::abs(a[i] - b[i]));
    EXPECT_LT(apart / *std::max_element(b.begin(), b.end()), 5e-9) << frequency;
    EXPECT_NEAR(usual.of_mode(2, frequency), a[5], 1e-12 * a[5]);
  }
}

/// The tables across are interpolated from transforms at a few wave numbers: those for records at
/// 1 MHz hold the resistances of the audible band as smaller ones do.
TEST(Resistance, DoesNotDependOnTheHighestFrequency) {
  const Radiator plate = supported_plate(0.3, 0.2, {{1, 1}, {2, 3}, {5, 2}});
  const RadiationResistance low(plate, air, 20e3), high(plate, air, 500e3);
  for (const double frequency : {50.0, 3e3, 20e3}) {
    const std::vector<double> a = low.lower_half(frequency), b = high.lower_half(frequency);
    const double largest = *std::max_element(b.begin(), b.end());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 5e-9 * largest) << frequency;
  }
}

/// Modes of different parity do not couple; of shapes without a parity all do, and have the same
/// resistances as where it is known.
TEST(Resistance, OfModesOfOneParityIsThatOfAllModes) {
  const std::vector<PlateMode> numbers{{1, 1}, {2, 1}, {3, 1}, {1, 2}, {3, 3}, {2, 2}, {4, 1}};
  const Radiator plate = supported_plate(0.3, 0.2, numbers);
  const RadiationResistance resistance(plate, air, 30e3);
  for (const std::vector<std::size_t>& group : resistance.groups())
    for (const std::size_t k : group) {
      EXPECT_EQ(numbers[k].along % 2, numbers[group[0]].along % 2);
      EXPECT_EQ(numbers[k].across % 2, numbers[group[0]].across % 2);
    }
  EXPECT_EQ(resistance.groups().size(), 4u);

  Radiator other = plate;  // with one shape more, of no parity along and across
  other.modes.push_back({[](double x) { return x * x; }, other.across.size()});
  other.across.emplace_back([](double y) { return 1 + y; });
  const RadiationResistance all(other, air, 30e3);
  ASSERT_EQ(all.groups().size(), 1u);
  for (const double frequency : {100.0, 4e3, 30e3}) {
    const std::vector<double> a = resistance.lower_half(frequency), b = all.lower_half(frequency);
    const double largest = *std::max_element(a.begin(), a.end());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-9 * largest) << frequency;
    EXPECT_GT(std::abs(b.back()), 0);
  }
}

/// Sixteen frequencies are summed side by side: each is as if it were alone.
TEST(Resistance, OfSeveralFrequenciesIsThatOfEach) {
  const Radiator plate = supported_plate(0.3, 0.2, {{1, 1}, {2, 3}, {3, 1}, {5, 2}});
  const RadiationResistance resistance(plate, air, 20e3);
  std::vector<double> frequencies;
  for (int i = 0; i < 37; ++i) frequencies.push_back(540.0 * i);
  const auto found = resistance.of_groups(frequencies);
  ASSERT_EQ(found.size(), frequencies.size());
  for (std::size_t i = 0; i < frequencies.size(); ++i)
    EXPECT_EQ(found[i], resistance.of_groups({&frequencies[i], 1}).front());
}

/// The bound on the air's inertia, against the static integral of a piston's 1/r.
TEST(Resistance, InertiaOfTheAirIsBounded) {
  const Radiator face = piston(0.3, 0.2);
  const Points along = even_points(0, 0.3, 0, {6, 1, 1}),
               across = even_points(0, 0.2, 0, {6, 1, 1});
  double sum = 0;  // density/(2 pi) integral integral 1/r, with one face 1 um above the other
  for (std::size_t i = 0; i < along.size(); ++i)
    for (std::size_t j = 0; j < across.size(); ++j)
      sum += along.weight[i] * across.weight[j] *
             transfer(face, air, {along.at[i], across.at[j], 1e-6}, 0).front().real();
  const double mass_per_area = 15.6;
  const double lowered = 2 * sum / face.area() / mass_per_area / 2;
  const double bound = inertia_of_air(face, air, mass_per_area);
  EXPECT_LT(lowered, bound);
  EXPECT_GT(lowered, 0.7 * bound);
}

}  // namespace
}  // namespace ra2d
