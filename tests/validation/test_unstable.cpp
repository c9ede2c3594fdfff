// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "host/scene_file/scene_file.hpp"
#include "kernels/limits.hpp"
#include "tests/compare.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// A step beyond the limit of the explicit contact spring is noticed, and no other step.
namespace ra2d::test {
namespace {

/// The kappa at which a motion of two steps' period neither grows nor falls, contact at slider node
/// n alone and nothing sliding. With U1 = -U0, V1 = -V0, backward Euler gives U0 = -tau V1/2 and
///   m (4 + 4 zeta omega tau + (omega tau)^2) U0 = tau^2 k phi sum_j phi_j U_j,
/// so 1 = k sum_j phi_j^2 tau^2/(m (4 + 4 zeta omega tau + (omega tau)^2)).
double limiting_kappa(const Scene& s, int node) {
  double sum = 0;
  const auto add = [&](const Body& beam, double x) {
    for (const BodyMode& mode : beam.modes) {
      const double psi = shape_at(mode, x);
      const double turn = mode.omega * s.time.step;
      sum += psi * psi * s.time.step * s.time.step /
             (beam.modes[0].mass * (4 + 4 * beam.modes[0].zeta * turn + turn * turn));
    }
  };
  add(make_body(s.resonator), s.start + node * s.spacing);
  add(make_body(s.slider), node * s.spacing);
  return 1 / sum / s.spacing / std::min(s.resonator.width, s.slider.width);
}

/// Runs to the end.
Snapshot run(const Model& model, const ModalStart& start) {
  Batch batch({model}, {start});
  do {
    batch.march(model.steps);
    batch.drain(0);
  } while (batch.snapshot(0).status == Status::running);
  return batch.snapshot(0);
}

/// Runs from the scene's equilibrium with the plate nudged by a share of its deflection.
Snapshot run_nudged(const Scene& scene, double share) {
  const Model model = make_model(scene);
  ModalStart start = make_start(model);
  for (double& u : start.resonator_u) u *= 1 + share;
  return run(model, start);
}

/// Runs from the equilibrium over a softer contact, a tenth of the limit.
Snapshot run_stiffened(Scene scene, double beyond, int node) {
  const double limit = limiting_kappa(scene, node);
  scene.contact.stiffness = 0.1 * limit;
  const ModalStart start = make_start(make_model(scene));
  scene.contact.stiffness = beyond * limit;
  return run(make_model(scene), start);
}

// The energy is checked every 4096 steps at the least (longest_flight, kernels/limits.hpp).
constexpr std::int64_t steps_between_checks = 4096;

TEST(Unstable, TheLimitIsWhereTheFormulaPutsIt) {
  // just beyond, the smallest nudge grows; just below, it does not
  for (const double zeta : {0.0, 0.02, 0.5})
    for (const double step : {3e-7, 2e-6}) {
      SCOPED_TRACE(testing::Message() << "zeta " << zeta << ", step " << step);
      Scene s = pressed_plate();
      s.resonator.damping = zeta;
      s.time.step = step;
      s.duration = 4000 * step;
      const double limit = limiting_kappa(s, 50);
      const auto left = [&](double share) {
        s.contact.stiffness = share * limit;
        s.initial = Initial::statics;
        const Snapshot end = run_nudged(s, 1e-9);
        double speed = 0;
        for (const double v : end.resonator_v) speed = std::max(speed, std::abs(v));
        return speed;
      };
      // (1.02 limit)/limit: per step the alternating motion grows by about exp(2 sqrt(0.02)) ...
      EXPECT_GT(left(1.02), 1e3 * left(0.98));
    }
}

TEST(Unstable, NoticedWithinABoundedNumberOfStepsAtRest) {
  // At 1.5 times the limit the motion grows by (z + sqrt(z^2 - 1))^2, z^2 = 1.5, a step: 3.7. From
  // roundings to the deflection takes 30 steps; then the contact opens, and what comes back from
  // each shock grows by a factor that depends on where in a step it falls. The closer to the limit,
  // the more of them it takes.
  for (const double beyond : {1.5, 4.0, 100.0}) {
    SCOPED_TRACE(beyond);
    const Snapshot end = run_stiffened(pressed_plate(), beyond, 50);
    EXPECT_TRUE(end.status == Status::unstable || end.status == Status::not_finite);
    EXPECT_LE(end.step, 4 * steps_between_checks);
    EXPECT_FALSE(end.energy <= end.energy_limit);
  }
}

TEST(Unstable, NoticedWithAFreeSlider) {
  Scene s = pressed_plate();
  s.slider.support = Support::free;
  s.slider.load_is_weight = true;
  s.slider.thickness = 0.004;
  s.gap.reset();
  s.slider.surface = peaks({{.at = 0.001, .height = 1e-5, .half_width = 3e-5},
                            {.at = 0.003, .height = 1e-5, .half_width = 3e-5}});
  const Snapshot end = run_stiffened(s, 10, 25);
  EXPECT_TRUE(end.status == Status::unstable || end.status == Status::not_finite);
  EXPECT_LE(end.step, 4 * steps_between_checks);
}

TEST(Unstable, NoticedWhileSliding) {
  for (const double beyond : {2.0, 20.0}) {
    SCOPED_TRACE(beyond);
    Scene s = pressed_plate();
    s.speed = 0.2;
    const Snapshot end = run_stiffened(s, beyond, 50);
    EXPECT_TRUE(end.status == Status::unstable || end.status == Status::not_finite);
    EXPECT_LE(end.step, 4 * steps_between_checks);
  }
}

TEST(Unstable, ACubeThatBouncesBackToWhereItStartedIsNot) {
  // at the top of a bounce the load has put in nothing on the whole, and a little speed is left
  for (const bool pinned : {false, true})
    for (const Scheme& scheme : schemes_and_implicit()) {
      SCOPED_TRACE(testing::Message() << scheme.name << (pinned ? ", no modes" : ", rigid"));
      Scene s = read_scene(scene_file("drop"));
      s.resonator.support = pinned ? Support::pinned : Support::rigid;
      s.resonator.modes = 0;
      s.resonator.max_frequency.reset();
      s.duration = 0.01;
      s.output.rate = 1e5;
      s.time.step = 1e-7;
      s = with(s, scheme);
      s.time.force = true;
      const Snapshot end = run(make_model(s), make_start(make_model(s)));
      EXPECT_EQ(end.status, Status::done) << "at step " << end.step;
      EXPECT_GE(end.shocks_begun, 2);
    }
}

TEST(Unstable, AContactThatBeginsBetweenTheStagesOfAStepIsNot) {
  // bodies at rest that touch: the first step meets a peak at its later stages alone, so nothing
  // has supplied the energy at its end but what the face does at these. Each step has its sample,
  // and with it the check.
  Scene s = read_scene(scene_file("dang2012-pinned"));
  s.slider.support = Support::rigid;
  s.initial = Initial::rest;
  s.gap.reset();
  s.time.step = 1e-8;
  s.output.rate = 1e8;
  s.duration = 2e-6;
  for (const Scheme& scheme : schemes) {
    if (scheme.table().stages == 1) continue;
    for (int seed = 1; seed <= 8; ++seed) {
      SCOPED_TRACE(testing::Message() << scheme.name << ", seed " << seed);
      s.slider.surface.seed = seed;
      const Model model = make_model(with(s, scheme));
      const Snapshot end = run(model, make_start(model));
      EXPECT_EQ(end.status, Status::done) << "at step " << end.step;
    }
  }
}

TEST(Unstable, TheScenesBesideItGoOn) {
  Scene good = pressed_plate();
  good.initial = Initial::rest;
  good.gap = 1e-5 - 1e-9;
  good.contact.stiffness = 0.05 * limiting_kappa(good, 50);
  good.speed = 0.3;
  Scene bad = good;
  bad.contact.stiffness = 50 * limiting_kappa(bad, 50);
  Scene other = good;
  other.speed = 0;
  other.resonator.modes = 3;
  const std::vector<Recording> all = simulate({good, bad, other, bad});
  EXPECT_NE(all[1].end.status, Status::done);
  EXPECT_LT(all[1].end.step, all[0].end.step);
  for (const auto& [batched, alone] :
       {std::pair{all[0], simulate(good)}, std::pair{all[2], simulate(other)}}) {
    EXPECT_EQ(batched.end.status, Status::done);
    EXPECT_TRUE(same(alone, batched));
  }
  // and a failure comes at the same step each time
  EXPECT_EQ(all[1].end.step, all[3].end.step);
  EXPECT_EQ(all[1].end.step, simulate(bad).end.step);
}

TEST(Stable, NinetyPerCentOfTheLimitRunsThrough) {
  // omega_c tau = 2 sqrt(0.9). The nudge is below the overlap, so that the contact stays closed: a
  // shock may return up to 1/(1 - 0.9) of its energy or as little as 1 - 0.9, by where in a step it
  // falls.
  for (const double share : {0.5, 0.9}) {
    SCOPED_TRACE(share);
    Scene s = pressed_plate();
    s.contact.stiffness = share * limiting_kappa(s, 50);
    s.duration = 0.5;
    const Snapshot end = run_nudged(s, 1e-7);
    EXPECT_EQ(end.status, Status::done);
    EXPECT_EQ(end.contact_steps, end.step);
  }
}

TEST(Stable, AQuarterOfTheLimitRunsThroughManyShocks) {
  Scene s = pressed_plate();
  s.contact.stiffness = 0.25 * limiting_kappa(s, 50);
  s.speed = 0.05;
  s.duration = 0.5;
  const Snapshot end = run_nudged(s, 1e-3);
  EXPECT_EQ(end.status, Status::done);
  EXPECT_GT(end.shocks_begun, 50);
}

TEST(Stable, NoFalseAlarmOnTheScenesThatComeWithTheProgram) {
  for (const char* name : {"dang2012", "dang2012-pinned", "drop", "moving-force", "peaks"}) {
    SCOPED_TRACE(name);
    Scene s = read_scene(scene_file(name));
    s.duration = std::min(s.duration, 5e-3);
    const Recording run = simulate(s);
    EXPECT_EQ(run.end.status, Status::done);
    EXPECT_EQ(run.end.step, run.model.steps);
  }
}

TEST(Stable, NoFalseAlarmForAnyDamping) {
  for (const double zeta : {0.0, 1e-4, 0.3, 2.0})
    for (const bool free : {false, true}) {
      SCOPED_TRACE(testing::Message() << "zeta " << zeta << (free ? ", free" : ", pinned"));
      Scene s = pressed_plate();
      s.resonator.damping = s.slider.damping = zeta;
      s.speed = 0.4;
      s.duration = 0.02;
      s.gap = 3e-6;
      s.resonator.surface = gaussian(1.5e-6, 4e-4, 6);
      s.slider.surface = gaussian(1.5e-6, 4e-4, 5);
      if (free) {
        s.slider.support = Support::free;
        s.slider.load = 2;
        s.gap.reset();
      }
      s.contact.stiffness = 0.01 * limiting_kappa(s, 50);
      const Recording run = simulate(s);
      EXPECT_EQ(run.end.status, Status::done)
          << "energy " << run.end.energy << " J, limit " << run.end.energy_limit << " J, step "
          << run.end.step;
      EXPECT_GT(run.end.contact_steps, 0);
    }
}

TEST(Stable, NoFalseAlarmWhenAPeakIsLiftedAndLetDownAgain) {
  // The imposed motion does work on the way up and gets nearly all of it back on the way down. What
  // is left is as small as the scheme's error of first order in the work that went through, and can
  // come out negative. A check at every sample sees the largest work; a check at the ends alone
  // does not.
  for (const double rate : {5e5, 1e3})
    for (const double step : {4e-7, 2e-7, 1e-7, 2e-8}) {
      SCOPED_TRACE(testing::Message() << step << " s, " << rate << " Hz");
      Scene s = pressed_plate();
      s.initial = Initial::rest;
      s.spacing = 5e-5;
      s.time.step = step;
      s.duration = 8e-4;
      s.output.rate = rate;
      s.start = 0.02;
      s.speed = 20;
      s.gap = 1.95e-5;
      s.contact.stiffness = 2e12;
      s.resonator.modes = 5;
      s.resonator.surface = peaks({{.at = 0.029, .height = 1e-5, .half_width = 3e-4}});
      s.slider.surface = peaks({{.at = 3e-3, .height = 1e-5, .half_width = 3e-4}});
      const Recording run = simulate(s);
      EXPECT_EQ(run.end.status, Status::done)
          << "energy " << run.end.energy << " J, limit " << run.end.energy_limit << " J, step "
          << run.end.step;
      EXPECT_GT(run.end.contact_steps, 5);
    }
}

TEST(Stable, NoFalseAlarmWhereOnlyTheDeflectionDoesWork) {
  // Flat faces but for the peak that presses: a beam on two supports gets stiffer towards its end,
  // as 1/(x (L - x))^2, so a peak that keeps its height and slides there does work on the
  // deflection alone.
  Scene s = pressed_plate();
  s.start = 0.028;
  s.speed = 2;
  s.duration = 0.0139;
  s.contact.stiffness = 0.05 * limiting_kappa(s, 50);
  const Recording run = simulate(s);
  const auto stiffness = [&](double x) { return 1 / std::pow(x * (s.resonator.length - x), 2); };
  ASSERT_GT(stiffness(0.0578), 2 * energy_factor * stiffness(0.03));
  EXPECT_EQ(run.end.status, Status::done) << "energy " << run.end.energy << " J, limit "
                                          << run.end.energy_limit << " J, step " << run.end.step;
  EXPECT_GT(run.end.energy, energy_factor * (run.samples.kinetic[0] + run.samples.elastic[0]));
}

}  // namespace
}  // namespace ra2d::test
