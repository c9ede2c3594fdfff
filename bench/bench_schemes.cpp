// SPDX-License-Identifier: BSD-3-Clause
// Costs of every scheme and both contact laws, beside backward Euler in the same run:
//
//   OMP_NUM_THREADS=1 bench_schemes --benchmark_repetitions=5
//   --benchmark_enable_random_interleaving=true
//
// A table of medians stands at the end: nanoseconds per step, per force evaluation (a step's
// stages), and both over backward Euler's. Cases, one scene on one thread, for each method:
//
//   flight/...    nothing can touch: a step is one product a mode, whatever the scheme
//   contact/...   a free slider that does not slide, held at the same two nodes at every step
//   paper/...     scenes/dang2012.toml after 20 ms of the method's own
//
// Predicted before measuring: flight the same for all within the two more operations a mode that
// the forms without U1 = U0 + tau V1 take; contact in proportion to the stages, a stage without the
// record cheaper than the first, and dearer by what it sums of the stages before; the implicit
// variant and multipliers two to three times the explicit force.
//
// Results on one core of a Zen 4 server with GCC 12: flight 4.4 for backward Euler and
// midpoint, 4.6 for all others; contact 44 a force, RK8 52, which sums up to ten stages before; on
// the paper's scene 22 to 26 a force, RK8 30; the implicit variant 2.8 to 3.0 and multipliers 2.45
// to 2.6 times backward Euler's step there. In contact runs differ: backward Euler 39 to 44, exact
// 47 and at times 66. The first version of the staged step took 60 in contact where it now takes
// 47: it kept room for eleven stages where there is one.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "bench/program.hpp"
#include "bench/report.hpp"
#include "bench/timing.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d::bench {
namespace {

struct Named {
  std::string name;
  Method method;
};

std::vector<Named> methods() {
  std::vector<Named> all;
  for (const auto& [name, scheme] : schemes.words)
    if (scheme != SchemeKind::adaptive)  // which has no step to be timed
      all.push_back({name, {{scheme}}});
  all.push_back({"backward-euler+new", {{SchemeKind::backward_euler, ForceTime::new_time}}});
  for (const auto& [name, scheme] : schemes.words)
    if (takes_multipliers(scheme))
      all.push_back({name + "+multiplier", {{scheme}, ContactLaw::multiplier}});
  return all;
}

void add_cases() {
  for (const bool small : {false, true}) {
    const std::string size = small ? "/small" : "";
    for (const Named& named : methods()) {
      const Method method = named.method;
      const Work bare = small ? Work{5000, 1} : Work{500'000, 4};
      // no more shocks to a stretch than there is room for
      const Work rough = small ? Work{5000, 1} : Work{250'000, 8};
      add("flight/" + named.name + size, bare.stretches,
          [=](auto& state) { time_march(state, {in_flight(method)}, bare); });
      add("contact/" + named.name + size, bare.stretches,
          [=](auto& state) { time_march(state, {in_contact(method)}, bare); });
      add("paper/" + named.name + size, rough.stretches, [=](auto& state) {
        time_march(state,
                   {small ? at_start(Paper::free_slider, 0, method)
                          : settled(Paper::free_slider, 1, method)[0]},
                   rough);
      });
    }
  }
}

/// Medians per step and per force evaluation, and those of backward Euler under them.
std::string table(const RatioReporter& reporter) {
  std::string out = fmt::format("\n{:<38}{:>10}{:>12}{:>14}{:>18}\n", "ns", "a step", "a force",
                                "step / BE's", "force / BE's");
  for (const std::string scene : {"flight", "contact", "paper"})
    for (const std::string size : {"", "/small"}) {
      const double euler = reporter.median_of(scene + "/backward-euler" + size);
      for (const Named& named : methods()) {
        const double step = reporter.median_of(scene + "/" + named.name + size);
        if (!(step > 0)) continue;
        const bool held = named.method.law == ContactLaw::multiplier;
        const double force = step / (held ? 1 : scheme_table(named.method.time.scheme).stages);
        out +=
            fmt::format("{:<38}{:>10.2f}{:>12.2f}{:>14.2f}{:>18.2f}\n",
                        scene + "/" + named.name + size, step, force, step / euler, force / euler);
      }
    }
  return out;
}

const Added added({"schemes", add_cases, nullptr, table});

}  // namespace
}  // namespace ra2d::bench
