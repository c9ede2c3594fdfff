// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/body/plate.hpp"
#include "tests/areal_reference.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/compare.hpp"
#include "tests/effort.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// The march over the rows of areal scenes, in fixed steps.
namespace ra2d::test {
namespace {

// ---- against the reference: nothing opens or closes

struct Smooth {
  Scheme scheme;
  double step;  // s, the coarsest: errors are above roundings and small beside the motion
};
void PrintTo(const Smooth& c, std::ostream* out) { *out << c.scheme.name; }

class ArealOrder : public testing::TestWithParam<Smooth> {};
INSTANTIATE_TEST_SUITE_P(Schemes, ArealOrder,
                         testing::Values(Smooth{schemes[0], 2.5e-8}, Smooth{schemes[1], 1e-6},
                                         Smooth{schemes[2], 2.5e-8}, Smooth{schemes[3], 1e-6},
                                         Smooth{schemes[4], 2e-6}, Smooth{schemes[5], 4e-6},
                                         Smooth{schemes[6], 2.5e-8}, Smooth{schemes[7], 1e-6},
                                         Smooth{schemes_and_implicit().back(), 2.5e-8}),
                         [](const auto& info) { return info.param.scheme.name; });

/// A block pressed into the plate with all its nodes, on soft springs, for less than a spacing.
ArealScene pressed_block() {
  ArealScene s = small_areal_scene(Support::free, 12);
  s.start = 0.01;
  s.speed = 1.5;
  s.gap = -6e-6;
  s.stiffness = 2e10;
  return s;
}

TEST_P(ArealOrder, ErrorsFallAsTheSchemesWithoutEvents) {
  const ArealScene s = pressed_block();
  constexpr double duration = 1.2e-4;
  const ArealReference reference = areal_reference(s, {duration});
  ASSERT_EQ(reference.openings, 0);
  ASSERT_EQ(reference.states[0].contacts, 300);
  const auto [scheme, coarsest] = GetParam();
  std::vector<double> errors;
  for (int level = 0; level < 3; ++level) {
    const double step = std::ldexp(coarsest, -level);
    const Recording r = simulate(areal_march(s, scheme, step, std::lround(duration / step)));
    ASSERT_EQ(r.end.status, Status::done);
    EXPECT_EQ(state_at(r, 1).contacts, 300);
    errors.push_back(state_distance(s, reference.states[0], state_at(r, 1)));
  }
  EXPECT_LT(errors[0], 0.1);
  for (int level = 1; level < 3; ++level)
    EXPECT_NEAR(std::log2(errors[level - 1] / errors[level]), scheme.table().order, 0.2)
        << errors[level - 1] << " to " << errors[level];
}

// ---- against the reference: shocks

struct Rough {
  std::string name;
  ArealScene (*scene)();
};
void PrintTo(const Rough& c, std::ostream* out) { *out << c.name; }

constexpr double duration = 3e-4;

class ArealMarch : public testing::TestWithParam<Rough> {
 protected:
  static const ArealReference& reference() {
    static std::map<std::string, ArealReference> found;
    ArealReference& of = found[GetParam().name];
    if (of.states.empty()) {
      std::vector<double> times;
      for (int i = 0; i <= 10; ++i) times.push_back(duration * i / 10);
      of = areal_reference(GetParam().scene(), times);
    }
    return of;
  }
  /// Errors at the first four samples, the largest: later chaos takes over.
  static double error(const Recording& r) {
    double most = 0;
    for (std::size_t i = 1; i <= 4; ++i)
      most =
          std::max(most, state_distance(GetParam().scene(), reference().states[i], state_at(r, i)));
    return most;
  }
  /// Shocks against the reference's; impulses and places to `error`, times to a thousandth of that
  /// in seconds, and a step.
  static void compare_shocks(const Recording& r, double step, double error) {
    std::vector<ArealShock> expected = reference().shocks;
    struct Found {
      double start, impulse, x, y;
    };
    std::vector<Found> found;
    const auto take = [&](const auto& shock) {
      found.push_back(
          {static_cast<double>(shock.start) * step, shock.impulse * step,
           shock.moment / shock.impulse * GetParam().scene().spacing,
           r.model.side + r.model.spacing_y * (0.5 + shock.across_moment / shock.impulse)});
    };
    for (const ShockRow& shock : r.shocks) take(shock);
    for (const OpenShock& shock : r.end.open_shocks) take(shock);
    // a touch that lies between two steps is no shock of the march
    std::erase_if(expected, [&](const ArealShock& s) { return s.end - s.start < 2 * step; });
    ASSERT_EQ(found.size(), expected.size());
    const auto by_impulse = [](const auto& a, const auto& b) { return a.impulse > b.impulse; };
    std::sort(found.begin(), found.end(), by_impulse);
    std::sort(expected.begin(), expected.end(), by_impulse);
    double most = 0;
    for (const ArealShock& shock : expected) most = std::max(most, shock.impulse);
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found[i].impulse, expected[i].impulse, error * most);
      if (expected[i].impulse < 0.05 * most) continue;  // two may be nearly equal
      EXPECT_NEAR(found[i].start, expected[i].start, 1e-3 * error);
      EXPECT_NEAR(found[i].x, expected[i].x, error * GetParam().scene().spacing);
      EXPECT_NEAR(found[i].y, expected[i].y, error * GetParam().scene().spacing_y);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Scenes, ArealMarch,
                         testing::Values(Rough{"RigidBlock", rigid_block},
                                         Rough{"FreeBlock", free_block},
                                         Rough{"SixtyModes", sixty_modes},
                                         Rough{"OneBump", one_bump}),
                         [](const auto& info) { return info.param.name; });

/// More nodes in contact than there is room for at first, in one window.
TEST(ArealRoom, GrowsWithTheContactAndChangesNoBit) {
  ArealScene s = pressed_block();
  s.speed = 20;
  const int steps = draws(600);
  for (const Scheme& scheme : schemes_and_implicit()) {
    const Started all = areal_march(s, scheme, 1e-8, steps, 3),
                  started = areal_march(s, scheme, 1e-8, steps, 3, Nodes::candidates);
    Launches with_room;
    with_room.batch.capacity.nodes = 1024;
    const Recording expected = simulate(all, with_room);
    ASSERT_EQ(expected.end.most_nodes, 300);
    EXPECT_TRUE(same(expected, simulate(all))) << scheme.name;
    EXPECT_TRUE(same(expected, simulate(started))) << scheme.name;
    Launches one_place;
    one_place.batch.capacity.nodes = 1;
    EXPECT_TRUE(same(expected, simulate(started, one_place))) << scheme.name;
  }
}

TEST(ArealTiles, CandidatesChangeNoBit) {
  for (const int i : {2, 4, 8}) {
    const Scheme scheme = schemes_and_implicit()[i];
    const ArealScene s = many_nodes();
    const Recording all = simulate(areal_march(s, scheme, 2e-8, 10'000, 10)),
                    candidates =
                        simulate(areal_march(s, scheme, 2e-8, 10'000, 10, Nodes::candidates));
    EXPECT_GT(all.end.shocks_begun, 10) << scheme.name;
    EXPECT_TRUE(same(all, candidates)) << scheme.name;
    EXPECT_LT(5 * candidates.end.evaluated, all.end.evaluated) << scheme.name;
  }
}

TEST_P(ArealMarch, ErrorsFallWithTheStep) {
  // A contact that begins or ends within a step leaves an error of second order, whatever the
  // scheme. How large it is depends on where in the step: over eightfold steps the fall may be a
  // few times more or less.
  for (const auto& [scheme, order] :
       {std::pair{schemes_and_implicit().back(), 1},
        std::pair{scheme_of(SchemeKind::backward_euler), 1},
        std::pair{scheme_of(SchemeKind::midpoint), 2},
        std::pair{scheme_of(SchemeKind::gautschi), 2}, std::pair{scheme_of(SchemeKind::heun), 2},
        std::pair{scheme_of(SchemeKind::rk4), 2}}) {
    const double step = order == 1 ? 2e-8 : 1e-7;
    double errors[2];
    for (const int i : {0, 1}) {
      const double tau = i == 0 ? step : step / 8;
      const Recording r =
          simulate(areal_march(GetParam().scene(), scheme, tau, std::lround(duration / tau), 10));
      ASSERT_EQ(r.end.status, Status::done);
      errors[i] = error(r);
    }
    EXPECT_LT(errors[1], order == 1 ? 2e-2 : 1e-4) << scheme.name;
    EXPECT_GT(std::log2(errors[0] / errors[1]) / 3, order == 1 ? 0.6 : 1.2)
        << scheme.name << ": " << errors[0] << " to " << errors[1];
  }
}

TEST_P(ArealMarch, ShocksAreThoseOfTheReference) {
  const double step = 2e-9;
  const Recording r = simulate(areal_march(GetParam().scene(), scheme_of(SchemeKind::rk4), step,
                                           std::lround(duration / step), 10));
  ASSERT_EQ(r.end.status, Status::done);
  compare_shocks(r, step, 1e-3);
}

TEST_P(ArealMarch, EnergyCloses) {
  const Recording r =
      simulate(areal_march(GetParam().scene(), scheme_of(SchemeKind::rk4), 2e-9, 150'000, 10));
  double most = 0;
  for (std::size_t i = 0; i < r.samples.time.size(); ++i)
    most = std::max(most, r.samples.kinetic[i] + r.samples.elastic[i] + r.samples.contact[i]);
  const ArealState& end = reference().states[10];
  // sums over the steps: off by a step's share of what a spacing, 1e-4 s, puts in and takes out
  EXPECT_NEAR(r.samples.sliding_work[10], end.sliding_work, 1e-3 * most);
  EXPECT_NEAR(r.samples.damping_loss[10], end.damping_loss, 1e-4 * most);
  EXPECT_NEAR(r.samples.contact[10], end.contact, 1e-4 * most);
  EXPECT_NEAR(r.samples.force[10], end.force, 1e-3 * std::max(1.0, end.force));
  EXPECT_EQ(r.samples.nodes[10], end.contacts);
}

// ---- moving forces

/// Off every middle, so that all modes are driven, and one that leaves the plate. Nothing touches.
TEST(ArealForces, MovePlatesAsTheReference) {
  ArealScene s = small_areal_scene(Support::free, 24);
  s.gap = 1e-3;
  s.forces = {{3, 20, 0.011, 0.0137}, {-2, 40, 0.0585, 0.031}};
  constexpr double duration = 1e-4;
  const ArealState expected = areal_reference(s, {duration}).states[0];
  // the map ends where the block does, the forces go on
  const double reached = (s.start + s.speed * duration + s.block.length) / s.spacing;
  for (std::vector<double>& row : s.plate_heights)
    row.resize(std::min(row.size(), static_cast<std::size_t>(reached) + 3));
  ASSERT_LT(static_cast<double>(s.plate_heights[0].size()) * s.spacing, 0.8 * s.plate.length);
  const double step = duration / 4000;
  const Recording adaptive = simulate(areal_march(s, 1e-12, duration)),
                  fixed = simulate(areal_march(s, scheme_of(SchemeKind::rk4), step, 4000));
  EXPECT_LT(state_distance(s, expected, state_at(adaptive, 1)), 1e-10);
  EXPECT_NEAR(adaptive.samples.load_work[1], expected.load_work, 1e-9 * expected.energy());
  // of a force that leaves within a step, up to a step's impulse
  EXPECT_LT(state_distance(s, expected, state_at(fixed, 1)), 1e-3);
}

TEST(ArealForces, OnANodalLineLeaveItsModesAlone) {
  ArealScene s = small_areal_scene(Support::rigid, 24);
  s.gap = 1e-3;
  s.forces = {{3, 20, 0.011, s.plate.width / 2}};
  const Started started = areal_march(s, 1e-10, 1e-4);
  const Recording r = simulate(started);
  const std::vector<PinnedPlateMode> modes = plate_modes(s.plate, 24);
  double odd = 0, even = 0;
  for (std::size_t k = 0; k < 24; ++k)
    (modes[k].n % 2 == 0 ? even : odd) += std::abs(r.samples.resonator_velocity[24 + k]);
  EXPECT_GT(odd, 0);
  EXPECT_LT(even, 1e-14 * odd);
}

// ---- adaptive steps

TEST_P(ArealMarch, AdaptiveStepsAreWithinTheirTolerance) {
  for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-12}) {
    const Recording r = simulate(areal_march(GetParam().scene(), tolerance, duration, 10));
    ASSERT_EQ(r.end.status, Status::done);
    // far below it: between shocks steps end where nodes pass each other, and those are short
    EXPECT_LT(error(r), std::max(0.1 * tolerance, 1e-13));
  }
}

TEST_P(ArealMarch, AdaptiveShocksAreThoseOfTheReference) {
  const Recording r = simulate(areal_march(GetParam().scene(), 1e-12, duration, 10));
  ASSERT_EQ(r.end.status, Status::done);
  compare_shocks(r, r.model.tick, 1e-7);
  double most = 0;
  for (std::size_t i = 0; i < r.samples.time.size(); ++i)
    most = std::max(most, r.samples.kinetic[i] + r.samples.elastic[i] + r.samples.contact[i]);
  const ArealState& end = reference().states[10];
  EXPECT_NEAR(r.samples.sliding_work[10], end.sliding_work, 1e-7 * most);
  EXPECT_NEAR(r.samples.damping_loss[10], end.damping_loss, 1e-7 * most);
  EXPECT_NEAR(r.samples.contact[10], end.contact, 1e-7 * most);
  EXPECT_NEAR(r.samples.force[10], end.force, 1e-7 * std::max(1.0, end.force));
  EXPECT_EQ(r.samples.nodes[10], end.contacts);
}

TEST_P(ArealMarch, CandidatesAndLaunchesChangeNoBitOfAdaptiveSteps) {
  const Started all = areal_march(GetParam().scene(), 1e-8, duration, 10, Nodes::all),
                started = areal_march(GetParam().scene(), 1e-8, duration, 10);
  const Recording whole = simulate(all), candidates = simulate(started);
  EXPECT_EQ(whole.end.status, Status::done);
  EXPECT_GT(whole.end.contact_steps, 0);
  EXPECT_TRUE(same(whole, candidates));
  EXPECT_LT(candidates.end.evaluated, whole.end.evaluated);
  EXPECT_TRUE(same(whole, simulate(started, {.steps = whole.model.steps / 37, .batch = {}})));
  Launches narrow;
  narrow.batch.capacity.nodes = 1;
  EXPECT_TRUE(same(whole, simulate(started, narrow)));
}

// ---- the same bits

TEST_P(ArealMarch, CandidatesLaunchesAndPaddingChangeNoBit) {
  for (const Scheme& scheme : schemes_and_implicit()) {
    const Started all = areal_march(GetParam().scene(), scheme, 1e-8, 3000, 10),
                  started =
                      areal_march(GetParam().scene(), scheme, 1e-8, 3000, 10, Nodes::candidates);
    const Recording whole = simulate(all);
    const Recording candidates = simulate(started);
    EXPECT_TRUE(same(whole, candidates)) << scheme.name;
    EXPECT_LT(candidates.end.evaluated, whole.end.evaluated) << scheme.name;
    if (scheme.table().order > 1) {
      EXPECT_EQ(whole.end.status, Status::done) << scheme.name;
    }
    EXPECT_GT(whole.end.contact_steps, 0);
    for (const std::int64_t steps : {997, 61})
      EXPECT_TRUE(same(whole, simulate(started, {.steps = steps, .batch = {}}))) << scheme.name;
    Launches padded;
    padded.batch.least_packs = 32 / 4;
    EXPECT_TRUE(same(whole, simulate(all, padded))) << scheme.name;
  }
}

TEST_P(ArealMarch, SavedStatesGoOnToTheSameBits) {
  const Started started = areal_march(GetParam().scene(), scheme_of(SchemeKind::midpoint), 1e-8,
                                      3000, 1, Nodes::candidates);
  EXPECT_TRUE(goes_on_when_saved(started, 1234));
}

// ---- exact limits

TEST_P(ArealMarch, MirrorImagesGiveMirrorImages) {
  const ArealScene s = GetParam().scene();
  const Scheme& scheme = scheme_of(SchemeKind::midpoint);
  const Recording a = simulate(areal_march(s, scheme, 1e-8, 10'000)),
                  b = simulate(areal_march(mirrored(s), scheme, 1e-8, 10'000));
  EXPECT_GT(a.end.contact_steps, 0);
  ArealState one = state_at(a, 1);
  // roundings of b - l2 - y0 and of the sums, which shocks amplify
  EXPECT_LT(state_distance(s, one, mirrored(s, state_at(b, 1))), 1e-9);
  EXPECT_EQ(a.shocks.size() + a.end.open_shocks.size(), b.shocks.size() + b.end.open_shocks.size());
}

std::pair<Started, Started> plane_and_rows(Support support, int rows, ContactLaw law) {
  Scene s = rough_scene(support);
  s.contact.law = law;
  if (law == ContactLaw::multiplier) s.gap.reset();  // touching at t = 0
  s.time.scheme = SchemeKind::midpoint;
  s.time.nodes = Nodes::all;
  set_steps(s, 1e-8, 20'000, 4);
  Started plane{make_model(s), {}};
  plane.start = make_start(plane.model);
  return {plane, with_rows(plane, rows)};
}

TEST(ArealLimits, MapsThatAreConstantInYGiveThePlaneScene) {
  for (const Support support : {Support::rigid, Support::pinned, Support::free})
    for (const int rows : {1, 2, 7}) {
      const auto [plane, areal] = plane_and_rows(support, rows, ContactLaw::penalty);
      const Recording a = simulate(plane), b = simulate(areal);
      ASSERT_EQ(b.end.status, Status::done);
      EXPECT_GE(a.shocks.size(), 3);
      ASSERT_EQ(a.samples.nodes.size(), b.samples.nodes.size());
      // a row is a share of the strip: sums of other roundings, which shocks amplify
      double most_u = 0, most_v = 0, most_force = 0;
      for (const double u : a.samples.resonator_displacement)
        most_u = std::max(most_u, std::abs(u));
      for (const double v : a.samples.resonator_velocity) most_v = std::max(most_v, std::abs(v));
      for (const double f : a.samples.force) most_force = std::max(most_force, f);
      for (std::size_t i = 0; i < a.samples.resonator_displacement.size(); ++i) {
        EXPECT_NEAR(a.samples.resonator_displacement[i], b.samples.resonator_displacement[i],
                    1e-9 * most_u);
        EXPECT_NEAR(a.samples.resonator_velocity[i], b.samples.resonator_velocity[i],
                    1e-9 * most_v);
      }
      for (std::size_t i = 0; i < a.samples.force.size(); ++i) {
        EXPECT_NEAR(a.samples.force[i], b.samples.force[i], 1e-7 * most_force);
        EXPECT_EQ(rows * a.samples.nodes[i], b.samples.nodes[i]);
      }
      // each reaches over all rows
      ASSERT_EQ(a.shocks.size(), b.shocks.size());
      for (std::size_t i = 0; i < a.shocks.size(); ++i) {
        EXPECT_EQ(a.shocks[i].start, b.shocks[i].start);
        EXPECT_EQ(a.shocks[i].last, b.shocks[i].last);
        EXPECT_NEAR(a.shocks[i].peak, b.shocks[i].peak, 1e-6 * a.shocks[i].peak);
        EXPECT_NEAR(a.shocks[i].moment, b.shocks[i].moment, 1e-6 * a.shocks[i].moment);
      }
    }
}

/// Which of the rows carries the force of a strip is left open, the motion is not.
TEST(ArealLimits, MultipliersOnEqualRowsMoveAsInThePlane) {
  for (const Support support : {Support::rigid, Support::pinned, Support::free})
    for (const int rows : {1, 2, 7}) {
      const auto [plane, areal] = plane_and_rows(support, rows, ContactLaw::multiplier);
      const Recording a = simulate(plane), b = simulate(areal);
      ASSERT_EQ(b.end.status, Status::done);
      EXPECT_GE(a.shocks.size(), 1);
      double most_u = 0;
      for (const double u : a.samples.resonator_displacement)
        most_u = std::max(most_u, std::abs(u));
      ASSERT_EQ(a.samples.resonator_displacement.size(), b.samples.resonator_displacement.size());
      for (std::size_t i = 0; i < a.samples.resonator_displacement.size(); ++i)
        EXPECT_NEAR(a.samples.resonator_displacement[i], b.samples.resonator_displacement[i],
                    1e-9 * most_u);
      ASSERT_EQ(a.shocks.size(), b.shocks.size());
    }
}

TEST_P(ArealMarch, MultipliersKeepTheFacesApart) {
  for (const SchemeKind kind : {SchemeKind::backward_euler, SchemeKind::heun}) {
    const Scheme scheme{{{kind}, ContactLaw::multiplier}, "of multipliers"};
    ArealScene scene = GetParam().scene();  // touching at t = 0
    scene.gap += rest_overlap(areal_march(scene, scheme, 1e-8, 1).model);
    const Started all = areal_march(scene, scheme, 1e-8, 6000, 300),
                  candidates = areal_march(scene, scheme, 1e-8, 6000, 300, Nodes::candidates);
    const Recording r = simulate(all);
    ASSERT_EQ(r.end.status, Status::done);
    EXPECT_GT(r.end.contact_steps, 0);
    EXPECT_TRUE(same(r, simulate(candidates)));
    // samples fall on steps: where a force acts the faces just touch, elsewhere they are apart
    const std::size_t modes2 = r.model.resonator.modes.size(), modes1 = r.model.slider.modes.size();
    Model there = r.model;
    for (std::size_t i = 0; i < r.samples.time.size(); ++i) {
      there.position =
          r.model.position + static_cast<double>(i) * r.model.steps_per_sample * r.model.advance;
      const auto row = [&](const std::vector<double>& of, std::size_t modes) {
        const auto begin = of.begin() + static_cast<std::ptrdiff_t>(i * modes);
        return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(modes));
      };
      const std::vector<double> over =
          overlaps(there, row(r.samples.resonator_displacement, modes2),
                   row(r.samples.slider_displacement, modes1));
      const double most = *std::max_element(over.begin(), over.end());
      // roundings of heights of 1e-5 m
      EXPECT_LT(most, 1e-5 * 512 * std::numeric_limits<double>::epsilon());
      if (r.samples.force[i] > 0) {
        EXPECT_GT(most, -1e-5 * 512 * std::numeric_limits<double>::epsilon());
      }
    }
  }
}

TEST(ArealLimits, ABlockAtRestStaysAtRest) {
  ArealScene s = free_block();
  s.speed = 0;
  Started started = areal_march(s, scheme_of(SchemeKind::midpoint), 1e-8, 5000, 5);
  started.model.scene.initial = Initial::statics;
  started.start = make_start(started.model);
  EXPECT_NEAR(started.start.contact_force, s.block.load, 1e-9 * s.block.load);
  EXPECT_GE(started.start.loaded_nodes.size(), 3);  // heave, pitch and roll
  const Recording r = simulate(started);
  ASSERT_EQ(r.end.status, Status::done);
  for (const double f : r.samples.force) EXPECT_NEAR(f, s.block.load, 1e-6 * s.block.load);
  EXPECT_EQ(r.samples.nodes.back(), static_cast<double>(started.start.loaded_nodes.size()));
  double most = 0;
  for (const double u : started.start.resonator_u) most = std::max(most, std::abs(u));
  for (std::size_t k = 0; k < started.start.resonator_u.size(); ++k)
    EXPECT_NEAR(r.end.resonator_u[k], started.start.resonator_u[k], 1e-6 * most);
}

/// Of many nodes the equilibrium is sought with some; in the end all that overlap carry the load.
TEST(ArealLimits, TheStaticStartTakesInEveryNodeThatOverlaps) {
  ArealScene s = small_areal_scene(Support::free, 12);
  s.spacing = 2.5e-5, s.spacing_y = 5e-5;
  s.block.length = 299 * s.spacing, s.block.width = 60 * s.spacing_y;
  s.stiffness = 1e13;
  s.plate_heights = rough_map(60, 2401, 2e-6, 5);
  s.block_heights = rough_map(60, 300, 2e-6, 6);
  Started started = areal_march(s, scheme_of(SchemeKind::midpoint), 1e-8, 1);
  started.model.scene.initial = Initial::statics;
  const ModalStart start = make_start(started.model);
  EXPECT_NEAR(start.contact_force, s.block.load, 1e-9 * s.block.load);
  const std::vector<double> over = overlaps(started.model, start.resonator_u, start.slider_u);
  EXPECT_EQ(std::count_if(over.begin(), over.end(), [](double o) { return o >= 0; }),
            static_cast<std::ptrdiff_t>(start.loaded_nodes.size()));
  EXPECT_GT(start.loaded_nodes.size(), 50);
}

// ---- what is refused

TEST(ArealModel, RefusesWhatDoesNotFit) {
  const ArealScene fits = rigid_block();
  const Started started = areal_march(fits, scheme_of(SchemeKind::midpoint), 1e-8, 100);
  const Scene scene = started.model.scene;
  const HeightMaps maps{.rows = started.model.rows,
                        .spacing_y = started.model.spacing_y,
                        .side = started.model.side,
                        .resonator = started.model.resonator_height,
                        .slider = started.model.slider_height};
  const auto refused = [&](const std::function<void(Scene&, HeightMaps&)>& change) {
    Scene s = scene;
    HeightMaps m = maps;
    change(s, m);
    try {
      make_model(s, m);
    } catch (const RequestError& fault) {
      return std::string(fault.what());
    }
    return std::string("taken");
  };
  const auto expect = [&](const char* key, const std::function<void(Scene&, HeightMaps&)>& change) {
    EXPECT_NE(refused(change).find(key), std::string::npos) << key << ": " << refused(change);
  };
  EXPECT_EQ(refused([](Scene&, HeightMaps&) {}), "taken");
  expect("resonator.moving_force", [](Scene& s, HeightMaps&) {
    s.resonator.moving_forces = {{1, 1, 0}};  // no y
  });
  expect("output.probes", [](Scene& s, HeightMaps&) { s.output.probes = {0.01}; });
  expect("output.slider_probes", [](Scene& s, HeightMaps&) { s.output.slider_probes = {0.001}; });
  expect("scene.spacing_y", [](Scene&, HeightMaps& m) { m.spacing_y = 0; });
  expect("scene.spacing_y", [](Scene&, HeightMaps& m) { m.spacing_y = 1; });
  expect("slider.surface", [](Scene&, HeightMaps& m) { m.rows = 5; });
  expect("slider.surface", [](Scene&, HeightMaps& m) { m.slider.pop_back(); });
  expect("slider.surface", [](Scene&, HeightMaps& m) { m.slider[7] = std::nan(""); });
  expect("resonator.surface", [](Scene&, HeightMaps& m) { m.resonator.pop_back(); });
  expect("resonator.surface", [](Scene&, HeightMaps& m) { m.resonator.clear(); });
  expect("resonator.surface", [](Scene&, HeightMaps& m) { m.resonator[7] = INFINITY; });
  expect("resonator.surface", [](Scene& s, HeightMaps&) { s.start = 0.0545; });
  expect("scene.side", [](Scene&, HeightMaps& m) { m.side = -1e-3; });
  expect("scene.side", [](Scene&, HeightMaps& m) { m.side = 0.0376; });
  expect("block", [](Scene& s, HeightMaps&) { s.slider.support = Support::pinned; });
}

}  // namespace
}  // namespace ra2d::test
