// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "bench/places.hpp"
#include "bench/program.hpp"
#include "bench/timing.hpp"
#include "host/device/backend.hpp"
#include "host/run/simulation.hpp"
#include "host/scene_file/scene_file.hpp"

/// Many scenes of very unequal cost side by side: how far the threads are from sharing the work
/// evenly.
///
/// 64 scenes, the paper's with the slider free and pinned in turn, adaptive, at speeds from 0.02 to
/// 0.5 m/s. `work` is what the threads spent on scenes, one after the other [s]; `balance` is wall
/// time times threads over that: 1 for perfect sharing.
namespace ra2d::bench {
namespace {

using Clock = std::chrono::steady_clock;

std::vector<Scene> unequal_scenes(int count, double duration) {
  const Scene papers[] = {read_scene(scene_file("dang2012")),
                          read_scene(scene_file("dang2012-pinned"))};
  std::vector<Scene> scenes;
  for (int i = 0; i < count; ++i) {
    Scene scene = papers[i % 2];
    scene.time.scheme = SchemeKind::adaptive;
    scene.time.tolerance = 1e-6;
    scene.duration = duration;
    // in no order of cost
    const double place = std::fmod(0.618 * i, 1.0);
    scene.speed = 0.02 * std::pow(25.0, place);
    scenes.push_back(scene);
  }
  return scenes;
}

void time_batch(benchmark::State& state, int slots, double duration) {
  const std::vector<Scene> scenes = unequal_scenes(64, duration);
  double wall = 0, work = 0;
  for (auto _ : state) {
    const Clock::time_point begin = Clock::now();
    std::vector<std::unique_ptr<SceneRun>> runs(scenes.size());
    Simulation simulation({.slots = slots});
    simulation.run([&](std::size_t i) -> SceneRun* {
      if (i >= scenes.size()) return nullptr;
      Model model = make_model(scenes[i]);
      ModalStart start = make_start(model);
      runs[i] = std::make_unique<SceneRun>(std::move(model), std::move(start));
      return runs[i].get();
    });
    const double took = std::chrono::duration<double>(Clock::now() - begin).count();
    state.SetIterationTime(took);
    wall += took;
    work += simulation.busy_seconds();
    for (const auto& run : runs)
      if (run->status() != Status::done) state.SkipWithError("a scene ended before its time");
  }
  state.counters["work"] = work;
  state.counters["balance"] = wall * scenes_at_once() / work;
}

void add_cases() {
  for (const bool small : {false, true})
    for (const int slots : {4, 16, 64})
      add(fmt::format("unequal/{}{}", slots, small ? "/small" : ""), 1,
          [=](benchmark::State& state) { time_batch(state, slots, small ? 1e-3 : 0.2); });
}

const Added added({"batch", add_cases});

}  // namespace
}  // namespace ra2d::bench
