// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernels/adaptive/overlaps.hpp"
#include "tests/bodies_by_hand.hpp"

/// Nodes that touch within a step are flagged: each case is one that a part of the proof is there for.
namespace {

using namespace ra2d;
using test::Amplitudes, test::BodiesByHand, test::Packs, test::Real, test::lanes;
using test::K, test::width;

/// How many nodes the march flags in a step of a second between two states, listed in `watch`.
int flag(BodiesByHand& bodies, const MotionBounds& bounds, const Amplitudes& u0,
         const Amplitudes& v0, const Amplitudes& u1, const Amplitudes& v1) {
  SceneTables& t = bodies.t;
  t.look_at = Nodes::all;
  const NodeContact<HostLanes, K> contact(lanes, t, bodies.s);
  const ModalSeries<HostLanes, K> series(lanes, t, bodies.s, contact);
  Overlaps<HostLanes, K> overlaps(lanes, t, bodies.s, contact, series);
  const Packs u(u0), v(v0);
  ModalState<HostLanes, K> now;
  for (int p = 0; p < K; ++p) now.u[p] = u.u[p], now.v[p] = v.u[p], now.square[p] = Real(0.0);
  overlaps.see_beginning(Place(t, 0), now);
  overlaps.see_end(Place(t, 1), Packs(u1).u, Packs(v1).u);
  return overlaps.flag(t.step, bounds, overlaps.longest_rise(now.u, bounds, 1));
}

/// Two groups of slider nodes with wide gaps but for the one that a test is about.
constexpr int nodes = 2 * width;

TEST(Overlaps, ANodeThatTheCubicsTakeForOpenIsFlagged) {
  // at rest, and just touching: of a wave cos z about the patch's centre they leave out z^4/24
  for (int node = 0; node < nodes; ++node) {
    const int patch = 8 + node / width * width + width / 2;
    BodiesByHand bodies({{1 / BodiesByHand::radius, patch + 0.5}}, {}, nodes);
    bodies.t.position = 8;
    Amplitudes u{}, v{};
    u[0] = 1e-6;
    for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? 0 : -1, u, 8);
    const MotionBounds bounds{
        .travel = 0, .fourth = 0, .cubic_remainder = bodies.tail[0] * u[0], .size = u[0]};
    EXPECT_EQ(flag(bodies, bounds, u, v, u, v), 1) << "node " << node;
    EXPECT_TRUE(bodies.watched(node, 1)) << "node " << node;
  }
}

TEST(Overlaps, ANodeThatTouchesAndIsGoneByTheEndIsFlagged) {
  // the slider falls upwards and back: overlap -0.9 h + 4 h t (1 - t)
  constexpr double h = 1e-6;
  for (int node = 0; node < nodes; ++node) {
    BodiesByHand bodies({}, {std::vector<double>(nodes, 1.0)}, nodes);
    bodies.t.position = 8;
    Amplitudes u{}, v0{}, v1{};
    v0[0] = 4 * h, v1[0] = -4 * h;
    for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? -0.9 * h : -1, u, 8);
    const MotionBounds bounds{.travel = h, .fourth = 0, .cubic_remainder = 0, .size = h};
    EXPECT_EQ(flag(bodies, bounds, u, v0, u, v1), 1) << "node " << node;
    EXPECT_TRUE(bodies.watched(node, 1)) << "node " << node;
  }
}

TEST(Overlaps, ANodeThatPassesACrestIsFlagged) {
  // bodies at rest, and a node that touches the bent beam's crest half way: nothing but the way brings
  // it there
  constexpr double beta = 0.02, way = 0.9375, size = 1e-3;
  for (int node = 0; node < nodes; ++node) {
    BodiesByHand bodies({{beta, 8 + node + 0.5 * way}}, {}, nodes);
    bodies.t.position = 8;
    bodies.t.advance = way;
    Amplitudes u{}, v{};
    u[0] = size;
    for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? 0 : -1, u, 8 + 0.5 * way);
    const MotionBounds bounds{.travel = 0,
                              .fourth = std::pow(beta * way, 4) * size,
                              .cubic_remainder = bodies.tail[0] * size,
                              .size = size};
    ASSERT_GT(-bodies.overlap(u, 8, node), 4 * bounds.cubic_remainder) << "it is seen to be open";
    EXPECT_EQ(flag(bodies, bounds, u, v, u, v), 1) << "node " << node;
    EXPECT_TRUE(bodies.watched(node, 1)) << "node " << node;
  }
}

}  // namespace
