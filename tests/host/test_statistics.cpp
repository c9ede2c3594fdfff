// SPDX-License-Identifier: BSD-3-Clause
#include "host/result/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/result/level.hpp"
#include "host/run/simulation.hpp"
#include "tests/scenes.hpp"

namespace ra2d::test {
namespace {

TEST(Median, OfAnEvenNumberIsHalfWayBetweenTheTwoInTheMiddle) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({8, 1, 3, 2}), 2.5);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(LogHistogram, QuantileIsTheSmallestValueThatTheShareDoesNotExceed) {
  LogHistogram h;
  for (int i = 1; i <= 9; ++i) h.add(i);
  const auto near = [](double value) { return value * LogHistogram::resolution; };
  EXPECT_NEAR(h.quantile(0.5), 5, near(5));  // of 4.5 values, the fifth
  EXPECT_NEAR(h.quantile(0.9), 9, near(9));
  EXPECT_NEAR(h.quantile(1.0 / 3), 3, near(3));
  EXPECT_EQ(h.total(), 9);
  EXPECT_TRUE(std::isnan(LogHistogram().quantile(0.5)));
}

TEST(Level, OfTenTimesTheReferenceIsTwentyDecibels) {
  EXPECT_NEAR(level(1e-9), 0, 1e-14);
  EXPECT_NEAR(level(1e-8), 20, 1e-13);
}

/// Keeps the shocks.
struct Shocks : Sink {
  std::vector<Shock> all;
  void take(const SampleBlock&) override {}
  void take(const std::vector<Shock>& more) override {
    all.insert(all.end(), more.begin(), more.end());
  }
};

TEST(Accounts, CountTheShocksThatBeginFromTheAskedTimeOn) {
  Scene s = plate_scene(3, 0.004, 1e-3);
  s.spacing = 2e-5;
  s.speed = 0.1;
  s.duration = 0.01;
  s.contact.stiffness = 1e14;
  s.time.step = 1e-7;
  s.output.rate = 1e4;
  s.output.from = 0.005;
  s.resonator.surface = gaussian(5e-7, 2e-4, 3);
  s.slider.surface = gaussian(5e-7, 2e-4, 4);
  const Model model = make_model(s);
  Shocks shocks;
  SceneRun run(model, make_start(model), {}, &shocks);
  Simulation().run({&run});
  const auto counted = std::count_if(shocks.all.begin(), shocks.all.end(),
                                     [&](const Shock& shock) { return shock.start >= 0.005; });
  EXPECT_GT(counted, 0);
  EXPECT_LT(counted, static_cast<std::ptrdiff_t>(shocks.all.size()));
  EXPECT_EQ(run.accounts().durations.total(), counted);
  EXPECT_EQ(run.accounts().forces.total(), counted);
}

}  // namespace
}  // namespace ra2d::test
