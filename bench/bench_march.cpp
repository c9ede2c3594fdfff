// SPDX-License-Identifier: BSD-3-Clause
// Cost of a step on the paper's scenes, against two baselines (bench/baselines.hpp):
//
//   bench_march --benchmark_repetitions=10 --benchmark_enable_random_interleaving=true
//
// (add --benchmark_filter=-/small/ to leave out the smallest cases, which are there for CTest, and
// --benchmark_out=FILE --benchmark_out_format=json to keep the numbers). A table of medians and
// ratios stands at the end. On a machine that others use, too, set OMP_NUM_THREADS=1 for all but
// the batches and read the processor's time: a second thread that waits its turn for the processor
// holds up the end of every launch.
//
// Before anything is timed, the baselines are checked against the march over a stretch with
// contact; a state that differs by more than its bound, or another number of steps in contact, ends
// the program with status 1.
//
// Cases:
//
//   free/...     scenes/dang2012.toml: contact at 6 steps of 10
//   pinned/...   scenes/dang2012-pinned.toml: contact at 11 steps of 100
//   */plain, */tables            the baselines, on one thread
//   */all, */candidates          the march, one scene on one thread
//   free/batch/N                 N scenes with different surfaces on all threads; ns per scene-step
//   step/flight, step/contact    the march where nothing, and where always the same two nodes touch
//   chain/flight, chain/contact  the dependency chain of such a step alone (bench/chain.hpp)
//
// Every case but step/ and chain/ starts where the march stands after 20 ms (the small batch: at
// 0), and makes the same steps at every repetition.
//
// On one core of a Zen 5 server, 8 lanes, GCC 12, in ns per step: free/plain 393000, tables
// 4310, all 1590, candidates 17.6; pinned/plain 394000, tables 3660, all 1300, candidates 7.6. A
// step of flight takes 2.91 where its chain of three operations takes 2.82: three packs hide in one
// another's wait. A step with two nodes in contact takes 25 where the chain of one node takes 14,
// for 18 operations, the sum over lanes six of them. Beyond the chain it has the second node, the
// shapes at the present place, the sliding work and the shock's record.
//
// Debian's benchmark library calls itself a debug build. That does not matter here: stretches of
// many steps are timed, and the library does nothing within them.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/baselines.hpp"
#include "bench/chain.hpp"
#include "bench/program.hpp"
#include "bench/report.hpp"
#include "bench/scenes.hpp"
#include "bench/timing.hpp"

namespace ra2d::bench {
namespace {

const char* name(Paper paper) { return paper == Paper::free_slider ? "free" : "pinned"; }

template <class Baseline>
void time_baseline(benchmark::State& state, Paper paper, Work work) {
  const Prepared scene = settled(paper, 1)[0];
  Baseline baseline(scene.model, scene.start);
  time_stretches(
      state, static_cast<double>(work.steps), [&] { baseline.march(work.steps); }, [] {});
  state.counters["contact"] =
      static_cast<double>(baseline.contact_steps) / static_cast<double>(baseline.step);
}

void time_chain(benchmark::State& state, double (*chain)(std::int64_t), int operations,
                std::int64_t steps) {
  time_stretches(
      state, static_cast<double>(steps), [&] { benchmark::DoNotOptimize(chain(steps)); }, [] {});
  state.counters["chain_operations"] = operations;
}

void add_cases() {
  // full size and small
  for (const bool small : {false, true}) {
    const std::string size = small ? "/small" : "";
    const auto sized = [small](Work work, Work least) { return small ? least : work; };
    for (const Paper paper : {Paper::free_slider, Paper::pinned_slider}) {
      const std::string scene = name(paper);
      const auto baseline = [&](const char* which, auto run, Work work) {
        add(scene + "/" + which + size, work.stretches,
            [=](auto& state) { run(state, paper, work); });
      };
      baseline("plain", time_baseline<Plain>, sized({100, 4}, {20, 1}));
      baseline("tables", time_baseline<Tables>, sized({4000, 4}, {500, 1}));
      const auto march = [&](const char* which, Nodes nodes, Work work) {
        add(scene + "/" + which + size, work.stretches, [=](auto& state) {
          time_march(state, {evaluating(settled(paper, 1)[0], nodes)}, work);
        });
      };
      march("all", Nodes::all, sized({2000, 20}, {500, 1}));
      march("candidates", Nodes::candidates, sized({1'000'000, 4}, {20'000, 1}));
    }
    if (small) {
      add("free/batch/2/small", 1, [](auto& state) {
        time_march(state, {at_start(Paper::free_slider, 0), at_start(Paper::free_slider, 1)},
                   {20'000, 1});
      });
    } else {
      for (const int scenes : {2, 8, 64})
        add(fmt::format("free/batch/{}", scenes), 1, [=](auto& state) {
          const Work work{8'000'000 / scenes, 1};
          time_march(state, settled(Paper::free_slider, scenes), work);
        });
    }
    const Work bare = sized({1'000'000, 4}, {10'000, 1});
    add("step/flight" + size, bare.stretches,
        [=](auto& state) { time_march(state, {in_flight()}, bare); });
    add("step/contact" + size, bare.stretches,
        [=](auto& state) { time_march(state, {in_contact()}, bare); });
    add("chain/flight" + size, bare.stretches, [=](auto& state) {
      time_chain(state, flight_chain, flight_chain_operations(), bare.steps);
    });
    add("chain/contact" + size, bare.stretches, [=](auto& state) {
      time_chain(state, contact_chain, contact_chain_operations(), bare.steps);
    });
  }
}

// ---- the check
// -------------------------------------------------------------------------------------

/// Largest difference of the modal states, displacements and velocities each over the largest of
/// their kind.
double difference(const Snapshot& march, const BaselineModes& resonator,
                  const BaselineModes& slider) {
  const auto kind = [](const std::vector<double>& a1, const std::vector<double>& b1,
                       const std::vector<double>& a2, const std::vector<double>& b2) {
    double apart = 0, largest = 0;
    const auto compare = [&](const std::vector<double>& a, const std::vector<double>& b) {
      for (std::size_t k = 0; k < a.size(); ++k) {
        apart = std::max(apart, std::abs(a[k] - b[k]));
        largest = std::max(largest, std::abs(a[k]));
      }
    };
    compare(a1, b1);
    compare(a2, b2);
    return apart / largest;
  };
  return std::max(kind(march.resonator_u, resonator.u, march.slider_u, slider.u),
                  kind(march.resonator_v, resonator.v, march.slider_v, slider.v));
}

/// Both baselines against the march over a stretch with contact.
bool baselines_agree() {
  constexpr std::int64_t stretch = 300;
  bool agree = true;
  for (const Paper paper : {Paper::free_slider, Paper::pinned_slider}) {
    const Prepared scene = before_contact(settled(paper, 1)[0], stretch);
    Batch batch = make_batch({scene});
    march_on(batch, 1, 2 * stretch);
    const Snapshot march = batch.snapshot(0);
    const auto check = [&](const char* which, auto baseline, double bound) {
      baseline.march(2 * stretch);
      const double apart = difference(march, baseline.resonator, baseline.slider);
      const bool good = apart <= bound && baseline.contact_steps == march.contact_steps;
      fmt::print(stderr,
                 "{}/{}: {} steps, {} of them with contact ({} in the march), relative difference "
                 "{:.1e}, at the most {:.1e}{}\n",
                 name(paper), which, 2 * stretch, baseline.contact_steps, march.contact_steps,
                 apart, bound, good ? "" : ": WRONG");
      agree = agree && good;
    };
    // roundings of both, and what the contact makes of them
    check("plain", Plain(scene.model, scene.start), 1e-10);
    // psi interpolated linearly: (beta chi)^2 / 8 of the highest mode, and a factor of ten for what
    // the stiff contact makes of it over the stretch
    const double turn = highest_wave_number(scene.model.resonator) * scene.model.scene.spacing;
    check("tables", Tables(scene.model, scene.start), 10 * turn * turn / 8);
  }
  return agree;
}

const Added added({"march", add_cases, baselines_agree,
                   [](const RatioReporter& reporter) { return reporter.table(); }});

}  // namespace
}  // namespace ra2d::bench
