// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "tests/adaptive.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/effort.hpp"
#include "tests/outcomes.hpp"
#include "tests/schemes.hpp"

/// The saved state is all that a march needs: the rest is thrown away between launches, and the
/// answer keeps its bits. It also keeps them where room runs out in the middle of a run.
namespace ra2d::test {
namespace {

void expect_goes_on_the_same(const Started& c, std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  const Outcome whole = march(c.model, c.start, c.model.scene.time.nodes);
  EXPECT_TRUE(same(whole, march_from_saved_states(c.model, c.start, seed)));
}

struct SavedState_ : testing::TestWithParam<Scheme> {};

TEST_P(SavedState_, IsAllThatAMarchGoesOnFrom) {
  std::int64_t contact = 0, shocks = 0;
  for (std::uint64_t seed = 1; seed <= 6; seed += draws_enough() ? 1 : 2)
    for (const ContactLaw law : {ContactLaw::penalty, ContactLaw::multiplier}) {
      if (law == ContactLaw::multiplier && !takes_multipliers(GetParam().time.scheme)) continue;
      Variant variant{.scheme = GetParam()};
      variant.adapt = [&](Scene& s) {
        s.contact.law = law;
        s.time.nodes = seed % 3 == 0 ? Nodes::all : Nodes::candidates;
      };
      const Started c = random_scene(seed, variant);
      expect_goes_on_the_same(c, seed);
      const Snapshot end = march(c.model, c.start, c.model.scene.time.nodes).end;
      contact += end.contact_steps;
      shocks += end.shocks_begun;
    }
  EXPECT_GT(contact, 0);
  EXPECT_GT(shocks, 0);
}

INSTANTIATE_TEST_SUITE_P(Schemes, SavedState_, testing::ValuesIn(schemes),
                         [](const auto& tested) { return tested.param.name; });

TEST(SavedStates, OfTheAdaptiveScheme) {
  for (const Faces faces : {Faces::linear, Faces::smooth}) {
    std::int64_t shocks = 0;
    const auto scenes = static_cast<std::uint64_t>(draws(12));
    for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
      const Started c = random_adaptive_scene(seed, faces);
      expect_goes_on_the_same(c, seed);
      shocks += march(c.model, c.start, Nodes::candidates).end.shocks_begun;
    }
    EXPECT_GT(shocks, draws_enough() ? 10 : 0);
  }
}

TEST(SavedStates, OfSmoothMaps) {
  for (const Support block : {Support::rigid, Support::free}) {
    ArealScene s = small_areal_scene(block);
    s.faces = Faces::smooth;
    const Started c = areal_march(s, 1e-6, 1e-4, 4);
    EXPECT_GT(march(c.model, c.start, Nodes::candidates).end.shocks_begun, 0);
    expect_goes_on_the_same(c, 1);
  }
}

TEST(Capacity, RunsOutAndGrowsWithTheSameBits) {
  for (const bool found_together : {false, true}) {
    Scene scene = rough_scene(Support::free);
    if (found_together)
      scene.time.contact_force = ForceTime::new_time;
    else
      scene = adaptive(scene, 1e-8);
    const Recording expected = simulate(scene);
    ASSERT_EQ(expected.end.status, Status::done);
    ASSERT_GT(expected.end.most_nodes, 1);
    for (const int nodes : {1, 2, 3})
      EXPECT_TRUE(same(expected, simulate(scene, {.batch = {.capacity = {.nodes = nodes}}})))
          << nodes << " nodes at first, found at once: " << found_together;
  }
}

constexpr int wedge_rows = 260, wedge_steps = 21;

/// A block of 260 x 260 nodes that falls off by 2 nm a node, on a plate that rises by 1 nm a node:
/// so many nodes of each row touch at first, one more with each node that the block has slid.
ArealScene wedge(int touching) {
  constexpr int before = 10, row = 260, beyond = 10;
  ArealScene s = rigid_block();
  s.plate.modes = 3;
  s.spacing = s.spacing_y = 1e-5;
  s.block.length = (row - 1) * s.spacing, s.block.width = wedge_rows * s.spacing_y;
  s.start = before * s.spacing;
  s.stiffness = 1e10;
  std::vector<double> plate(before + row + beyond), block(row);
  for (std::size_t i = 0; i < plate.size(); ++i) plate[i] = 1e-9 * static_cast<double>(i);
  for (std::size_t i = 0; i < block.size(); ++i) block[i] = -2e-9 * static_cast<double>(i);
  s.plate_heights.assign(wedge_rows, plate);
  s.block_heights.assign(wedge_rows, block);
  s.gap = 1e-9 * (before - touching + 0.5);
  return s;
}

/// Over 4.2 nodes.
Outcome slide_wedge(int touching, Nodes nodes) {
  const Started c = areal_march(wedge(touching), schemes[0], 1e-6, wedge_steps, 1, nodes);
  EXPECT_EQ(c.start.loaded_nodes.size(), std::size_t(touching * wedge_rows));
  return march(c.model, c.start, nodes);
}

TEST(Capacity, OfArealScenesEndsAtTheMostNodesThatCanBeFollowed) {
  const Outcome most = slide_wedge(248, Nodes::candidates);  // more than half of the longest list
  EXPECT_EQ(most.end.status, Status::done);
  EXPECT_EQ(most.end.most_nodes, 252 * wedge_rows);
  EXPECT_TRUE(same(most, slide_wedge(248, Nodes::all)));
  EXPECT_EQ(slide_wedge(250, Nodes::candidates).end.status, Status::crowded);
}

}  // namespace
}  // namespace ra2d::test
