// SPDX-License-Identifier: BSD-3-Clause
// Cost of a simulated second with the adaptive scheme, with the error beside it:
//
//   OMP_NUM_THREADS=1 bench_adaptive --benchmark_repetitions=5
//   --benchmark_enable_random_interleaving=true
//
// Cases, one scene on one thread: second/SCENE/METHOD, both readings of the paper, the adaptive
// scheme at a ladder of tolerances and the paper's backward Euler and midpoint at its step of 1e-8
// s beside it. Counters: wall seconds per simulated second, steps per simulated second, and the
// relative error of the state just before the 5th shock (energy norm, against a tolerance of
// 1e-12). `ra2d chart accuracy` draws the whole picture, other integrators included.
//
// Predicted: some 50 000 events (a node that touches or lets go) a second under the free slider, a
// step each and as many between them, at twenty terms of ten packed operations a node, 0.5 us: 0.05
// to 0.1 s. Came out, to 1e-6: 106 000 steps of 1.8 us. In a profile no part takes more than a
// seventh: the series of the modes first, then looks at the gap, the nodes' expansions, searches
// for crossings and hulls with about a twentieth each.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "bench/places.hpp"
#include "bench/program.hpp"
#include "bench/report.hpp"
#include "bench/timing.hpp"
#include "host/chart/methods.hpp"
#include "host/run/timed_run.hpp"
#include "host/scene/names.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d::bench {
namespace {

TimedRun run(const Scene& scene, const RunLimits& limits = {}) {
  const Model model = make_model(scene);
  return timed_run(model, make_start(model), limits);
}

/// Of the state just before the 5th shock.
double error_of(const Scene& scene, const Method& setting) {
  const Method finest = sized({{SchemeKind::adaptive}}, 1e-12);
  // in whole microseconds, so that a fixed step ends there
  const double end =
      1e-6 * std::floor(1e6 * run(with(scene, finest), {.shocks = 5}).shocks.at(4).start);
  const Scene at_end = ending_at(scene, finest, end);
  return state_error(make_model(at_end), run(ending_at(scene, setting, end)).state,
                     run(at_end).state);
}

void add_case(const std::string& name, const Scene& scene, const Method& setting, double stretch) {
  add(name, 1, [=](benchmark::State& state) {
    double seconds = 0, simulated = 0, steps = 0;
    for (auto _ : state) {
      const TimedRun one = run(with(scene, setting), {.time = stretch});
      state.SetIterationTime(one.seconds);
      seconds += one.seconds;
      simulated += one.time;
      steps += static_cast<double>(one.end.steps_made);
    }
    state.counters["wall_per_second"] = seconds / simulated;
    state.counters["steps_per_second"] = steps / simulated;
    state.counters["state_error"] = error_of(scene, setting);
  });
}

void add_cases() {
  for (const std::string name : {"dang2012-pinned", "dang2012"})
    for (const bool small : {false, true}) {
      const Scene scene = read_scene(scene_file(name));
      const auto full_name = [&](const std::string& method) {
        return "second/" + name + "/" + method + (small ? "/small" : "");
      };
      for (const double tolerance : {1e-3, 1e-6, 1e-8, 1e-10})
        add_case(full_name(fmt::format("adaptive:{:g}", tolerance)), scene,
                 sized({{SchemeKind::adaptive}}, tolerance), small ? 1e-3 : 1.0);
      for (const SchemeKind scheme : {SchemeKind::backward_euler, SchemeKind::midpoint})
        add_case(full_name(schemes.name(scheme)), scene, sized({{scheme}}, 1e-8),
                 small ? 1e-4 : 0.1);
    }
}

const Added added({"adaptive", add_cases});

}  // namespace
}  // namespace ra2d::bench
