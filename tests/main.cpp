// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdlib>

#include "host/run/batch.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const char* threads = std::getenv("RA2D_TEST_THREADS");
  const ra2d::Backend backend(threads ? std::atoi(threads) : 0);
  return RUN_ALL_TESTS();
}
