// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "kernels/adaptive/flight.hpp"
#include "kernels/contact/node_contact.hpp"
#include "tests/dice.hpp"
#include "tests/filled.hpp"
#include "tests/scenes.hpp"

/// The tables that the march reads, as the host fills them: that they are fine, long and wide enough
/// for what the kernels make of them.
namespace {

using namespace ra2d;
using test::Dice, test::Filled, test::lanes, test::packs, test::width;

constexpr double eps = std::numeric_limits<double>::epsilon();
using Real = HostLanes::Real;

Scene strip(Support support, int modes, double spacing) {
  Scene s = test::strip_scene(modes, 0.02, 0.02, 0.02);
  s.resonator.support = support;
  s.spacing = spacing;
  s.gap = 1e-3;
  s.contact.stiffness = 1e13;
  s.time.step = 1e-7;
  s.duration = 1e-4;
  s.output.rate = 1e5;
  return s;
}

TEST(FilledTables, MakeANodesShapesToRoundings) {
  // Through patches, series and windows, as the march goes, against the modes themselves. Each shape
  // meets the roundings of its series (four for every term, and three of its place, which turn it by
  // beta radius), two ulp that the window leaves out, and on the other side those of beta x.
  Dice dice(1);
  for (const Support support : {Support::pinned, Support::free})
    for (const double spacing : {2e-5, 1e-4, 1e-3}) {
      const Filled f(strip(support, 16, spacing));
      std::vector<double> shape(4 * packs * width), face(2);
      for (int trial = 0; trial < 300; ++trial) {
        const int node = dice.pick(f.t.nodes);
        SceneTables at = f.t;
        at.position = dice.uniform(0, f.model.resonator_height.size() - f.t.nodes - 1.0);
        const Place place(at, 0);
        expand_node<HostLanes, packs>(lanes, at, place, node, shape.data(), face.data());
        for (const double side : {-0.5, 0.5}) {
          const double o = side * at.window_width;
          const double x = (place.base + node + (place.part + 0.5) * at.window_width + o) * spacing;
          for (int k = 0; k < f.modes(); ++k) {
            const auto c = [&](int m) { return shape[m * packs * width + k]; };
            double exact;
            evaluate(f.mode(k), f.model.resonator.length, x, 1, &exact);
            const double roundings = 4 * f.t.terms + 3 + 8 + 16 + 2 * f.mode(k).beta * x;
            ASSERT_NEAR(c(0) + o * (c(1) + o * (c(2) + o * c(3))), exact,
                        roundings * eps * f.size(k))
                << "mode " << k << ", spacing " << spacing << ", x " << x;
          }
        }
      }
    }
}

TEST(FilledTables, HaveAPatchUnderEveryGroup) {
  // from one end of the resonator to the other, with patches as wide as the beam and as a few nodes
  for (const int modes : {1, 2, 16})
    for (const double spacing : {5e-4, 1e-3, 2e-3})
      for (int nodes = 2; nodes < 2 * width + 2; ++nodes) {
        Scene s = strip(Support::pinned, modes, spacing);
        s.slider.length = (nodes - 1) * spacing;
        s.start = 0;
        const Filled f(s);
        ASSERT_EQ(f.t.nodes, nodes);
        const int last = static_cast<int>(f.model.resonator_height.size()) - nodes;
        for (int base = 0; base <= last; ++base) {
          SceneTables at = f.t;
          at.position = base;
          for (int group = 0; group < f.t.groups; ++group)
            ASSERT_LT(GroupPlace<HostLanes>(at, Place(at, 0), group).patch, f.n.patches)
                << modes << " modes, " << nodes << " nodes at " << base;
        }
      }
}

TEST(FilledTables, BoundAFlightFromOneSideToTheOther) {
  // A mode without damping, let go at U, is at -U half a period later: no tighter bound is true.
  Scene s = strip(Support::pinned, 6, 1e-3);
  s.resonator.damping = 0;
  s.time.scheme = SchemeKind::adaptive;
  const Filled f(s);
  const Flight<HostLanes, packs> flight(lanes, f.t);
  for (int k = 0; k < f.modes(); ++k) {
    std::array<double, packs * width> amplitude{};
    amplitude[k] = 1e-6;
    Real u[packs], v[packs];
    for (int p = 0; p < packs; ++p) u[p] = lanes.load(amplitude.data() + p * width), v[p] = 0.0;
    const double half_a_period = std::numbers::pi / f.mode(k).omega;
    const MotionBounds bounds = flight.bounds(u, v, half_a_period);
    const double way = 2 * amplitude[k] * f.t.largest_shape[k];
    EXPECT_GE(bounds.travel, way * (1 - 8 * eps)) << "mode " << k;
    EXPECT_LE(bounds.travel, way * (1 + 8 * eps)) << "mode " << k << ": it can be no more";
  }
}

}  // namespace
