// SPDX-License-Identifier: BSD-3-Clause
// Cost of a simulated second of areal scenes: a free block of 10 x 10 mm, and the paper's of
// 20 x 20 mm, pressed by their weight on a plate of steel of 300 x 200 x 2 mm (174 modes below 20
// kHz), maps of Rq 8 um and RSm 1.55 mm, at 0.1 m/s, 1e16 Pa/m:
//
//   OMP_NUM_THREADS=1 bench_areal --benchmark_repetitions=3
//
// Cases: second/SIDE mm/SPACING um/METHOD. Counters: wall seconds per simulated second, steps,
// shocks and evaluated nodes per simulated second, seconds until it is ready, and the largest
// number of nodes in contact at once. side_by_side/SIDE mm/SPACING um: as many copies of a scene as
// there are threads, beside one.
//
// docs/performance.md shows what came out (areal_cost.csv and .png, which areal_cost.py makes).
// Asked, and what came out in different hours of one machine:
//   adaptive, 10 mm at 50 um               0.4 s a second   0.37 to 0.50
//   adaptive, 20 mm at 8 um                5 s              4.3 to 6.0, 4.5 in a quiet hour
//   fixed steps good to 1e-3 (gautschi)    2 s there        1.2 to 1.3
//   efficiency of two scenes on two cores  0.95             0.93 to 1.02
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "bench/program.hpp"
#include "bench/report.hpp"
#include "bench/timing.hpp"
#include "host/chart/methods.hpp"
#include "host/device/backend.hpp"
#include "host/model/model.hpp"
#include "host/run/timed_run.hpp"
#include "host/surface/random_map.hpp"

namespace ra2d::bench {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

BodySpec steel(Support support, double length, double width, double thickness) {
  BodySpec body;
  body.support = support;
  body.length = length, body.width = width, body.thickness = thickness;
  body.young = 210e9, body.density = 7800, body.poisson = 0.3, body.damping = 0.02;
  return body;
}

Model block_on_plate(double side, double spacing, double duration, const Method& method) {
  Scene s;
  s.resonator = steel(Support::pinned, 0.3, 0.2, 2e-3);
  s.resonator.max_frequency = 20e3;
  s.slider = steel(Support::free, side, side, 20e-3);
  s.slider.load_is_weight = true;
  s.spacing = spacing;
  s.speed = 0.1;
  s.start = 0.05;
  s.duration = duration;
  s.initial = Initial::statics;
  s.contact.stiffness = 1e16;
  s.output.rate = 48e3;
  s = with(s, method);
  HeightMaps maps;
  maps.rows = static_cast<int>(std::lround(side / spacing));
  maps.spacing_y = spacing;
  maps.side = 0.5 * (s.resonator.width - side);
  RandomMap face{.rq = 8e-6, .rsm = 1.55e-3, .rsm_y = 1.55e-3, .exact = true, .seed = 1};
  const auto whole = [&](double length) { return (std::round(length / spacing) + 0.25) * spacing; };
  maps.slider = random_map(face, whole(side), side, spacing, spacing).heights;
  face.seed = 2;
  const double swept = whole(s.start + s.speed * duration + side + 4 * spacing);
  maps.resonator = random_map(face, swept, side, spacing, spacing).heights;
  s.gap = 45e-6;
  return make_model(s, maps);
}

void add_case(double side, double spacing, const Method& method, const std::string& name,
              double duration) {
  add(fmt::format("second/{:g}mm/{:g}um/{}", 1e3 * side, 1e6 * spacing, name), 1,
      [=](benchmark::State& state) {
        double seconds = 0, simulated = 0, ready = 0, nodes = 0, steps = 0, shocks = 0, seen = 0;
        for (auto _ : state) {
          const auto begin = Clock::now();
          const Model model = block_on_plate(side, spacing, duration, method);
          const ModalStart start = make_start(model);
          ready = since(begin);
          const TimedRun one = timed_run(model, start);
          state.SetIterationTime(one.seconds);
          seconds += one.seconds;
          simulated += one.time;
          nodes = static_cast<double>(one.end.most_nodes);
          steps += static_cast<double>(one.end.steps_made);
          shocks += static_cast<double>(one.end.shocks_begun);
          seen += static_cast<double>(one.end.evaluated);
        }
        state.counters["wall_per_second"] = seconds / simulated;
        state.counters["steps_per_second"] = steps / simulated;
        state.counters["shocks_per_second"] = shocks / simulated;
        state.counters["evaluated_per_second"] = seen / simulated;
        state.counters["most_nodes"] = nodes;
        state.counters["ready"] = ready;
      });
}

/// As many copies of one scene side by side as there are threads, beside one of them alone: the
/// time of one over that of all of them is 1 where threads do not slow one another down.
void add_side_by_side(double side, double spacing, double duration, const std::string& small = "") {
  add(fmt::format("side_by_side/{:g}mm/{:g}um{}", 1e3 * side, 1e6 * spacing, small), 1,
      [=](benchmark::State& state) {
        const Model model =
            block_on_plate(side, spacing, duration, sized({{SchemeKind::adaptive}}, 1e-6));
        const ModalStart start = make_start(model);
        const auto count = static_cast<std::size_t>(scenes_at_once());
        const std::vector<Model> models(count, model);
        const std::vector<ModalStart> starts(count, start);
        double one = 0, all = 0;
        for (auto _ : state) {
          one += timed_run(model, start).seconds;
          const double seconds = timed_runs(models, starts).front().seconds;
          state.SetIterationTime(seconds);
          all += seconds;
        }
        state.counters["scenes"] = static_cast<double>(count);
        state.counters["efficiency"] = one / all;
      });
}

void add_cases() {
  const auto adaptive = [](double tolerance) { return sized({{SchemeKind::adaptive}}, tolerance); };
  const auto midpoint = [](double step) { return sized({{SchemeKind::midpoint}}, step); };
  add_case(4e-3, 1e-4, adaptive(1e-6), "adaptive:1e-06/small", 2e-3);
  add_case(4e-3, 1e-4, midpoint(1e-7), "midpoint:1e-07/small", 1e-3);
  for (const double spacing : {64e-6, 50e-6, 32e-6, 16e-6})
    add_case(10e-3, spacing, adaptive(1e-6), "adaptive:1e-06", 1);
  add_case(10e-3, 50e-6, midpoint(1e-7), "midpoint:1e-07", 0.1);
  for (const double spacing : {32e-6, 8e-6})
    add_case(20e-3, spacing, midpoint(1e-6), "midpoint:1e-06", 0.02);
  // at 8 um 7e-4 off before the 5th shock: ra2d chart accuracy has it, with --set time.step=4e-6
  for (const double spacing : {50e-6, 32e-6, 16e-6, 8e-6})
    add_case(20e-3, spacing, sized({{SchemeKind::gautschi}}, 4e-6), "gautschi:4e-06", 0.1);
  for (const double spacing : {64e-6, 32e-6, 16e-6, 8e-6})
    add_case(20e-3, spacing, adaptive(1e-6), "adaptive:1e-06", 1);
  for (const double side : {5e-3, 40e-3, 80e-3})
    add_case(side, 32e-6, adaptive(1e-6), "adaptive:1e-06", 1);
  add_side_by_side(4e-3, 1e-4, 2e-3, "/small");
  add_side_by_side(10e-3, 50e-6, 1);
  add_side_by_side(20e-3, 8e-6, 0.1);
}

const Added added({"areal", add_cases});

}  // namespace
}  // namespace ra2d::bench
