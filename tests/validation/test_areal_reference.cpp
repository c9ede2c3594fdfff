// SPDX-License-Identifier: BSD-3-Clause
#include "tests/areal_reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/body/block.hpp"
#include "host/body/plate.hpp"
#include "tests/adaptive.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

/// The reference for areal scenes against theory, before anything is held to it.
namespace ra2d::test {
namespace {

struct Case {
  std::string name;
  ArealScene (*scene)();
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

ArealScene moving_force() {
  ArealScene s = small_areal_scene(Support::free);
  s.forces = {{.force = 3, .speed = 30, .start = 0.035, .y = 0.012}};
  return s;
}
const std::vector<Case> cases{{"RigidBlock", rigid_block},
                              {"FreeBlock", free_block},
                              {"SixtyModes", sixty_modes},
                              {"OneBump", one_bump},
                              {"MovingForce", moving_force}};

constexpr double duration = 3e-4;

class ArealReferences : public testing::TestWithParam<Case> {
 protected:
  /// Of the case, at 0, duration/10, ... duration.
  static const ArealReference& usual() {
    static std::map<std::string, ArealReference> found;
    std::vector<double> times;
    for (int i = 0; i <= 10; ++i) times.push_back(duration * i / 10);
    ArealReference& of = found[GetParam().name];
    if (of.states.empty()) of = areal_reference(GetParam().scene(), times);
    return of;
  }
};
INSTANTIATE_TEST_SUITE_P(Scenes, ArealReferences, testing::ValuesIn(cases),
                         [](const auto& info) { return info.param.name; });

TEST_P(ArealReferences, Converge) {
  const ArealScene s = GetParam().scene();
  const ArealReference& a = usual();
  const ArealReference b =
      areal_reference(s, {duration / 2, duration}, {.order = 34, .longest = 0.7});
  EXPECT_GT(b.steps, a.steps);
  for (int i = 0; i < 2; ++i) {
    const ArealState& state = a.states[5 * (i + 1)];
    ASSERT_GT(state.energy(), 0);
    EXPECT_LT(state_distance(s, state, b.states[i]), 1e-13);
    EXPECT_EQ(state.contacts, b.states[i].contacts);
  }
  EXPECT_GE(a.shocks.size(), 1);
  ASSERT_EQ(a.shocks.size(), b.shocks.size());
  EXPECT_EQ(a.closings, b.closings);
  for (std::size_t i = 0; i < a.shocks.size(); ++i) {
    const ArealShock &one = a.shocks[i], &other = b.shocks[i];
    EXPECT_NEAR(one.start, other.start, 1e-13 * duration);
    EXPECT_NEAR(one.end, other.end, 1e-13 * duration);
    EXPECT_NEAR(one.impulse, other.impulse, 1e-12 * one.impulse);
    EXPECT_NEAR(one.peak, other.peak, 1e-12 * one.peak);
    EXPECT_NEAR(one.x, other.x, 1e-12 * one.x);
    EXPECT_EQ(one.nodes, other.nodes);
  }
}

TEST_P(ArealReferences, ErrorsFallAsTheSeriesDo) {
  // what is left out of a step: longest^(order + 1)/(order + 1)!, give or take what the events do
  const ArealScene s = GetParam().scene();
  const double time = duration / 5;
  const ArealState& best = usual().states[2];
  const double coarse = state_distance(s, best, areal_reference(s, {time}, {6, 0.5}).states[0]),
               fine = state_distance(s, best, areal_reference(s, {time}, {12, 0.5}).states[0]);
  const double theory = std::pow(0.5, 6) * std::tgamma(8) / std::tgamma(14);
  EXPECT_GT(coarse, 1e-12);
  EXPECT_LT(fine, 30 * theory * coarse + 1e-14);
}

TEST_P(ArealReferences, EnergyCloses) {
  const ArealReference& r = usual();
  double most = 0;
  for (const ArealState& state : r.states) most = std::max(most, state.energy());
  for (const ArealState& state : r.states)
    EXPECT_NEAR(state.energy() - state.supplied(), r.states[0].energy(), 1e-14 * most);
  EXPECT_GT(r.states.back().damping_loss, 1e-4 * most);
  EXPECT_GT(std::abs(r.states.back().sliding_work), 1e-4 * most);
}

TEST_P(ArealReferences, MirrorImagesGiveMirrorImages) {
  const ArealScene s = GetParam().scene();
  ArealReference a = usual(), b = areal_reference(mirrored(s), {duration});
  const ArealState state = mirrored(s, b.states[0]);
  // b - l2 - y0 is rounded: some 1e-16 of a shape, which shocks amplify
  EXPECT_LT(state_distance(s, a.states.back(), state), 1e-11);
  ASSERT_EQ(a.shocks.size(), b.shocks.size());
  for (ArealReference* each : {&a, &b})  // several may begin at t = 0
    std::sort(
        each->shocks.begin(), each->shocks.end(),
        [](const ArealShock& one, const ArealShock& other) { return one.impulse < other.impulse; });
  for (std::size_t i = 0; i < a.shocks.size(); ++i) {
    EXPECT_NEAR(a.shocks[i].impulse, b.shocks[i].impulse, 1e-10 * a.shocks[i].impulse);
    EXPECT_NEAR(a.shocks[i].y, s.plate.width - b.shocks[i].y, 1e-10 * s.plate.width);
  }
}

TEST_P(ArealReferences, ScaleAsTheEquationsDo) {
  // heights, gap and loads by c: displacements, too. Stiffness, density and loads by c: the motion
  // stays. Speed by c, stiffness by c^2 and with it Young's modulus and loads: times by 1/c.
  const ArealScene s = GetParam().scene();
  const ArealState& a = usual().states[5];
  struct Group {
    double heights, forces, masses, times;
  };
  constexpr double c = 3;
  for (const Group g : {Group{c, c, 1, 1}, Group{1, c, c, 1}, Group{1, c * c, 1, 1 / c}}) {
    ArealScene scaled = s;
    for (HeightMap* map : {&scaled.plate_heights, &scaled.block_heights})
      for (std::vector<double>& row : *map)
        for (double& h : row) h *= g.heights;
    scaled.gap *= g.heights;
    scaled.speed /= g.times;
    for (ArealForce& f : scaled.forces) f.force *= g.forces, f.speed /= g.times;
    scaled.block.load *= g.forces;
    scaled.stiffness *= g.forces / g.heights;
    scaled.plate.young *= g.forces / g.heights;
    scaled.plate.density *= g.masses;
    scaled.block.density *= g.masses;
    ArealState state = areal_reference(scaled, {duration / 2 * g.times}).states[0];
    for (std::vector<double>* u : {&state.plate_u, &state.block_u})
      for (double& each : *u) each /= g.heights;
    for (std::vector<double>* v : {&state.plate_v, &state.block_v})
      for (double& each : *v) each *= g.times / g.heights;
    EXPECT_LT(state_distance(s, a, state), 1e-11);
    EXPECT_NEAR(state.energy(), g.forces * g.heights * a.energy(), 1e-11 * state.energy());
    EXPECT_NEAR(state.force, g.forces * a.force, 1e-9 * state.force);
    EXPECT_EQ(state.contacts, a.contacts);
  }
}

TEST(ArealReference, ImpulsesAreTheLoadTimesTheTime) {
  const ArealScene s = free_block();
  const ArealReference r = areal_reference(s, {duration});
  double impulse = 0;
  for (const ArealShock& shock : r.shocks) impulse += shock.impulse;
  // mass times the mean velocity of the block, downwards positive
  const double area = s.block.length * s.block.width,
               momentum = make_block(s.block).mass * r.states[0].block_v[0] / std::sqrt(area);
  EXPECT_NEAR(impulse, s.block.load * duration - momentum, 1e-13 * s.block.load * duration);
  EXPECT_GT(impulse, 0.1 * s.block.load * duration);
}

TEST(ArealReference, RunsBackToWhereItCameFrom) {
  ArealScene s = free_block();
  s.speed = 0;
  s.plate.damping = 0;
  s.start = 0.01003;
  const ArealState there = areal_reference(s, {3e-4}).states[0];
  s.plate_u = there.plate_u, s.block_u = there.block_u;
  s.plate_v = there.plate_v, s.block_v = there.block_v;
  for (std::vector<double>* v : {&s.plate_v, &s.block_v})
    for (double& each : *v) each = -each;
  const ArealReference back = areal_reference(s, {0, 3e-4});
  EXPECT_GT(back.openings, 0);
  ArealState rest = back.states[1];
  for (std::vector<double>* each : {&rest.plate_u, &rest.plate_v, &rest.block_u, &rest.block_v})
    std::fill(each->begin(), each->end(), 0.0);
  ArealState end = back.states[1];
  const double left =
      apart(make_plate(s.plate), end.plate_u, end.plate_v, rest.plate_u, rest.plate_v) +
      apart(make_block(s.block), end.block_u, end.block_v, rest.block_u, rest.block_v);
  EXPECT_LT(std::sqrt(left / there.energy()), 1e-12);
}

TEST(ArealReference, PointForceCrossesThePlateAsInClosedForm) {
  // mu (U'' + omega^2 U) = F psi(v t, y), psi = A sin(W t): U = F A/mu (sin W t - W/omega
  // sin omega t)/(omega^2 - W^2)
  ArealScene s = small_areal_scene(Support::rigid);
  s.plate.damping = 0;
  s.gap = 1;
  const double force = 2.5, speed = 40, y = 0.0123;
  s.forces = {{.force = force, .speed = speed, .start = 0, .y = y}};
  const double time = 1.1e-3;
  const ArealState state = areal_reference(s, {time}).states[0];
  const Body plate = make_plate(s.plate);
  const std::vector<PinnedPlateMode> modes = plate_modes(s.plate, 1000);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const double omega = modes[k].omega, w = modes[k].m * pi * speed / s.plate.length,
                 a = 2 / std::sqrt(0.06 * 0.04) * std::sin(modes[k].n * pi * y / 0.04),
                 scale = force * a / (7800 * 1e-3) / (omega * omega - w * w);
    // double precision: phases of up to omega t
    EXPECT_NEAR(state.plate_u[k], scale * (std::sin(w * time) - w / omega * std::sin(omega * time)),
                1e-15 * omega * time * std::abs(scale));
    EXPECT_NEAR(state.plate_v[k], scale * w * (std::cos(w * time) - std::cos(omega * time)),
                1e-15 * omega * time * std::abs(scale * w));
  }
  EXPECT_NEAR(state.energy(), state.load_work, 1e-15 * state.energy());
  // once it has left, what it put in stays
  const ArealReference after = areal_reference(s, {1.5e-3, 1.55e-3, 1.6e-3});
  EXPECT_EQ(after.states[1].load_work, after.states[2].load_work);
}

/// A rigid plate, flat, under a free block without a load that comes down at 0.1 m/s.
ArealScene falling_block() {
  ArealScene s = small_areal_scene(Support::free);
  s.plate.support = Support::rigid;
  s.plate.modes = 0;
  s.block.load = 0;
  s.gap = 1e-5;
  for (std::vector<double>& row : s.block_heights) row.assign(30, 0.0);
  for (std::vector<double>& row : s.plate_heights) row.assign(301, 0.0);
  s.block_v = {0.1 * std::sqrt(s.block.length * s.block.width), 0, 0};
  return s;
}

TEST(ArealReference, ABlockReboundsAsASpringLetsIt) {
  // On one node at (x, y) from its middle its mass is M/(1 + 12 x^2/l1^2 + 12 y^2/l2^2): half a
  // period of that on the spring, twice its momentum.
  struct Node {
    int i, j;
  };
  for (const Node at : {Node{0, 0}, Node{14, 6}, Node{29, 9}}) {
    ArealScene s = falling_block();
    s.block_heights[at.j][at.i] = 5e-6;
    const double x = at.i * 2e-4 / s.block.length - 0.5, y = (at.j + 0.5) / 10 - 0.5;
    const double mass = make_block(s.block).mass / (1 + 12 * x * x + 12 * y * y),
                 spring = 1e14 * 2e-4 * 2.5e-4, omega = std::sqrt(spring / mass);
    const double start = 5e-6 / 0.1;
    // until the node is in the air again, and before others touch
    const ArealReference r = areal_reference(s, {start + 1.01 * pi / omega});
    ASSERT_EQ(r.shocks.size(), 1);
    const ArealShock& shock = r.shocks[0];
    EXPECT_FALSE(shock.is_open);
    EXPECT_EQ(shock.nodes, 1);
    EXPECT_NEAR(shock.start, start, 1e-15 * start);
    EXPECT_NEAR(shock.end - shock.start, pi / omega, 1e-14 * start);
    EXPECT_NEAR(shock.impulse, 2 * mass * 0.1, 1e-14 * shock.impulse);
    EXPECT_NEAR(shock.peak, 0.1 * std::sqrt(spring * mass), 1e-14 * shock.peak);
    // the force is even about the middle of its time
    EXPECT_NEAR(shock.x, s.start + at.i * 2e-4 + 2 * (start + 0.5 * pi / omega), 1e-16);
    EXPECT_NEAR(shock.y, s.side + (at.j + 0.5) * 2.5e-4, 1e-16);
    // heave, pitch and roll share what there was
    EXPECT_NEAR(r.states[0].kinetic, 0.5 * make_block(s.block).mass * 0.01, 1e-17);
  }
}

TEST(ArealReference, OneModeSwingsOnOneSpring) {
  // at rest, d deep: mu U'' = -(mu omega^2 + K psi^2) U - K d psi
  ArealScene s = falling_block();
  s.block.support = Support::rigid;
  s.block_v.clear();
  s.plate = small_areal_scene(Support::rigid, 1).plate;
  s.plate.damping = 0;
  s.speed = 0;
  s.stiffness = 1e12;
  const double depth = 1e-6, time = 7e-4, spring = 1e12 * 2e-4 * 2.5e-4;
  s.block_heights[7][20] = s.gap + depth;
  const double x = s.start + 20 * 2e-4, y = s.side + 7.5 * 2.5e-4, mass = 7800 * 1e-3,
               psi = 2 / std::sqrt(0.06 * 0.04) * std::sin(pi * x / 0.06) * std::sin(pi * y / 0.04),
               wave = pi * pi * (1 / (0.06 * 0.06) + 1 / (0.04 * 0.04)),
               free = wave * std::sqrt(210e9 * 1e-6 / (12 * (1 - 0.09) * 7800)),
               omega = std::sqrt(free * free + spring * psi * psi / mass),
               most = spring * depth * psi / (mass * omega * omega);
  const ArealReference r = areal_reference(s, {time});
  EXPECT_NEAR(r.states[0].plate_u[0], -most * (1 - std::cos(omega * time)),
              4e-16 * omega * time * most);
  EXPECT_NEAR(r.states[0].plate_v[0], -most * omega * std::sin(omega * time),
              4e-16 * omega * time * most * omega);
  EXPECT_NEAR(r.states[0].force, spring * (depth + psi * r.states[0].plate_u[0]),
              1e-14 * spring * depth);
  EXPECT_EQ(r.openings, 0);
}

TEST(ArealReference, ARidgePassesUnderARigidBlock) {
  // the force follows the straight lines of the plate's face
  ArealScene s = falling_block();
  s.block.support = Support::rigid;
  s.block_v.clear();
  s.gap = 4e-6;
  s.start = 0.01;
  s.plate_heights[2][51] = 1e-5;  // passes under nodes 1 and 0
  const double spacing_time = 1e-4, spring = 1e14 * 2e-4 * 2.5e-4;
  const ArealReference r = areal_reference(s, {0.98e-4});
  ASSERT_EQ(r.shocks.size(), 1);
  // node 1 stands on the ridge at t = 0, 6 um deep, and leaves at 0.6 spacings; node 0 comes at 0.4
  const ArealShock& shock = r.shocks[0];
  EXPECT_EQ(shock.start, 0);
  EXPECT_TRUE(shock.is_open);
  EXPECT_EQ(shock.nodes, 2);
  const auto triangle = [&](double depth) { return 0.5 * spring * depth * depth / 1e-5; };
  EXPECT_NEAR(shock.impulse, (triangle(6e-6) + triangle(5.8e-6)) * spacing_time,
              1e-14 * shock.impulse);
  EXPECT_NEAR(shock.peak, spring * 6e-6, 1e-14 * shock.peak);
  EXPECT_NEAR(r.states[0].force, spring * 5.8e-6, 1e-13 * shock.peak);
  EXPECT_NEAR(r.states[0].sliding_work, 0.5 * spring * (5.8e-6 * 5.8e-6 - 6e-6 * 6e-6), 1e-17);
}

TEST(ArealReference, EightNeighboursAreOneShock) {
  ArealScene s = falling_block();
  s.block.support = Support::rigid;
  s.block_v.clear();
  for (const auto& [i, j] : {std::pair{3, 3}, {4, 4}, {5, 3}, {5, 2}, {7, 2}, {5, 5}, {9, 9}})
    s.block_heights[j][i] = 1.1e-5;
  const ArealReference r = areal_reference(s, {1e-4});
  ASSERT_EQ(r.shocks.size(), 3);  // (7, 2) and (9, 9) are alone
  std::vector<int> nodes;
  for (const ArealShock& shock : r.shocks) nodes.push_back(shock.nodes);
  std::sort(nodes.begin(), nodes.end());
  EXPECT_EQ(nodes, (std::vector<int>{1, 1, 5}));
}

TEST(ArealReference, ForcesOfPiecesAddUpFromWhenTheyMeet) {
  ArealScene s = falling_block();
  s.block.support = Support::rigid;
  s.block_v.clear();
  s.start = 0.01;
  // Node 3 stays 1 um deep. Node 5 begins on a ridge, 6.5 um deep, and leaves it for node 4, which
  // touches at 0.75 spacings. From then on the three carry 3 um.
  s.block_heights[4][3] = 1.1e-5;
  s.block_heights[4][4] = 5.5e-6;
  s.block_heights[4][5] = 1.05e-5;
  s.plate_heights[4][55] = 6e-6;
  const double spring = 1e14 * 2e-4 * 2.5e-4;
  const ArealReference apart = areal_reference(s, {0.7e-4}), met = areal_reference(s, {0.9e-4});
  ASSERT_EQ(apart.shocks.size(), 2);
  EXPECT_NEAR(apart.shocks[0].peak, spring * 1e-6, 1e-14 * spring * 1e-5);
  EXPECT_NEAR(apart.shocks[1].peak, spring * 6.5e-6, 1e-14 * spring * 1e-5);
  ASSERT_EQ(met.shocks.size(), 1);
  EXPECT_EQ(met.shocks[0].nodes, 3);
  EXPECT_NEAR(met.shocks[0].peak, spring * 6.5e-6, 1e-14 * spring * 1e-5);
  EXPECT_NEAR(met.states[0].force, spring * 3e-6, 1e-13 * spring * 1e-5);
}

/// The plane scene of a model, in so many rows.
ArealScene plane_scene(const Model& model, int rows) {
  ArealScene s;
  s.is_plane = true;
  s.plate = model.scene.resonator;
  s.block = model.scene.slider;
  s.spacing = model.scene.spacing;
  s.spacing_y = s.block.width / rows;
  s.start = model.scene.start;
  s.speed = model.scene.speed;
  s.gap = model.delta;
  s.stiffness = model.scene.contact.stiffness;
  s.plate_heights.assign(rows, model.resonator_height);
  s.block_heights.assign(rows, model.slider_height);
  return s;
}

TEST(ArealReference, ShapesConstantInYGiveThePlaneScene) {
  for (const Support support : {Support::rigid, Support::free}) {
    Scene scene = plate_scene(8, 0.004, 0.004);
    scene.slider.support = support;
    scene.slider.load = support == Support::free ? 5 : 0;
    scene.speed = 2;
    scene.start = 0.0203;
    scene.gap = 1.9e-5;
    scene.contact.stiffness = 1e13;
    scene.slider.surface = peaks({{.at = 0.0015, .height = 1e-5, .half_width = 4e-4}});
    scene.resonator.surface = peaks({{.at = 0.0222, .height = 1e-5, .half_width = 4e-4},
                                     {.at = 0.0228, .height = 1e-5, .half_width = 4e-4}});
    scene.duration = 6e-4;
    scene.output.rate = 1 / scene.duration;
    const Recording plane = simulate(adaptive(scene, 1e-13));
    const ArealReference r = areal_reference(plane_scene(plane.model, 4), {scene.duration});
    const ArealState& state = r.states[0];
    const double left = apart(plane.model.resonator, state.plate_u, state.plate_v,
                              plane.end.resonator_u, plane.end.resonator_v) +
                        apart(plane.model.slider, state.block_u, state.block_v, plane.end.slider_u,
                              plane.end.slider_v);
    // a shock amplifies what came before it by up to some ten times; roundings of double precision
    const double bound = 1e-10;
    EXPECT_LT(std::sqrt(left / state.energy()), bound);
    ASSERT_EQ(plane.shocks.size(), r.shocks.size());
    ASSERT_GE(r.shocks.size(), 1);
    for (std::size_t i = 0; i < r.shocks.size(); ++i) {
      const double impulse = plane.shocks[i].impulse * plane.model.tick;
      EXPECT_NEAR(impulse, r.shocks[i].impulse, 10 * bound * impulse);
      EXPECT_NEAR(plane.shocks[i].peak, r.shocks[i].peak, 100 * bound * r.shocks[i].peak);
    }
  }
}

TEST(ArealReference, RefusesMapsThatDoNotFit) {
  ArealScene s = rigid_block();
  s.block_heights[3].pop_back();
  EXPECT_THROW(areal_reference(s, {duration}), std::invalid_argument);
  s = rigid_block();
  s.plate_heights.pop_back();
  EXPECT_THROW(areal_reference(s, {duration}), std::invalid_argument);
  s = rigid_block();
  EXPECT_THROW(areal_reference(s, {1.0}), std::invalid_argument);  // behind the end of the map
  s.plate_v = {0, 1};
  EXPECT_THROW(areal_reference(s, {duration}), std::invalid_argument);
}

}  // namespace
}  // namespace ra2d::test
