// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "host/model/areal_size.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/study/run_memory.hpp"
#include "host/system/machine_memory.hpp"
#include "tests/places.hpp"

namespace ra2d {
namespace {

/// An areal scene whose maps take so much [bytes], about, and none of it is touched here.
Scene scene_of(double bytes) {
  Scene scene = read_scene(test::scene_file("areal"));
  scene.spacing_y = scene.spacing = 1e-5;
  const double at_10_um = areal_memory(scene) - program_memory;
  scene.spacing_y = scene.spacing = 1e-5 / std::sqrt(bytes / at_10_um);
  return scene;
}

TEST(RunMemory, OfProcessesOnOneMachineEachHasItsShare) {
  const auto machine = static_cast<double>(machine_memory());
  const Scene scene = scene_of(0.05 * machine);
  RunMemory alone(1), one_of_ten(10);
  const RunMemory::Part first = alone.part_for(scene), shared = one_of_ten.part_for(scene);
  EXPECT_TRUE(alone.has_room(0.06 * machine));
  EXPECT_FALSE(one_of_ten.has_room(0.06 * machine));  // of a tenth there is a twentieth left
  EXPECT_TRUE(one_of_ten.may_have_room(0.5 * machine));
  EXPECT_FALSE(one_of_ten.may_have_room(1.01 * machine));
}

TEST(RunMemory, WhatRunsHaveYetToTouchIsNotFree) {
  const double half = 0.5 * static_cast<double>(available_memory());
  const Scene scene = scene_of(half);
  RunMemory memory(1);
  EXPECT_FALSE(memory.in_use());
  {
    const RunMemory::Part first = memory.part_for(scene);
    EXPECT_TRUE(memory.in_use());
    EXPECT_FALSE(memory.has_room(1.5 * half));
    std::optional<RunMemory::Part> second;
    EXPECT_NO_THROW(second.emplace(memory.part_for(scene_of(0.2 * half))));
    EXPECT_THROW(memory.part_for(scene_of(1.4 * half)), MemoryShortage);
    second.reset();
  }
  EXPECT_FALSE(memory.in_use());
  EXPECT_TRUE(memory.has_room(1.5 * half));
}

TEST(RunMemory, PlaneScenesAreNotCounted) {
  RunMemory memory(1);
  const RunMemory::Part part = memory.part_for(read_scene(test::scene_file("dang2012")));
  EXPECT_FALSE(memory.in_use());
}

}  // namespace
}  // namespace ra2d
