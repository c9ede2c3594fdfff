// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include "host/result/record.hpp"
#include "host/run/v_rms.hpp"
#include "tests/numbers.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// The schemes on modes that touch nothing: their orders, on the march, against closed forms.
namespace ra2d::test {
namespace {

using Complex = std::complex<long double>;

/// A mode that oscillates under p sin(drive t + phase): U = homogeneous + particular.
struct Oscillator {
  long double omega, zeta, p = 0, drive = 0, phase = 0;
  long double u0, v0;

  Complex at(long double t) const {  // (U, V)
    const Complex i(0, 1);
    const Complex answer = p / (omega * omega - drive * drive + 2.0L * i * zeta * omega * drive);
    const auto forced = [&](long double time) {
      const Complex y = answer * std::exp(i * (drive * time + phase));
      return Complex(y.imag(), (i * drive * y).imag());
    };
    const Complex start = Complex(u0, v0) - forced(0), decay = zeta * omega;
    const long double turn = omega * std::sqrt(1 - zeta * zeta), d = decay.real();
    const long double c = std::cos(turn * t), s = std::sin(turn * t) / turn, e = std::exp(-d * t);
    const long double u = start.real(), v = start.imag();
    return forced(t) +
           Complex(e * (u * c + (v + d * u) * s), e * (v * c - (d * v + omega * omega * u) * s));
  }
};

/// Largest errors over the samples, U's times omega, summed over the modes.
struct Errors {
  double u = 0, v = 0;
};
Errors errors_of(const Recording& run, const std::vector<Oscillator>& modes) {
  EXPECT_EQ(run.end.status, Status::done);
  EXPECT_EQ(run.end.contact_steps, 0);
  Errors most;
  for (std::size_t i = 0; i < run.samples.time.size(); ++i) {
    Errors e;
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const Complex y = modes[k].at(run.samples.time[i]);
      const std::size_t at = i * modes.size() + k;
      e.u += static_cast<double>(
          std::abs(modes[k].omega * (run.samples.resonator_displacement[at] - y.real())));
      e.v += static_cast<double>(std::abs(run.samples.resonator_velocity[at] - y.imag()));
    }
    most.u = std::max(most.u, e.u);
    most.v = std::max(most.v, e.v);
  }
  return most;
}

/// A scheme and the steps at which its order is measured, over `levels` halvings: errors there are
/// small against the motion and large against roundings.
struct Case {
  Scheme scheme;
  double x;    // omega tau at the coarsest, of the fastest mode
  int forced;  // order when the force changes with time
  int loss;    // order of the damping loss
};
constexpr int levels = 4;

class OrderOf : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Schemes, OrderOf,
                         testing::Values(Case{schemes[0], 0.02, 1, 1}, Case{schemes[1], 0.2, 2, 2},
                                         Case{schemes[2], 0.02, 1, 1}, Case{schemes[3], 0.2, 2, 2},
                                         Case{schemes[4], 0.4, 4, 2}, Case{schemes[5], 1.2, 8, 2},
                                         Case{schemes[6], 0.05, 1, 2}, Case{schemes[7], 0.2, 2, 2},
                                         // without contact there is nothing to be implicit about
                                         Case{schemes_and_implicit().back(), 0.02, 1, 1}),
                         [](const auto& info) { return info.param.scheme.name; });

/// Marches the scenes that `prepare(level)` makes, in one batch.
template <class Prepare>
std::vector<Recording> at_all_levels(const Prepare& prepare) {
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  for (int level = 0; level <= levels; ++level) {
    auto [model, start] = prepare(level);
    count_energy(model, start);
    models.push_back(model);
    starts.push_back(start);
  }
  return simulate(models, starts);
}

/// From halving to halving and over all of them, with a next term that is no larger than the first
/// would be at x = 1.
void expect_order(const std::vector<double>& errors, int order, double x, const char* what) {
  for (std::size_t level = 1; level < errors.size(); ++level) {
    const double fine = std::ldexp(x, -static_cast<int>(level));
    EXPECT_NEAR(std::log2(errors[level - 1] / errors[level]), order,
                0.1 + std::log2((1 + 2 * fine) / (1 + fine)))
        << what << ", halving " << level << ": " << errors[level - 1] << " to " << errors[level];
  }
  EXPECT_NEAR(std::log2(errors.front() / errors.back()) / levels, order,
              0.1 + std::log2((1 + x) / (1 + std::ldexp(x, -levels))) / levels)
      << what;
}

/// A vibrating beam; `turns` in radians of the fastest mode, a sample about every radian.
struct Vibrating {
  Model model;
  ModalStart start;
};
Vibrating vibrating(const Scheme& scheme, int modes, double zeta, double x, double turns,
                    int level) {
  Scene s = with(lone_beam(modes, zeta), scheme);
  const Body beam = make_body(s.resonator);
  const double apart = std::max(1.0, x);
  const int samples = static_cast<int>(std::round(turns / apart));
  const int steps = samples * static_cast<int>(std::round(apart / x)) << level;
  set_steps(s, turns / beam.modes.back().omega / steps, steps, samples);
  Vibrating out{make_model(s), {}};
  out.start = make_start(out.model);
  for (int k = 0; k < modes; ++k) {
    out.start.resonator_u[k] = 1e-3 / beam.modes[k].omega;
    out.start.resonator_v[k] = 0.7e-3 * (k % 2 == 0 ? 1 : -1);
  }
  return out;
}
std::vector<Oscillator> oscillators(const Model& model, const ModalStart& start) {
  std::vector<Oscillator> out;
  for (std::size_t k = 0; k < model.resonator.modes.size(); ++k)
    out.push_back({model.resonator.modes[k].omega, model.resonator.modes[0].zeta, 0, 0, 0,
                   start.resonator_u[k], start.resonator_v[k]});
  return out;
}

TEST_P(OrderOf, FreeDampedModes) {
  const Case& c = GetParam();
  const bool exact =
      c.scheme.time.scheme == SchemeKind::exact || c.scheme.time.scheme == SchemeKind::gautschi;
  for (const double zeta : {0.02, 0.3}) {
    SCOPED_TRACE(zeta);
    const auto runs = at_all_levels(
        [&](int level) { return vibrating(c.scheme, exact ? 4 : 1, zeta, c.x, 12, level); });
    std::vector<double> u, v;
    for (const Recording& run : runs) {
      const Errors e = errors_of(run, oscillators(run.model, run.start));
      u.push_back(e.u);
      v.push_back(e.v);
      if (!exact) continue;
      // a weight's roundings and those of a step's two sums: eight at the most, of each mode's norm
      const double size = 4 * 1.3e-3;
      EXPECT_LE(std::max(e.u, e.v), 4 * eps * static_cast<double>(run.model.steps) * size);
    }
    if (exact) continue;
    expect_order(u, c.scheme.table().order, c.x, "displacement");
    expect_order(v, c.scheme.table().order, c.x, "velocity");
  }
}

TEST(ExactScheme, IsExactAtLargeStepsToo) {
  for (const double zeta : {0.0, 0.02, 0.9})
    for (const double x : {0.5, 3.0, 50.0}) {
      SCOPED_TRACE(testing::Message() << "zeta " << zeta << ", x " << x);
      Scene s = with(lone_beam(3, zeta), schemes[6]);
      const int steps = 1000;
      set_steps(s, x / make_body(s.resonator).modes.back().omega, steps, 100);
      const Model model = make_model(s);
      ModalStart start = make_start(model);
      start.resonator_u = {1e-6, -1e-6, 1e-7};
      start.resonator_v = {1e-3, 2e-3, -1e-3};
      count_energy(model, start);
      const Recording run = simulate({model}, {start})[0];
      const Errors e = errors_of(run, oscillators(model, start));
      // and the angle of a step is known to x eps/2 only; the mode's norm is below 4e-3 in all
      EXPECT_LE(std::max(e.u, e.v), (4 + x) * eps * steps * 4e-3);
    }
}

/// Its V is that of a chord: at x = 1 its square is 8 % less than that of the velocity.
TEST(GautschiScheme, LevelAndLossAreThoseOfTheVelocity) {
  constexpr double x = 1.0, zeta = 1e-4;
  Scene s = with(lone_beam(1, zeta), scheme_of(SchemeKind::gautschi));
  set_steps(s, x / make_body(s.resonator).modes[0].omega, 2000, 2);
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  start.resonator_v = {1e-3};
  count_energy(model, start);
  const Recording run = simulate({model}, {start})[0];
  // the energy falls by exp(-2 zeta omega t); its mean over the time, but for a period's share of
  // it
  const double decay = 2 * zeta * x * 2000, mean = -std::expm1(-decay) / decay;
  const double expected = std::sqrt(0.5 * mean * mean_squares(model)[0]) * 1e-3;
  EXPECT_NEAR(v_rms(model, run.end, {}) / expected, 1, 2e-3);
  EXPECT_NEAR(run.samples.damping_loss.back() / (start.energy * -std::expm1(-decay)), 1, 2e-3);
}

TEST_P(OrderOf, ModesUnderASmoothForce) {
  // A force that travels on the beam all the time: mode k feels (P/m) sqrt(2/L) sin(k pi (a + V
  // t)/L).
  const Case& c = GetParam();
  constexpr int modes = 3;
  constexpr double force = 2, from = 0.05;
  double speed = 0;
  const auto runs = at_all_levels([&](int level) {
    Vibrating out = vibrating(c.scheme, modes, 0.02, c.x, 15, level);
    Scene s = out.model.scene;
    const Body beam = make_body(s.resonator);
    // from 0.05 m to 0.25 m of 0.3 m while the fastest mode turns by 15: mode 3 is driven at 0.42
    // of its frequency, mode 2 at 0.6, mode 1 at 1.3
    speed = 0.2 / s.duration;
    s.resonator.moving_forces = {{force, speed, from}};
    out.model = make_model(s);
    return out;
  });
  std::vector<double> u, v;
  for (const Recording& run : runs) {
    std::vector<Oscillator> reference = oscillators(run.model, run.start);
    const Body& beam = run.model.resonator;
    for (int k = 0; k < modes; ++k) {
      reference[k].p = force / beam.modes[0].mass * std::sqrt(2 / beam.length);
      reference[k].drive = (k + 1) * pi * speed / beam.length;
      reference[k].phase = (k + 1) * pi * from / beam.length;
    }
    const Errors e = errors_of(run, reference);
    u.push_back(e.u);
    v.push_back(e.v);
  }
  expect_order(u, c.forced, c.x, "displacement");
  expect_order(v, c.forced, c.x, "velocity");
}

TEST_P(OrderOf, AMassUnderItsLoadOnASpringOfContact) {
  // One peak that never leaves the flat resonator: x'' = (L - k x)/m for its depth x, so
  // x = L/k + (x0 - L/k) cos(omega t). The load acts at every stage, and so does the force at its
  // depth.
  const Case& c = GetParam();
  if (c.scheme.table().stages < 2)
    GTEST_SKIP() << "its contact force is that of the step's beginning";
  constexpr double omega = 1e4, height = 1e-5, load = 0.03;
  Scene s = with(plate_scene(1, 0.004, 1e-3, 0.0), c.scheme);
  s.resonator = rigid(s.resonator);
  s.slider = steel(0.004, 1e-3, 0.02, 0.0, 0);
  s.slider.support = Support::free;
  s.slider.load = load;
  s.slider.surface = peaks({{.at = 0.002, .height = height, .half_width = s.spacing}});
  s.initial = Initial::rest;
  const Body slider = make_body(s.slider);
  const double mass = slider.mass, k = mass * omega * omega;
  s.contact.stiffness = k / s.spacing / s.slider.width;
  const double rest = load / k, begin = 0.5 * rest, end = 7.0;
  s.gap = height - begin;
  const auto runs = at_all_levels([&](int level) {
    const auto steps = static_cast<std::int64_t>(std::ceil(end / c.x)) << level;
    set_steps(s, end / omega / static_cast<double>(steps), steps);
    const Model model = make_model(s);
    return std::pair{model, make_start(model)};
  });
  std::vector<double> errors;
  for (const Recording& run : runs) {
    ASSERT_EQ(run.end.contact_steps, run.end.step);
    const double heave = 1 / std::sqrt(s.slider.length);  // of the mode, everywhere
    const double u = run.end.slider_u[0] * heave, v = run.end.slider_v[0] * heave;
    errors.push_back(std::hypot(u + begin - rest - (begin - rest) * std::cos(end),
                                v / omega + (begin - rest) * std::sin(end)));
  }
  expect_order(errors, c.scheme.table().order, c.x, "depth and velocity");
}

TEST_P(OrderOf, TheDampingLossOfWhatBeginsWithAVelocityIsAllThatGoes) {
  // The loss is summed over the steps with half weights at both ends where the scheme's order
  // allows: with the first velocity left out it would miss zeta omega tau of the energy at the
  // start.
  const Case& c = GetParam();
  if (c.scheme.table().order < 2) GTEST_SKIP() << "the scheme itself takes or gives as much";
  const double x = 0.02, zeta = 0.05;
  Scene s = with(lone_beam(1, zeta), c.scheme);
  set_steps(s, x / make_body(s.resonator).modes[0].omega, 500);
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  start.resonator_v = {1e-3};
  count_energy(model, start);
  const SampleBlock samples = simulate({model}, {start})[0].samples;
  const double before = samples.kinetic.front() + samples.elastic.front();
  const double left = samples.kinetic.back() + samples.elastic.back();
  EXPECT_LT(left, 0.5 * before);
  EXPECT_NEAR(samples.damping_loss.back(), before - left, 0.2 * zeta * x * before);
}

TEST_P(OrderOf, EnergyAndLevelOfAFreeDecay) {
  // What is missing in the balance is the scheme's error, or that of the loss: 2 zeta omega m V^2
  // summed over the steps, with half weights at both ends (order 2), over the midpoint scheme's
  // half steps (order 2), or over backward Euler's new velocities (order 1).
  const Case& c = GetParam();
  const double x = std::min(c.x, 0.05);
  const auto runs =
      at_all_levels([&](int level) { return vibrating(c.scheme, 1, 0.3, x, 11, level); });
  std::vector<double> residual, level_error;
  for (const Recording& run : runs) {
    EXPECT_GT(run.samples.damping_loss.back(), 0.3 * run.energy.turnover);
    EXPECT_GT(std::abs(run.energy.relative()), 1e-12) << "roundings";
    residual.push_back(std::abs(run.energy.residual));
    // E(0) - E(T) = 2 zeta omega m V_rms^2 T for one mode: what the level is made of, without half
    // weights
    const Oscillator mode = oscillators(run.model, run.start)[0];
    const Complex end = mode.at(run.model.scene.duration);
    const auto energy = [&](long double u, long double v) {
      return v * v + mode.omega * mode.omega * u * u;
    };
    const double square = static_cast<double>(
        (energy(mode.u0, mode.v0) - energy(end.real(), end.imag())) / (4 * mode.zeta * mode.omega));
    level_error.push_back(run.end.resonator_square[0] * run.model.scene.time.step / square - 1);
  }
  expect_order(residual, c.loss, x, "energy");
  // The level counts the new velocities: (V(T)^2 - V(0)^2) tau/2 too much, of first order; the rest
  // is the scheme's.
  for (int level = 0; level <= levels; ++level)
    EXPECT_LE(std::abs(level_error[level]), 12 * std::ldexp(x, -level));
}

}  // namespace
}  // namespace ra2d::test
