// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "kernels/adaptive/slider_path.hpp"
#include "tests/dice.hpp"

namespace {

using namespace ra2d;
using test::Dice;

SceneTables moving(double position, double advance, int windows = 1) {
  SceneTables t;
  t.motion.position = position;
  t.motion.advance = advance;
  t.motion.windows = windows;
  t.motion.window_width = 1.0 / windows;
  return t;
}

TEST(SliderPath, KnowsThetaOfTicksThatNoDoubleHolds) {
  // 2^61 ticks of 5/2^48 and some more: every number here but that of the tick is a double
  const SceneTables t = moving(0.25, 5 * 0x1p-48);
  const SliderPath path(t.motion);
  constexpr std::int64_t far = std::int64_t{1} << 61;
  const Place start = path.at(far);
  EXPECT_EQ(start.base, 5 << 13);
  EXPECT_EQ(start.theta, 0.25);
  for (const std::int64_t more : {1LL, 255LL, 257LL, 2047LL, 2049LL, 123456789LL, 123456789012LL}) {
    const double theta = 0.25 + static_cast<double>(more) * t.motion.advance;
    EXPECT_EQ(path.at(far + more).theta, theta) << more;
    EXPECT_EQ(path.moved(start, far + more).theta, theta) << more;
  }
}

TEST(SliderPath, ComesToTheNextNodeAndWindowInOneStep) {
  // At a hundredth of a rounding of the position a tick: what stopped short would stand there for a
  // hundred steps.
  Dice dice(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const double position = dice.uniform(0, 1), far = dice.ratio(1, 1e5);
    const double advance = 1e-2 * 0x1p-52 * (position + far);
    const SceneTables t = moving(position, advance, 1 + dice.pick(9));
    const SliderPath path(t.motion);
    const auto step = static_cast<std::int64_t>(far / advance);
    const Place place = path.at(step);
    const Place node = path.at(step + path.ticks_to_next_node(place));
    EXPECT_EQ(node.base, place.base + 1) << "trial " << trial;
    // and no farther than four roundings of the position
    EXPECT_LT(node.position - node.base, 8 * 0x1p-52 * (place.position + 1)) << "trial " << trial;
    const Place window = path.at(step + path.ticks_to_next_window(place));
    EXPECT_EQ(window.window(t.motion), place.window(t.motion) + 1) << "trial " << trial;
  }
}

TEST(SliderPath, OfASliderAtRestHasNoEnd) {
  const SceneTables t = moving(3.25, 0);
  const SliderPath path(t.motion);
  EXPECT_GT(path.ticks_to_next_node(path.at(7)), std::int64_t{1} << 61);
  EXPECT_EQ(path.at(std::int64_t{1} << 61).theta, 0.25);
}

}  // namespace
