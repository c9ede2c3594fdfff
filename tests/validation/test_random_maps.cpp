// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "tests/areal_reference.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/compare.hpp"
#include "tests/dice.hpp"
#include "tests/effort.hpp"
#include "tests/outcomes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// Areal scenes drawn at random.
namespace ra2d::test {
namespace {

/// A march of it by any method, between faces of either kind.
Started any_march(RandomMaps drawn, std::uint64_t seed, Nodes nodes) {
  Dice dice(seed + 1'000'000);
  ArealScene& s = drawn.scene;
  if (dice.one_in(3)) s.faces = Faces::smooth;
  const std::int64_t samples = 1 + dice.pick(100);
  if (dice.one_in(3)) {
    const double tolerances[] = {1e-3, 1e-6, 1e-6, 1e-8, 1e-10};
    return areal_march(s, tolerances[dice.pick(5)], drawn.duration, samples, nodes);
  }
  const auto all = schemes_under_laws();
  SchemeUnderLaw method = all[dice.pick(static_cast<int>(all.size()))];
  method.scheme.law = method.law;
  // what overlaps at the start would be thrown apart at once
  if (method.law == ContactLaw::multiplier) s.gap += 1e-5;
  const double step = dice.ratio(3e-3, 0.5) / drawn.fastest;
  const auto steps = static_cast<std::int64_t>(std::min(4000.0, drawn.duration / step));
  return areal_march(s, method.scheme, step, steps, std::min(samples, steps), nodes);
}

TEST(RandomMaps, CandidatesLaunchesAndRoomChangeNoBit) {
  Seen seen;
  const auto scenes = static_cast<std::uint64_t>(draws(40));
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomMaps drawn = random_maps(seed, 120);
    const Recording whole = simulate(any_march(drawn, seed, Nodes::all));
    const Started started = any_march(drawn, seed, Nodes::candidates);
    EXPECT_TRUE(same(whole, simulate(started)));
    EXPECT_TRUE(same(whole, simulate(started, {.steps = whole.model.steps / 17, .batch = {}})));
    Launches narrow;
    narrow.batch.capacity.nodes = 1;
    EXPECT_TRUE(same(whole, simulate(started, narrow)));
    seen.count(whole.end.contact_steps, whole.end.shocks_begun);
  }
  if (!draws_enough()) return;
  EXPECT_GE(seen.touching, seen.scenes / 2);
  EXPECT_GE(seen.with_shocks, seen.scenes / 3);
}

/// The tolerance is that of a step, and most are far below it. In so short a run all of them
/// together are held to twice that, times what the motion makes of a disturbance: which the
/// reference shows, from velocities that are hardly other ones.
TEST(RandomMaps, AdaptiveStepsComeToTheReference) {
  constexpr int samples = 4;
  constexpr double change = 1e-7, chaos = 1e-3;
  Seen seen;
  for (std::uint64_t seed = 1; seen.scenes < draws(40); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomMaps drawn = random_maps(seed, 30, true);
    const ArealScene& s = drawn.scene;
    if (s.plate_v.empty()) continue;
    ArealScene other = s;
    for (std::vector<double>* of : {&other.plate_v, &other.block_v})
      for (double& v : *of) v *= 1 + change;
    const ArealReference expected = reference_at_samples(s, drawn.duration, samples),
                         aside = reference_at_samples(other, drawn.duration, samples);
    for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
      const Recording r = simulate(areal_march(s, tolerance, drawn.duration, samples));
      ASSERT_EQ(r.end.status, Status::done);
      double most = 0;  // J
      for (int i = 0; i <= samples; ++i) {
        const ArealState& state = expected.states[i];
        most = std::max(most, state.energy());
        const double share = std::sqrt(state.energy() / most),
                     grown = share * state_distance(s, state, aside.states[i]) / change,
                     error = share * state_distance(s, state, state_at(r, i));
        if (tolerance * grown > chaos) break;
        EXPECT_LT(error, 2 * tolerance * std::max(1.0, grown)) << tolerance << ", sample " << i;
      }
      if (tolerance == 1e-6) seen.count(r.end.contact_steps, r.end.shocks_begun);
    }
  }
  if (!draws_enough()) return;
  EXPECT_GE(seen.touching, seen.scenes / 2);
}

}  // namespace
}  // namespace ra2d::test
