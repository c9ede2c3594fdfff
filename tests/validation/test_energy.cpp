// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

/// The energy closes: kinetic + elastic + contact + damping loss = start + sliding work + load
/// work. What is missing is the scheme's error, of first order in the step.
namespace ra2d::test {
namespace {

/// A plate with a few modes under a smooth rigid slider.
Scene smooth_scene(double damping) {
  Scene s = plate_scene(4, 0.004, 0.004, damping);
  s.duration = 4e-4;
  s.start = 0.028;
  s.output.rate = 5e4;
  s.contact.stiffness = 1e12;
  return s;
}

SurfaceSpec one_peak(double at, double half_width) {
  return peaks({{.at = at, .height = 1e-5, .half_width = half_width}});
}

/// Halves the step four times; the residual halves each time, to 15 % of an order.
void expect_first_order(const Scene& scene, std::int64_t least_contact) {
  double coarse = 0;
  for (int halving = 0; halving <= 4; ++halving) {
    Scene fine = scene;
    fine.time.step = std::ldexp(scene.time.step, -halving);
    const Recording run = simulate(fine);
    ASSERT_EQ(run.end.status, Status::done);
    EXPECT_GE(run.end.contact_steps, least_contact << halving);
    const double residual = run.energy.residual;
    // far above roundings, so that it is the scheme that is seen
    EXPECT_GT(std::abs(run.energy.relative()), 1e-9);
    EXPECT_LT(std::abs(run.energy.relative()), 0.2);
    if (halving > 0) {
      EXPECT_NEAR(std::log2(coarse / residual), 1.0, 0.15)
          << "halving " << halving << ", residual " << residual << " J of " << run.energy.turnover;
    }
    coarse = residual;
  }
}

TEST(EnergyOrder, SingleShock) {
  // a peak slides against a peak and past it
  for (const double damping : {0.0, 0.02}) {
    SCOPED_TRACE(damping);
    Scene s = smooth_scene(damping);
    s.speed = 5;
    s.gap = 1.95e-5;
    s.slider.surface = one_peak(0.002, 4e-4);
    s.resonator.surface = one_peak(0.0308, 4e-4);
    expect_first_order(s, 100);
  }
}

TEST(EnergyOrder, ThrownPlateStrikesAStandingPeak) {
  for (const double damping : {0.0, 0.1}) {
    SCOPED_TRACE(damping);
    Scene s = smooth_scene(damping);
    s.resonator.modes = 2;
    s.gap = 1.0e-5;
    s.slider.surface = one_peak(0.002, 2e-4);
    s.resonator.moving_forces = {{.force = 4, .speed = 0, .start = 0.03}};
    expect_first_order(s, 100);
  }
}

TEST(EnergyOrder, RoughFacesBeforeChaos) {
  for (const double damping : {0.0, 0.05}) {
    SCOPED_TRACE(damping);
    Scene s = smooth_scene(damping);
    s.duration = 2e-4;
    s.speed = 0.5;
    s.time.step = 5e-8;
    s.gap = 1.2e-6;
    s.contact.stiffness = 1e11;
    s.resonator.surface = gaussian(1e-6, 1e-3, 8);
    s.slider.surface = gaussian(1e-6, 1e-3, 7);
    expect_first_order(s, 100);
  }
}

TEST(EnergyOrder, FreeSliderUnderALoad) {
  Scene s = smooth_scene(0.02);
  s.slider.support = Support::free;
  s.slider.modes = 0;
  s.slider.load = 40;
  s.slider.surface = one_peak(0.002, 4e-4);
  s.gap = 1.05e-5;
  s.contact.stiffness = 1e11;
  expect_first_order(s, 100);
}

TEST(EnergyOrder, MovingForceWithoutContact) {
  for (const double damping : {0.0, 0.02}) {
    SCOPED_TRACE(damping);
    Scene s = smooth_scene(damping);
    s.gap = 1e-2;
    s.duration = 1e-3;
    s.resonator.moving_forces = {{.force = 10, .speed = 40, .start = 0.01}};
    expect_first_order(s, 0);
  }
}

TEST(EnergyOrder, MovingForceUnderSchemesOfStages) {
  // the force's work is that at the step, whatever the scheme asks of it within one, in free flight
  // and where every state is searched
  for (const SchemeKind scheme :
       {SchemeKind::explicit_euler, SchemeKind::heun, SchemeKind::rk4, SchemeKind::rk8})
    for (const Nodes nodes : {Nodes::candidates, Nodes::all}) {
      SCOPED_TRACE(testing::Message() << "scheme " << static_cast<int>(scheme)
                                      << (nodes == Nodes::all ? ", all nodes" : ""));
      Scene s = smooth_scene(0.02);
      s.time.scheme = scheme;
      s.time.nodes = nodes;
      s.gap = 1e-2;
      s.duration = 1e-3;
      s.resonator.moving_forces = {{.force = 10, .speed = 40, .start = 0.01}};
      expect_first_order(s, 0);
    }
}

TEST(Energy, ALongChaoticRunKeepsClosing) {
  // Backward Euler damps a mode by omega tau/2 on top of zeta, and its loss is what is missing:
  // below omega tau/(2 zeta) of the damping loss for the highest mode, and far less for the others.
  // The explicit contact spring gives or takes omega_c tau of a shock's energy with either sign,
  // which averages out.
  Scene s = smooth_scene(0.02);
  s.duration = 0.03;
  s.speed = 0.5;
  s.start = 0.02;
  s.time.step = 5e-8;
  s.resonator.modes = 8;
  s.slider.support = Support::free;
  s.slider.load = 5;
  s.contact.stiffness = 1e13;
  s.resonator.surface = gaussian(2e-6, 5e-4, 8);
  s.slider.surface = gaussian(2e-6, 5e-4, 7);
  s.initial = Initial::statics;
  const Recording run = simulate(s);
  ASSERT_EQ(run.end.status, Status::done);
  ASSERT_GT(run.shocks.size(), 100u);
  const double omega = run.model.resonator.modes.back().omega;
  const double share = omega * s.time.step / (2 * s.resonator.damping);
  ASSERT_LT(share, 0.5) << "the bound says nothing";
  EXPECT_LT(std::abs(run.energy.residual), share * run.samples.damping_loss.back());
  EXPECT_GT(run.samples.damping_loss.back(), 10 * run.samples.kinetic.back())
      << "many times the energy that is there has gone through";
}

TEST(Energy, NothingHappensNothingIsMissing) {
  Scene s = smooth_scene(0.02);
  s.gap = 1e-3;
  const Recording run = simulate(s);
  EXPECT_EQ(run.energy.residual, 0.0);
  EXPECT_EQ(run.energy.turnover, 0.0);
}

}  // namespace
}  // namespace ra2d::test
