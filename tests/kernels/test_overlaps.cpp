// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "kernels/adaptive/overlaps.hpp"
#include "kernels/limits.hpp"
#include "tests/bodies_by_hand.hpp"
#include "tests/kernels_of.hpp"

/// Nodes that touch within a step are flagged: each case is one that a part of the proof is there
/// for.
namespace {

using namespace ra2d;
using test::Amplitudes, test::BodiesByHand, test::Packs, test::Real, test::lanes;
using test::K, test::width;

/// How many nodes the march flags in a step of a second between two states; they are listed.
int flag(BodiesByHand& bodies, const MotionBounds& bounds, const Amplitudes& u0,
         const Amplitudes& v0, const Amplitudes& u1, const Amplitudes& v1) {
  SceneTables& t = bodies.t;
  t.bounds.searched = Nodes::all;
  auto overlaps = test::overlaps_of<K>(t, bodies.s);
  const Packs u(u0), v(v0);
  ModalState<HostLanes, K> now;
  for (int p = 0; p < K; ++p) now.u[p] = u.u[p], now.v[p] = v.u[p], now.square[p] = Real(0.0);
  overlaps.evaluate(Place(t.motion, 0), now.u, now.v, Place(t.motion, 1), Packs(u1).u, Packs(v1).u);
  return overlaps.flag(Place(t.motion, 0), now.u, t.motion.time_step, bounds,
                       overlaps.longest_rise(now.u, bounds, 1));
}

/// How far open node 0 of a flat face may be at the beginning of a step and still be flagged.
double widest_flagged(BodiesByHand& bodies, const MotionBounds& bounds, const Amplitudes& u0,
                      const Amplitudes& v0, const Amplitudes& u1, const Amplitudes& v1) {
  double flagged = 0, not_flagged = 10;
  for (int i = 0; i < 60; ++i) {
    const double open = 0.5 * (flagged + not_flagged);
    bodies.set_overlap(0, -open, u0, bodies.t.motion.position);
    (flag(bodies, bounds, u0, v0, u1, v1) == 1 ? flagged : not_flagged) = open;
  }
  return flagged;
}

/// Two groups of slider nodes with wide gaps but for the one that a test is about.
constexpr int nodes = 2 * width;

TEST(Overlaps, ANodeThatTheCubicsTakeForOpenIsFlagged) {
  // at rest, and just touching: of a wave cos z about the patch's centre they leave out z^4/24
  for (int node = 0; node < nodes; ++node) {
    const int patch = 8 + node / width * width + width / 2;
    BodiesByHand bodies({{1 / BodiesByHand::radius, patch + 0.5}}, {}, nodes);
    bodies.t.motion.position = 8;
    Amplitudes u{}, v{};
    u[0] = 1e-6;
    for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? 0 : -1, u, 8);
    const MotionBounds bounds{.travel = 0,
                              .fourth_derivative = 0,
                              .cubic_remainder = bodies.tail[0] * u[0],
                              .size = u[0]};
    EXPECT_EQ(flag(bodies, bounds, u, v, u, v), 1) << "node " << node;
    EXPECT_TRUE(bodies.lists(node, 1)) << "node " << node;
  }
}

TEST(Overlaps, ANodeThatTouchesAndIsGoneByTheEndIsFlagged) {
  // the slider falls upwards and back: overlap -0.9 h + 4 h t (1 - t)
  constexpr double h = 1e-6;
  for (int node = 0; node < nodes; ++node) {
    BodiesByHand bodies({}, {std::vector<double>(nodes, 1.0)}, nodes);
    bodies.t.motion.position = 8;
    Amplitudes u{}, v0{}, v1{};
    v0[0] = 4 * h, v1[0] = -4 * h;
    for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? -0.9 * h : -1, u, 8);
    const MotionBounds bounds{.travel = h, .fourth_derivative = 0, .cubic_remainder = 0, .size = h};
    EXPECT_EQ(flag(bodies, bounds, u, v0, u, v1), 1) << "node " << node;
    EXPECT_TRUE(bodies.lists(node, 1)) << "node " << node;
  }
}

TEST(Overlaps, ANodeThatPassesACrestIsFlagged) {
  // bodies at rest, and a node that touches the deflected beam's crest half way: only the
  // sliding brings it there
  constexpr double beta = 0.02, advance = 0.9375, size = 1e-3;
  for (int node = 0; node < nodes; ++node) {
    BodiesByHand bodies({{beta, 8 + node + 0.5 * advance}}, {}, nodes);
    bodies.t.motion.position = 8;
    bodies.t.motion.advance = advance;
    Amplitudes u{}, v{};
    u[0] = size;
    for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? 0 : -1, u, 8 + 0.5 * advance);
    const MotionBounds bounds{.travel = 0,
                              .fourth_derivative = std::pow(beta * advance, 4) * size,
                              .cubic_remainder = bodies.tail[0] * size,
                              .size = size};
    ASSERT_GT(-bodies.overlap(u, 8, node), 4 * bounds.cubic_remainder) << "it is seen to be open";
    EXPECT_EQ(flag(bodies, bounds, u, v, u, v), 1) << "node " << node;
    EXPECT_TRUE(bodies.lists(node, 1)) << "node " << node;
  }
}

// ---- the constants of the proof, each where it is reached (proofs.md)

const std::vector<double> up(1, 1.0);  // shape of a slider of one node that moves as a whole
constexpr double always_unclear = 1e300;

TEST(OverlapsProof, TheErrorOfACubicIsReachedByAQuartic) {
  // The overlap c t^2 (h - t)^2 - c h^4/16 touches half way. The cubic through its ends is
  // constant: it misses c h^4/16, which is h^4/384 of the fourth derivative, 24 c.
  const Amplitudes still{};
  for (const double h : {0.5, 1.0, 2.0})
    for (const double excess : {1.0, 1.5}) {
      constexpr double c = 3;
      BodiesByHand bodies({}, {up}, 1);
      bodies.t.motion.position = 8, bodies.t.motion.time_step = h,
      bodies.t.adaptive.cubic_excess = excess;
      const MotionBounds bounds{
          .travel = 9, .fourth_derivative = 24 * c, .cubic_remainder = 0, .size = 0};
      const double exact = c * std::pow(h, 4) / 16;
      EXPECT_NEAR(widest_flagged(bodies, bounds, still, still, still, still), exact * excess,
                  1e-12 * exact)
          << "h " << h;
    }
}

TEST(OverlapsProof, ACubicsCoefficientsLieAThirdAboveAnArc) {
  // The overlap s t (h - t)/h - g touches where g = s h/4. Bernstein's coefficients go up to s h/3
  // - g: they are wide by 4/3, which is what not looking for the top costs.
  constexpr double h = 2, s = 3;
  BodiesByHand bodies({}, {up}, 1);
  bodies.t.motion.position = 8, bodies.t.motion.time_step = h;
  Amplitudes u{}, v0{}, v1{};
  v0[0] = s, v1[0] = -s;
  const MotionBounds bounds{.travel = 9, .fourth_derivative = 0, .cubic_remainder = 0, .size = 0};
  EXPECT_NEAR(widest_flagged(bodies, bounds, u, v0, u, v1), 4.0 / 3 * (s * h / 4), 1e-12);
}

TEST(OverlapsProof, ARiseIsReachedByWhatTheModesTravel) {
  const Amplitudes still{};
  constexpr double travel = 0.75;
  BodiesByHand bodies({}, {up}, 1);
  bodies.t.motion.position = 8;
  const MotionBounds bounds{
      .travel = travel, .fourth_derivative = always_unclear, .cubic_remainder = 0, .size = 0};
  EXPECT_NEAR(widest_flagged(bodies, bounds, still, still, still, still), travel, 1e-12);
}

TEST(OverlapsProof, ARiseIsReachedOnASteepFace) {
  const Amplitudes still{};
  constexpr double advance = 0.25, rise = 2;
  BodiesByHand bodies({}, {up}, 1);
  bodies.t.motion.position = 8, bodies.t.motion.advance = advance,
  bodies.t.faces.steepest_rise = rise;
  const MotionBounds bounds{
      .travel = 0, .fourth_derivative = always_unclear, .cubic_remainder = 0, .size = 0};
  EXPECT_NEAR(widest_flagged(bodies, bounds, still, still, still, still), advance * rise, 1e-12);
}

TEST(OverlapsProof, ARiseIsReachedOnTheFlankOfABentBeam) {
  // the steepest place of a wave comes when the node is half way
  constexpr double beta = 1e-3, advance = 0.5, size = 100;
  BodiesByHand bodies({{beta, 8 + 0.5 * advance + M_PI_2 / beta}}, {}, 1);
  bodies.t.motion.position = 8, bodies.t.motion.advance = advance;
  Amplitudes u{}, v{};
  u[0] = size;
  const double risen = bodies.overlap(u, 8 + advance, 0) - bodies.overlap(u, 8, 0);
  const MotionBounds bounds{
      .travel = 0, .fourth_derivative = always_unclear, .cubic_remainder = 0, .size = 0};
  const double widest = widest_flagged(bodies, bounds, u, v, u, v);
  EXPECT_GE(widest, risen * (1 - 1e-9));
  EXPECT_LE(widest, risen * (1 + 1e-6));  // (beta way)^2/24
}

TEST(OverlapsProof, WhatACubicOverAPatchLeavesOutIsReachedAtItsEdge) {
  // The first node of a group on a wide patch is a chi short of the radius that the bound is for.
  // It touches, and what is seen is open by nearly the whole bound.
  constexpr int wide = 256;
  const double radius = BodiesByHand::radius_of(wide), beta = 0.25 / radius;
  BodiesByHand bodies({{beta, 1.5 * wide}}, {}, 1, wide);
  bodies.t.motion.position = wide - width / 2;
  ASSERT_EQ(GroupPlace<HostLanes>(bodies.t.patches, Place(bodies.t.motion, 0), 0).patch, 1);
  Amplitudes u{}, v{};
  u[0] = 1;
  bodies.set_overlap(0, 0, u, bodies.t.motion.position);
  const double z = beta * (0.5 * wide + width / 2), left_out = std::cos(z) - (1 - z * z / 2);
  EXPECT_GT(left_out, 0.9 * bodies.tail[0]);
  EXPECT_LE(left_out, bodies.tail[0]);
  const MotionBounds bounds{
      .travel = 0, .fourth_derivative = 0, .cubic_remainder = bodies.tail[0], .size = 0};
  EXPECT_EQ(flag(bodies, bounds, u, v, u, v), 1);
  bodies.set_overlap(0, left_out - 1.001 * bodies.tail[0], u, bodies.t.motion.position);
  EXPECT_EQ(flag(bodies, bounds, u, v, u, v), 0) << "and no more than the bound";
}

TEST(OverlapsProof, RoundingsOfASumOverAllModesReachHalfTheirBound) {
  // A slider with all the modes that there is room for but one. Each adds half an ulp to 1, and
  // none is seen: all that they come to is lost. The bound has room for the same again in what it
  // is compared with.
  constexpr int sliding = most_modes - 1;
  SceneTables t;
  t.faces.groups = 1, t.slider.first_lane = 1, t.slider.modes = sliding, t.slider.row = width;
  std::vector<double> shape(sliding * width, 1.0), amplitude(most_modes, -0x1p-53);
  t.slider.shape = shape.data();
  std::array<double, width> sum;
  lanes.store(sum.data(),
              add_slider_displacement(lanes, t.slider, amplitude.data(), 0, Real(-1.0)));
  constexpr double lost = sliding * 0x1p-53;
  EXPECT_EQ(sum[0], -1.0);
  const MotionBounds bounds{.travel = 0, .fourth_derivative = 0, .cubic_remainder = 0, .size = 1};
  EXPECT_NEAR(bounds.rounding() / lost, 2, 0.01);
}

TEST(OverlapsProof, AnOverlapHasRoomForItsRoundings) {
  // Of roundings of a displacement: one of the value, a third of one of the rate over the step, one
  // of the series that is searched; three are taken. Of those of the faces: one when it is seen,
  // one when it is searched.
  const Amplitudes still{};
  constexpr double slack = 0.125, size = 0x1p41;
  BodiesByHand bodies({}, {up}, 1);
  bodies.t.motion.position = 8;
  const MotionBounds of_modes{
      .travel = 9, .fourth_derivative = 0, .cubic_remainder = 0, .size = size};
  EXPECT_NEAR(widest_flagged(bodies, of_modes, still, still, still, still), 3 * of_modes.rounding(),
              1e-12);
  EXPECT_GE(3, 1 + 1.0 / 3 + 1);
  bodies.t.faces.rounding = slack;
  const MotionBounds of_faces{.travel = 9, .fourth_derivative = 0, .cubic_remainder = 0, .size = 0};
  EXPECT_NEAR(widest_flagged(bodies, of_faces, still, still, still, still), 2 * slack, 1e-12);
}

TEST(OverlapsProof, ToleranceIsMoreThanTheLongestChainOfRoundings) {
  // The longest chain in an overlap's series: the packs of all modes one after the other, then the
  // lanes, then every other term of the polynomial. Each may lose half an ulp; the packs do here.
  constexpr int longest_chain = most_modes / width;
  std::vector<double> row(longest_chain * width, 1.0), amplitude(longest_chain * width, 0.0);
  std::array<Real, longest_chain> packs;
  for (int p = 0; p < longest_chain; ++p) amplitude[p * width] = p == 0 ? 1.0 : 0x1p-53;
  for (int p = 0; p < longest_chain; ++p) packs[p] = lanes.load(amplitude.data() + p * width);
  Real sum = lanes.load(row.data()) * packs[0];
  for (int p = 1; p < longest_chain; ++p)
    sum = multiply_add(lanes.load(row.data() + p * width), packs[p], sum);
  EXPECT_EQ(lanes.sum(sum), 1.0) << "all but the first are lost";
  const double lost = (longest_chain - 1) * 0x1p-53;
  const double others = (std::log2(width) + overlap_terms / 2 + 1) * 0x1p-53;

  BodiesByHand bodies({{1, 0}}, {}, 1);
  Amplitudes u{};
  u[0] = 1;
  const auto overlaps = test::overlaps_of<K>(bodies.t, bodies.s);
  const double touch = overlaps.overlap_rounding(Packs(u).u);
  EXPECT_GE(touch, lost + others);
  // a count of roundings, in packs of four 64 + 2 + 17 of 128
  EXPECT_EQ(touch / 0x1p-53, width >= 4 ? 128 : width == 2 ? 256 : 512);
  bodies.t.faces.rounding = 0.5;
  EXPECT_EQ(overlaps.overlap_rounding(Packs(u).u), 0.5 + touch) << "and those of the faces";
}

TEST(Overlaps, AContactThatBeginsDoesNotEndAtTheSameTick) {
  // Flat faces that touch, at rest: the overlap is zero, without any rounding. Where +tolerance and
  // -tolerance were both zero, a contact would begin and end there for ever.
  BodiesByHand bodies({}, {up}, 1);
  const Amplitudes still{};
  const auto overlaps = test::overlaps_of<K>(bodies.t, bodies.s);
  const double tolerance = overlaps.overlap_rounding(Packs(still).u);
  // the slider is pressed on: o = x^2/2
  const double pressed[] = {0.0, 0.0, 0.5};
  const auto crossing = [&](double sign) {
    return first_crossing(pressed, 2, sign, tolerance, 0.25 * tolerance, 1.0, 1.0);
  };
  EXPECT_GT(crossing(1.0), 0.0) << "begins";
  EXPECT_LT(crossing(1.0), 1e-30) << "begins, with no delay";
  EXPECT_GT(crossing(-1.0), 1.0) << "ends";
}

TEST(OverlapsProof, CandidateGroupsHoldForTheLongestRise) {
  // what the step can rise by, and half as much again so that the list lasts
  const Amplitudes still{};
  constexpr double travel = 0.75;
  for (const double open : {travel * (1 - 1e-9), 1.5 * travel * (1 - 1e-9), 1.6 * travel}) {
    BodiesByHand bodies({}, {up}, 1);
    SceneTables& t = bodies.t;
    t.motion.position = 8;
    bodies.set_overlap(0, -open, still, 8);
    auto overlaps = test::overlaps_of<K>(t, bodies.s);
    ModalState<HostLanes, K> now;
    for (int p = 0; p < K; ++p) now.u[p] = now.v[p] = now.square[p] = Real(0.0);
    const MotionBounds bounds{
        .travel = travel, .fourth_derivative = always_unclear, .cubic_remainder = 0, .size = 0};
    const Rise rise = overlaps.longest_rise(now.u, bounds, 1);
    overlaps.find_groups(Place(t.motion, 0), now, bounds, rise, 0);
    overlaps.evaluate(Place(t.motion, 0), now.u, now.v, Place(t.motion, 1), now.u, now.v);
    EXPECT_EQ(overlaps.flag(Place(t.motion, 0), now.u, t.motion.time_step, bounds,
                            {2 * rise.any, 2 * rise.rest}),
              open < 1.5 * travel ? 1 : 0)
        << open;
  }
}

}  // namespace
