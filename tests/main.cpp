// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdlib>

#include "host/device/backend.hpp"
#include "host/device/device.hpp"
#include "tests/separate_device.hpp"

/// One thread, but where threads are the subject (RA2D_TEST_THREADS): two tests that run at a time
/// with two threads each would keep one another waiting on two cores. RA2D_TEST_SEPARATE_DEVICE:
/// marched on a device that has memory of its own.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const char* threads = std::getenv("RA2D_TEST_THREADS");
  const ra2d::Backend backend(threads ? std::atoi(threads) : 1);
  ra2d::test::SeparateDevice separate;
  if (std::getenv("RA2D_TEST_SEPARATE_DEVICE") != nullptr) ra2d::march_on(&separate);
  return RUN_ALL_TESTS();
}
