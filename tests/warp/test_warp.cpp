// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "tests/warp/warp.hpp"

/// That the warp of the tests finds what it is there to find.
namespace ra2d::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Kernel = std::function<void(const FiberLanes&)>;

constexpr LaneOrder all_orders[] = {LaneOrder::ascending, LaneOrder::descending,
                                    LaneOrder::shuffled};

void run(Warp& warp, const Kernel& kernel) {
  warp.run([&](int lane) { kernel(FiberLanes{warp, lane}); });
}
/// The fault that the lanes are caught at; empty: none.
std::string caught(const Kernel& kernel) {
  Warp warp;
  try {
    run(warp, kernel);
  } catch (const Diverged& diverged) {
    return diverged.what();
  }
  return {};
}

TEST(Warp, ReductionsAreThoseOfAllLanes) {
  for (const LaneOrder order : all_orders) {
    Warp warp(order);
    std::array<double, warp_width> ended{};
    run(warp, [&](const FiberLanes& lanes) {
      EXPECT_EQ(lanes.sum(lanes.index()), 31 * 32 / 2);
      EXPECT_EQ(lanes.min(10 - lanes.index()), -21);
      EXPECT_EQ(lanes.max(10 - lanes.index()), 10);
      EXPECT_EQ(lanes.at_least(lanes.index(), 30), 3u << 30);
      EXPECT_EQ(lanes.next(2 * lanes.index()), 2 * std::min(lanes.lane + 1, 31));
      lanes.sync();
      lanes.store(ended.data(), 1);
    });
    EXPECT_THAT(ended, testing::Each(1));
    EXPECT_EQ(warp.reductions(), 5);
    EXPECT_EQ(warp.syncs(), 1);
  }
}

TEST(Warp, LanesThatGoDifferentWaysAreCaught) {
  // not within a macro, where all stands on one line
  const std::string sum_or_sync = caught([](const FiberLanes& lanes) {
    if (lanes.lane == 7)
      lanes.sum(1.0);
    else
      lanes.sync();
  });
  EXPECT_THAT(sum_or_sync, AllOf(HasSubstr("lane 0 is at a sync"), HasSubstr("lane 7 is at a sum"),
                                 HasSubstr("test_warp.cpp")));
  const std::string in_two_places = caught([](const FiberLanes& lanes) {
    if (lanes.lane < 16)
      lanes.sum(1.0);
    else
      lanes.sum(1.0);
  });
  EXPECT_THAT(in_two_places,
              AllOf(HasSubstr("lane 0 is at a sum"), HasSubstr("lane 16 is at a sum")));
  const std::string once_more = caught([](const FiberLanes& lanes) {
    for (int i = 0; i < (lanes.lane == 3 ? 5 : 4); ++i) lanes.sync();
  });
  EXPECT_THAT(once_more,
              AllOf(HasSubstr("lane 0 is at its end"), HasSubstr("lane 3 is at a sync")));
  const std::string early = caught([](const FiberLanes& lanes) {
    if (lanes.lane == 31) return;
    lanes.min(1.0);
  });
  EXPECT_THAT(early, AllOf(HasSubstr("lane 0 is at a min"), HasSubstr("lane 31 is at its end")));
}

TEST(Warp, AFaultInOneLaneIsTheCallers) {
  Warp warp;
  EXPECT_THROW(run(warp,
                   [](const FiberLanes& lanes) {
                     if (lanes.lane == 5) throw std::runtime_error("no");
                     lanes.sync();
                   }),
               std::runtime_error);
  run(warp, [](const FiberLanes& lanes) { lanes.sync(); });  // and it can be used again
  EXPECT_EQ(warp.syncs(), 1);
}

/// The leader writes what the others read, with or without a sync between.
void read_after_write(bool in_order) {
  Warp warp;
  double shared = 0;
  std::array<double, warp_width> read{};
  run(warp, [&](const FiberLanes& lanes) {
    if (lanes.leader()) shared = 1;
    if (in_order)
      lanes.sync();
    else
      lanes.sum(1.0);  // orders nothing that is not in a register
    lanes.store(read.data(), shared);
  });
  EXPECT_THAT(read, testing::Each(1));
}
/// One lane writes a value that the others have read.
void write_after_read(bool in_order) {
  Warp warp;
  double shared = 1;
  std::array<double, warp_width> read{};
  run(warp, [&](const FiberLanes& lanes) {
    lanes.store(read.data(), shared);
    if (in_order)
      lanes.sync();
    else
      lanes.sum(1.0);
    if (lanes.leader()) shared = 2;
  });
  EXPECT_THAT(read, testing::Each(1));
}

TEST(WarpDeathTest, AMissingSyncIsARace) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const auto& kernel : {read_after_write, write_after_read}) {
    kernel(true);
    EXPECT_EXIT(
        {
          kernel(false);
          std::exit(0);  // with another status after a race
        },
        testing::ExitedWithCode(66), "data race");
  }
}

}  // namespace
}  // namespace ra2d::test
