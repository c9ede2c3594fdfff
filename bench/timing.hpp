// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdint>
#include <ctime>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "bench/scenes.hpp"
#include "host/base/version.hpp"
#include "host/chart/context.hpp"
#include "host/device/backend.hpp"

/// How a march is timed.
namespace ra2d::bench {

/// How much a case does: stretches of so many steps of each scene, each timed on its own.
struct Work {
  std::int64_t steps;
  int stretches;
};

/// Times stretch after stretch; `between` runs untimed after each of them. Returns the seconds.
template <class Advance, class Between>
double time_stretches(benchmark::State& state, double steps, const Advance& advance,
                      const Between& between) {
  double total = 0, processor = 0, stretches = 0;
  for (auto _ : state) {
    const std::clock_t processor_begin = std::clock();
    const auto begin = std::chrono::steady_clock::now();
    advance();
    const auto end = std::chrono::steady_clock::now();
    processor += static_cast<double>(std::clock() - processor_begin) / CLOCKS_PER_SEC;
    const double seconds = std::chrono::duration<double>(end - begin).count();
    state.SetIterationTime(seconds);
    total += seconds;
    ++stretches;
    between();
  }
  state.counters["ns_per_step"] = 1e9 * total / (steps * stretches);
  state.counters["cpu_ns_per_step"] = 1e9 * processor / (steps * stretches);
  return total;
}

/// Scenes marched side by side; the time per step is that of a scene-step.
inline void time_march(benchmark::State& state, const std::vector<Prepared>& scenes, Work work) {
  const int count = static_cast<int>(scenes.size());
  Batch batch = make_batch(scenes);
  std::int64_t target = 0;
  const double scene_steps = static_cast<double>(work.steps) * count;
  double stretches = 0;
  std::string fault;
  const double total = time_stretches(
      state, scene_steps, [&] { batch.march(target += work.steps); },
      [&] {
        ++stretches;
        for (int i = 0; i < count; ++i) {
          batch.drain(i);
          if (batch.snapshot(i).step != target) fault = "a launch ended before its time";
        }
      });
  if (!fault.empty()) state.SkipWithError(fault.c_str());
  double contact = 0, evaluated = 0;
  for (int i = 0; i < count; ++i) {
    const Snapshot now = batch.snapshot(i);
    contact += static_cast<double>(now.contact_steps);
    evaluated += static_cast<double>(now.evaluated);
  }
  state.counters["contact"] = contact / (scene_steps * stretches);
  state.counters["nodes_per_step"] = evaluated / (scene_steps * stretches);
  state.counters["scene_steps_per_second"] = scene_steps * stretches / total;
}

inline void add(const std::string& case_name, int stretches,
                std::function<void(benchmark::State&)> run) {
  benchmark::RegisterBenchmark(case_name.c_str(),
                               [run = std::move(run)](benchmark::State& state) {
                                 try {
                                   run(state);
                                 } catch (const std::exception& error) {
                                   state.SkipWithError(error.what());
                                 }
                               })
      ->UseManualTime()
      ->Iterations(stretches)  // the same steps in every repetition
      ->Unit(benchmark::kMillisecond);
}

/// Writes the origin of the results into their file.
inline void add_context() {
  benchmark::AddCustomContext("ra2d", version() + " (" + commit() + ")");
  benchmark::AddCustomContext("backend", backend_name());
  if (!backend_device().empty()) benchmark::AddCustomContext("device", backend_device());
  benchmark::AddCustomContext("threads", std::to_string(backend_threads()));
  benchmark::AddCustomContext("lanes", std::to_string(backend_lanes()));
  benchmark::AddCustomContext("compiler", compiler_name());
}

}  // namespace ra2d::bench
