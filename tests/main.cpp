// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdlib>

#include "host/device/backend.hpp"

/// One thread, but where threads are the subject (RA2D_TEST_THREADS): two tests that run at a time
/// with two threads each would keep one another waiting on two cores.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const char* threads = std::getenv("RA2D_TEST_THREADS");
  const ra2d::Backend backend(threads ? std::atoi(threads) : 1);
  return RUN_ALL_TESTS();
}
