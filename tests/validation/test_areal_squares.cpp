// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "host/device/layout.hpp"
#include "tests/areal_reference.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/compare.hpp"
#include "tests/effort.hpp"
#include "tests/outcomes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// Areal scenes of many modes in fixed steps: lists of nodes that are kept
/// (kernels/candidates.hpp), most of them of nodes so fine that squares of them share their sums
/// over the modes (kernels/contact/clustered_contact.hpp).
namespace ra2d::test {
namespace {

constexpr double duration = 1.5e-4;
constexpr int samples = 5;
constexpr int modes = 70;  // of the plate: so many that lists are kept (kernels/candidates.hpp)
constexpr int lanes_of_a_pack = 8;

ArealScene scene() { return fine_maps(modes); }
Started march(const Scheme& scheme, double step, Nodes nodes = Nodes::candidates,
              std::int64_t kept = samples) {
  return areal_march(scene(), scheme, step, std::lround(duration / step), kept, nodes);
}
const ArealReference& reference() {
  static const ArealReference found = reference_at_samples(scene(), duration, samples);
  return found;
}
double largest_error(const Recording& r) { return largest_distance(scene(), reference(), r); }

TEST(ArealSquares, AreThereWhereNodesAreFineAndForcesExplicit) {
  const auto degree = [](const Scheme& scheme, int lanes) {
    return cluster_degree(march(scheme, 1e-8).model, lanes);
  };
  for (const SchemeKind kind : {SchemeKind::midpoint, SchemeKind::rk4, SchemeKind::explicit_euler})
    EXPECT_GT(degree(scheme_of(kind), lanes_of_a_pack), 0);
  EXPECT_EQ(degree(schemes_and_implicit().back(), lanes_of_a_pack), 0);
  EXPECT_EQ(degree(scheme_of(SchemeKind::midpoint), 32), 0) << "a group is wider than a square";
  const Model coarse = areal_march(free_block(), scheme_of(SchemeKind::midpoint), 1e-8, 10).model;
  EXPECT_EQ(cluster_degree(coarse, lanes_of_a_pack), 0);
}

TEST(ArealSquares, MoveAsTheReference) {
  EXPECT_GT(reference().states[samples].contacts, 12);
  // contacts begin and end within steps, which leaves errors of second order
  double errors[2];
  for (const int i : {0, 1}) {
    const Recording r = simulate(march(scheme_of(SchemeKind::rk4), i == 0 ? 1e-8 : 6.25e-10));
    ASSERT_EQ(r.end.status, Status::done);
    errors[i] = largest_error(r);
  }
  EXPECT_LT(errors[1], 1e-6);
  EXPECT_GT(std::log2(errors[0] / errors[1]) / 4, 1.0) << errors[0] << " to " << errors[1];
}

/// The middle of the last squares lies beyond the last row, which alone touches.
TEST(ArealSquares, ReachTheLastRow) {
  constexpr double brief = 4e-6;
  for (const int rows : {17, 18, 19, 20, 33}) {
    SCOPED_TRACE(rows);
    const ArealScene s = fine_maps(modes, rows, 5e-7);
    const ArealReference expected = reference_at_samples(s, brief, 1);
    ASSERT_GT(expected.states[1].contacts, 0);
    const Recording r =
        simulate(areal_march(s, scheme_of(SchemeKind::rk4), 1e-9, std::lround(brief / 1e-9), 1));
    EXPECT_LT(largest_distance(s, expected, r), 1e-6);
  }
}

TEST(ArealSquares, EnergyCloses) {
  const Recording r = simulate(march(scheme_of(SchemeKind::rk4), 5e-9));
  const ArealState& end = reference().states[samples];
  const double supplied = 4 * (end.energy() + end.damping_loss);
  // sums over the steps: off by a step's share of what a spacing, 1.5e-5 s, puts in and takes out
  EXPECT_NEAR(r.samples.sliding_work[samples], end.sliding_work, 1e-3 * supplied);
  EXPECT_NEAR(r.samples.damping_loss[samples], end.damping_loss, 1e-3 * supplied);
  EXPECT_NEAR(r.samples.contact[samples], end.contact, 1e-5 * supplied);
  EXPECT_EQ(r.samples.nodes[samples], end.contacts);
}

/// March of all nodes, of candidates, in many launches, and with memory that grows with the
/// contact.
void expect_same_bits(const Started& all, const Started& started) {
  const Recording whole = simulate(all);
  EXPECT_EQ(whole.end.status, Status::done);
  const Recording candidates = simulate(started);
  EXPECT_TRUE(same(whole, candidates));
  // all nodes count once a step, however many stages it has
  const SchemeKind kind = all.model.scene.time.scheme;
  const int stages = kind == SchemeKind::rk8 ? scheme_table(kind).stages : 1;
  EXPECT_LT(candidates.end.evaluated, stages * whole.end.evaluated);
  EXPECT_TRUE(same(whole, simulate(started, {.steps = whole.model.steps / 37, .batch = {}})));
  Launches narrow;
  narrow.batch.capacity.nodes = 1;
  EXPECT_TRUE(same(whole, simulate(started, narrow)));
}
constexpr int often = 400;  // samples, between two steps, too: most while a list is kept

TEST(ArealSquares, CandidatesAndLaunchesChangeNoBit) {
  for (const auto& [kind, step] :
       {std::pair{SchemeKind::midpoint, 1e-8}, std::pair{SchemeKind::explicit_euler, 1e-8},
        std::pair{SchemeKind::gautschi, 2e-7}, std::pair{SchemeKind::heun, 1e-7},
        std::pair{SchemeKind::rk4, 1e-7}, std::pair{SchemeKind::rk8, 2e-7}}) {
    SCOPED_TRACE(scheme_of(kind).name);
    expect_same_bits(march(scheme_of(kind), step, Nodes::all, often),
                     march(scheme_of(kind), step, Nodes::candidates, often));
  }
}

/// Nodes that stand further apart have no squares. Long steps keep lists there, too.
TEST(ArealLists, KeptInLongStepsChangeNoBit) {
  const ArealScene s = many_nodes(modes);
  for (const auto& [kind, step] :
       {std::pair{SchemeKind::midpoint, 2e-7}, std::pair{SchemeKind::gautschi, 1e-6},
        std::pair{SchemeKind::heun, 2e-7}, std::pair{SchemeKind::rk8, 1e-6}}) {
    SCOPED_TRACE(scheme_of(kind).name);
    const int steps = draws(static_cast<int>(std::lround(1e-3 / step))),
              kept = std::min(often, steps);
    const Started started = areal_march(s, scheme_of(kind), step, steps, kept, Nodes::candidates);
    const Extents n = extents_of(started.model, choose_series(started.model, lanes_of_a_pack), 128,
                                 lanes_of_a_pack, {});
    EXPECT_TRUE(n.keeps_lists);
    EXPECT_EQ(n.cluster_degree, 0);
    expect_same_bits(areal_march(s, scheme_of(kind), step, steps, kept), started);
  }
}

TEST(ArealSquares, SavedStatesGoOnToTheSameBits) {
  const Started started = march(scheme_of(SchemeKind::midpoint), 1e-8);
  EXPECT_TRUE(goes_on_when_saved(started, started.model.steps / 3));
}

}  // namespace
}  // namespace ra2d::test
