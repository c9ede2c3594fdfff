// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "kernels/adaptive/slider_way.hpp"
#include "tests/dice.hpp"

namespace {

using namespace ra2d;
using test::Dice;

SceneTables moving(double position, double advance, int windows = 1) {
  SceneTables t;
  t.position = position;
  t.advance = advance;
  t.windows = windows;
  t.window_width = 1.0 / windows;
  return t;
}

TEST(SliderWay, KnowsThetaOfTicksThatNoDoubleHolds) {
  // 2^61 ticks of 5/2^48 and some more: every number here but that of the tick is a double
  const SceneTables t = moving(0.25, 5 * 0x1p-48);
  const SliderWay way(t);
  constexpr std::int64_t far = std::int64_t{1} << 61;
  const Place start = way.stand(far);
  EXPECT_EQ(start.base, 5 << 13);
  EXPECT_EQ(start.theta, 0.25);
  for (const std::int64_t more : {1LL, 255LL, 257LL, 2047LL, 2049LL, 123456789LL, 123456789012LL}) {
    const double theta = 0.25 + static_cast<double>(more) * t.advance;
    EXPECT_EQ(way.stand(far + more).theta, theta) << more;
    EXPECT_EQ(way.moved(start, far + more).theta, theta) << more;
  }
}

TEST(SliderWay, ComesToTheNextNodeAndWindowInOneStep) {
  // At a hundredth of a rounding of the position a tick: what stopped short would stand there for a
  // hundred steps.
  Dice dice(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const double position = dice.uniform(0, 1), far = dice.ratio(1, 1e5);
    const double advance = 1e-2 * 0x1p-52 * (position + far);
    const SceneTables t = moving(position, advance, 1 + dice.pick(9));
    const SliderWay way(t);
    const auto step = static_cast<std::int64_t>(far / advance);
    const Place place = way.stand(step);
    const Place node = way.stand(step + way.ticks_to_next_node(place));
    EXPECT_EQ(node.base, place.base + 1) << "trial " << trial;
    // and no farther than four roundings of the position
    EXPECT_LT(node.position - node.base, 8 * 0x1p-52 * (place.position + 1)) << "trial " << trial;
    const Place window = way.stand(step + way.ticks_to_next_window(place));
    EXPECT_EQ(window.window(t), place.window(t) + 1) << "trial " << trial;
  }
}

TEST(SliderWay, OfASliderAtRestHasNoEnd) {
  const SceneTables t = moving(3.25, 0);
  const SliderWay way(t);
  EXPECT_GT(way.ticks_to_next_node(way.stand(7)), std::int64_t{1} << 61);
  EXPECT_EQ(way.stand(std::int64_t{1} << 61).theta, 0.25);
}

}  // namespace
