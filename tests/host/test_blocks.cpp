// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "host/system/blocks.hpp"

namespace {

TEST(Blocks, EachIndexFallsIntoOneBlock) {
  for (const std::size_t count : {0, 1, 7, 8, 9, 1000}) {
    std::vector<int> seen(count, 0);
    ra2d::in_blocks(count, 8, [&](std::size_t block, std::size_t first, std::size_t last) {
      EXPECT_EQ(first, 8 * block);
      EXPECT_LE(last, first + 8);
      for (std::size_t i = first; i < last; ++i) ++seen[i];
    });
    EXPECT_EQ(seen, std::vector<int>(count, 1));
  }
}

TEST(Blocks, OneBlockStaysOnTheCallersThread) {
  std::thread::id who;
  ra2d::in_blocks(5, 8,
                  [&](std::size_t, std::size_t, std::size_t) { who = std::this_thread::get_id(); });
  EXPECT_EQ(who, std::this_thread::get_id());
}

TEST(Blocks, AFaultEndsThemAndIsTheCallers) {
  std::atomic<int> calls = 0;
  EXPECT_THROW(ra2d::in_blocks(1'000'000, 1,
                               [&](std::size_t, std::size_t, std::size_t) {
                                 ++calls;
                                 throw std::runtime_error("no");
                               }),
               std::runtime_error);
  EXPECT_LE(calls, 4);  // one a thread
}

}  // namespace
