// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "host/device/batch.hpp"
#include "host/result/record.hpp"
#include "host/run/samples.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

/// Bodies that vibrate and touch nothing: every mode is a damped oscillator. Its motion, and the
/// motion that backward Euler gives it, have closed forms.
namespace {

using namespace ra2d;

using test::eps;
using test::pi;

/// A steel strip 300 mm long and a short one a metre above it.
Scene far_apart() {
  Scene s = test::strip_scene(1, 0.02, 0.1, 0.1);
  s.gap = 1.0;
  s.contact.stiffness = 1e14;
  s.slider.damping = 0.01;
  return s;
}

struct Case {
  std::string name;
  Support resonator;
  int resonator_modes;
  Support slider;
  int slider_modes;
};
const Case cases[] = {
    {"PinnedResonator", Support::pinned, 4, Support::rigid, 0},
    {"FreeResonator", Support::free, 3, Support::rigid, 0},
    {"FreeSlider", Support::pinned, 1, Support::free, 3},
    {"PinnedSlider", Support::pinned, 2, Support::pinned, 2},
};

Scene scene_of(const Case& c) {
  Scene s = far_apart();
  s.resonator.support = c.resonator;
  s.resonator.modes = c.resonator_modes;
  s.slider.support = c.slider;
  s.slider.modes = c.slider_modes;
  return s;
}

/// Sets the number and the length of the steps, with a sample at the beginning, at the end, and
/// `samples` - 1 between.
void set_steps(Scene& s, double step, int steps, int samples = 1) {
  s.time.step = step;
  s.duration = steps * step;
  s.output.rate = samples / s.duration;
}

struct March {
  Model model;
  Snapshot end;
  SampleBlock samples;
};

/// The modes of both bodies in one list, the resonator's first.
std::vector<double> joined(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out = a;
  out.insert(out.end(), b.begin(), b.end());
  return out;
}
std::vector<BodyMode> modes_of(const Model& m) {
  std::vector<BodyMode> modes = m.resonator.modes;
  modes.insert(modes.end(), m.slider.modes.begin(), m.slider.modes.end());
  return modes;
}

struct Start {
  std::vector<double> u, v;  // of the joined list
};

double energy_of(const Model& m, const std::vector<double>& u, const std::vector<double>& v) {
  const std::vector<BodyMode> modes = modes_of(m);
  double sum = 0;
  for (std::size_t k = 0; k < modes.size(); ++k)
    sum += 0.5 * modes[k].mass * (v[k] * v[k] + std::pow(modes[k].omega * u[k], 2));
  return sum;
}

March march(const Scene& scene, const Start& start) {
  March run;
  run.model = make_model(scene);
  const auto split = static_cast<std::ptrdiff_t>(run.model.resonator.modes.size());
  ModalStart begin;
  begin.resonator_u.assign(start.u.begin(), start.u.begin() + split);
  begin.resonator_v.assign(start.v.begin(), start.v.begin() + split);
  begin.slider_u.assign(start.u.begin() + split, start.u.end());
  begin.slider_v.assign(start.v.begin() + split, start.v.end());
  begin.energy = energy_of(run.model, start.u, start.v);
  Batch batch({run.model}, {begin});
  batch.march(run.model.steps);
  run.end = batch.snapshot(0);
  run.samples = make_samples(run.model, begin, batch.drain(0), 0);
  EXPECT_EQ(run.end.status, Status::done);
  EXPECT_EQ(run.end.contact_steps, 0);
  return run;
}
std::vector<double> u_of(const Snapshot& s) { return joined(s.resonator_u, s.slider_u); }
std::vector<double> v_of(const Snapshot& s) { return joined(s.resonator_v, s.slider_v); }

/// Every mode with about as much energy as the others, micrometres of displacement.
Start random_start(const Model& m, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.5, 1);
  Start start;
  for (const BodyMode& mode : modes_of(m)) {
    start.u.push_back(mode.omega > 0 ? 1e-3 * uniform(random) / mode.omega : 1e-6);
    start.v.push_back(1e-3 * uniform(random));
  }
  return start;
}

struct State {
  long double u, v;
};

/// U'' + 2 zeta omega U' + omega^2 U = 0.
State exact(double omega, double zeta, double u, double v, double time) {
  if (omega == 0) return {u + static_cast<long double>(v) * time, v};
  const long double decay = static_cast<long double>(zeta) * omega, t = time;
  const long double turn = omega * std::sqrt(1 - static_cast<long double>(zeta) * zeta);
  const long double c = std::cos(turn * t), s = std::sin(turn * t) / turn, e = std::exp(-decay * t);
  return {e * (u * c + (v + decay * u) * s),
          e * (v * c - (decay * v + static_cast<long double>(omega) * omega * u) * s)};
}

/// Backward Euler's step (U, V) -> (U + tau V1, V1), V1 = (V - tau omega^2 U)/s, as a matrix.
struct Matrix {
  long double a[2][2];
};
Matrix operator*(const Matrix& x, const Matrix& y) {
  Matrix out{};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) out.a[i][j] = x.a[i][0] * y.a[0][j] + x.a[i][1] * y.a[1][j];
  return out;
}
Matrix one_step(double omega, double zeta, double tau) {
  const long double w = omega, t = tau, s = 1 + 2 * zeta * w * t + w * w * t * t;
  const long double uv = -t * w * w / s;
  return {{{1 + t * uv, t / s}, {uv, 1 / s}}};
}
/// The matrix to the power `steps`, by squaring.
State discrete(double omega, double zeta, double tau, int steps, double u, double v) {
  Matrix power{{{1, 0}, {0, 1}}}, square = one_step(omega, zeta, tau);
  for (; steps > 0; steps /= 2, square = square * square)
    if (steps % 2 == 1) power = power * square;
  return {power.a[0][0] * u + power.a[0][1] * v, power.a[1][0] * u + power.a[1][1] * v};
}

double norm(double omega, long double u, long double v) {
  return static_cast<double>(std::hypot(v, omega * u));
}

class FreeDecay : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Decay, FreeDecay, testing::ValuesIn(cases),
                         [](const auto& info) { return info.param.name; });

/// Distance of the run's end from the exact one: energy norm of mode k, or of all.
double error_of(const March& run, const Start& start, double time) {
  const std::vector<BodyMode> modes = modes_of(run.model);
  const std::vector<double> u = u_of(run.end), v = v_of(run.end);
  double sum = 0;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    if (modes[k].omega == 0) continue;
    const State end = exact(modes[k].omega, modes[k].zeta, start.u[k], start.v[k], time);
    sum += std::pow(norm(modes[k].omega, u[k] - end.u, v[k] - end.v), 2);
  }
  return std::sqrt(sum);
}

/// Five lengths of step over the same time: the error halves with each.
void falls_at_first_order(Scene scene, const Start& start, double omega, double time) {
  // Numerical damping exp(-omega^2 tau t/2) is linear in tau while its exponent is small.
  int steps = static_cast<int>(std::ceil(omega * omega * time * time / 0.1));
  double coarse = 0;
  for (int level = 0; level < 5; ++level, steps *= 2) {
    set_steps(scene, time / steps, steps);
    const double error = error_of(march(scene, start), start, time);
    if (level > 0) {
      EXPECT_NEAR(std::log2(coarse / error), 1.0, 0.1) << steps << " steps";
    }
    coarse = error;
  }
}

TEST_P(FreeDecay, SingleModesConvergeAtFirstOrder) {
  Scene scene = scene_of(GetParam());
  set_steps(scene, 1e-6, 1);
  const Model model = make_model(scene);
  const std::vector<BodyMode> modes = modes_of(model);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    if (modes[k].omega == 0) continue;
    Start start = random_start(model, 1);
    for (std::size_t l = 0; l < modes.size(); ++l)
      if (l != k) start.u[l] = start.v[l] = 0;
    const double time = 1.3 * 2 * pi / modes[k].omega;
    falls_at_first_order(scene, start, modes[k].omega, time);

    // Modes do not know of one another.
    set_steps(scene, time / 1000, 1000);
    const March run = march(scene, start);
    for (std::size_t l = 0; l < modes.size(); ++l) {
      if (l == k) continue;
      EXPECT_EQ(u_of(run.end)[l], 0);
      EXPECT_EQ(v_of(run.end)[l], 0);
    }
  }
}

TEST_P(FreeDecay, SuperpositionConvergesAtFirstOrder) {
  Scene scene = scene_of(GetParam());
  set_steps(scene, 1e-6, 1);
  const Model model = make_model(scene);
  double lowest = 1e300, highest = 0;
  for (const BodyMode& mode : modes_of(model)) {
    if (mode.omega > 0) lowest = std::min(lowest, mode.omega);
    highest = std::max(highest, mode.omega);
  }
  // a whole period of the slowest, as long as the fastest is still there to be seen
  const double time = 2 * pi * std::min(1 / lowest, 8 / highest);
  falls_at_first_order(scene, random_start(model, 2), highest, time);
}

TEST_P(FreeDecay, IsTheSchemesOwnClosedForm) {
  // A step rounds each coefficient (s's four and the quotient: five), two fma in V and one in U: at
  // the most eight roundings, four eps, of the mode's norm; all of them decay as the mode does from
  // there on.
  constexpr int steps = 100'000;
  Scene scene = scene_of(GetParam());
  set_steps(scene, 1e-7, steps, 10);
  const Model model = make_model(scene);
  const Start start = random_start(model, 3);
  const March run = march(scene, start);
  const std::vector<BodyMode> modes = modes_of(run.model);
  const std::vector<double> u = u_of(run.end), v = v_of(run.end);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const double omega = modes[k].omega, zeta = modes[k].zeta;
    const State end = discrete(omega, zeta, scene.time.step, steps, start.u[k], start.v[k]);
    if (omega == 0) {
      EXPECT_EQ(v[k], start.v[k]);  // a rigid mode drifts, and nothing rounds its velocity
      EXPECT_NEAR(u[k], static_cast<double>(end.u), steps * eps / 2 * std::abs(u[k]));
      continue;
    }
    // powers of the step exceed its spectral radius by no more than the damping couples U and V
    const double grown = (1 + zeta) / (1 - zeta);
    EXPECT_LE(norm(omega, u[k] - end.u, v[k] - end.v),
              4 * steps * eps * grown * norm(omega, end.u, end.v))
        << "mode " << k;
  }
}

TEST_P(FreeDecay, EnergyGoesWhereItShould) {
  // Exactly: m (V1^2 - V0^2 + omega^2 (U1^2 - U0^2))/2 = -2 zeta omega m tau V1^2
  //          - m ((V1 - V0)^2 + omega^2 (U1 - U0)^2)/2,
  // damping loss and what the scheme itself dissipates.
  constexpr int steps = 20'000, samples = 8;
  Scene scene = scene_of(GetParam());
  set_steps(scene, 2e-6, steps, samples);
  const Model model = make_model(scene);
  const Start start = random_start(model, 4);
  const March run = march(scene, start);
  const std::vector<BodyMode> modes = modes_of(run.model);
  ASSERT_EQ(run.samples.time.size(), samples + 1);

  std::vector<State> y;
  for (std::size_t k = 0; k < modes.size(); ++k) y.push_back({start.u[k], start.v[k]});
  long double damping = 0, scheme = 0, square = 0;
  const double before = energy_of(run.model, start.u, start.v);
  // eight roundings a step, as above, twice in an energy; the sums' own, one a step
  const auto tolerance = [&](int step) { return (8 + 1) * eps * step * before + 4 * eps * before; };
  for (int step = 0; step <= steps; ++step) {
    if (step % (steps / samples) == 0) {
      const std::size_t i = static_cast<std::size_t>(step) * samples / steps;
      long double kinetic = 0, elastic = 0;
      for (std::size_t k = 0; k < modes.size(); ++k) {
        const double m = modes[k].mass;
        kinetic += 0.5L * m * y[k].v * y[k].v;
        elastic += 0.5L * m * std::pow(modes[k].omega * y[k].u, 2);
      }
      EXPECT_NEAR(run.samples.kinetic[i], static_cast<double>(kinetic), tolerance(step));
      EXPECT_NEAR(run.samples.elastic[i], static_cast<double>(elastic), tolerance(step));
      EXPECT_NEAR(run.samples.damping_loss[i], static_cast<double>(damping), tolerance(step));
      EXPECT_NEAR(run.samples.kinetic[i] + run.samples.elastic[i] + run.samples.damping_loss[i] +
                      static_cast<double>(scheme),
                  before, tolerance(step));
      EXPECT_EQ(run.samples.contact[i], 0);
      EXPECT_EQ(run.samples.sliding_work[i], 0);
      EXPECT_EQ(run.samples.load_work[i], 0);
    }
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const BodyMode& mode = modes[k];
      const State old = y[k];
      const Matrix map = one_step(mode.omega, mode.zeta, scene.time.step);
      y[k] = {map.a[0][0] * old.u + map.a[0][1] * old.v, map.a[1][0] * old.u + map.a[1][1] * old.v};
      if (step == steps) continue;
      damping += 2 * static_cast<long double>(mode.zeta) * mode.omega * mode.mass *
                 scene.time.step * y[k].v * y[k].v;
      scheme += 0.5L * mode.mass *
                (std::pow(y[k].v - old.v, 2) + std::pow(mode.omega * (y[k].u - old.u), 2));
      if (k < run.model.resonator.modes.size()) square += y[k].v * y[k].v;
    }
  }
  EXPECT_GT(static_cast<double>(damping), 0.1 * before) << "nothing is tested";
  double sum = 0;
  for (const double each : run.end.resonator_square) sum += each;
  // what v_rms is made of: eight roundings of a V^2 at each step's age, one of its sum
  EXPECT_NEAR(sum, static_cast<double>(square), 10 * eps * steps * static_cast<double>(square));
}

TEST_P(FreeDecay, DampingLossConvergesToTheEnergyLost) {
  Scene scene = scene_of(GetParam());
  set_steps(scene, 1e-6, 1);
  const Model model = make_model(scene);
  const Start start = random_start(model, 5);
  constexpr double time = 2e-3;
  double lost = energy_of(model, start.u, start.v);
  const std::vector<BodyMode> modes = modes_of(model);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const State end = exact(modes[k].omega, modes[k].zeta, start.u[k], start.v[k], time);
    lost -= 0.5 * modes[k].mass * std::pow(norm(modes[k].omega, end.u, end.v), 2);
  }
  double coarse = 0;
  int steps = 50'000;
  for (int level = 0; level < 4; ++level, steps *= 2) {
    set_steps(scene, time / steps, steps);
    const double error = std::abs(march(scene, start).samples.damping_loss.back() - lost);
    if (level > 0) {
      EXPECT_NEAR(std::log2(coarse / error), 1.0, 0.1) << steps << " steps";
    }
    coarse = error;
  }
}

TEST(RigidModes, OfASliderDriftUniformlyAndFallUnderALoad) {
  constexpr int steps = 100'000;
  Scene scene = scene_of(cases[2]);
  scene.slider.modes = 0;
  scene.slider.load = 3;
  set_steps(scene, 1e-7, steps);
  const Model model = make_model(scene);
  const March run = march(scene, {{0, 2e-6, -1e-6}, {0, 1e-3, 2e-3}});
  // translation: V = V0 + n tau F/m, U = U0 + n tau V0 + n (n + 1)/2 tau^2 F/m; a rounding a step
  // in each, V's carried on by U, and three in the coefficient
  const long double velocity_per_step =
      static_cast<long double>(scene.time.step) * model.slider.load[0] / model.slider.modes[0].mass;
  const long double n = steps, v = 1e-3L + n * velocity_per_step;
  const long double u = 2e-6L + scene.time.step * (n * 1e-3L + n * (n + 1) / 2 * velocity_per_step);
  EXPECT_NEAR(run.end.slider_v[0], static_cast<double>(v), steps * eps * static_cast<double>(v));
  EXPECT_NEAR(run.end.slider_u[0], static_cast<double>(u),
              2 * steps * eps * static_cast<double>(u));
  // rotation: no load, no change
  EXPECT_EQ(run.end.slider_v[1], 2e-3);
  EXPECT_NEAR(run.end.slider_u[1], -1e-6 + 2e-3 * run.model.scene.duration, steps * eps * 2e-5);
  // the load's work is the force times the way of the middle
  const double displacement = (run.end.slider_u[0] - 2e-6) / std::sqrt(scene.slider.length);
  EXPECT_NEAR(run.samples.load_work.back(), 3 * displacement, 8 * eps * 3 * displacement);
}

}  // namespace
