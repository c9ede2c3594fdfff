// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "host/device/batch.hpp"
#include "tests/adaptive.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/outcomes.hpp"
#include "tests/schemes.hpp"
#include "tests/warp/marches.hpp"
#include "tests/warp/scene_on_lanes.hpp"

/// The very marches of production on the 32 lanes of a warp: the bits of a pack of 32, in whatever
/// order the lanes come, and, as the thread sanitizer sees it, no read or write of the shared state
/// that a `sync` does not order.
namespace ra2d::test {
namespace {

constexpr int scenes_each = 3;          // one for each order of the lanes
constexpr std::int64_t longest = 1500;  // steps
constexpr LaneOrder orders[] = {LaneOrder::ascending, LaneOrder::descending, LaneOrder::shuffled};

bool fits(const Model& model) {
  return model.resonator.modes.size() + model.slider.modes.size() <= most_packs * warp_width;
}

/// Marches a scene on a pack and on a warp, in two launches, and compares.
void expect_same(const Started& c, std::int64_t steps, Seen& seen) {
  const int least_packs = seen.scenes % 4 == 0 ? most_packs : 1;
  SceneOnLanes pack(c.model, c.start, least_packs);
  const std::int64_t targets[] = {steps / 3, steps};
  for (const std::int64_t target : targets)
    march_on_pack(pack.packs(), pack.tables(), pack.state(), target);
  SceneOnLanes lanes(c.model, c.start, least_packs);
  Warp warp(orders[seen.scenes % std::size(orders)]);
  for (const std::int64_t target : targets)
    march_on_warp(warp, lanes.packs(), lanes.tables(), lanes.state(), target);
  EXPECT_EQ(lanes.differs_from(pack), "");
  seen.count(pack.state().carried.sums.contact_steps, pack.state().carried.shocks.begun);
}

class MarchOnWarp : public testing::TestWithParam<SchemeUnderLaw> {};

TEST_P(MarchOnWarp, RandomScenesHaveTheBitsOfAPack) {
  Seen seen;
  for (std::uint64_t seed = 1; seen.scenes < scenes_each; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Started c = random_scene(seed, GetParam().variant());
    if (fits(c.model)) expect_same(c, longest, seen);
  }
  EXPECT_GE(seen.touching, scenes_each / 2);
  EXPECT_GE(seen.with_shocks, 1);
}

INSTANTIATE_TEST_SUITE_P(Schemes, MarchOnWarp, testing::ValuesIn(schemes_under_laws()),
                         [](const auto& info) { return info.param.name(); });

TEST(MarchOnWarp, SmoothFacesHaveTheBitsOfAPack) {
  const std::vector<Scheme> kinds = {
      {{{SchemeKind::midpoint}}, "midpoint"},
      {{{SchemeKind::rk4}}, "rk4"},
      {{{SchemeKind::adaptive}}, "adaptive"},
      {{{SchemeKind::backward_euler, ForceTime::new_time}}, "new force"},
      {{{SchemeKind::backward_euler}, ContactLaw::multiplier}, "multipliers"}};
  for (const Scheme& kind : kinds) {
    SCOPED_TRACE(kind.name);
    const Variant variant{kind, 0, [](Scene& s) { s.faces = Faces::smooth; }};
    Seen seen;
    for (std::uint64_t seed = 1; seen.touching < 1; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const Started c = random_scene(seed, variant);
      if (fits(c.model)) expect_same(c, longest / 10, seen);
    }
  }
}

/// Velocities of all modes.
std::vector<double> velocities(const Snapshot& s) {
  std::vector<double> all = s.resonator_v;
  all.insert(all.end(), s.slider_v.begin(), s.slider_v.end());
  return all;
}
/// The largest difference over the largest value.
double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0, size = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    difference = std::max(difference, std::abs(a[k] - b[k]));
    size = std::max(size, std::abs(a[k]));
  }
  return size > 0 ? difference / size : difference;
}

// Sums over 32 lanes round otherwise than those over the lanes of a CPU. So a GPU's motion is off
// by a rounding a step, each made as much larger by the shocks that follow as a nudge of the gap
// is.
class PackBesideHost : public testing::TestWithParam<SchemeUnderLaw> {};

TEST_P(PackBesideHost, IsOffByRoundingsThatShocksEnlarge) {
  constexpr double nudge = 1e-10;  // of the largest height
  Seen seen;
  for (std::uint64_t seed = 1; seen.scenes < scenes_each; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Started c = random_scene(seed, GetParam().variant());
    if (!fits(c.model)) continue;
    SceneOnLanes pack(c.model, c.start, 1);
    march_on_pack(pack.packs(), pack.tables(), pack.state(), longest);
    Batch host({c.model}, {c.start});
    host.march(longest);
    double height = std::abs(c.model.delta);
    for (const double h : c.model.slider_height) height = std::max(height, std::abs(h));
    c.model.delta += nudge * height;
    Batch nudged({c.model}, {c.start});
    nudged.march(longest);
    const std::vector<double> here = velocities(host.snapshot(0));
    const double enlarged = distance(here, velocities(nudged.snapshot(0))) / nudge;
    const double steps = static_cast<double>(host.snapshot(0).step);
    EXPECT_EQ(host.snapshot(0).shocks_begun, pack.state().carried.shocks.begun);
    const double found =
        distance(here, {pack.state().out.now.v, pack.state().out.now.v + here.size()});
    EXPECT_LE(found, steps * 0x1p-53 * std::max(1.0, enlarged));
    seen.count(pack.state().carried.sums.contact_steps, pack.state().carried.shocks.begun);
  }
  EXPECT_GE(seen.touching, scenes_each / 2);
  EXPECT_GE(seen.with_shocks, 1);
}
INSTANTIATE_TEST_SUITE_P(Schemes, PackBesideHost, testing::ValuesIn(schemes_under_laws()),
                         [](const auto& info) { return info.param.name(); });

TEST(MarchOnWarp, ArealScenesHaveTheBitsOfAPack) {
  constexpr std::int64_t steps = 200;
  for (const Faces faces : {Faces::linear, Faces::smooth}) {
    SCOPED_TRACE(faces == Faces::smooth ? "smooth" : "linear");
    ArealScene scene = sixty_modes();
    scene.faces = faces;
    for (const Scheme& kind : schemes_and_implicit()) {
      if (kind.table().stages > 4) continue;
      SCOPED_TRACE(kind.name);
      Seen seen;
      expect_same(areal_march(scene, kind, 1e-8, steps, 2, Nodes::candidates), steps, seen);
      EXPECT_EQ(seen.touching, 1);
    }
    Seen seen;
    const Started c = areal_march(scene, 1e-6, 3e-4, 10);
    expect_same(c, c.model.steps / 20, seen);
    EXPECT_EQ(seen.touching, 1);
  }
}

TEST(MarchOnWarp, ClustersHaveTheBitsOfAPack) {
  for (const double tolerance : {1e-6, 1e-8}) {
    const Started c = areal_march(fine_maps(100), tolerance, 1e-4, 10);
    ASSERT_GT(cluster_degree(c.model, warp_width), 0);
    for (Seen seen; seen.scenes < 3;) {  // in each order of the lanes
      seen.touching = 0;
      expect_same(c, c.model.steps / 20, seen);
      EXPECT_EQ(seen.touching, 1);
    }
  }
}

TEST(MarchOnWarp, AdaptiveScenesHaveTheBitsOfAPack) {
  Seen seen;
  for (std::uint64_t seed = 1; seen.scenes < scenes_each; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Started c = random_adaptive_scene(seed);
    if (fits(c.model)) expect_same(c, c.model.steps / 25, seen);
  }
  EXPECT_GE(seen.touching, scenes_each / 3);
  EXPECT_GE(seen.with_shocks, 1);
}

}  // namespace
}  // namespace ra2d::test
