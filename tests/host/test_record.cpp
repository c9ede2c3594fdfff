// SPDX-License-Identifier: BSD-3-Clause
#include "host/result/record.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "host/model/model.hpp"
#include "host/result/energy.hpp"
#include "host/run/samples.hpp"
#include "host/run/simulation.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

/// Samples and shocks in SI units, from hand-made rows of the march.
namespace ra2d::test {
namespace {

/// Two bodies with modes, pinned.
Scene two_beams() {
  Scene s = plate_scene(2, 0.004, 1e-3);
  s.slider = steel(0.004, 1e-3, 0.02, 0.02, 3);
  s.gap = 1e-5;
  s.contact.stiffness = 1e13;
  s.output.probes = {0.015};
  s.output.slider_probes = {0.001};
  return s;
}

/// One sample of eight lanes, of zeros.
Drained resting_sample() {
  Drained drained;
  drained.lanes = 8;
  drained.samples = 1;
  drained.sample_rows.assign(sample::row(8), 0.0);
  return drained;
}

TEST(Samples, ReadEachBodysProbesThroughItsOwnModes) {
  const Model model = make_model(two_beams());
  const ModalStart start = make_start(model);
  Drained drained = resting_sample();
  const double u[] = {1e-6, -2e-6, 3e-6, 5e-6, -7e-6}, v[] = {1e-3, 4e-3, -2e-3, 1e-3, 6e-3};
  for (int k = 0; k < 5; ++k) {
    drained.sample_rows[k] = u[k];
    drained.sample_rows[8 + k] = v[k];
  }
  const SampleBlock block = make_samples(model, start, drained, 0);
  // a pinned beam: sqrt(2/L) sin(k pi x/L)
  const auto sum = [](const double* a, int modes, double length, double x) {
    double s = 0;
    for (int k = 0; k < modes; ++k)
      s += a[k] * std::sqrt(2 / length) * std::sin((k + 1) * pi * x / length);
    return s;
  };
  const auto near = [](double found, double expected) {
    EXPECT_NEAR(found, expected, 64 * eps * std::abs(expected));
  };
  near(block.probe_displacement.at(0), sum(u, 2, 0.06, 0.015));
  near(block.probe_velocity.at(0), sum(v, 2, 0.06, 0.015));
  near(block.slider_probe_displacement.at(0), sum(u + 2, 3, 0.004, 0.001));
  near(block.slider_probe_velocity.at(0), sum(v + 2, 3, 0.004, 0.001));
}

TEST(Samples, ThatAreNoNumbersAreNotFinite) {
  const Model model = make_model(two_beams());
  const ModalStart start = make_start(model);
  const Drained drained = resting_sample();
  EXPECT_TRUE(is_finite(make_samples(model, start, drained, 0)));
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()})
    for (const int at : {0, 3, 8 + 4, 16 + static_cast<int>(sample::force),
                         16 + static_cast<int>(sample::damping_loss)}) {
      Drained spoilt = drained;
      spoilt.sample_rows[at] = bad;
      EXPECT_FALSE(is_finite(make_samples(model, start, spoilt, 0))) << bad << " at " << at;
    }
}

TEST(Shocks, LastFromTheirFirstStepThroughTheirLast) {
  const Model model = make_model(two_beams());  // steps of 0.1 us
  const std::vector<Shock> ended = make_shocks(
      model, std::vector<ShockRow>{
                 {.serial = 4, .start = 10, .last = 12, .peak = 3, .impulse = 5, .moment = 500}});
  EXPECT_EQ(ended[0].serial, 4);
  EXPECT_NEAR(ended[0].start, 10e-7, 4 * eps * 10e-7);
  EXPECT_NEAR(ended[0].duration, 3e-7, 4 * eps * 3e-7);
  EXPECT_NEAR(ended[0].impulse, 5e-7, 4 * eps * 5e-7);
  EXPECT_NEAR(ended[0].position, 100 * 4e-5, 4 * eps * 100 * 4e-5);
  const std::vector<Shock> touched =
      make_shocks(model, std::vector<ShockRow>{{.serial = 0, .start = 7, .last = 7, .place = 25}});
  EXPECT_NEAR(touched[0].duration, 1e-7, 4 * eps * 1e-7);
  EXPECT_NEAR(touched[0].position, 25 * 4e-5, 4 * eps * 25 * 4e-5);
}

/// Rows stand in the middle of their strips; without a force the row is that of the first node.
TEST(Shocks, OfArealScenesStandOnTheirRows) {
  Model model = make_model(two_beams());
  const std::vector<ShockRow> rows{
      {.serial = 0, .start = 1, .last = 2, .impulse = 5, .moment = 0, .across_moment = 15},
      {.serial = 1, .start = 7, .last = 7, .place = 25, .row = 4}};
  for (const Shock& shock : make_shocks(model, rows)) EXPECT_EQ(shock.y, 0);
  model.is_areal = true;
  model.side = 0.01;
  model.spacing_y = 2e-4;
  const std::vector<Shock> shocks = make_shocks(model, rows);
  EXPECT_NEAR(shocks[0].y, 0.01 + 3.5 * 2e-4, 4 * eps * 0.01);
  EXPECT_NEAR(shocks[1].y, 0.01 + 4.5 * 2e-4, 4 * eps * 0.01);
}

TEST(EnergyAccount, BeginsWithTheFirstSampleThatCounts) {
  SampleBlock block;
  block.time = {0, 1, 2, 3};
  block.kinetic = {0, 5, 6, 8};
  block.elastic = {0, 1, 1, 2};
  block.contact = {0, 0, 1, 0};
  block.damping_loss = {0, 10, 12, 13};
  block.sliding_work = {0, 100, 101, 103};
  block.load_work = {0, 1000, 1003, 1004.5};
  EnergyAccount account(1.0);
  account.add(block);
  // stored 6 to 10, lost 3, slid 3, loaded 4.5
  EXPECT_EQ(account.balance().residual, 10 + 3 - 3 - 4.5 - 6);
  EXPECT_EQ(account.balance().turnover, 10);
  EXPECT_EQ(account.balance().samples, 2);
  // in contact at 2 alone
  EXPECT_EQ(account.contact_share_of_energy(), 1.0 / (6 + 1));
  EXPECT_TRUE(std::isnan(EnergyAccount().contact_share_of_energy()));
}

TEST(Accounts, BeginAtTheAskedStepWhereverALaunchWouldEnd) {
  Scene s = two_beams();
  s.duration = 1e-3;
  s.output.from = 3.7e-4;
  const Model model = make_model(s);
  SceneRun run(model, make_start(model));
  Simulation({.ticks = 1000}).run({&run});
  EXPECT_EQ(run.accounts().begin.step, 3700);
  EXPECT_EQ(run.accounts().now.step, 10000);
}

TEST(Snapshot, SumsDoNotDependOnWhenSamplesWereTaken) {
  // in flight and in contact, half way between the samples of one and at a sample of the other
  Scene s = pressed_plate();
  s.speed = 0.5;
  s.duration = 2e-3;
  s.contact.stiffness = 1e12;
  s.resonator.surface = gaussian(1e-6, 4e-4, 3);
  s.resonator.moving_forces = {{.force = 1, .speed = 2, .start = 0.01}};
  const auto half_way = [&](double rate) {
    s.output.rate = rate;
    const Model model = make_model(s);
    SceneRun run(model, make_start(model), {.time = 1e-3});
    Simulation().run({&run});
    return run.accounts().now;
  };
  const Snapshot often = half_way(1e5), seldom = half_way(500);
  ASSERT_EQ(often.step, 1000);
  ASSERT_EQ(seldom.step, 1000);
  EXPECT_GT(often.contact_steps, 100);
  const auto near = [](double a, double b) { EXPECT_NEAR(a, b, 1000 * eps * std::abs(b)); };
  for (std::size_t k = 0; k < often.resonator_square.size(); ++k) {
    EXPECT_GT(often.resonator_square[k], 0);
    near(often.resonator_square[k], seldom.resonator_square[k]);
  }
  EXPECT_NE(often.sliding_work, 0);
  EXPECT_NEAR(often.sliding_work, seldom.sliding_work, 1e-9 * std::abs(often.sliding_work));
  EXPECT_NEAR(often.force_work, seldom.force_work, 1e-9 * std::abs(often.force_work));
}

TEST(EnergyBalance, OfRoundingsThereIsNothingToCompare) {
  EnergyBalance balance{.residual = -2e-31, .turnover = 9e-31, .samples = 2};
  EXPECT_TRUE(balance.is_of_roundings());
  EXPECT_TRUE(std::isnan(balance.closure()));
  balance.turnover = 2e-30;
  EXPECT_FALSE(balance.is_of_roundings());
  EXPECT_DOUBLE_EQ(balance.relative(), -0.1);
  balance.turnover = 0;  // nothing is missing of nothing
  EXPECT_FALSE(balance.is_of_roundings());
  EXPECT_EQ(balance.closure(), 0.0);
}

}  // namespace
}  // namespace ra2d::test
