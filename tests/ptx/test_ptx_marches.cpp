// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "host/device/layout.hpp"
#include "tests/adaptive.hpp"
#include "tests/outcomes.hpp"
#include "tests/ptx/march_program.hpp"
#include "tests/ptx/pack_march.hpp"
#include "tests/schemes.hpp"

/// The marches as nvcc compiles them, on the lanes of a warp, which one scene has, or several: the
/// bits of packs as wide as a scene's team, no races, no access outside a scene's arrays, no
/// meeting that some lanes miss. RA2D_TEST_PTX names the folder with the PTX (make_ptx.py).
namespace ra2d::test {
namespace {

constexpr std::int64_t longest = 800;  // steps
constexpr PtxWarp::Order orders[] = {PtxWarp::Order::in_step, PtxWarp::Order::shuffled,
                                     PtxWarp::Order::in_step, PtxWarp::Order::descending,
                                     PtxWarp::Order::in_step, PtxWarp::Order::ascending};

class PtxMarch : public testing::TestWithParam<Form> {
 protected:
  static const Program& program() {
    static MarchPrograms programs(std::getenv("RA2D_TEST_PTX"));
    return programs.of(GetParam());
  }
  void SetUp() override {
    if (std::getenv("RA2D_TEST_PTX") == nullptr) GTEST_SKIP() << "RA2D_TEST_PTX names no PTX";
  }

  static TeamShape shape() { return shape_of(GetParam()); }
  static int teams() { return warp_width / shape().width; }
  static bool has_lanes_for(const Started& c) {
    return c.model.resonator.modes.size() + c.model.slider.modes.size() <=
           static_cast<std::size_t>(shape().modes());
  }
  /// Whether a scene is of this form, and its team has lanes for its modes.
  static bool fits(const Started& c) {
    return has_lanes_for(c) && form_of(c.model.scene) == GetParam();
  }
  /// Marches scenes on packs and on the teams of a warp, in two launches, and compares.
  static void expect_same(const std::vector<Started>& scenes, std::int64_t steps, Seen& seen) {
    std::vector<std::unique_ptr<SceneOnLanes>> packs, lanes;
    TeamScenes of_warp;
    for (const Started& c : scenes) {
      packs.push_back(std::make_unique<SceneOnLanes>(c.model, c.start, shape()));
      lanes.push_back(std::make_unique<SceneOnLanes>(c.model, c.start, shape()));
      of_warp.push_back(lanes.back().get());
    }
    PtxWarp warp = warp_for(program(), of_warp, orders[seen.scenes % std::size(orders)]);
    for (const std::int64_t target : {steps / 3, steps}) {
      for (const auto& pack : packs) march_on_pack(*pack, target);
      march(warp, of_warp, target);
    }
    EXPECT_THAT(warp.races(), testing::IsEmpty());
    for (std::size_t k = 0; k < scenes.size(); ++k) {
      const CarriedState& carried = packs[k]->state().carried;
      EXPECT_EQ(lanes[k]->differs_from(*packs[k]), "") << "team " << k;
      seen.count(carried.sums.contact_steps, carried.shocks.begun);
    }
  }
};

TEST_P(PtxMarch, RandomScenesHaveTheBitsOfAPack) {
  Seen seen;
  if (GetParam() == Form::adaptive) {
    for (std::uint64_t seed = 1; seen.scenes < 10; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const Started c = random_adaptive_scene(seed);
      if (fits(c)) expect_same({c}, c.model.steps / 25, seen);
    }
  } else {
    for (const SchemeUnderLaw& scheme : schemes_under_laws()) {
      SCOPED_TRACE(scheme.name());
      // two warps; where they have several teams, one of the second's has no scene
      std::vector<Started> scenes;
      for (std::uint64_t seed = 1, warps = 0; seed < 40 && warps < 2; ++seed) {
        const Started c = random_scene(seed, scheme.variant());
        if (!fits(c)) continue;
        scenes.push_back(c);
        const auto wanted = static_cast<std::size_t>(teams() > 1 ? teams() - warps : 1);
        if (scenes.size() < wanted) continue;
        SCOPED_TRACE("seed " + std::to_string(seed));
        expect_same(scenes, longest, seen);
        scenes.clear();
        ++warps;
      }
    }
  }
  EXPECT_GE(seen.touching, 2);
  EXPECT_GE(seen.with_shocks, 1);
}

TEST_P(PtxMarch, SmoothFacesHaveTheBitsOfAPack) {
  const std::vector<Scheme> kinds = {
      {{{SchemeKind::midpoint}}, "midpoint"},
      {{{SchemeKind::rk4}}, "rk4"},
      {{{SchemeKind::adaptive}}, "adaptive"},
      {{{SchemeKind::backward_euler, ForceTime::new_time}}, "new force"},
      {{{SchemeKind::backward_euler}, ContactLaw::multiplier}, "multipliers"}};
  Seen seen;
  for (const Scheme& kind : kinds) {
    SCOPED_TRACE(kind.name);
    const Variant variant{kind, 0, [](Scene& s) { s.faces = Faces::smooth; }};
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const Started c = random_scene(seed, variant);
      if (!fits(c)) continue;
      const int touching = seen.touching;
      expect_same({c}, longest / 5, seen);
      if (seen.touching > touching) break;
    }
  }
  EXPECT_GE(seen.touching, 1);
}

/// A scene of this form that touches in its first steps.
Started touching_scene(Form form, std::int64_t steps) {
  const SchemeKind kind = form == Form::adaptive ? SchemeKind::adaptive
                          : form == Form::staged ? SchemeKind::rk4
                                                 : SchemeKind::backward_euler;
  const ForceTime force = form == Form::implicit ? ForceTime::new_time : ForceTime::old_time;
  for (std::uint64_t seed = 1;; ++seed) {
    Started c = random_scene(seed, {{{{kind, force}}, ""}, 0, {}});
    const TeamShape shape = shape_of(form);
    if (c.model.resonator.modes.size() + c.model.slider.modes.size() >
        static_cast<std::size_t>(shape.modes()))
      continue;
    SceneOnLanes scene(c.model, c.start, shape);
    march_on_pack(scene, steps);
    if (scene.state().carried.sums.contact_steps > 0) return c;
  }
}

TEST_P(PtxMarch, LaunchesThatTheClockEndsHaveTheBitsOfOne) {
  const Started c = touching_scene(GetParam(), longest);
  const std::int64_t steps = GetParam() == Form::adaptive ? c.model.steps / 25 : longest;
  SceneOnLanes whole(c.model, c.start, shape()), parts(c.model, c.start, shape());
  PtxWarp one = warp_for(program(), {&whole}, PtxWarp::Order::in_step);
  march(one, {&whole}, steps);
  PtxWarp many = warp_for(program(), {&parts}, PtxWarp::Order::in_step);
  int launches = 0;
  for (; launches < 1000 && parts.state().carried.step < whole.state().carried.step; ++launches)
    march(many, {&parts}, steps, 100);
  // but for how many nodes were looked at, and what earlier launches left behind the open shocks
  const SceneState& of = whole.state();
  parts.state().carried.sums.evaluated = of.carried.sums.evaluated;
  for (int i = of.carried.shocks.open_count; i < 2 * of.work.runs.capacity; ++i)
    parts.state().out.now.open[i] = of.out.now.open[i];
  EXPECT_EQ(parts.differs_from(whole), "");
  EXPECT_GT(launches, 2);
  EXPECT_LT(launches, 1000);
}

// Not every sync that is run is needed in a scene: some stand for paths that it does not take. But
// a third at the least is, and none that is missing changes a bit unnoticed.
TEST_P(PtxMarch, MissingSyncsAreNoticed) {
  constexpr std::int64_t steps = 300;
  constexpr std::size_t chosen = 30;
  const Started c = touching_scene(GetParam(), steps);
  SceneOnLanes whole(c.model, c.start, shape());
  PtxWarp with_all = warp_for(program(), {&whole}, PtxWarp::Order::in_step);
  march(with_all, {&whole}, steps);
  std::vector<std::size_t> syncs = program().syncs();
  std::erase_if(syncs, [&](std::size_t sync) { return with_all.counts()[sync] == 0; });
  std::mt19937 random{7};
  std::shuffle(syncs.begin(), syncs.end(), random);
  syncs.resize(std::min(syncs.size(), chosen));
  std::size_t noticed = 0;
  for (const std::size_t sync : syncs) {
    SCOPED_TRACE(program().place(program().instructions()[sync]));
    SceneOnLanes scene(c.model, c.start, shape());
    PtxWarp warp = warp_for(program(), {&scene}, PtxWarp::Order::shuffled);
    warp.ignore(sync);
    bool raced = false;
    try {
      march(warp, {&scene}, steps);
    } catch (const WarpFault&) {  // what it read too early led it astray
      raced = true;
    }
    raced = raced || !warp.races().empty();
    EXPECT_TRUE(raced || scene.differs_from(whole).empty());
    noticed += raced;
  }
  EXPECT_GE(3 * noticed, syncs.size()) << noticed << " of " << syncs.size();
}

// Were the compiler free to fuse others, a GPU's bits would depend on its version.
TEST_P(PtxMarch, FusesNoMultiplyAddThatIsNotWritten) {
  std::map<std::string, std::vector<std::string>> texts;
  const auto source_of = [&](const Instruction& i) -> std::string {
    const std::string& file = program().source_file(i);
    std::vector<std::string>& lines = texts[file];
    if (lines.empty()) {
      std::ifstream in(file);
      for (std::string line; std::getline(in, line);) lines.push_back(line);
    }
    const auto line = static_cast<std::size_t>(i.source_line);
    return line >= 1 && line <= lines.size() ? lines[line - 1] : "";
  };
  int written = 0;
  for (const Instruction& i : program().instructions()) {
    if (i.opcode.rfind("fma", 0) != 0) continue;
    ++written;
    ASSERT_THAT(source_of(i), testing::HasSubstr("fma")) << program().place(i);
  }
  EXPECT_GT(written, 100);
}

INSTANTIATE_TEST_SUITE_P(Forms, PtxMarch, testing::ValuesIn(MarchPrograms::forms),
                         [](const auto& info) { return MarchPrograms::name(info.param); });

}  // namespace
}  // namespace ra2d::test
