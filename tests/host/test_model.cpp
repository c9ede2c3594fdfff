// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "host/result/level.hpp"
#include "host/result/record.hpp"
#include "host/run/samples.hpp"
#include "host/run/v_rms.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"

namespace ra2d::test {
namespace {

Scene adaptive_scene(double duration, double rate) {
  Scene s = plate_scene(3, 0.004, 1e-3);
  s.gap = 1e-3;
  s.contact.stiffness = 1e13;
  s.time.scheme = SchemeKind::adaptive;
  s.time.step = 0;
  s.duration = duration;
  s.output.rate = rate;
  return s;
}

struct Times {
  double duration, rate;
  std::int64_t samples;
  bool whole;  // the last sample stands at the end
};
// roundings make some whole numbers of intervals seem not to be; some runs end before the second
// sample, and some last for long
const std::vector<Times> times{{1.0, 100e3, 100001, true},
                               {0.3, 100e3, 30001, true},
                               {0.1, 3e3, 301, true},
                               {0.7, 44.1e3, 30871, true},
                               {2e-3, 1e6, 2001, true},
                               {1 / 3., 3, 2, true},
                               {0.07, 100, 8, true},
                               {0.05, 12345.678, 618, false},
                               {0.1, 12.0, 2, false},
                               {1e-3, 10.0, 1, false},
                               {1e-20, 1e-5, 1, false},
                               {1e-9, 1e18, 1000000001, true},
                               {3600.0, 48e3, 172800001, true},
                               {86400.5, 1.0, 86401, false},
                               {1e12, 1e3, 1000000000000001, true}};

TEST(Clock, SamplesFallOnItsTicks) {
  for (const auto& [duration, rate, samples, whole] : times) {
    SCOPED_TRACE(testing::Message() << duration << " s at " << rate << " Hz");
    const Model m = make_model(adaptive_scene(duration, rate));
    int exponent = 0;
    EXPECT_EQ(std::frexp(m.steps_per_sample, &exponent), 0.5) << "a power of two";
    EXPECT_GE(m.steps_per_sample, 1);
    EXPECT_LT(m.steps, std::int64_t{1} << 60);
    EXPECT_EQ(m.samples, samples);
    if (m.samples == 1) continue;  // at t = 0
    EXPECT_EQ(m.steps_per_sample * m.tick, 1 / rate);
    const std::int64_t last = (m.samples - 1) * std::llround(m.steps_per_sample);
    EXPECT_LE(last, m.steps);
    EXPECT_LT(static_cast<double>(m.steps - last), m.steps_per_sample);
    if (whole) {
      EXPECT_EQ(last, m.steps);
    }
    EXPECT_NEAR(static_cast<double>(last) * m.tick, static_cast<double>(m.samples - 1) / rate,
                2 * eps * duration);
  }
}

TEST(Clock, EndsWithTheRun) {
  for (const auto& [duration, rate, samples, whole] : times) {
    SCOPED_TRACE(testing::Message() << duration << " s at " << rate << " Hz");
    const Model m = make_model(adaptive_scene(duration, rate));
    EXPECT_NEAR(static_cast<double>(m.steps) * m.tick, duration, 0.5 * m.tick + 8 * eps * duration);
  }
}

TEST(Clock, TicksAsFinelyAsItsNumbersReach) {
  for (const auto& [duration, rate, samples, whole] : times) {
    SCOPED_TRACE(testing::Message() << duration << " s at " << rate << " Hz");
    const Model m = make_model(adaptive_scene(duration, rate));
    if (m.tick <= 0x1p-60) {
      // no finer than it must be
      EXPECT_TRUE(m.steps_per_sample == 1 || 2 * m.tick > 0x1p-60);
    } else {
      EXPECT_GE(static_cast<double>(m.steps), 0x1p59);
    }
  }
  EXPECT_LE(make_model(adaptive_scene(1.0, 100e3)).tick, 0x1p-51);
  EXPECT_LE(make_model(adaptive_scene(250.0, 100e3)).tick, 0x1p-51);
  EXPECT_GT(make_model(adaptive_scene(3600.0, 100e3)).tick, 0x1p-51);
}

TEST(Clock, CarriesTheSlider) {
  Scene s = adaptive_scene(0.1, 100e3);
  s.speed = 0.1;
  const Model m = make_model(s);
  EXPECT_NEAR(m.advance * static_cast<double>(m.steps), s.speed * s.duration / s.spacing,
              4 * eps * 250);
}

TEST(Clock, OfFixedStepsIsTheStep) {
  Scene s = adaptive_scene(2e-3, 1e6);
  s.time.scheme = SchemeKind::rk4;
  s.time.step = 1e-7;
  const Model m = make_model(s);
  EXPECT_EQ(m.tick, s.time.step);
  EXPECT_EQ(m.steps, 20000);
  EXPECT_EQ(m.steps_per_sample, 10);
  EXPECT_EQ(m.samples, 2001);
}

TEST(Clock, SamplesAreNoCloserThanSteps) {
  // a rate that is one sample a step but for its roundings: a sample that fell before the step at
  // which the one before it was written would never be
  Scene s = adaptive_scene(3e-3, 3333333.3334);
  s.time.scheme = SchemeKind::backward_euler;
  s.time.step = 3e-7;
  const Model m = make_model(s);
  EXPECT_EQ(m.steps_per_sample, 1);
  EXPECT_EQ(m.samples, m.steps + 1);
}

TEST(Clock, GivesShocksTheirTimes) {
  Scene s = adaptive_scene(1.0, 100e3);
  s.speed = 1e-3;
  const Model m = make_model(s);
  const auto ticks = [&](double seconds) { return std::llround(seconds / m.tick); };
  const std::vector<ShockRow> rows{{.serial = 3,
                                    .start = ticks(0.25),
                                    .last = ticks(0.25 + 3e-5),
                                    .peak = 2.0,
                                    .impulse = 4e-5 / m.tick,
                                    .moment = 4e-5 / m.tick * 100}};
  const Shock shock = make_shocks(m, rows)[0];
  // ticks() rounds as doubles do: at a quarter of a second to more than a tick
  EXPECT_NEAR(shock.start, 0.25, m.tick + 0.5 * eps);
  EXPECT_NEAR(shock.duration, 3e-5, 2 * m.tick + eps);
  EXPECT_EQ(shock.peak_force, 2.0);
  EXPECT_NEAR(shock.impulse, 4e-5, 4 * eps * 4e-5);
  EXPECT_NEAR(shock.position, 100 * s.spacing, 4 * eps * 100 * s.spacing);
}

/// A model under other settings is the one that the scene would make, and shares the faces.
TEST(WithSettings, IsTheModelOfTheScene) {
  Scene beams = plate_scene(3, 0.004, 1e-3);
  beams.resonator.surface = gaussian(1e-6, 1e-3, 1);
  beams.slider.surface = gaussian(1e-6, 1e-3, 2);
  beams.gap.reset();
  beams.contact.stiffness = 1e15;
  beams.time.step = 1e-7;
  beams.speed = 0.1;
  Scene block = read_scene(scene_file("areal"));
  block.slider.length = block.slider.width = 2e-3;
  for (Scene first : {beams, block}) {
    first.duration = 2e-3;
    first.output.rate = 1e4;
    const Model made = make_model(first);
    Scene second = first;
    second.duration = 1e-3;
    second.output.rate = 5e3;
    second.output.window = {0.2e-3, 0.8e-3};
    second.contact.law = ContactLaw::multiplier;
    second.time.scheme =
        first.time.scheme == SchemeKind::adaptive ? SchemeKind::midpoint : SchemeKind::adaptive;
    second.time.step = 3e-7;
    second.time.tolerance = 1e-4;
    const Model m = with_settings(made, second), expected = make_model(second);
    EXPECT_EQ(m.slider_height.data(), made.slider_height.data());
    EXPECT_EQ(m.slider_height, expected.slider_height);
    EXPECT_EQ(m.delta, expected.delta);
    EXPECT_EQ(m.tick, expected.tick);
    EXPECT_EQ(m.advance, expected.advance);
    EXPECT_EQ(m.steps, expected.steps);
    EXPECT_EQ(m.end, expected.end);
    EXPECT_EQ(m.samples, expected.samples);
    EXPECT_EQ(m.first_sample, expected.first_sample);
    EXPECT_EQ(m.steps_per_sample, expected.steps_per_sample);
    EXPECT_EQ(m.scene.time, expected.scene.time);
    EXPECT_EQ(m.scene.duration, expected.scene.duration);
    EXPECT_EQ(m.scene.output.rate, expected.scene.output.rate);
    EXPECT_EQ(m.scene.contact.law, expected.scene.contact.law);
    EXPECT_EQ(m.scene.side, expected.scene.side);
    EXPECT_EQ(m.doubts, made.doubts);
  }
}

TEST(Touching, IsTheSmallestGapWithoutOverlap) {
  // the highest place of the sum of both faces is in the middle, where the peaks stand against each
  // other
  Scene s = plate_scene(3, 0.004, 1e-3);
  s.gap.reset();
  s.resonator.surface = peaks({{.at = 0.022, .height = 3e-6, .half_width = 3e-4}});
  s.slider.surface = peaks({{.at = 0.002, .height = 2e-6, .half_width = 3e-4}});
  const Model m = make_model(s);
  EXPECT_NEAR(m.delta, 5e-6, 8 * eps * 5e-6);
  const std::vector<double> overlap = overlaps(m, {}, {});
  EXPECT_NEAR(*std::max_element(overlap.begin(), overlap.end()), 0, 8 * eps * 5e-6);
}

TEST(Level, IsOfTheElasticMotionAlone) {
  Scene s = plate_scene(3, 0.004, 1e-3);
  s.resonator.support = Support::free;
  s.gap = 1.0;
  const Model m = make_model(s);
  ASSERT_EQ(m.resonator.modes.size(), 5);
  Snapshot end;
  end.step = 10;
  end.resonator_square = {10.0, 40.0, 0.0, 0.0, 0.0};  // it falls and turns
  EXPECT_EQ(v_rms(m, end), 0);
  EXPECT_EQ(level(0), -std::numeric_limits<double>::infinity());
  // the mean square of a shape over the length is 1/L, over its nodes that but for the ends, where
  // a free shape is 4/L
  end.resonator_square = {10.0, 40.0, 0.0, 90.0, 0.0};
  const double L = s.resonator.length;
  EXPECT_NEAR(v_rms(m, end), 3 / std::sqrt(L), 4 * s.spacing / L * 3 / std::sqrt(L));
  // from a step on: what was summed and counted before it is left out
  Snapshot begin = end;
  begin.step = 6;
  begin.resonator_square[3] = 50.0;
  EXPECT_NEAR(v_rms(m, end, begin) / v_rms(m, end), std::sqrt(40.0 / 4) / std::sqrt(90.0 / 10),
              4 * eps);
  EXPECT_TRUE(std::isnan(v_rms(m, end, end)));
}

}  // namespace
}  // namespace ra2d::test
