// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/result/record.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

/// A constant force that crosses a pinned beam without damping (Fryba, Vibration of Solids and
/// Structures under Moving Loads, chapter 1; Olsson, J. Sound Vib. 145, 1991). Mode k feels P
/// psi_k(v t) = P sqrt(2/L) sin(k pi v t/L) while the force is on the beam, and then vibrates
/// freely.
namespace {

using namespace ra2d;

using test::eps;
using test::pi;

constexpr int modes = 5;
constexpr double force = 10;  // N

/// The two bodies never touch: the beam bends by less than the millimetre between them.
Scene crossing(double speed) {
  Scene s = test::strip_scene(modes, 0, 0.14, 0.02);
  s.gap = 1e-3;
  s.contact.stiffness = 1e15;
  s.resonator.moving_forces = {{force, speed, 0.0}};
  s.output.probes = {0.5 * s.resonator.length};
  return s;
}

void set_steps(Scene& s, double duration, int steps, int samples = 1) {
  s.time.step = duration / steps;
  s.duration = duration;
  s.output.rate = samples / duration;
}

/// (pi/L) sqrt(D/m) = omega L/pi of the first mode: a force of this speed passes a half wave of the
/// first mode in half its period.
double critical_speed() {
  Scene s = crossing(1);
  const Body beam = make_body(s.resonator);
  return beam.modes[0].omega * beam.length / pi;
}

struct State {
  double u, v;
};

/// Mode k (from 0) at a time: U'' + omega^2 U = p sin(Omega t), from rest, until the force leaves
/// at L/v.
State mode_at(const Body& beam, int k, double speed, double time) {
  const double omega = beam.modes[k].omega, drive = (k + 1) * pi * speed / beam.length;
  const double p = force / beam.modes[0].mass * std::sqrt(2 / beam.length);
  const double left = beam.length / speed, t = std::min(time, left);
  State y;
  if (std::abs(drive - omega) < 1e-9 * omega) {
    // at resonance the amplitude grows with time; 1e-9 off, the two forms differ by as little
    y.u = p / (2 * omega * omega) * (std::sin(omega * t) - omega * t * std::cos(omega * t));
    y.v = p / 2 * t * std::sin(omega * t);
  } else {
    const double scale = p / (omega * omega - drive * drive);
    y.u = scale * (std::sin(drive * t) - drive / omega * std::sin(omega * t));
    y.v = scale * drive * (std::cos(drive * t) - std::cos(omega * t));
  }
  const double c = std::cos(omega * (time - t)), s = std::sin(omega * (time - t));
  return {y.u * c + y.v / omega * s, y.v * c - omega * y.u * s};
}

double deflection(const Body& beam, double x, double speed, double time) {
  double sum = 0;
  for (int k = 0; k < modes; ++k)
    sum += mode_at(beam, k, speed, time).u * std::sqrt(2 / beam.length) *
           std::sin((k + 1) * pi * x / beam.length);
  return sum;
}

double energy(const Body& beam, double speed, double time) {
  double sum = 0;
  for (int k = 0; k < modes; ++k) {
    const State y = mode_at(beam, k, speed, time);
    sum += 0.5 * beam.modes[k].mass * (y.v * y.v + std::pow(beam.modes[k].omega * y.u, 2));
  }
  return sum;
}

TEST(MovingForceSeries, SolvesTheEquationOfMotion) {
  // The reference itself, by central differences: h^2/12 omega_max^4 U and the rounding eps U/h^2.
  const Body beam = make_body(crossing(1).resonator);
  for (const double ratio : {0.4, 1.0, 1.7}) {
    const double speed = ratio * critical_speed(), left = beam.length / speed;
    for (int k = 0; k < modes; ++k)
      for (const double time : {0.3 * left, 0.9 * left, 1.4 * left}) {
        const double omega = beam.modes[k].omega, drive = (k + 1) * pi * speed / beam.length;
        const double h = 1e-3 / std::max(omega, drive);
        const State y = mode_at(beam, k, speed, time);
        const double before = mode_at(beam, k, speed, time - h).u;
        const double after = mode_at(beam, k, speed, time + h).u;
        const double p = time < left ? force / beam.modes[0].mass * std::sqrt(2 / beam.length) *
                                           std::sin(drive * time)
                                     : 0.0;
        const double top = force / beam.modes[0].mass * std::sqrt(2 / beam.length);
        // all terms are of the order p (secular ones times the angle passed, below 10); h omega =
        // 1e-3
        EXPECT_NEAR((after - 2 * y.u + before) / (h * h) + omega * omega * y.u, p, 1e-5 * top);
        EXPECT_NEAR((after - before) / (2 * h), y.v, 1e-5 * top / omega);
      }
  }
}

struct Speed {
  const char* name;
  double ratio;  // to the critical speed
};
class MovingForceSpeeds : public testing::TestWithParam<Speed> {};
INSTANTIATE_TEST_SUITE_P(Speeds, MovingForceSpeeds,
                         testing::Values(Speed{"Subcritical", 0.4}, Speed{"Critical", 1.0},
                                         Speed{"Supercritical", 1.7}),
                         [](const auto& info) { return info.param.name; });

/// Errors over a run, each the largest over the samples.
struct Errors {
  double deflection = 0, velocity = 0, work = 0;
};
Errors errors_of(const Scene& scene, double speed) {
  const test::Recording run = test::simulate(scene);
  EXPECT_EQ(run.end.status, Status::done);
  EXPECT_EQ(run.end.contact_steps, 0);
  const Body& beam = run.model.resonator;
  const double middle = 0.5 * beam.length;
  Errors e;
  for (std::size_t i = 0; i < run.samples.time.size(); ++i) {
    const double t = run.samples.time[i];
    double rate = 0;
    for (int k = 0; k < modes; ++k)
      rate +=
          mode_at(beam, k, speed, t).v * std::sqrt(2 / beam.length) * std::sin((k + 1) * pi / 2);
    e.deflection = std::max(e.deflection, std::abs(run.samples.probe_displacement[i] -
                                                   deflection(beam, middle, speed, t)));
    e.velocity = std::max(e.velocity, std::abs(run.samples.probe_velocity[i] - rate));
    // no damping: what the force did is what the beam has
    e.work = std::max(e.work, std::abs(run.samples.load_work[i] - energy(beam, speed, t)));
  }
  return e;
}

TEST_P(MovingForceSpeeds, DeflectionAndWorkConvergeAtFirstOrder) {
  const double speed = GetParam().ratio * critical_speed();
  Scene scene = crossing(speed);
  const double left = scene.resonator.length / speed;
  Errors coarse;
  int steps = 100'000;  // over one and a half crossings: the force leaves at two thirds
  for (int level = 0; level < 5; ++level, steps *= 2) {
    set_steps(scene, 1.5 * left, steps, 200);
    const Errors fine = errors_of(scene, speed);
    if (level > 0) {
      EXPECT_NEAR(std::log2(coarse.deflection / fine.deflection), 1.0, 0.1) << steps << " steps";
      EXPECT_NEAR(std::log2(coarse.velocity / fine.velocity), 1.0, 0.1) << steps << " steps";
      EXPECT_NEAR(std::log2(coarse.work / fine.work), 1.0, 0.1) << steps << " steps";
    }
    coarse = fine;
  }
}

/// Backward Euler by hand, all modes, in long double: states, the force's work, the scheme's
/// dissipation.
struct ByHand {
  std::vector<long double> u, v;
  long double work = 0, dissipation = 0;
};
ByHand march_by_hand(const Model& model, const std::vector<MovingForce>& forces, int steps) {
  const Body& beam = model.resonator;
  ByHand y{std::vector<long double>(modes, 0), std::vector<long double>(modes, 0)};
  const long double tau = model.scene.time.step;
  for (int n = 0; n < steps; ++n)
    for (int k = 0; k < modes; ++k) {
      const long double omega = beam.modes[k].omega;
      long double f = 0;
      for (const MovingForce& each : forces) {
        const long double x = each.start + n * (each.speed * tau);
        if (x >= 0 && x <= beam.length)
          f += each.force * static_cast<long double>(beam.modes[k].shape->largest()) *
               std::sin(static_cast<long double>(beam.modes[k].shape->wave_number()) * x);
      }
      const long double v1 =
          (y.v[k] - tau * omega * omega * y.u[k] + tau * f / beam.modes[0].mass) /
          (1 + omega * omega * tau * tau);
      y.work += tau * f * v1;
      y.dissipation +=
          0.5L * beam.modes[0].mass * (std::pow(v1 - y.v[k], 2) + std::pow(omega * tau * v1, 2));
      y.u[k] += tau * v1;
      y.v[k] = v1;
    }
  return y;
}

TEST_P(MovingForceSpeeds, IsBackwardEulerToTheLastRoundings) {
  const double speed = GetParam().ratio * critical_speed();
  constexpr int steps = 30'000;
  Scene scene = crossing(speed);
  set_steps(scene, 1.5 * scene.resonator.length / speed, steps);
  const test::Recording run = test::simulate(scene);
  const ByHand hand = march_by_hand(run.model, scene.resonator.moving_forces, steps);
  // Eight roundings a step in each mode (see the free decay) and some forty in the force's shape:
  // the series' table stands at patch centres, whose phase beta x is itself rounded. Counted on the
  // energy that the force could at most have given.
  double scale = 0;
  for (int k = 0; k < modes; ++k)
    scale += std::hypot(static_cast<double>(hand.v[k]),
                        run.model.resonator.modes[k].omega * static_cast<double>(hand.u[k]));
  const double velocity_a_step = force / run.model.resonator.modes[0].mass *
                                 run.model.resonator.modes[0].shape->largest() * scene.time.step;
  const double tolerance = steps * eps * (4 * scale + 20 * velocity_a_step);
  for (int k = 0; k < modes; ++k) {
    EXPECT_NEAR(run.end.resonator_v[k], static_cast<double>(hand.v[k]), tolerance);
    EXPECT_NEAR(run.model.resonator.modes[k].omega * run.end.resonator_u[k],
                static_cast<double>(run.model.resonator.modes[k].omega * hand.u[k]), tolerance);
  }
}

TEST_P(MovingForceSpeeds, WorkClosesTheEnergy) {
  // Exactly: kinetic + elastic = work - dissipation of the scheme, m ((V1 - V0)^2 + omega^2 (U1 -
  // U0)^2)/2 a step and mode. So the balance's residual is that dissipation and nothing else.
  const double speed = GetParam().ratio * critical_speed();
  constexpr int steps = 30'000;
  Scene scene = crossing(speed);
  set_steps(scene, 1.5 * scene.resonator.length / speed, steps);
  const test::Recording run = test::simulate(scene);
  const ByHand hand = march_by_hand(run.model, scene.resonator.moving_forces, steps);
  const double most = run.energy.turnover;
  const double tolerance = 50 * steps * eps * most;  // roundings as above, squared
  EXPECT_NEAR(run.samples.load_work.back(), static_cast<double>(hand.work), tolerance);
  EXPECT_NEAR(run.end.force_work, static_cast<double>(hand.work), tolerance);
  EXPECT_NEAR(run.energy.residual, -static_cast<double>(hand.dissipation), tolerance);
  EXPECT_GT(static_cast<double>(hand.dissipation), 1e3 * tolerance) << "nothing is tested";
  EXPECT_EQ(run.samples.load_work.front(), 0);
  EXPECT_EQ(run.samples.damping_loss.back(), 0);
  EXPECT_EQ(run.samples.sliding_work.back(), 0);
}

TEST_P(MovingForceSpeeds, AdaptiveStepsKeepTheirTolerance) {
  const double speed = GetParam().ratio * critical_speed();
  Scene scene = crossing(speed);
  set_steps(scene, 1.5 * scene.resonator.length / speed, 1, 200);
  scene.time.scheme = SchemeKind::adaptive;
  const Body beam = make_body(scene.resonator);
  double most_u = 0, most_v = 0, most = 0;
  for (int i = 0; i <= 200; ++i) {
    const double t = scene.duration * i / 200;
    most_u = std::max(most_u, std::abs(deflection(beam, 0.15, speed, t)));
    most = std::max(most, energy(beam, speed, t));
  }
  most_v = std::sqrt(2 * most / beam.modes[0].mass) * std::sqrt(2 / beam.length);
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    scene.time.tolerance = tolerance;
    const Errors e = errors_of(scene, speed);
    // some fifty steps, and what they leave of each adds up at the worst; 1e-13: the force's place,
    // in patches, and the time, each to some hundred ulp of what they are multiplied with
    EXPECT_LT(e.deflection, (10 * tolerance + 1e-13) * most_u) << tolerance;
    EXPECT_LT(e.velocity, (10 * tolerance + 1e-13) * most_v) << tolerance;
    EXPECT_LT(e.work, (10 * tolerance + 1e-13) * most) << tolerance;
  }
}

TEST(MovingForce, EnergyClosesAtFirstOrder) {
  const double speed = 0.6 * critical_speed();
  Scene scene = crossing(speed);
  double coarse = 0;
  int steps = 50'000;
  for (int level = 0; level < 5; ++level, steps *= 2) {
    set_steps(scene, 1.5 * scene.resonator.length / speed, steps, 10);
    const double residual = test::simulate(scene).energy.residual;
    EXPECT_LT(residual, 0);
    if (level > 0) {
      EXPECT_NEAR(std::log2(coarse / residual), 1.0, 0.1) << steps << " steps";
    }
    coarse = residual;
  }
}

TEST(MovingForce, BeamVibratesFreelyOnceItHasLeft) {
  const double speed = 0.7 * critical_speed();
  constexpr int steps = 40'000, samples = 40;
  Scene scene = crossing(speed);
  set_steps(scene, 2 * scene.resonator.length / speed, steps, samples);
  const test::Recording run = test::simulate(scene);
  const double work = run.samples.load_work[samples / 2 + 1];
  EXPECT_GT(work, 0);
  for (int i = samples / 2 + 1; i <= samples; ++i) {
    EXPECT_EQ(run.samples.load_work[i], work);  // nothing is added, not even a zero's rounding
    // energy then only falls
    EXPECT_LE(run.samples.kinetic[i] + run.samples.elastic[i],
              run.samples.kinetic[i - 1] + run.samples.elastic[i - 1]);
  }
}

TEST(MovingForce, TwoForcesSuperpose) {
  const double speed = 0.8 * critical_speed();
  constexpr int steps = 30'000;
  Scene one = crossing(speed), other = one, both = one;
  other.resonator.moving_forces = {{-4.0, -0.5 * speed, 0.25}};  // down, and towards the left
  both.resonator.moving_forces.push_back(other.resonator.moving_forces[0]);
  for (Scene* s : {&one, &other, &both}) set_steps(*s, 0.3 / speed, steps);
  const auto runs = test::simulate(std::vector<Scene>{one, other, both});
  const ByHand hand = march_by_hand(runs[2].model, both.resonator.moving_forces, steps);
  double scale = 0;
  for (int i : {0, 1})
    for (int k = 0; k < modes; ++k)
      scale += std::hypot(runs[i].end.resonator_v[k],
                          runs[i].model.resonator.modes[k].omega * runs[i].end.resonator_u[k]);
  const double velocity_a_step = 14 / runs[0].model.resonator.modes[0].mass *
                                 runs[0].model.resonator.modes[0].shape->largest() * one.time.step;
  const double tolerance = steps * eps * (4 * scale + 20 * velocity_a_step);  // as above
  for (int k = 0; k < modes; ++k) {
    EXPECT_NEAR(runs[0].end.resonator_v[k] + runs[1].end.resonator_v[k], runs[2].end.resonator_v[k],
                tolerance);
    EXPECT_NEAR(runs[2].end.resonator_v[k], static_cast<double>(hand.v[k]), tolerance);
  }
}

TEST(MovingForce, BeforeTheBeamIsNoForce) {
  // It enters after half of the run, from outside the left end.
  const double speed = 0.5 * critical_speed();
  Scene scene = crossing(speed);
  scene.resonator.moving_forces[0].start = -0.1;
  set_steps(scene, 0.2 / speed, 2000, 4);
  const test::Recording run = test::simulate(scene);
  for (int i = 0; i <= 1; ++i) {
    EXPECT_EQ(run.samples.kinetic[i], 0);
    EXPECT_EQ(run.samples.load_work[i], 0);
  }
  EXPECT_GT(run.samples.kinetic[3], 0);
  const ByHand hand = march_by_hand(run.model, scene.resonator.moving_forces, 2000);
  EXPECT_NEAR(run.samples.load_work.back(), static_cast<double>(hand.work),
              50 * 2000 * eps * run.energy.turnover);
}

}  // namespace
