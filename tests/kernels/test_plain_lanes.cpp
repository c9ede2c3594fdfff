// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/device/device.hpp"
#include "tests/adaptive.hpp"
#include "tests/kernels/plain_march.hpp"
#include "tests/outcomes.hpp"
#include "tests/schemes.hpp"
#include "tests/separate_device.hpp"

/// The marches of production, on the lanes that march here (SIMD registers, on a GPU the threads of
/// a warp) and on lanes that are nothing but doubles on one thread of the host: the same bits. So
/// nothing but the reductions that PackLanes has is asked of the lanes, no instruction rounds
/// otherwise, and on a GPU the compiler has fused no operations, and every thread has seen what the
/// others wrote.
namespace ra2d::test {
namespace {

constexpr int scenes_each = 16;

MarchScene plain_march_for(Form form, const TeamShape& shape) {
  const int packs = shape.packs;
  if (std::find(plain_packs.begin(), plain_packs.end(), packs) == plain_packs.end())
    throw std::logic_error("no plain march for that many packs");
  switch (form) {
    case Form::semi_implicit:
      return plain_march_of<Form::semi_implicit>(packs);
    case Form::staged:
      return plain_march_of<Form::staged>(packs);
    case Form::implicit:
      return plain_march_of<Form::implicit>(packs);
    case Form::adaptive:
      return plain_march_of<Form::adaptive>(packs);
  }
  return nullptr;
}

bool fits(const Model& model, int packs) {
  return model.resonator.modes.size() + model.slider.modes.size() <=
         static_cast<std::size_t>(packs * pack_width);
}

// as many lanes as a GPU has for a form: the team that leaves fewest without a mode
TEST(PlainLanes, AMarchIsOfTheSmallestTeamThatHasRoom) {
  using Compiled = ShapeList<TeamShape{32, 1}, TeamShape{32, 2}, TeamShape{32, 8}, TeamShape{8, 3}>;
  EXPECT_TRUE((Compiled::smallest(1) == TeamShape{8, 3}));
  EXPECT_TRUE((Compiled::smallest(24) == TeamShape{8, 3}));
  EXPECT_TRUE((Compiled::smallest(25) == TeamShape{32, 1}));
  EXPECT_TRUE((Compiled::smallest(33) == TeamShape{32, 2}));
  EXPECT_TRUE((Compiled::smallest(256) == TeamShape{32, 8}));
  EXPECT_EQ(Compiled::smallest(257).packs, 0);
}

void expect_same(const Started& c, int packs, Seen& seen) {
  const BatchOptions padded{.capacity = {}, .least_packs = packs};
  const Outcome outcome = march(c.model, c.start, c.model.scene.time.nodes, padded);
  SeparateDevice device(std::size_t{1} << 40, plain_march_for);
  const MarchedThere there(device);
  EXPECT_TRUE(same(outcome, march(c.model, c.start, c.model.scene.time.nodes, padded)));
  seen.count(outcome.end.contact_steps, outcome.end.shocks_begun);
}

/// The first `steps` of it.
Started beginning(Started c, std::int64_t steps) {
  c.model.steps = std::min(c.model.steps, steps);
  c.model.samples =
      1 + static_cast<std::int64_t>(static_cast<double>(c.model.steps) / c.model.steps_per_sample);
  return c;
}

class PlainLanes : public testing::TestWithParam<SchemeUnderLaw> {};

TEST_P(PlainLanes, GiveTheSameBits) {
  Seen seen;
  for (std::uint64_t seed = 1; seen.scenes < scenes_each; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Started c = random_scene(seed, GetParam().variant());
    const int packs = plain_packs[seed % plain_packs.size()];
    if (fits(c.model, packs)) expect_same(beginning(c, 5000), packs, seen);
  }
  EXPECT_GE(seen.touching, scenes_each / 2);
  EXPECT_GE(seen.with_shocks, 1);
}

INSTANTIATE_TEST_SUITE_P(Schemes, PlainLanes, testing::ValuesIn(schemes_under_laws()),
                         [](const auto& info) { return info.param.name(); });

TEST(PlainLanes, GiveTheSameBitsOfTheAdaptiveScheme) {
  if (march_device() != nullptr)
    GTEST_SKIP() << "a GPU's exp2 and log2, which the length of a step comes from, are not libm's";
  Seen seen;
  for (std::uint64_t seed = 1; seen.scenes < scenes_each; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Started c = random_adaptive_scene(seed);
    const int packs = plain_packs[seed % plain_packs.size()];
    if (fits(c.model, packs)) expect_same(beginning(c, c.model.steps / 10), packs, seen);
  }
  EXPECT_GE(seen.touching, scenes_each / 3);
  EXPECT_GE(seen.with_shocks, 1);
}

}  // namespace
}  // namespace ra2d::test
