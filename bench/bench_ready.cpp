// SPDX-License-Identifier: BSD-3-Clause
// Cost of a scene before it is marched:
//
//   OMP_NUM_THREADS=1 bench_ready --benchmark_repetitions=5
//   --benchmark_enable_random_interleaving=true
//
// Cases: both readings of the paper, adaptive, each time with other surfaces beside a scene that
// has the same bodies, as the next run of a study finds it. Counters, in ms of one core: `model`
// (beams and surfaces), `start` (where it starts: of the free slider the static equilibrium),
// `tables` (what the march reads) and `second`, the march of one simulated second at a tolerance of
// 1e-6. `gpu` says how many times faster than this one core a GPU may march beside 16 such cores
// before they fall behind with making scenes ready: 16 second / (model + start + tables).
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <string>

#include "bench/program.hpp"
#include "bench/scenes.hpp"
#include "bench/timing.hpp"
#include "host/run/timed_run.hpp"

namespace ra2d::bench {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

void time_ready(benchmark::State& state, Paper paper, int scenes, double duration) {
  const Method method{{SchemeKind::adaptive}};
  const auto variant = [&](int number) {
    Scene scene = scene_of(paper, number, method);
    scene.duration = duration;
    return scene;
  };
  double model_time = 0, start_time = 0, tables_time = 0, march_time = 0;
  int done = 0;
  for (auto _ : state) {
    Batch batch(2);
    const Model other = make_model(variant(0));
    batch.put(0, other, make_start(other));
    double seconds = 0;
    for (int i = 1; i <= scenes; ++i, ++done) {
      const Scene scene = variant(i);
      const Clock::time_point begin = Clock::now();
      const Model model = make_model(scene);
      const Clock::time_point modelled = Clock::now();
      const ModalStart start = make_start(model);
      const Clock::time_point started = Clock::now();
      batch.put(1, model, start);
      const Clock::time_point filled = Clock::now();
      model_time += milliseconds(begin, modelled);
      start_time += milliseconds(modelled, started);
      tables_time += milliseconds(started, filled);
      seconds += 1e-3 * milliseconds(begin, filled);
      // of a few, at a second's cost
      if (i <= 3) march_time += 1e3 * timed_run(model, start, {}).seconds / (3 * duration);
    }
    state.SetIterationTime(seconds);
  }
  const double count = done, all = (model_time + start_time + tables_time) / count;
  state.counters["model"] = model_time / count;
  state.counters["start"] = start_time / count;
  state.counters["tables"] = tables_time / count;
  const double second = march_time / (count / scenes);
  state.counters["second"] = second;
  state.counters["gpu"] = 16 * second / all;
}

void add_cases() {
  for (const bool small : {false, true})
    for (const Paper paper : {Paper::free_slider, Paper::pinned_slider})
      add(fmt::format("ready/{}{}", paper == Paper::free_slider ? "free" : "pinned",
                      small ? "/small" : ""),
          1, [=](benchmark::State& state) {
            time_ready(state, paper, small ? 3 : 40, small ? 1e-3 : 1.0);
          });
}

const Added added({"ready", add_cases});

}  // namespace
}  // namespace ra2d::bench
