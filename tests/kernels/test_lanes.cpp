// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

#include "kernels/lanes.hpp"
#include "tests/numbers.hpp"

namespace {

using namespace ra2d;

constexpr int width = HostLanes::width;
using test::infinity;
using test::nan;
using Values = std::array<double, width>;

const HostLanes lanes;

static_assert(std::has_single_bit(static_cast<unsigned>(width)), "the sum's tree halves the lanes");

HostLanes::Real pack(const Values& x) { return lanes.load(x.data()); }

TEST(Lanes, LoadAndStoreKeepEveryLaneAndTouchNoOther) {
  std::array<double, width + 3> from{}, to{};
  for (int i = 0; i < width + 3; ++i) from[i] = i + 0.25;
  to.fill(-1);
  lanes.store(to.data() + 1, lanes.load(from.data() + 2));  // neither on a register's boundary
  EXPECT_EQ(to[0], -1);
  for (int lane = 0; lane < width; ++lane) EXPECT_EQ(to[lane + 1], lane + 2.25);
  EXPECT_EQ(to[width + 1], -1);
  EXPECT_EQ(to[width + 2], -1);
}

TEST(Lanes, IndexCountsTheLanes) {
  Values x;
  lanes.store(x.data(), lanes.index());
  for (int lane = 0; lane < width; ++lane) EXPECT_EQ(x[lane], lane);
}

TEST(Lanes, PacksToGoThroughAreThoseWithModesAndAtLeastOne) {
  // sums over the modes begin with the first pack: without modes it has to be set, too
  EXPECT_EQ(filled<64>(HostLanes(0)), 1);
  EXPECT_EQ(filled<64>(HostLanes(1)), 1);
  EXPECT_EQ(filled<64>(HostLanes(width)), 1);
  EXPECT_EQ(filled<64>(HostLanes(width + 1)), 2);
}

TEST(Lanes, SumOfEachLaneAloneAndOfAll) {
  Values all;
  for (int lane = 0; lane < width; ++lane) {
    Values one{};
    one[lane] = 3.5;
    EXPECT_EQ(lanes.sum(pack(one)), 3.5) << "lane " << lane;
    all[lane] = std::ldexp(1.0, lane);
  }
  EXPECT_EQ(lanes.sum(pack(all)), std::ldexp(1.0, width) - 1);
}

TEST(Lanes, SumAddsInOneFixedTree) {
  // Lane i with lane i + half, whatever the instruction set: results do not depend on it.
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 1000; ++trial) {
    Values x;
    for (double& each : x) each = uniform(random);
    Values tree = x;
    for (int half = width / 2; half > 0; half /= 2)
      for (int i = 0; i < half; ++i) tree[i] += tree[i + half];
    ASSERT_EQ(lanes.sum(pack(x)), tree[0]);
  }
}

TEST(Lanes, SmallestAndLargestInEveryLane) {
  for (int low = 0; low < width; ++low)
    for (int high = 0; high < width; ++high) {
      if (low == high) continue;
      Values x;
      for (int lane = 0; lane < width; ++lane) x[lane] = 0.125 * lane;
      x[low] = -1e30;
      x[high] = 7;
      EXPECT_EQ(lanes.min(pack(x)), -1e30);
      EXPECT_EQ(lanes.max(pack(x)), 7);
    }
  EXPECT_EQ(lanes.min(HostLanes::Real(-2.0)), -2);
  EXPECT_EQ(lanes.max(HostLanes::Real(-2.0)), -2);
}

TEST(Lanes, NextIsThatOfTheNextLane) {
  Values x, next;
  for (int lane = 0; lane < width; ++lane) x[lane] = lane + 0.25;
  lanes.store(next.data(), lanes.next(pack(x)));
  for (int lane = 0; lane < width; ++lane) EXPECT_EQ(next[lane], x[std::min(lane + 1, width - 1)]);
}

TEST(Lanes, AtLeastMarksEveryPattern) {
  // -1e30 is the height of the padding behind a face. A value that is not a number touches nothing.
  for (const double level : {0.0, -0.0, -1e-9, 1.5, -1e29}) {
    const double above[] = {level, std::nextafter(level, infinity), 1e30, infinity};
    const double below[] = {std::nextafter(level, -infinity), -1e30, nan, -infinity};
    for (std::uint32_t pattern = 0; pattern < 1u << width; ++pattern)
      for (int shift = 0; shift < 4; ++shift) {
        Values x;
        for (int lane = 0; lane < width; ++lane)
          x[lane] = pattern >> lane & 1 ? above[(lane + shift) % 4] : below[(lane + shift) % 4];
        ASSERT_EQ(lanes.at_least(pack(x), level), pattern) << "level " << level;
      }
  }
}

TEST(Lanes, AtLeastTakesBothZerosForOne) {
  constexpr std::uint32_t all = (1u << width) - 1;
  EXPECT_EQ(lanes.at_least(HostLanes::Real(-0.0), 0.0), all);
  EXPECT_EQ(lanes.at_least(HostLanes::Real(0.0), -0.0), all);
  EXPECT_EQ(lanes.at_least(HostLanes::Real(1.0), nan), 0u);
}

TEST(Lanes, MultiplyAddRoundsOnce) {
  // (1 + e)(1 - e) - 1 = -e^2: with two roundings nothing would be left of it.
  constexpr double e = 0x1p-30;
  EXPECT_EQ(multiply_add(1 + e, 1 - e, -1.0), -e * e);
  using Real = HostLanes::Real;
  Values packs, mixed;
  lanes.store(packs.data(), multiply_add(Real(1 + e), Real(1 - e), Real(-1.0)));
  lanes.store(mixed.data(), multiply_add(1 + e, Real(1 - e), Real(-1.0)));
  for (int lane = 0; lane < width; ++lane) {
    EXPECT_EQ(packs[lane], -e * e);
    EXPECT_EQ(mixed[lane], -e * e);
  }
}

TEST(Lanes, ACpuThreadLeadsItself) { EXPECT_TRUE(lanes.leader()); }

}  // namespace
