// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/effort.hpp"
#include "tests/numbers.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// Impacts on a penalty spring: the errors in state and energy that the kinks of the force at onset
/// and release give each scheme. And contact at the stages inside a step: leaving out the nodes
/// that cannot touch still changes nothing.
namespace ra2d::test {
namespace {

class EveryScheme : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, EveryScheme, testing::ValuesIn(schemes_and_implicit()),
                         [](const auto& info) { return info.param.name; });

// ---- one impact

/// A rigid body that falls on a peak of a rigid face: a mass m L that stays on the spring for half
/// a period and leaves at the speed at which it came. Nothing else moves, and free flight is exact
/// in all schemes, so all errors are those of the impact. In units of the speed and of omega_c they
/// depend on z = omega_c tau and on where in a step the onset falls.
struct Bounce {
  Model model;
  ModalStart start;
  double omega;             // of mass and spring
  double overlap, closing;  // exact ones at the end
};
constexpr double speed = 0.01;  // m/s

/// Starts `steps_before` steps (not a whole number) before the onset, and ends 1.5 radians after
/// the half period.
Bounce bounce(const Scheme& scheme, double z, double steps_before) {
  Scene s = with(strip_scene(0, 0, 0.1, 0.02), scheme);
  s.resonator = rigid(s.resonator);
  s.slider.support = Support::free;
  s.slider.surface = peaks({{.at = 0.01, .height = 40e-6, .half_width = 0.5e-3}});
  const auto steps = static_cast<std::int64_t>(std::ceil(steps_before + (pi + 1.5) / z));
  set_steps(s, 1e-6, steps);
  s.gap = 40e-6 + speed * s.time.step * steps_before;
  const double mass = make_body(s.slider).mass;
  Bounce b;
  b.omega = z / s.time.step;
  s.contact.stiffness = b.omega * b.omega * mass / (s.spacing * s.slider.width);
  b.model = make_model(s);
  b.start = make_start(b.model);
  b.start.slider_v[0] = speed * std::sqrt(s.slider.length);
  count_energy(b.model, b.start);
  b.closing = -speed;
  const double flown = (static_cast<double>(steps) - steps_before) * s.time.step - pi / b.omega;
  b.overlap = -speed * flown;
  return b;
}

/// Errors of an impact: of the state (energy norm, over the speed), and of the energy that it gives
/// back (logarithm of its share).
struct Wrong {
  double state, energy;
};
/// Errors over onsets all over a step and, as z varies slightly, over releases all over a step:
/// root mean square, and each of them.
std::vector<Wrong> impacts(const Scheme& scheme, double z) {
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  std::vector<Bounce> all;
  for (int i = 0; i < 16; ++i)
    for (int j = 0; j < 5; ++j)
      all.push_back(
          bounce(scheme, z * (1 + 0.02 * j * std::min(1.0, z / 0.1)), 5 + (i + 0.5) / 16));
  for (const Bounce& b : all) {
    models.push_back(b.model);
    starts.push_back(b.start);
  }
  const std::vector<Recording> runs = simulate(models, starts);
  std::vector<Wrong> out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(runs[i].end.status, Status::done);
    EXPECT_EQ(runs[i].end.shocks_begun, 1);
    EXPECT_EQ(runs[i].shocks.size(), 1u);
    const double shape = 1 / std::sqrt(all[i].model.slider.length);
    const double peak = all[i].model.slider_height[10] - all[i].model.delta;
    const double overlap = runs[i].samples.slider_displacement[2] * shape + peak;
    const double closing = runs[i].samples.slider_velocity[2] * shape;
    out.push_back(
        {std::hypot(closing - all[i].closing, all[i].omega * (overlap - all[i].overlap)) / speed,
         2 * std::log(std::abs(closing) / speed)});
  }
  return out;
}

TEST_P(EveryScheme, ImpactIsOfFirstOrderOrOfSecondWhateverTheSchemesOrder) {
  // The force of a step is wrong by up to its change over the step where a kink lies in it: an
  // error of O(z^2) in the speed, each of two times, with a factor that depends on where. No scheme
  // that does not look for the kink does better; the schemes of order one do worse, by what they
  // get wrong in between. Backward Euler with the old force is the midpoint scheme for a mass,
  // which has no stiffness of its own to be damped.
  const bool second =
      GetParam().table().order >= 2 ||
      (GetParam().time.scheme == SchemeKind::backward_euler && !GetParam().implicit());
  double coarse = 0;
  for (double z = 0.2; z > 0.01; z /= 2) {
    double sum = 0;
    const std::vector<Wrong> all = impacts(GetParam(), z);
    for (const Wrong& w : all) sum += w.state * w.state;
    const double fine = std::sqrt(sum / static_cast<double>(all.size()));

    if (coarse > 0) {
      EXPECT_NEAR(std::log2(coarse / fine), second ? 2 : 1, 0.15) << "z " << z;
    }
    coarse = fine;
  }
}

TEST_P(EveryScheme, ImpactGivesBackTheEnergyThatTheorySays) {
  for (const double z : {0.2, 0.1, 0.05, 0.025, 0.0125}) {
    double theory = 0;
    switch (GetParam().time.scheme) {
      case SchemeKind::explicit_euler:
        theory = pi * z;
        break;
      case SchemeKind::exact:
        theory = pi * z / 2;
        break;
      case SchemeKind::backward_euler:
        theory = GetParam().implicit() ? -pi * z : 0;
        break;
      case SchemeKind::heun:
        theory = pi * z * z * z / 4;
        break;
      default:
        break;
    }
    // At a kink the force is wrong by up to k V tau, for up to a step: its impulse by z^2 of m V,
    // the energy by 2 z^2, at the onset and at the release. Theory's next terms are of O(z^3).
    for (const Wrong& w : impacts(GetParam(), z))
      EXPECT_LE(std::abs(w.energy - theory), 4 * z * z) << "z " << z;
  }
}

TEST(Impact, OfAMassIsTheSameInBackwardEulerAndMidpoint) {
  const std::vector<Wrong> a = impacts(schemes[2], 0.1), b = impacts(schemes[1], 0.1);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].energy, b[i].energy);
}

// ---- all nodes, candidates

TEST_P(EveryScheme, RandomScenesAreTheSameBitForBitOverAllNodesAndCandidates) {
  int touching = 0, in_and_out = 0, marched = 0;
  double evaluated = 0, steps_nodes = 0;
  // a step of the scheme of thirteen stages takes far longer than one of the others
  const int seeds = draws(GetParam().time.scheme == SchemeKind::rk8 ? 3 : 8);
  for (const double turn : {0.0, 0.3, 1.9, 2.01, 2.9})
    for (int seed = 1; seed <= seeds; ++seed) {
      SCOPED_TRACE(testing::Message() << "omega tau " << turn << ", seed " << seed);
      const Started c = random_scene(1000 + 13 * seed, {GetParam(), turn});
      const Outcome all = march(c.model, c.start, Nodes::all);
      const Outcome some = march(c.model, c.start, Nodes::candidates);
      EXPECT_TRUE(same(all, some));
      ++marched;
      touching += all.end.contact_steps > 0;
      in_and_out += all.end.shocks_begun >= 5;
      evaluated += static_cast<double>(some.end.evaluated);
      steps_nodes += static_cast<double>(all.end.evaluated);
    }
  if (!draws_enough()) return;
  // the scenes do what they are for
  EXPECT_GE(touching, marched * 2 / 3);
  EXPECT_GE(in_and_out, marched / 4);
  EXPECT_LT(evaluated, 0.95 * steps_nodes);
}

/// Steep faces and a plate that hardly moves: the places of the nodes decide which of them touch.
TEST_P(EveryScheme, NodesThatPassSteepPlacesWithinAStepAreTheSame) {
  for (const double advance :
       draws_enough() ? std::vector<double>{0.013, 0.17, 0.31, 0.5, 0.77, 0.99, 1.3, 4.7}
                      : std::vector<double>{0.17, 0.99, 4.7}) {
    SCOPED_TRACE(advance);
    Scene s = with(plate_scene(3, 0.004, 0.004), GetParam());
    s.spacing = 2e-5;
    s.time.step = 1e-8;
    s.speed = advance * s.spacing / s.time.step;
    s.start = 0.0101;
    s.duration = 0.03 / s.speed;
    s.output.rate = 0.1 / s.time.step;
    // as steep as can be from a node to the next
    s.resonator.surface = gaussian(1e-6, 8e-5, 5);
    s.slider.surface = gaussian(1e-6, 8e-5, 6);
    s.contact.stiffness = 1e8;  // hardly any force
    s.gap = 3.5e-6;
    const Model model = make_model(s);
    EXPECT_GT(expect_both_same(model, make_start(model)).end.shocks_begun, 3);
  }
}

/// The slider's position, some 20 000 chi, is rounded to 3.6e-12 chi. Here it stays for tens of
/// steps, then moves by one rounding, with stages in between.
TEST_P(EveryScheme, CreepSlowerThanTheRoundingOfThePositionIsTheSame) {
  Scene s = with(plate_scene(1, 2e-4, 0.004), GetParam());
  s.spacing = 1e-5;
  s.time.step = 1e-8;
  s.duration = 4e-5;
  s.resonator.length = 0.3;
  s.start = 0.2;
  s.resonator.surface = peaks({{.at = 0.2006, .height = 2e-5, .half_width = 1e-3}});
  s.slider.surface = peaks({{.at = 1e-4, .height = 2e-5, .half_width = 5e-6}});
  s.contact.stiffness = 1e15;
  for (const double creep : {4e-11, 2e-10})
    for (int i = 0; i < 4; ++i) {
      SCOPED_TRACE(testing::Message() << creep << " m/s, " << i);
      s.speed = creep;
      Model model = make_model(s);
      const double rise = 2e-5 * pi / 2 / 1e-3;  // m/m, half way up the peak
      model.delta += (1000 + 157 * i) * creep * s.time.step * rise;
      EXPECT_GT(expect_both_same(model, make_start(model)).end.contact_steps, 0);
    }
}

/// The first steps from rest: outer forces have hardly done any work yet, and nothing is taken for
/// energy from nowhere.
TEST_P(EveryScheme, NoFalseAlarmFromRestUnderALoadAndAMovingForce) {
  for (const bool free : {true, false}) {
    Scene s = with(plate_scene(3, 0.004, 0.004, 0.3), GetParam());
    s.duration = 1e-5;
    s.output.rate = 1e7;  // the energy is checked at each step
    s.gap = 1e-5;
    s.contact.stiffness = 1e12;
    if (free) {
      s.slider.support = Support::free;
      s.slider.load = 10;
    } else {
      s.resonator.moving_forces = {{.force = 3, .speed = 40, .start = 0.01}};
    }
    const Recording run = simulate(s);
    EXPECT_EQ(run.end.status, Status::done) << "at step " << run.end.step;
    EXPECT_GT(run.end.energy, 0);
  }
}

/// Rough faces, for every scheme, over all nodes and candidates.
std::vector<Scene> rough_scenes(const Scheme& scheme) {
  std::vector<Scene> scenes;
  for (const Support support : {Support::free, Support::pinned, Support::rigid})
    for (const Nodes nodes : {Nodes::candidates, Nodes::all}) {
      Scene s = with(rough_scene(support), scheme);
      s.time.nodes = nodes;
      s.duration = 1e-4;
      s.start = 0.0203;  // a fifth of a node off the grid, when the spacing is 40 um
      if (support == Support::free)
        s.resonator.moving_forces = {{.force = 3, .speed = 40, .start = 0.01}};
      if (support == Support::pinned) s.output.rate = 1e7 / 3.7;  // not a whole number of steps
      scenes.push_back(s);
    }
  return scenes;
}

TEST_P(EveryScheme, LaunchesAndBuffersOfAnyLengthGiveTheSameBits) {
  for (const Scene& scene : rough_scenes(GetParam())) {
    const Recording whole = simulate(scene);
    if (GetParam().time.scheme != SchemeKind::explicit_euler) {  // whose motion grows in contact
      EXPECT_EQ(whole.end.status, Status::done);
    }
    EXPECT_GT(whole.end.contact_steps, 0);
    for (const std::int64_t steps : {1, 7, 333})
      EXPECT_TRUE(same(whole, simulate(scene, {.steps = steps, .batch = {}}))) << steps << " steps";
    const BatchOptions small{.capacity = {.samples = 2, .shocks = 1}, .least_packs = 3};
    EXPECT_TRUE(same(whole, simulate(scene, {.batch = small})));
  }
}

TEST(Batches, SchemesBesideEachOtherGiveTheSameBitsAsAlone) {
  std::vector<Scene> scenes;
  for (const Scheme& scheme : schemes_and_implicit())
    for (const Scene& scene : rough_scenes(scheme)) scenes.push_back(scene);
  const std::vector<Recording> batch = simulate(scenes, {.steps = 211, .batch = {}});
  for (std::size_t i = 0; i < scenes.size(); ++i)
    EXPECT_TRUE(same(simulate(scenes[i]), batch[i])) << "scene " << i;
}

}  // namespace
}  // namespace ra2d::test
