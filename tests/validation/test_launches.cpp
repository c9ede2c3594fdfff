// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "host/device/device.hpp"
#include "host/run/launch_length.hpp"
#include "host/run/simulation.hpp"
#include "host/system/interruption.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

/// The answer of a scene does not depend, to the last bit, on where a run is cut into launches, on
/// buffers, on padding, or on the other scenes of its batch.
namespace ra2d::test {
namespace {

/// Sliders of all supports, over all nodes and candidates.
std::vector<Scene> kinds() {
  std::vector<Scene> scenes;
  for (const Support support : {Support::free, Support::pinned, Support::rigid})
    for (const Nodes nodes : {Nodes::candidates, Nodes::all}) {
      scenes.push_back(rough_scene(support));
      scenes.back().time.nodes = nodes;
    }
  scenes[0].resonator.moving_forces = {{.force = 3, .speed = 40, .start = 0.01}};
  scenes[2].output.rate = 1e7 / 3.7;  // not a whole number of steps
  return scenes;
}

TEST(Launches, AnyLengthGivesTheSameBits) {
  std::vector<Scene> scenes = kinds();
  for (Scene& scene : scenes) {
    const auto compare = [&](std::initializer_list<std::int64_t> lengths) {
      const Recording whole = simulate(scene);
      ASSERT_EQ(whole.end.status, Status::done);
      EXPECT_GT(whole.end.contact_steps, 0);
      for (const std::int64_t steps : lengths)
        EXPECT_TRUE(same(whole, simulate(scene, {.steps = steps, .batch = {}})))
            << steps << " steps";
    };
    compare({97, 1000, 6000});
    scene.duration /= 5;
    compare({1, 7});
  }
}

TEST(Launches, EndSoonWhenTheyAreInterrupted) {
  if (march_device() != nullptr) GTEST_SKIP() << "a device ends its launch first";
  for (const SchemeKind scheme :
       {SchemeKind::backward_euler, SchemeKind::rk4, SchemeKind::adaptive})
    for (const Nodes nodes : {Nodes::candidates, Nodes::all}) {
      Scene scene = rough_scene(Support::free);
      scene.time.scheme = scheme;
      if (scheme == SchemeKind::adaptive && nodes == Nodes::all) continue;
      const Model model = make_model(scene);
      const ModalStart start = make_start(model);
      Batch cut({model}, {start}), whole({model}, {start});
      interrupt(2);
      cut.march(model.steps);
      interrupt(0);
      EXPECT_EQ(cut.snapshot(0).step, 0);
      EXPECT_EQ(cut.snapshot(0).status, Status::running);
      // and nothing has come of it
      cut.march(model.steps / 10);
      whole.march(model.steps / 10);
      EXPECT_TRUE(same("resonator displacement", cut.snapshot(0).resonator_u,
                       whole.snapshot(0).resonator_u));
      EXPECT_EQ(cut.snapshot(0).step, whole.snapshot(0).step);
    }
}

TEST(Launches, TheFirstIsShortWhereStepsAreCostly) {
  Scene scene = rough_scene(Support::free);
  scene.duration = 1;
  const std::int64_t usual = LaunchLength(make_model(scene)).steps();
  scene.resonator.moving_forces.resize(20'000);
  EXPECT_LE(LaunchLength(make_model(scene)).steps(), std::max<std::int64_t>(1, usual / 20'000));
}

/// Results of a batch of one scene.
void take(Outcome& out, Batch& batch) {
  const Drained drained = batch.drain(0);
  out.lanes = drained.lanes;
  out.rows.insert(out.rows.end(), drained.sample_rows.begin(), drained.sample_rows.end());
  out.shocks.insert(out.shocks.end(), drained.shocks.begin(), drained.shocks.end());
}

TEST(Launches, RandomLengthsGiveTheSameBits) {
  for (const Scene& scene : kinds()) {
    const Model model = make_model(scene);
    const ModalStart start = make_start(model);
    Outcome out[2];
    for (const int random : {0, 1}) {
      std::mt19937 dice(17);
      Batch batch({model}, {start});
      std::int64_t target = 0;
      do {
        target += random ? 1 + dice() % 300 : model.steps + 1;
        batch.march(target);
        // one in three buffers stays where it is until later
        if (random && dice() % 3 == 0) continue;
        take(out[random], batch);
      } while (batch.snapshot(0).status == Status::running);
      take(out[random], batch);
      out[random].end = batch.snapshot(0);
    }
    EXPECT_TRUE(same(out[0], out[1]));
  }
}

TEST(Launches, SmallBuffersGiveTheSameBits) {
  for (const Scene& scene : kinds()) {
    const Recording expected = simulate(scene);
    for (const int samples : {1, 2, 17})
      for (const int shocks : {1, 5}) {
        const BatchOptions options{.capacity = {.samples = samples, .shocks = shocks}};
        EXPECT_TRUE(same(expected, simulate(scene, {.steps = 1'000'000, .batch = options})))
            << samples << " samples, " << shocks << " shocks";
      }
  }
}

TEST(Launches, AFullBufferHoldsTheMarchUp) {
  // ... and loses nothing while nobody empties it
  Scene scene = rough_scene(Support::free);
  const Model model = make_model(scene);
  Batch batch({model}, {make_start(model)}, {.capacity = {.samples = 10}});
  for (int i = 0; i < 3; ++i) {
    batch.march(model.steps);
    EXPECT_EQ(batch.snapshot(0).step, 100);  // sample 10 is due here and finds no room
    EXPECT_EQ(batch.snapshot(0).status, Status::running);
  }
  EXPECT_EQ(batch.drain(0).samples, 10);
  batch.march(model.steps);
  EXPECT_EQ(batch.snapshot(0).step, 200);
}

TEST(Launches, PaddingGivesTheSameBits) {
  for (const Scene& scene : kinds()) {
    const Recording expected = simulate(scene);
    for (const int packs : {2, 3, 4, 6, 8})
      EXPECT_TRUE(same(expected, simulate(scene, {.batch = {.least_packs = packs}})))
          << packs << " packs";
  }
}

TEST(Launches, OtherScenesBesideItChangeNothing) {
  std::vector<Scene> scenes = kinds();
  scenes[1].duration /= 3;         // ends early
  scenes[3].resonator.modes = 20;  // pads the others
  scenes[4].slider.length = 0.02;
  scenes[5].spacing = 1e-5;
  scenes[5].duration = 1e-4;
  const std::vector<Recording> batch = simulate(scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    EXPECT_TRUE(same(simulate(scenes[i]), batch[i])) << "scene " << i;
  const std::vector<Recording> in_pieces = simulate(scenes, {.steps = 777, .batch = {}});
  for (std::size_t i = 0; i < scenes.size(); ++i)
    EXPECT_TRUE(same(batch[i], in_pieces[i])) << "scene " << i;
}

TEST(Launches, SamplesBetweenTwoStepsAreInterpolatedLinearly) {
  Scene scene = rough_scene(Support::free);
  scene.duration = 2e-4;
  scene.output.rate = 1e7;
  const Recording every = simulate(scene);
  const SampleBlock& e = every.samples;
  ASSERT_EQ(e.time.size(), 2001u);
  constexpr double ulp = std::numeric_limits<double>::epsilon();
  for (const double steps : {1.1, 3.7, 7.0, 12.5, 100.0 / 3}) {
    SCOPED_TRACE(std::to_string(steps) + " steps a sample");
    scene.output.rate = 1e7 / steps;
    const Recording some = simulate(scene);
    const SampleBlock& s = some.samples;
    ASSERT_EQ(s.time.size(), static_cast<std::size_t>(2000 / steps + 1e-9) + 1);
    const auto expect_between = [&](const std::vector<double>& fine,
                                    const std::vector<double>& coarse, double roundings,
                                    const std::string& what) {
      const std::size_t columns = fine.size() / e.time.size();
      ASSERT_EQ(coarse.size(), columns * s.time.size()) << what;
      for (std::size_t j = 0; j < s.time.size(); ++j) {
        const double place = static_cast<double>(j) * steps;
        const auto left = std::min(static_cast<std::size_t>(place + 1e-9), e.time.size() - 2);
        const double share = place - static_cast<double>(left);
        for (std::size_t k = 0; k < columns; ++k) {
          const double a = fine[left * columns + k], b = fine[(left + 1) * columns + k];
          // the share itself is rounded at up to 2000 steps
          EXPECT_NEAR(coarse[j * columns + k], (1 - share) * a + share * b,
                      roundings * ulp * (std::abs(a) + std::abs(b)) + 4000 * ulp * std::abs(b - a))
              << what << ", sample " << j;
        }
      }
    };
    expect_between(e.resonator_displacement, s.resonator_displacement, 4, "resonator displacement");
    expect_between(e.resonator_velocity, s.resonator_velocity, 4, "resonator velocity");
    expect_between(e.slider_displacement, s.slider_displacement, 4, "slider displacement");
    expect_between(e.slider_velocity, s.slider_velocity, 4, "slider velocity");
    expect_between(e.force, s.force, 4, "force");
    expect_between(e.contact, s.contact, 8, "contact energy");
    // sums over up to 2000 steps, closed at other places
    expect_between(e.damping_loss, s.damping_loss, 2000, "damping loss");
    for (std::size_t j = 0; j < s.time.size(); ++j)  // nodes are counted, not interpolated
      EXPECT_EQ(s.nodes[j],
                e.nodes[static_cast<std::size_t>(static_cast<double>(j) * steps + 1e-9)]);
    EXPECT_EQ(some.end.resonator_u, every.end.resonator_u);
  }
}

TEST(Launches, ScenesWithoutMemoryBesideTheOthersWait) {
  const std::vector<Scene> scenes = kinds();
  const std::vector<Recording> alone = simulate(scenes);
  std::size_t largest = 0;
  for (const Recording& r : alone) largest = std::max(largest, Batch({r.model}, {r.start}).bytes());
  for (const double share : {1.0, 2.5}) {
    Launches few;
    few.batch.memory = static_cast<std::size_t>(share * static_cast<double>(largest));
    const std::vector<Recording> waited = simulate(scenes, few);
    for (std::size_t i = 0; i < scenes.size(); ++i)
      EXPECT_TRUE(same(alone[i], waited[i])) << "scene " << i;
  }
  Launches none;
  none.batch.memory = largest - 1;  // not even alone
  EXPECT_THROW(simulate(scenes, none), std::bad_alloc);
}

TEST(Launches, ASceneThatDoesNotFitAloneStopsNoOther) {
  const std::vector<Scene> scenes = kinds();
  std::vector<std::size_t> bytes;
  std::vector<std::unique_ptr<SceneRun>> runs;
  for (const Scene& scene : scenes) {
    const Model model = make_model(scene);
    const ModalStart start = make_start(model);
    bytes.push_back(Batch({model}, {start}).bytes());
    runs.push_back(std::make_unique<SceneRun>(model, start));
  }
  SimulationOptions options;
  options.slots = 3;
  options.batch.memory = *std::max_element(bytes.begin(), bytes.end()) - 1;
  std::atomic<std::size_t> done = 0;
  std::size_t refused = 0;
  Simulation simulation(options);
  simulation.run([&](std::size_t i) { return i < runs.size() ? runs[i].get() : nullptr; },
                 [&](SceneRun& run) {
                   EXPECT_TRUE(run.over());
                   ++done;
                 },
                 [&] {
                   std::size_t held = 0;
                   for (const auto& run : runs) held += simulation.holds(*run);
                   EXPECT_LE(held, 3u);
                 },
                 [&](SceneRun& run) {
                   EXPECT_FALSE(simulation.holds(run));
                   ++refused;
                 });
  const auto large = std::count_if(bytes.begin(), bytes.end(),
                                   [&](std::size_t b) { return b > options.batch.memory; });
  EXPECT_EQ(refused, static_cast<std::size_t>(large));
  EXPECT_EQ(done + refused, scenes.size());
  EXPECT_GE(done.load(), 1u);
}

/// A scene that cannot be made for now is asked for again when another is over.
TEST(Launches, ScenesThatCannotBeMadeYetAreMadeLater) {
  const std::vector<Scene> scenes = kinds();
  const std::vector<Recording> alone = simulate(scenes);
  std::vector<std::unique_ptr<SceneRun>> runs;
  for (const Recording& r : alone) runs.push_back(std::make_unique<SceneRun>(r.model, r.start));
  SimulationOptions options;
  options.slots = 3;
  options.ticks = 1000;
  std::mutex mutex;
  std::size_t next = 0, on_their_way = 0, most = 0;
  Simulation simulation(options);
  simulation.run(
      [&](std::size_t) -> SceneRun* {
        const std::lock_guard lock(mutex);
        if (next >= runs.size()) return nullptr;
        if (on_their_way >= 2) throw std::bad_alloc();  // memory for two
        most = std::max(most, ++on_their_way);
        return runs[next++].get();
      },
      [&](SceneRun&) {
        const std::lock_guard lock(mutex);
        --on_their_way;
      });
  EXPECT_EQ(next, runs.size());
  EXPECT_EQ(most, 2u);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_TRUE(runs[i]->over());
    EXPECT_EQ(runs[i]->accounts().now.resonator_u, alone[i].end.resonator_u) << "scene " << i;
  }
  // a thread sees no more scenes, and then the one that another had in hand cannot be made yet
  SceneRun first(alone[0].model, alone[0].start), last(alone[1].model, alone[1].start);
  options.slots = 2;
  std::atomic<int> call = 0;
  Simulation handed_back(options);
  handed_back.run([&](std::size_t) -> SceneRun* {
    switch (call++) {
      case 0:
        return &first;
      case 2:
        throw std::bad_alloc();
      case 3:
        return &last;
      default:
        return nullptr;
    }
  });
  EXPECT_TRUE(last.over());
  // where no scene is on its way nothing frees memory any more
  Simulation none(options);
  EXPECT_THROW(none.run([](std::size_t) -> SceneRun* { throw std::bad_alloc(); }), std::bad_alloc);
}

// Their memory is there again once they are gone.
TEST(Launches, MemoryOfABatchIsGivenBack) {
  const Model model = make_model(rough_scene(Support::free));
  const ModalStart start = make_start(model);
  const std::size_t one = Batch({model}, {start}).bytes();
  Batch batch(2, {.capacity = {}, .least_packs = 0, .memory = one + one / 2});
  for (int time = 0; time < 3; ++time) {
    batch.put(0, model, start);
    EXPECT_EQ(batch.bytes(), one);
    EXPECT_THROW(batch.put(1, model, start), std::bad_alloc);
    EXPECT_EQ(batch.bytes(), one);
    batch.put(0, model, start);  // in its own place
    batch.empty(0);
  }
}

}  // namespace
}  // namespace ra2d::test
