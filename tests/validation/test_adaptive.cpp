// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "tests/adaptive.hpp"
#include "tests/effort.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

/// The adaptive scheme: its answer depends on neither launches, batches nor candidates; samples
/// hold the contact law; it ends where it cannot go on. Its errors: test_adaptive_errors.cpp.
namespace ra2d::test {
namespace {

// ---- invariance -------------------------------------------------------------------------------

/// A scene of every form of contact, over candidates.
std::vector<Scene> kinds(Faces faces = Faces::linear) {
  std::vector<Scene> scenes;
  for (const Support support : {Support::free, Support::pinned, Support::rigid})
    for (const double tolerance : {1e-5, 1e-10}) {
      scenes.push_back(adaptive(rough_scene(support), tolerance));
      scenes.back().duration = 2e-4;
    }
  scenes[0].resonator.moving_forces = {{.force = 3, .speed = 40, .start = 0.01}};
  scenes[1].speed = 0;
  scenes[2].output.rate = 1e7 / 3.7;
  scenes[3].slider.surface = {};  // flat: dozens of nodes touch
  scenes[3].contact.stiffness = 1e12;
  scenes[4].output.rate = 1e3;  // no sample but the first
  // flat faces, let go where they touch
  scenes.push_back(adaptive(plate_scene(4, 0.004, 0.004), 1e-8));
  scenes.back().slider.support = Support::free;
  scenes.back().slider.load = 5;
  scenes.back().contact.stiffness = 1e12;
  scenes.back().duration = 2e-4;
  for (Scene& s : scenes) s.faces = faces;
  return scenes;
}

struct AdaptiveInvariance : testing::TestWithParam<Faces> {};
INSTANTIATE_TEST_SUITE_P(Faces, AdaptiveInvariance, testing::Values(Faces::linear, Faces::smooth),
                         [](const auto& faces) {
                           return faces.param == Faces::linear ? "Linear" : "Smooth";
                         });

TEST_P(AdaptiveInvariance, RandomScenesAreTheSameBitForBit) {
  const int scenes = draws(GetParam() == Faces::linear ? 40 : 25);
  constexpr std::uint64_t begin = 53;  // the usual forty make fewer than 20 000 steps each
  int done = 0, touching = 0, in_and_out = 0;
  std::vector<double> evaluated;  // share of those of all nodes
  for (std::uint64_t seed = begin; seed < begin + scenes; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Started c = random_adaptive_scene(seed, GetParam());
    const Recording all = run(c, Nodes::all);
    const Recording some = run(c);
    EXPECT_TRUE(same(all, some)) << "candidates";
    for (const int samples : {1, 3}) {
      const BatchOptions buffers{.capacity = {.samples = samples, .shocks = samples}};
      EXPECT_TRUE(same(all, run(c, Nodes::candidates, {.batch = buffers})))
          << samples << " samples and shocks";
    }
    for (const int launches : {17, 401})
      EXPECT_TRUE(same(all, run(c, launches == 17 ? Nodes::all : Nodes::candidates,
                                {.steps = c.model.steps / launches + 1})))
          << launches << " launches";
    EXPECT_TRUE(same(all, run(c, Nodes::candidates, {.batch = {.least_packs = 3}}))) << "padded";
    done += all.end.status == Status::done;
    touching += all.end.contact_steps > 0;
    in_and_out += all.end.shocks_begun >= 5;
    if (all.end.evaluated > 0)
      evaluated.push_back(static_cast<double>(some.end.evaluated) /
                          static_cast<double>(all.end.evaluated));
  }
  EXPECT_EQ(done, scenes);
  if (!draws_enough()) return;
  EXPECT_GE(touching, scenes / 2);
  EXPECT_GE(in_and_out, scenes / 4);
  ASSERT_FALSE(evaluated.empty());
  const auto middle = evaluated.begin() + std::ssize(evaluated) / 2;
  std::nth_element(evaluated.begin(), middle, evaluated.end());
  EXPECT_LT(*middle, GetParam() == Faces::linear ? 0.75 : 0.9);
}

TEST_P(AdaptiveInvariance, OneStepALaunch) {
  for (const Scene& scene : kinds(GetParam())) {
    const Recording whole = simulate(scene);
    ASSERT_EQ(whole.end.status, Status::done);
    EXPECT_GT(whole.end.contact_steps, 0);
    // a launch to the next tick makes one step, after steps of no length at which contacts begin
    Batch batch({whole.model}, {whole.start});
    Snapshot now = batch.snapshot(0);
    std::vector<double> rows;
    std::int64_t launches = 0;
    for (; now.status == Status::running; ++launches) {
      batch.march(now.step + 1);
      now = batch.snapshot(0);
      const Drained drained = batch.drain(0);
      rows.insert(rows.end(), drained.sample_rows.begin(), drained.sample_rows.end());
    }
    EXPECT_GT(2 * launches, whole.end.steps_made);
    EXPECT_EQ(now.steps_made, whole.end.steps_made);
    EXPECT_TRUE(same("last resonator displacement", whole.end.resonator_u, now.resonator_u));
    EXPECT_TRUE(same("last slider velocity", whole.end.slider_v, now.slider_v));
    const Capacity roomy{
        .samples = 1'000'000, .sample_bytes = 1 << 26, .nodes = whole.model.nodes()};
    Batch again({whole.model}, {whole.start}, {.capacity = roomy});
    again.march(whole.model.steps);
    EXPECT_TRUE(same("samples", again.drain(0).sample_rows, rows));
  }
}

TEST_P(AdaptiveInvariance, OtherScenesBesideItChangeNothing) {
  std::vector<Scene> scenes = kinds(GetParam());
  scenes[1].duration /= 3;
  scenes[3].resonator.modes = 20;
  scenes.push_back(rough_scene(Support::rigid));  // of fixed steps
  scenes.back().duration = 1e-4;
  const std::vector<Recording> batch = simulate(scenes);
  const std::vector<Recording> in_pieces =
      simulate(scenes, {.steps = batch[2].model.steps / 97, .batch = {.capacity = {.samples = 7}}});
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Recording alone = simulate(scenes[i]);
    EXPECT_TRUE(same(alone, batch[i])) << "scene " << i;
    EXPECT_TRUE(same(alone, in_pieces[i])) << "scene " << i;
  }
}

TEST_P(AdaptiveInvariance, AFullBufferHoldsTheMarchUp) {
  // and loses nothing while nobody empties it
  const Recording whole = simulate(kinds(GetParam())[0]);
  Batch batch({whole.model}, {whole.start}, {.capacity = {.samples = 10}});
  for (int i = 0; i < 3; ++i) {
    batch.march(whole.model.steps);
    const Snapshot now = batch.snapshot(0);
    EXPECT_EQ(now.status, Status::running);
    // the step that holds sample 10 is still to be made
    EXPECT_LE(now.step, 10 * static_cast<std::int64_t>(whole.model.steps_per_sample));
    EXPECT_GT(now.step, 0);
  }
  EXPECT_EQ(batch.drain(0).samples, 10);
  batch.march(whole.model.steps);
  EXPECT_EQ(batch.drain(0).samples, 10);
}

TEST(AdaptiveSteps, EndWhereStatisticsBegin) {
  // a beam with nothing near it: it could fly to the end at once
  Scene s = adaptive(lone_beam(2, 0.02), 1e-8);
  s.duration = 0.1;
  s.output.rate = 1e3;
  s.output.from = 0.0317;
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  start.resonator_v[0] = 0.1;
  count_energy(model, start);
  Batch batch({model}, {start});
  batch.march(first_counted(model));
  EXPECT_EQ(batch.snapshot(0).step, first_counted(model));
  batch.march(model.steps);
  EXPECT_EQ(batch.snapshot(0).step, model.steps);
}

// ---- what a sample holds ----------------------------------------------------------------------

/// Bound on the error of an overlap: roundings of its faces and of its modes, and what the windows'
/// cubics leave out of the modes, at most 1e-13 of them [m].
double overlap_error(const Model& m, const std::vector<double>& u2, const std::vector<double>& u1) {
  double size = 0;
  for (const double h : m.slider_height) size = std::max(size, std::abs(h) + std::abs(m.delta));
  double high = 0, steepest = 0;
  for (std::size_t n = 0; n + 1 < m.resonator_height.size(); ++n) {
    high = std::max(high, std::abs(m.resonator_height[n]));
    steepest = std::max(steepest, std::abs(m.resonator_height[n + 1] - m.resonator_height[n]));
  }
  size += high;
  double displacements = 0;
  for (std::size_t k = 0; k < u2.size(); ++k)
    displacements += std::abs(u2[k]) * m.resonator.modes[k].shape->largest();
  for (std::size_t k = 0; k < u1.size(); ++k)
    displacements += std::abs(u1[k]) * m.slider.modes[k].shape->largest();
  return 16 * eps * size + 4 * eps * m.position * steepest + 2e-13 * displacements;
}

TEST(AdaptiveSamples, HoldTheContactLaw) {
  // The overlaps that follow from a sample's displacements, by direct sums: their springs' force
  // and energy, and the number of nodes in contact.
  int touching = 0, in_two_or_more = 0;
  for (int seed = 1; seed <= draws(40); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // at the smallest tolerance all the terms of the shapes along the way are kept
    const Recording r = run(random_adaptive_scene(seed), 1e-13);
    const SampleBlock& s = r.samples;
    const std::size_t modes2 = r.model.resonator.modes.size(), modes1 = r.model.slider.modes.size();
    const std::size_t stride = 1 + s.time.size() / 60;
    for (std::size_t i = 0; i < s.time.size(); i += stride) {
      Model there = r.model;
      there.position += r.model.scene.speed * s.time[i] / r.model.scene.spacing;
      const auto part = [&](const std::vector<double>& all, std::size_t modes) {
        return std::vector<double>(all.begin() + i * modes, all.begin() + (i + 1) * modes);
      };
      const std::vector<double> u2 = part(s.resonator_displacement, modes2),
                                u1 = part(s.slider_displacement, modes1);
      const double off = overlap_error(there, u2, u1);
      double force = 0, energy = 0, blur = 0;
      int certain = 0, possible = 0;
      for (const double overlap : overlaps(there, u2, u1)) {
        certain += overlap > off;
        possible += overlap >= -off;
        if (overlap <= -off) continue;
        const double o = std::max(overlap, 0.0);
        force += there.node_stiffness * o;
        energy += 0.5 * there.node_stiffness * o * o;
        blur += there.node_stiffness * off;
      }
      EXPECT_GE(s.nodes[i], certain) << "sample " << i;
      EXPECT_LE(s.nodes[i], possible) << "sample " << i;
      EXPECT_NEAR(s.force[i], force, blur + 4 * eps * force) << "sample " << i;
      EXPECT_NEAR(s.contact[i], energy,
                  std::sqrt(2 * energy * blur * off) + blur * off + 8 * eps * energy)
          << "sample " << i;
      touching += certain > 0;
      in_two_or_more += certain > 1;
    }
  }
  if (!draws_enough()) return;
  EXPECT_GT(touching, 200);
  EXPECT_GT(in_two_or_more, 50);
}

TEST(AdaptiveSamples, InFreeDecayAreTheClosedFormAtTheirTimes) {
  for (const double zeta : {0.0, 0.02, 0.5}) {
    Scene s = adaptive(lone_beam(4, zeta), 1e-4);  // that plays no part: nothing touches
    s.duration = 0.01;
    s.output.rate = 1e5 / 3;  // no binary fraction
    const Model model = make_model(s);
    ModalStart start = make_start(model);
    for (int k = 0; k < 4; ++k) start.resonator_v[k] = 0.1 * (k + 1);
    count_energy(model, start);
    const Recording r = simulate({model}, {start})[0];
    ASSERT_EQ(r.samples.time.size(), 334u);
    const auto state = [&](int k, long double t) {
      const long double w = model.resonator.modes[k].omega, q = std::sqrt(1 - zeta * zeta) * w,
                        e = start.resonator_v[k] * std::exp(-zeta * w * t);
      return std::pair{e * std::sin(q * t) / q,
                       e * (std::cos(q * t) - zeta * w / q * std::sin(q * t))};
    };
    long double loss = 0;
    for (int k = 0; k < 4; ++k) {
      const double w = model.resonator.modes[k].omega, v0 = start.resonator_v[k];
      for (std::size_t i = 0; i < r.samples.time.size(); ++i) {
        const auto [u, v] = state(k, i * 3.0L / 1e5L);
        // a leap rounds to 8 eps and omega t to 1/2 eps; some thirty leaps to a sample; an ulp of
        // the time
        const double off = eps * (8 * 64 + 2 * w * r.samples.time[i]) * v0;
        EXPECT_NEAR(r.samples.resonator_velocity[4 * i + k], static_cast<double>(v), off);
        EXPECT_NEAR(r.samples.resonator_displacement[4 * i + k], static_cast<double>(u), off / w);
      }
      // what was lost of the energy is the integral of 2 zeta omega m V^2
      const long double last = (r.samples.time.size() - 1) * 3.0L / 1e5L;
      const auto [at_u, at_v] = state(k, last);
      loss += 0.5L * model.resonator.modes[0].mass * (v0 * v0 - at_v * at_v - w * w * at_u * at_u);
      const auto [u, v] = state(k, s.duration);
      if (zeta > 0) {
        const double square =
            static_cast<double>((v0 * v0 - v * v - w * w * u * u) / (4 * zeta * w));
        EXPECT_NEAR(r.end.resonator_square[k] * model.tick, square, 1e-12 * square);
      } else {
        const double square = static_cast<double>(
            0.5L * v0 * v0 * (s.duration + std::sin(2.0L * w * s.duration) / (2 * w)));
        EXPECT_NEAR(r.end.resonator_square[k] * model.tick, square, 1e-12 * square);
      }
    }
    EXPECT_NEAR(r.samples.damping_loss.back(), static_cast<double>(loss), 1e-12 * r.start.energy);
    EXPECT_EQ(r.end.contact_steps, 0);
    EXPECT_LT(std::abs(r.energy.relative()), 1e-12);
  }
}

TEST(AdaptiveSamples, HoldTheLossOfThousandsOfSteps) {
  // Sums are closed every 4096 steps. A force that never comes keeps the march from flying, so each
  // window is a step. The loss is the energy that the modes no longer have.
  Scene s = adaptive(lone_beam(8, 0.02), 1e-12);
  s.speed = 10;
  s.start = 0.05;
  s.duration = 0.01;
  s.output.rate = 1e4;
  s.resonator.moving_forces = {{.force = 1, .speed = 0, .start = -1}};
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  for (double& v : start.resonator_v) v = 0.1;
  count_energy(model, start);
  const Recording r = simulate({model}, {start})[0];
  ASSERT_EQ(r.end.status, Status::done);
  ASSERT_GT(r.end.steps_made, 2 * 4096);
  const double most = static_cast<double>(r.end.steps_made) * 2e-12 * start.energy;
  for (std::size_t i = 0; i < r.samples.time.size(); ++i)
    EXPECT_NEAR(r.samples.damping_loss[i],
                start.energy - r.samples.kinetic[i] - r.samples.elastic[i], most)
        << i;
  EXPECT_GT(r.samples.damping_loss.back(), 0.1 * start.energy);
}

TEST(AdaptiveSamples, AFlatBlockLetGoOnAFlatFloorBobsOnItsSprings) {
  // Both faces are exactly zero, and nothing moves: no overlap has any rounding. All nodes touch at
  // once. Under its load F the block bobs on springs of stiffness K, m o'' = F - K o, so that they
  // carry F (1 - cos(omega t)). At the end of each period the faces just touch again.
  for (const double stiffness : {1e11, 1e14})
    for (const double tolerance : {1e-6, 1e-10}) {
      Scene s = adaptive(plate_scene(0, 0.004, 0.004, 0.0), tolerance);
      s.resonator = rigid(s.resonator);
      s.slider.support = Support::free;
      s.slider.load = 5;
      s.contact.stiffness = stiffness;
      s.duration = 3e-4 * std::sqrt(1e11 / stiffness);
      s.output.rate = 100 / s.duration;
      const Recording r = simulate(s);
      SCOPED_TRACE(std::to_string(stiffness) + ", " + std::to_string(r.end.steps_made) + " steps");
      ASSERT_EQ(r.end.status, Status::done);
      EXPECT_EQ(r.end.most_nodes, r.model.nodes());
      const double omega =
          std::sqrt(r.model.nodes() * r.model.node_stiffness / r.model.slider.mass);
      ASSERT_GT(omega * s.duration, 2 * 2 * std::numbers::pi) << "two periods";
      for (std::size_t i = 0; i < r.samples.time.size(); ++i)
        EXPECT_NEAR(r.samples.force[i], 5 * (1 - std::cos(omega * r.samples.time[i])),
                    5 * 30 * tolerance)
            << i;
    }
}

TEST(AdaptiveSamples, StaticEquilibriumStaysAtRest) {
  for (const Support slider : {Support::rigid, Support::free}) {
    Scene s = adaptive(pressed_plate(), 1e-12);
    s.contact.stiffness = 1e14;
    s.slider.support = slider;
    if (slider == Support::free) {
      s.slider.load = 5;
      s.slider.surface = peaks({{.at = 0.0008, .height = 1e-5, .half_width = 3e-5},
                                {.at = 0.0032, .height = 1e-5, .half_width = 3e-5}});
    }
    const Recording r = simulate(s);
    ASSERT_EQ(r.end.status, Status::done);
    EXPECT_EQ(r.end.most_nodes, slider == Support::free ? 2 : 1);
    ASSERT_EQ(r.end.open_shocks.size(), slider == Support::free ? 2u : 1u);
    EXPECT_EQ(r.end.open_shocks[0].start, 0);
    const double force = r.samples.force[0];
    EXPECT_GT(force, 0);
    // Equilibrium is exact to some 1e-11 of the displacements, a few micrometres, and the overlap
    // is a hundredth of them or more. The rest rings.
    for (std::size_t i = 0; i < r.samples.time.size(); ++i)
      EXPECT_NEAR(r.samples.force[i], force, 1e-9 * force);
  }
}

// ---- bodies without modes ---------------------------------------------------------------------

TEST(AdaptiveRigid, NothingMovesThroughThousandsOfWindows) {
  // two rough faces that no mode moves: the overlaps are those of the faces
  Scene s = adaptive(rough_scene(Support::rigid), 1e-8);
  s.resonator.support = Support::rigid;
  s.resonator.modes = 0;
  s.duration = 2e-2;
  s.output.rate = 1e5;
  const Recording r = simulate(s);
  ASSERT_EQ(r.end.status, Status::done);
  EXPECT_GT(r.end.shocks_begun, 50);
  double gross = 0;
  for (std::size_t i = 1; i < r.samples.time.size(); ++i)
    gross += std::abs(r.samples.contact[i] - r.samples.contact[i - 1]);
  EXPECT_GT(gross, 0);
  // The energy of the springs is the work of the imposed motion. A step ends up to 4 ulp of the
  // position (a thousand chi) and two ticks behind a kink of the face, at some hundred kinks at
  // once. A sample within a step has the work up to the step's beginning.
  for (std::size_t i = 0; i < r.samples.time.size(); ++i)
    ASSERT_NEAR(r.samples.sliding_work[i], r.samples.contact[i] - r.samples.contact.front(),
                1e-11 * gross)
        << i;
}

TEST(AdaptiveRigid, BetweenSmoothFacesWorkAndImpulsesAreThoseOfTheTolerance) {
  // nothing moves but the slider along its path: the springs' work is all that there is
  Scene s = rough_scene(Support::rigid);
  s.faces = Faces::smooth;
  s.resonator.support = Support::rigid;
  s.resonator.modes = 0;
  s.duration = 2e-3;
  s.output.rate = 1e5;
  const auto at = [&](double tolerance) { return simulate(adaptive(s, tolerance)); };
  const Recording fine = at(1e-13);
  ASSERT_EQ(fine.end.status, Status::done);
  ASSERT_GT(fine.shocks.size(), 10);
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    const Recording r = at(tolerance);
    ASSERT_EQ(r.end.status, Status::done);
    // Found: closure to 0.5 of the tolerance. An impulse is a sum over the points of the step in
    // which the contact ends, too: found to 150 tolerances of the largest.
    EXPECT_LT(r.energy.closure(), tolerance) << tolerance;
    ASSERT_EQ(r.shocks.size(), fine.shocks.size()) << tolerance;
    double largest = 0, off = 0;
    for (std::size_t i = 0; i < r.shocks.size(); ++i) {
      largest = std::max(largest, fine.shocks[i].impulse);
      off = std::max(off, std::abs(r.shocks[i].impulse - fine.shocks[i].impulse));
    }
    EXPECT_LT(off, 1000 * tolerance * largest) << tolerance;
  }
}

TEST(AdaptiveRigid, AShockStandsWhereItsForceDoesOnTheMean) {
  // one node slides at a constant overlap: half way between where it begins and where it ends
  Scene s = adaptive(plate_scene(0, 0.004, 1e-3), 1e-8);
  s.resonator = rigid(s.resonator);
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 3e-5}});
  s.gap = 9e-6;
  s.speed = 1.0;
  s.contact.stiffness = 1e12;
  const Recording r = simulate(s);
  ASSERT_EQ(r.end.status, Status::done);
  ASSERT_EQ(r.end.open_shocks.size(), 1u);
  const OpenShock& shock = r.end.open_shocks[0];
  const double begin = (s.start + 0.002) / s.spacing, distance = s.speed * s.duration / s.spacing;
  EXPECT_NEAR(shock.impulse, shock.peak * static_cast<double>(r.model.steps),
              1e-12 * shock.impulse);
  // the mean of fifty spacings, each begun within 4 ulp of the position
  EXPECT_NEAR(shock.moment / shock.impulse, begin + 0.5 * distance, 1e-12 * begin);
}

TEST(AdaptiveRigid, AForceThatComesLate) {
  // nothing moves for a thousand windows, then everything
  Scene s = adaptive(rough_scene(Support::rigid), 1e-8);
  s.gap = 1e-3;
  s.speed = 10;
  s.duration = 2.5e-3;
  s.resonator.moving_forces = {{.force = 3, .speed = 10, .start = -0.02}};
  const Recording r = simulate(s);
  ASSERT_EQ(r.end.status, Status::done);
  for (std::size_t i = 0; i < r.samples.time.size(); ++i)
    EXPECT_EQ(r.samples.kinetic[i] > 0, r.samples.time[i] > 2e-3 * (1 + 1e-12)) << i;
  EXPECT_LT(std::abs(r.energy.relative()), 1e-8);
}

TEST(AdaptiveRigid, AHitOnAModeThatHasDiedAwayToAlmostNothing) {
  // between two hits it rings down so far that the squares of its motion underflow
  for (double second = 0.0183; second < 0.0193; second += 1e-4) {
    SCOPED_TRACE(second);
    Scene s = adaptive(plate_scene(0, 0.01, 0.01), 1e-8);
    s.resonator = steel(0.05, 0.01, 0.01, 0.2, 1);
    s.resonator.surface = peaks({{.at = 0.0155, .height = 1e-5, .half_width = 2e-4},
                                 {.at = second, .height = 1e-5, .half_width = 2e-4}});
    s.slider.surface = peaks({{.at = 0.005, .height = 1e-5, .half_width = 2e-4}});
    s.gap = 1.95e-5;
    s.start = 0.01;
    s.speed = 0.1;
    s.spacing = 2e-5;
    s.duration = 0.05;
    s.output.rate = 1e4;
    s.contact.stiffness = 1e13;
    const Recording r = simulate(s);
    ASSERT_EQ(r.end.status, Status::done);
    EXPECT_EQ(r.end.shocks_begun, 2);
    EXPECT_LT(std::abs(r.energy.relative()), 1e-6);
  }
}

// ---- where it cannot go on --------------------------------------------------------------------

/// Samples that are due before the last step made.
std::int64_t samples_before(const Recording& r) {
  return std::llround(std::ceil(static_cast<double>(r.end.step) / r.model.steps_per_sample));
}

TEST(AdaptiveRoom, GrowsWithTheNodesInContact) {
  Scene s = adaptive(plate_scene(4, 0.03, 0.004), 1e-6);
  s.spacing = 4e-5;  // 751 nodes
  s.start = 0.015;
  s.gap = 1e-6;
  s.slider.support = Support::free;
  s.slider.load = 5;
  s.contact.stiffness = 1e12;
  s.duration = 2e-3;
  const Recording r = simulate(s);
  EXPECT_EQ(r.end.status, Status::done);
  EXPECT_GT(r.end.most_nodes, 512);  // more than the room at first
  EXPECT_TRUE(same(simulate(s, {.batch = {.capacity = {.nodes = 1000}}}), r));
}

TEST(AdaptiveFailures, TooStiffForTheClock) {
  Scene s = adaptive(rough_scene(Support::pinned), 1e-8);
  s.contact.stiffness = 1e45;
  const Recording r = simulate(s);
  EXPECT_EQ(r.end.status, Status::stalled);
  EXPECT_LT(r.end.step, r.model.steps);
  EXPECT_EQ(static_cast<std::int64_t>(r.samples.time.size()), samples_before(r));
}

}  // namespace
}  // namespace ra2d::test
