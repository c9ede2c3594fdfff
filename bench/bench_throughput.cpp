// SPDX-License-Identifier: BSD-3-Clause
// Scenes by the thousand, on a GPU or on the cores of a CPU:
//
//   bench_throughput --benchmark_out=FILE.json             in a bundle: ra2d_bench throughput ...
//   bench/throughput.py GPU.json ONE_CORE.json ALL_CORES.json
//
// Cases: METHOD/PAPER/SCENES, both readings of the paper with other surfaces in every scene, from t
// = 0 on: the adaptive scheme at 1e-6 over a second, and the paper's backward Euler at 10 ns over
// 10 ms, with samples at 10 kHz; the former with samples at 100 kHz, which are 56 MB for each
// second that is simulated; and on a GPU the latter with a warp for each scene, where otherwise
// four share one (docs/gpu.md). They are run as a study runs them: on a GPU two crews take turns,
// on a CPU each thread has its scenes. Counters: `simulated`, seconds simulated in a second of wall
// time from the first launch to the last one; `shocks` begun in such a second; `whole`, seconds
// simulated in a second of all that it takes, making scenes ready included; `at_once`, scenes that
// one launch marched.
//
// Predicted for an H200 before there was one: it marches 1056 scenes at a moment. A step is a chain
// of some 1000 dependent operations of the adaptive scheme and of some 40 of a fixed step in
// flight, four times as long each as on a core; so 1056/4 times one core, where memory and
// divergence let it. What was measured, and why it is less: docs/gpu.md.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "bench/program.hpp"
#include "bench/scenes.hpp"
#include "bench/timing.hpp"
#include "host/device/backend.hpp"
#include "host/run/simulation.hpp"

namespace ra2d::bench {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// Runs that wait for a crew, made ready beforehand: the march alone is what is timed.
class Runs {
 public:
  Runs(Paper paper, const Method& method, double duration, double rate, int count)
      : runs_(static_cast<std::size_t>(count)) {
    side_by_side(count, [&](int i) {
      Scene scene = scene_of(paper, i, method);
      scene.duration = duration;
      scene.output.rate = rate;
      Model model = make_model(scene);
      ModalStart start = make_start(model);
      runs_[static_cast<std::size_t>(i)] =
          std::make_unique<SceneRun>(std::move(model), std::move(start));
    });
  }
  SceneRun* next() {
    const std::size_t i = next_++;
    return i < runs_.size() ? runs_[i].get() : nullptr;
  }
  double simulated() const {
    double sum = 0;
    for (const auto& run : runs_) sum += run->time();
    return sum;
  }
  double shocks() const {
    double sum = 0;
    for (const auto& run : runs_) sum += static_cast<double>(run->accounts().now.shocks_begun);
    return sum;
  }
  bool all_done() const {
    return std::all_of(runs_.begin(), runs_.end(),
                       [](const auto& run) { return run->status() == Status::done; });
  }

 private:
  std::vector<std::unique_ptr<SceneRun>> runs_;
  std::atomic<std::size_t> next_ = 0;
};

void time_throughput(benchmark::State& state, Paper paper, const Method& method, double duration,
                     double rate, bool whole_warps, int scenes) {
  const bool on_gpu = !backend_device().empty();
  for (auto _ : state) {
    const Clock::time_point begin = Clock::now();
    Runs runs(paper, method, duration, rate, scenes);
    const Clock::time_point ready = Clock::now();
    const int crews = std::min(scenes, on_gpu ? 2 : backend_threads());
    std::atomic<std::size_t> at_once = 0;
    std::mutex one_at_a_time;
    double longest = 0;  // s, of all launches of a crew
    const auto march = [&](int) {
      SimulationOptions options{.slots = on_gpu ? (scenes + crews - 1) / crews : 1};
      options.batch.memory = backend_memory() / static_cast<std::size_t>(crews);
      if (on_gpu) options.batch.capacity = capacity_on_a_gpu;
      if (whole_warps) options.batch.least_packs = 1;
      Simulation simulation(options);
      simulation.run([&](std::size_t) { return runs.next(); });
      at_once += simulation.most_at_once();
      const std::lock_guard lock(one_at_a_time);
      longest = std::max(longest, simulation.seconds());
    };
    if (on_gpu) {
      std::future<void> other;
      if (crews > 1) other = std::async(std::launch::async, march, 1);
      march(0);
      if (crews > 1) other.get();
    } else {
      side_by_side(crews, march);
    }
    const Clock::time_point end = Clock::now();
    state.SetIterationTime(seconds_between(ready, end));
    if (!runs.all_done()) state.SkipWithError("a scene ended before its time");
    state.counters["simulated"] = runs.simulated() / longest;
    state.counters["shocks"] = runs.shocks() / longest;
    state.counters["whole"] = runs.simulated() / seconds_between(begin, end);
    state.counters["at_once"] = static_cast<double>(at_once);
  }
}

void add_cases() {
  const Method adaptive = sized({{SchemeKind::adaptive}}, 1e-6);
  const Method fixed{{SchemeKind::backward_euler}};
  struct Setting {
    const char* name;
    Method method;
    double duration, rate;  // s, Hz
    bool whole_warps = false;
  };
  std::vector<Setting> settings = {{"adaptive", adaptive, 1.0, 1e4},
                                   {"backward-euler", fixed, 0.01, 1e4},
                                   {"adaptive-100kHz", adaptive, 1.0, 1e5}};
  if (!backend_device().empty())
    settings.push_back({"backward-euler-whole-warps", fixed, 0.01, 1e4, true});
  // a GPU is full with some thousands; on a CPU more than a few for each thread tell nothing new
  const int most = backend_device().empty() ? 4 * backend_threads() : 16384;
  for (const Setting& setting : settings)
    for (const Paper paper : {Paper::free_slider, Paper::pinned_slider}) {
      const std::string name =
          fmt::format("{}/{}", setting.name, paper == Paper::free_slider ? "free" : "pinned");
      for (int scenes = 1; scenes <= most; scenes *= 4)
        add(fmt::format("{}/{}", name, scenes), 1, [=](benchmark::State& state) {
          time_throughput(state, paper, setting.method, setting.duration, setting.rate,
                          setting.whole_warps, scenes);
        });
      add(name + "/small", 1, [=](benchmark::State& state) {
        time_throughput(state, paper, setting.method, 1e-4, setting.rate, setting.whole_warps, 2);
      });
    }
}

const Added added({"throughput", add_cases});

}  // namespace
}  // namespace ra2d::bench
