// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "host/device/backend.hpp"
#include "host/device/device.hpp"
#include "host/device/kokkos_device.hpp"
#include "tests/separate_device.hpp"

/// One thread, but where threads are the subject (RA2D_TEST_THREADS): two tests that run at a time
/// with two threads each would keep one another waiting on two cores. RA2D_TEST_DEVICE: "separate"
/// marches on a device that has memory of its own, "kokkos" through Kokkos alone, as on a GPU.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const char* threads = std::getenv("RA2D_TEST_THREADS");
  const ra2d::Backend backend(threads ? std::atoi(threads) : 1);
  const char* named = std::getenv("RA2D_TEST_DEVICE");
  const std::string device = named ? named : "";
  ra2d::test::SeparateDevice separate;
  if (device == "separate") ra2d::march_on(&separate);
  std::unique_ptr<ra2d::Device> kokkos;
  if (device == "kokkos") ra2d::march_on((kokkos = ra2d::make_kokkos_device()).get());
  return RUN_ALL_TESTS();
}
