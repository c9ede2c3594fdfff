// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "host/model/smooth_contact.hpp"
#include "host/run/timed_run.hpp"
#include "host/surface/spline.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/compare.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"
#include "tests/smooth_reference.hpp"

/// Areal scenes whose faces are splines along their rows.
namespace ra2d::test {
namespace {

/// Nodes so close that a mode is a cubic along a cell to 1e-11.
ArealScene smooth_maps(Support block, int rows, double spacing_y) {
  constexpr int nodes = 24;
  ArealScene s = small_areal_scene(block, 10);
  s.faces = Faces::smooth;
  s.spacing = 5e-5, s.spacing_y = spacing_y;
  s.block.length = (nodes - 1) * s.spacing, s.block.width = rows * spacing_y;
  s.plate_heights = rough_map(rows, 301, 2e-6, 11);
  s.block_heights = rough_map(rows, nodes, 2e-6, 12);
  return s;
}
ArealScene rigid_on_smooth() {
  ArealScene s = smooth_maps(Support::rigid, 10, 2e-4);
  s.gap = 4e-6;
  s.speed = 8;
  return s;
}
ArealScene free_on_smooth() {
  ArealScene s = smooth_maps(Support::free, 5, 2e-4);
  s.gap = 6.2e-6;
  s.block.load = 0.3;
  return s;
}
/// Contacts reach over several rows.
ArealScene fine_rows() {
  ArealScene s = smooth_maps(Support::free, 8, 1.5e-5);
  s.gap = 7e-6;
  s.block.load = 0.3;
  return s;
}
ArealScene many_on_smooth() {
  ArealScene s = many_nodes();
  s.faces = Faces::smooth;
  return s;
}

struct Case {
  std::string name;
  ArealScene (*scene)();
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

constexpr double duration = 4e-5;

class SmoothMaps : public testing::TestWithParam<Case> {
 protected:
  /// At the end; shocks by impulse, since two may begin at t = 0.
  static const Reference& reference() {
    static std::map<std::string, Reference> found;
    Reference& of = found[GetParam().name];
    if (of.states.empty()) {
      const Started started = areal_march(GetParam().scene(), 1e-6, duration);
      of = smooth_reference(started.model, started.start, {duration});
      std::sort(of.shocks.begin(), of.shocks.end(), by_impulse);
    }
    return of;
  }
  static constexpr auto by_impulse = [](const auto& a, const auto& b) {
    return a.impulse > b.impulse;
  };
};
INSTANTIATE_TEST_SUITE_P(Scenes, SmoothMaps,
                         testing::Values(Case{"RigidBlock", rigid_on_smooth},
                                         Case{"FreeBlock", free_on_smooth},
                                         Case{"FineRows", fine_rows}),
                         [](const auto& tested) { return tested.param.name; });

Scheme scheme_of(SchemeKind kind, ContactLaw law = ContactLaw::penalty) {
  return {{{kind}, law}, "of the test"};
}
State end_of(const Reference& r) {
  const ReferenceState& s = r.states.back();
  return {s.resonator_u, s.resonator_v, s.slider_u, s.slider_v};
}

// ---- against the reference

/// Other steps give the same, and it loses no energy. Its errors count against the energy of the
/// contact springs, of which a light block has little.
TEST(SmoothMapsReference, HasConverged) {
  const Started started = areal_march(free_on_smooth(), 1e-6, duration);
  const Reference a = smooth_reference(started.model, started.start, {duration}),
                  b = smooth_reference(started.model, started.start, {duration},
                                       {.tolerance = 3e-17, .longest = 0.6});
  EXPECT_LT(state_error(started.model, end_of(b), end_of(a)), 1e-13);
  const ReferenceState& e = a.states.back();
  const double energy = e.kinetic + e.elastic + e.contact;
  EXPECT_NEAR(energy + e.damping_loss - e.sliding_work - e.load_work, started.start.energy,
              1e-10 * std::max({started.start.energy, energy, e.load_work}));
}

TEST_P(SmoothMaps, AdaptiveKeepsItsTolerance) {
  const Reference& r = reference();
  ASSERT_GE(r.shocks.size(), 1);
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    const Started started = areal_march(GetParam().scene(), tolerance, duration);
    const TimedRun run = timed_run(started.model, started.start);
    ASSERT_EQ(run.status, Status::done) << tolerance;
    // a shock amplifies what came before it by up to some ten times
    const double bound = 100 * tolerance + 1e-9;
    EXPECT_LT(state_error(started.model, run.state, end_of(r)), bound) << tolerance;
    std::vector<Shock> shocks = run.shocks;
    ASSERT_EQ(shocks.size(), r.shocks.size()) << tolerance;
    std::sort(shocks.begin(), shocks.end(), by_impulse);
    for (std::size_t i = 0; i < r.shocks.size(); ++i) {
      EXPECT_NEAR(shocks[i].start, r.shocks[i].start, bound * duration) << tolerance;
      EXPECT_NEAR(shocks[i].impulse, r.shocks[i].impulse, 10 * bound * r.shocks[i].impulse)
          << tolerance;
    }
  }
}

TEST_P(SmoothMaps, FixedStepsComeToTheReferenceWithTheirOrder) {
  const Reference& r = reference();
  for (const auto& [kind, order] :
       {std::pair{SchemeKind::backward_euler, 1.0}, std::pair{SchemeKind::midpoint, 2.0},
        std::pair{SchemeKind::rk4, 2.5}}) {
    std::vector<double> errors;
    for (const double step : {4e-8, 2e-8, 1e-8, 5e-9}) {
      const Started started =
          areal_march(GetParam().scene(), scheme_of(kind), step, std::lround(duration / step));
      const TimedRun run = timed_run(started.model, started.start);
      ASSERT_EQ(run.status, Status::done);
      errors.push_back(state_error(started.model, run.state, end_of(r)));
    }
    // where in a step a contact begins or ends is chance
    const double chance = order > 2 ? 16 : 2;
    EXPECT_LT(errors.back(), chance * errors.front() / std::pow(8, order) + 1e-11)
        << testing::PrintToString(errors);
  }
}

TEST_P(SmoothMaps, EnergyClosesToTheTolerance) {
  for (const double tolerance : {1e-6, 1e-9}) {
    const Recording r = simulate(areal_march(GetParam().scene(), tolerance, 5 * duration, 10));
    ASSERT_EQ(r.end.status, Status::done);
    EXPECT_GT(r.end.contact_steps, 0);
    EXPECT_LT(r.energy.closure(), 100 * tolerance);
  }
}

// ---- the same bits

TEST_P(SmoothMaps, CandidatesLaunchesPaddingAndRoomChangeNoBit) {
  for (const double tolerance : {1e-4, 1e-8}) {
    const ArealScene s = GetParam().scene();
    const Recording all = simulate(areal_march(s, tolerance, duration, 10, Nodes::all));
    const Started started = areal_march(s, tolerance, duration, 10);
    EXPECT_GT(all.end.contact_steps, 0);
    const Recording some = simulate(started);
    EXPECT_TRUE(same(all, some));
    EXPECT_LT(some.end.evaluated, all.end.evaluated);
    EXPECT_TRUE(same(all, simulate(started, {.steps = started.model.steps / 7, .batch = {}})));
    Launches narrow;
    narrow.batch.capacity.nodes = 1;
    EXPECT_TRUE(same(all, simulate(started, narrow)));
    EXPECT_TRUE(goes_on_when_saved(started, started.model.steps / 2));
  }
  for (const Scheme& scheme : schemes_and_implicit()) {
    const ArealScene s = GetParam().scene();
    const Recording all = simulate(areal_march(s, scheme, 1e-8, 3000, 10));
    const Started started = areal_march(s, scheme, 1e-8, 3000, 10, Nodes::candidates);
    EXPECT_GT(all.end.contact_steps, 0) << scheme.name;
    EXPECT_TRUE(same(all, simulate(started))) << scheme.name;
    EXPECT_TRUE(same(all, simulate(started, {.steps = 997, .batch = {}}))) << scheme.name;
    Launches narrow, padded;
    narrow.batch.capacity.nodes = 1;
    padded.batch.least_packs = 32 / 4;
    EXPECT_TRUE(same(all, simulate(started, narrow))) << scheme.name;
    EXPECT_TRUE(same(all, simulate(started, padded))) << scheme.name;
  }
}

TEST(SmoothMapsInTiles, CandidatesChangeNoBit) {
  const ArealScene s = many_on_smooth();
  for (const double tolerance : {1e-5, 1e-8}) {
    const Recording all = simulate(areal_march(s, tolerance, 2e-4, 10, Nodes::all)),
                    some = simulate(areal_march(s, tolerance, 2e-4, 10));
    EXPECT_GT(all.end.shocks_begun, 5);
    EXPECT_TRUE(same(all, some));
    // longer windows at 1e-5 make fewer steps: all nodes are evaluated less often, others not
    EXPECT_LT((tolerance < 1e-6 ? 3 : 2) * some.end.evaluated, all.end.evaluated);
  }
  for (const int i : {2, 8}) {
    const Scheme scheme = schemes_and_implicit()[i];
    const Recording all = simulate(areal_march(s, scheme, 2e-8, 4'000, 10)),
                    some = simulate(areal_march(s, scheme, 2e-8, 4'000, 10, Nodes::candidates));
    EXPECT_GT(all.end.contact_steps, 0) << scheme.name;
    EXPECT_TRUE(same(all, some)) << scheme.name;
  }
}

/// Rows that all begin to touch within a step: the cells evaluated and those flagged are the same.
TEST(SmoothMapsRoom, IsEnoughForAllCells) {
  ArealScene s = smooth_maps(Support::free, 6, 2e-4);
  s.plate.support = Support::rigid;
  for (HeightMap* map : {&s.plate_heights, &s.block_heights})
    for (std::vector<double>& row : *map) std::fill(row.begin(), row.end(), 0.0);
  for (const std::size_t outer : {0, 5})
    std::fill(s.block_heights[outer].begin(), s.block_heights[outer].end(), 1e-9);
  s.gap = 2e-9;
  s.block.load = 5;
  Launches narrow;
  narrow.batch.capacity.nodes = 1;
  const Started started = areal_march(s, 1e-6, duration, 10);
  const Recording r = simulate(started);
  ASSERT_EQ(r.end.status, Status::done);
  EXPECT_GT(r.end.most_nodes, 100);
  EXPECT_TRUE(same(r, simulate(started, narrow)));
}

// ---- exact limits

TEST_P(SmoothMaps, MirrorImagesGiveMirrorImages) {
  const ArealScene s = GetParam().scene();
  const Recording a = simulate(areal_march(s, 1e-10, duration)),
                  b = simulate(areal_march(mirrored(s), 1e-10, duration));
  EXPECT_GT(a.end.contact_steps, 0);
  EXPECT_LT(state_distance(s, state_at(a, 1), mirrored(s, state_at(b, 1))), 1e-9);
  EXPECT_EQ(a.shocks.size() + a.end.open_shocks.size(), b.shocks.size() + b.end.open_shocks.size());
}

std::pair<Started, Started> plane_and_rows(Support support, int rows, SchemeKind kind) {
  Scene s = rough_scene(support);
  s.faces = Faces::smooth;
  s.time.scheme = kind;
  s.time.tolerance = 1e-10;
  s.duration = 2e-4;
  s.time.step = 1e-8;
  s.output.rate = 1 / s.duration;
  Started plane{make_model(s), {}};
  plane.start = make_start(plane.model);
  return {plane, with_rows(plane, rows)};
}

TEST(SmoothMapsLimits, MapsThatAreConstantInYGiveThePlaneScene) {
  for (const SchemeKind kind : {SchemeKind::midpoint, SchemeKind::adaptive})
    for (const Support support : {Support::rigid, Support::pinned, Support::free})
      for (const int rows : {1, 2, 7}) {
        const auto [plane, areal] = plane_and_rows(support, rows, kind);
        const Recording a = simulate(plane), b = simulate(areal);
        ASSERT_EQ(b.end.status, Status::done);
        EXPECT_GE(a.shocks.size(), 3);
        double most = 0;
        for (const double v : a.samples.resonator_velocity) most = std::max(most, std::abs(v));
        ASSERT_EQ(a.samples.resonator_velocity.size(), b.samples.resonator_velocity.size());
        // sums of other roundings, which shocks amplify; adaptive: other steps, too
        const double error = kind == SchemeKind::adaptive ? 1e-8 : 1e-9;
        for (std::size_t i = 0; i < a.samples.resonator_velocity.size(); ++i)
          EXPECT_NEAR(a.samples.resonator_velocity[i], b.samples.resonator_velocity[i],
                      error * most);
        ASSERT_EQ(a.shocks.size(), b.shocks.size());
        for (std::size_t i = 0; i < a.shocks.size(); ++i) {
          EXPECT_NEAR(a.shocks[i].peak, b.shocks[i].peak, 1e-6 * a.shocks[i].peak);
          EXPECT_NEAR(a.shocks[i].impulse, b.shocks[i].impulse, 1e-6 * a.shocks[i].impulse);
          EXPECT_NEAR(a.shocks[i].moment, b.shocks[i].moment, 1e-6 * a.shocks[i].moment);
        }
      }
}

TEST_P(SmoothMaps, MultipliersKeepTheFacesApart) {
  const Scheme scheme = scheme_of(SchemeKind::backward_euler, ContactLaw::multiplier);
  ArealScene s = GetParam().scene();  // touching at t = 0
  s.gap += rest_overlap(areal_march(s, scheme, 1e-8, 1).model);
  const Recording all = simulate(areal_march(s, scheme, 1e-8, 6000, 30));
  ASSERT_EQ(all.end.status, Status::done);
  EXPECT_GT(all.end.contact_steps, 0);
  EXPECT_TRUE(same(all, simulate(areal_march(s, scheme, 1e-8, 6000, 30, Nodes::candidates))));
  Model there = all.model;
  for (std::size_t i = 0; i < all.samples.time.size(); ++i) {
    there.position = all.model.position +
                     static_cast<double>(i) * all.model.steps_per_sample * all.model.advance;
    const ArealState state = state_at(all, i);
    std::vector<double> u = state.plate_u;
    u.insert(u.end(), state.block_u.begin(), state.block_u.end());
    // what overlaps by roundings of heights of 1e-5 m, over all cells
    const double over = 1e-5 * 512 * std::numeric_limits<double>::epsilon();
    EXPECT_LE(smooth_contact(there, u).energy,
              0.5 * there.node_stiffness * over * over * there.nodes());
  }
}

TEST(SmoothMapsAtRest, ABlockAtRestStaysAtRest) {
  for (const ContactLaw law : {ContactLaw::penalty, ContactLaw::multiplier}) {
    ArealScene s = free_on_smooth();
    s.speed = 0;
    Started started = areal_march(s, scheme_of(SchemeKind::backward_euler, law), 1e-8, 5000, 5);
    started.model.scene.initial = Initial::statics;
    started.start = make_start(started.model);
    EXPECT_NEAR(started.start.contact_force, s.block.load, 1e-9 * s.block.load);
    EXPECT_GE(started.start.loaded_nodes.size(), 3);  // heave, pitch and roll
    const Recording r = simulate(started);
    ASSERT_EQ(r.end.status, Status::done);
    for (const double f : r.samples.force) EXPECT_NEAR(f, s.block.load, 1e-6 * s.block.load);
    double most = 0;
    for (const double u : started.start.resonator_u) most = std::max(most, std::abs(u));
    for (std::size_t k = 0; k < started.start.resonator_u.size(); ++k)
      EXPECT_NEAR(r.end.resonator_u[k], started.start.resonator_u[k], 1e-6 * most);
  }
}

/// A row's spline is its own: as of a plane scene with that row alone.
TEST(SmoothMapsModel, RowsHaveTheirOwnSplines) {
  const Started started = areal_march(rigid_on_smooth(), 1e-6, duration);
  const Model& m = started.model;
  const int row = 3;
  const std::vector<double>& heights = m.slider_height;
  const std::vector<double> own(heights.begin() + row * m.row_nodes(),
                                heights.begin() + (row + 1) * m.row_nodes());
  const std::vector<double> curvature = spline_curvatures(own);
  for (int i = 0; i < m.row_nodes(); ++i)
    EXPECT_EQ(m.slider_curvature[static_cast<std::size_t>(row) * m.row_nodes() + i], curvature[i]);
}

}  // namespace
}  // namespace ra2d::test
