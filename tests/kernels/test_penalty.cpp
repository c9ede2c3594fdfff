// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "kernels/contact/penalty.hpp"
#include "kernels/lanes.hpp"

namespace {

using namespace ra2d;

constexpr Penalty spring{3e6};  // N/m
constexpr double micrometre = 0x1p-20;

TEST(Penalty, OpenGapHasNoForce) {
  EXPECT_EQ(spring.force(-micrometre), 0);
  EXPECT_EQ(spring.force(-std::numeric_limits<double>::denorm_min()), 0);
  EXPECT_EQ(spring.force(-1e30), 0);
}

TEST(Penalty, TouchingAtExactlyZeroHasNoForce) {
  EXPECT_EQ(spring.force(0.0), 0);
  EXPECT_EQ(spring.force(-0.0), 0);
}

TEST(Penalty, OverlapIsPushedApartInProportion) {
  EXPECT_EQ(spring.force(micrometre), 3e6 * micrometre);
  EXPECT_EQ(spring.force(2 * micrometre), 6e6 * micrometre);
}

TEST(Penalty, EachLaneHasItsOwnForce) {
  constexpr int width = HostLanes::width;
  std::array<double, width> overlap, force;
  for (int lane = 0; lane < width; ++lane) overlap[lane] = (lane - 1) * micrometre;
  HostLanes::store(force.data(), spring.force(HostLanes::load(overlap.data())));
  for (int lane = 0; lane < width; ++lane)
    EXPECT_EQ(force[lane], lane > 1 ? 3e6 * (lane - 1) * micrometre : 0) << "lane " << lane;
}

}  // namespace
