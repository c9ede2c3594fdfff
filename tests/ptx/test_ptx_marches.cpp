// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/adaptive.hpp"
#include "tests/outcomes.hpp"
#include "tests/ptx/march_program.hpp"
#include "tests/ptx/pack_march.hpp"
#include "tests/schemes.hpp"

/// What nvcc makes of the marches, on the lanes of a warp: the bits of a pack of 32, no races, no
/// access outside the scene's arrays, no meeting that some lanes miss. RA2D_TEST_PTX names the
/// folder with the PTX (make_ptx.py).
namespace ra2d::test {
namespace {

constexpr std::int64_t longest = 800;  // steps
constexpr PtxWarp::Order orders[] = {PtxWarp::Order::together, PtxWarp::Order::shuffled,
                                     PtxWarp::Order::together, PtxWarp::Order::descending,
                                     PtxWarp::Order::together, PtxWarp::Order::ascending};

class PtxMarch : public testing::Test {
 protected:
  static MarchPrograms& programs() {
    static MarchPrograms read(std::getenv("RA2D_TEST_PTX"));
    return read;
  }
  void SetUp() override {
    if (std::getenv("RA2D_TEST_PTX") == nullptr) GTEST_SKIP() << "RA2D_TEST_PTX names no PTX";
  }

  static bool fits(const Model& model) {
    return model.resonator.modes.size() + model.slider.modes.size() <= warp_width;
  }
  /// Marches a scene on a pack and on a warp, in two launches, and compares.
  static void expect_same(const Started& c, std::int64_t steps, Seen& seen) {
    SceneOnLanes pack(c.model, c.start, 1), lanes(c.model, c.start, 1);
    const Program& program = programs().of(lanes.tables().scheme.form);
    PtxWarp warp = warp_for(program, lanes, orders[seen.scenes % std::size(orders)]);
    for (const std::int64_t target : {steps / 3, steps}) {
      march_on_pack(pack, target);
      march(warp, lanes, target);
    }
    EXPECT_EQ(lanes.differs_from(pack), "");
    EXPECT_THAT(warp.races(), testing::IsEmpty());
    seen.count(pack.state().carried.sums.contact_steps, pack.state().carried.shocks.begun);
  }
  /// Every kind of scene that `draw` makes of a seed, until there are so many that fit.
  template <class Draw>
  static void expect_all_same(int scenes, const Draw& draw, Seen& seen) {
    const int already = seen.scenes;
    for (std::uint64_t seed = 1; seen.scenes < already + scenes; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const Started c = draw(seed);
      if (fits(c.model)) expect_same(c, std::min(longest, c.model.steps), seen);
    }
  }
};

TEST_F(PtxMarch, AllSchemesUnderAllLawsHaveTheBitsOfAPack) {
  Seen seen;
  for (const SchemeUnderLaw& scheme : schemes_under_laws()) {
    SCOPED_TRACE(scheme.name());
    expect_all_same(
        1, [&](std::uint64_t seed) { return random_scene(seed + static_cast<std::uint64_t>(seen.scenes), scheme.variant()); }, seen);
  }
  EXPECT_GE(seen.touching, seen.scenes / 2);
  EXPECT_GE(seen.with_shocks, 1);
}

TEST_F(PtxMarch, AdaptiveScenesHaveTheBitsOfAPack) {
  Seen seen;
  for (std::uint64_t seed = 1; seen.scenes < 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Started c = random_adaptive_scene(seed);
    if (fits(c.model)) expect_same(c, c.model.steps / 50, seen);
  }
  EXPECT_GE(seen.touching, 2);
  EXPECT_GE(seen.with_shocks, 1);
}

TEST_F(PtxMarch, SmoothFacesHaveTheBitsOfAPack) {
  const std::vector<Scheme> kinds = {
      {{{SchemeKind::rk4}}, "rk4"},
      {{{SchemeKind::adaptive}}, "adaptive"},
      {{{SchemeKind::backward_euler, ForceTime::new_time}}, "new force"},
      {{{SchemeKind::backward_euler}, ContactLaw::multiplier}, "multipliers"}};
  Seen seen;
  for (const Scheme& kind : kinds) {
    SCOPED_TRACE(kind.name);
    const Variant variant{kind, 0, [](Scene& s) { s.faces = Faces::smooth; }};
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Started c = random_scene(seed, variant);
      if (!fits(c.model)) continue;
      SCOPED_TRACE("seed " + std::to_string(seed));
      const int touching = seen.touching;
      expect_same(c, longest / 8, seen);
      if (seen.touching > touching) break;
    }
  }
  EXPECT_GE(seen.touching, static_cast<int>(kinds.size()));
}

// A lane that nothing holds back reads what another has not written yet.
TEST_F(PtxMarch, AMissingSyncIsNoticed) {
  const char* const only = std::getenv("EXPLORE");
  for (const SchemeKind kind : {SchemeKind::backward_euler, SchemeKind::rk4, SchemeKind::adaptive}) {
    const Variant variant{{{{kind}}, ""}, 0, {}};
    for (std::uint64_t seed = 1;; ++seed) {
      const Started c = random_scene(seed, variant);
      if (!fits(c.model)) continue;
      SceneOnLanes whole(c.model, c.start, 1);
      const Program& program = programs().of(whole.tables().scheme.form);
      PtxWarp first = warp_for(program, whole, PtxWarp::Order::together);
      march(first, whole, 100);
      if (whole.state().carried.sums.contact_steps == 0) continue;
      int run = 0, noticed = 0;
      for (const std::size_t sync : program.syncs()) {
        if (first.counts()[sync] == 0) continue;
        ++run;
        SceneOnLanes scene(c.model, c.start, 1);
        PtxWarp warp = warp_for(program, scene, PtxWarp::Order::together);
        warp.ignore(sync);
        march(warp, scene, 100);
        if (!warp.races().empty()) ++noticed;
        else if (only) printf("unnoticed %s count %d\n", program.place(program.instructions()[sync]).c_str(), (int)first.counts()[sync]);
      }
      printf("%d of %d noticed of %d\n", noticed, run, (int)program.syncs().size());
      break;
    }
  }
}

}  // namespace
}  // namespace ra2d::test
