// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/device/layout.hpp"
#include "tests/areal_reference.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/compare.hpp"
#include "tests/outcomes.hpp"
#include "tests/simulate.hpp"

/// Areal scenes whose nodes in contact stand in clusters that share their sums over the modes
/// (kernels/adaptive/contact_clusters.hpp).
namespace ra2d::test {
namespace {

constexpr double duration = 1.5e-4;
constexpr int samples = 5;
// of the lanes for which degrees differ with the tolerance: those of any CPU
constexpr int lanes_of_a_pack = 8;

Started fine_march(double tolerance, Nodes nodes = Nodes::candidates) {
  return areal_march(fine_maps(), tolerance, duration, samples, nodes);
}
const ArealReference& reference() {
  static const ArealReference found = reference_at_samples(fine_maps(), duration, samples);
  return found;
}
double largest_error(const Recording& r) { return largest_distance(fine_maps(), reference(), r); }

TEST(ArealClusters, ComeWithTheTolerance) {
  const auto degree = [](double tolerance) {
    return cluster_degree(fine_march(tolerance).model, lanes_of_a_pack);
  };
  EXPECT_EQ(degree(1e-6), 2);
  EXPECT_EQ(degree(1e-8), 3);
  EXPECT_EQ(degree(1e-12), 0);
  const Model coarse = areal_march(free_block(), 1e-6, duration).model;
  EXPECT_EQ(cluster_degree(coarse, lanes_of_a_pack), 0);
  // too few modes for a pack to be saved
  EXPECT_EQ(cluster_degree(fine_march(1e-6).model, 32), 0);
}

TEST(ArealClusters, MoveAsTheReference) {
  EXPECT_GT(reference().states[samples].contacts, 12);
  EXPECT_GT(reference().closings, 100);
  for (const double tolerance : {1e-6, 1e-8}) {
    const Recording r = simulate(fine_march(tolerance));
    ASSERT_EQ(r.end.status, Status::done);
    EXPECT_LT(largest_error(r), tolerance);
  }
  // with each node by itself
  EXPECT_LT(largest_error(simulate(fine_march(1e-12))), 1e-10);
}

TEST(ArealClusters, EnergyCloses) {
  for (const double tolerance : {1e-6, 1e-8}) {
    const Recording r = simulate(fine_march(tolerance));
    const ArealState& end = reference().states[samples];
    // energies are squares: twice the tolerance of what is there and what was lost, and twice
    // again, since in between there was more
    const double supplied = 4 * (end.energy() + end.damping_loss);
    EXPECT_NEAR(r.samples.sliding_work[samples], end.sliding_work, tolerance * supplied);
    EXPECT_NEAR(r.samples.damping_loss[samples], end.damping_loss, tolerance * supplied);
    EXPECT_NEAR(r.samples.contact[samples], end.contact, tolerance * supplied);
    EXPECT_EQ(r.samples.nodes[samples], end.contacts);
  }
}

TEST(ArealClusters, CandidatesAndLaunchesChangeNoBit) {
  for (const double tolerance : {1e-6, 1e-8}) {
    const Started started = fine_march(tolerance);
    const Recording whole = simulate(fine_march(tolerance, Nodes::all));
    EXPECT_EQ(whole.end.status, Status::done);
    const Recording candidates = simulate(started);
    EXPECT_TRUE(same(whole, candidates));
    EXPECT_LT(candidates.end.evaluated, whole.end.evaluated);
    EXPECT_TRUE(same(whole, simulate(started, {.steps = whole.model.steps / 37, .batch = {}})));
    Launches narrow;  // memory grows with the contact
    narrow.batch.capacity.nodes = 1;
    EXPECT_TRUE(same(whole, simulate(started, narrow)));
  }
}

TEST(ArealClusters, SavedStatesGoOnToTheSameBits) {
  const Started started = fine_march(1e-6);
  EXPECT_TRUE(goes_on_when_saved(started, started.model.steps / 3));
}

}  // namespace
}  // namespace ra2d::test
