// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "host/device/batch.hpp"
#include "host/model/bounds.hpp"
#include "host/result/record.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/gap.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "tests/dice.hpp"
#include "tests/kernels_of.hpp"
#include "tests/simulate.hpp"

namespace {

using namespace ra2d;

constexpr int width = HostLanes::width;
using Real = HostLanes::Real;

const HostLanes lanes;

SceneTables moving(double position, double advance, int windows = 1) {
  SceneTables t;
  t.motion.position = position;
  t.motion.advance = advance;
  t.motion.windows = windows;
  t.motion.window_width = 1.0 / windows;
  return t;
}

// ---- the gap ----------------------------------------------------------------------------------

TEST(Gap, IsTheDistanceLessWhatStandsTowardsTheOtherBody) {
  constexpr FaceBetweenNodes<double> on_a_node{4.0, 1e9, 0.0};
  EXPECT_EQ(gap(16.0, 1.0, 0.5, on_a_node, 2.0), 16 - 1 - 0.5 - 4 - 2);
  EXPECT_EQ(gap(16.0, -1.0, -0.5, on_a_node, -2.0), 16 + 1 + 0.5 - 4 + 2);
  EXPECT_EQ(gap(3.5, 1.0, 0.5, on_a_node, 2.0), -4) << "contact";
}

TEST(Gap, TakesTheResonatorsFaceOnTheLineBetweenItsNodes) {
  for (const double theta : {0.0, 0.25, 0.5, 0.875})
    EXPECT_EQ(gap(8.0, 0.0, 0.0, {2.0, -6.0, theta}, 0.0), 8 - (1 - theta) * 2 + theta * 6);
}

// ---- Place ------------------------------------------------------------------------------------

TEST(Place, BetweenTwoNodes) {
  const SceneTables t = moving(10.25, 0.125, 4);
  const Place start(t.motion, 0);
  EXPECT_EQ(start.position, 10.25);
  EXPECT_EQ(start.base, 10);
  EXPECT_EQ(start.theta, 0.25);
  EXPECT_EQ(start.part, 1);
  EXPECT_EQ(start.offset, 0.25 - 0.375);
  EXPECT_EQ(start.window(t.motion), 41);
  const Place later(t.motion, 5);
  EXPECT_EQ(later.position, 10.875);
  EXPECT_EQ(later.part, 3);
  EXPECT_EQ(later.offset, 0);
  EXPECT_EQ(later.window(t.motion), 43);
}

TEST(Place, OnANode) {
  const SceneTables t = moving(7, 0.25, 2);
  for (const std::int64_t step : {0, 4, 8}) {
    const Place place(t.motion, step);
    EXPECT_EQ(place.base, 7 + step / 4);
    EXPECT_EQ(place.theta, 0);
    EXPECT_EQ(place.part, 0);
    EXPECT_EQ(place.offset, -0.25);
    EXPECT_EQ(place.window(t.motion), 2 * place.base);
  }
}

TEST(Place, JustBeforeAndAfterACrossing) {
  // Whatever the number of windows: the last one ends where the next node's first begins.
  for (int windows = 1; windows <= 100; ++windows)
    for (const double node : {1.0, 2.0, 11.0, 15000.0}) {
      const SceneTables before = moving(std::nextafter(node, 0), 0, windows);
      const SceneTables after = moving(std::nextafter(node, 1e9), 0, windows);
      const Place left(before.motion, 0), on(moving(node, 0, windows).motion, 0),
          right(after.motion, 0);
      ASSERT_EQ(left.base, node - 1);
      ASSERT_LT(left.theta, 1);
      ASSERT_EQ(left.part, windows - 1);
      ASSERT_EQ(left.window(before.motion), node * windows - 1);
      ASSERT_EQ(on.window(before.motion), node * windows);
      ASSERT_EQ(right.base, node);
      ASSERT_GT(right.theta, 0);
      ASSERT_EQ(right.window(after.motion), node * windows);
    }
}

TEST(Place, WindowsFollowOneAnotherAndHoldTheirOffsets) {
  for (const int windows : {1, 2, 3, 7, 10}) {
    const SceneTables t = moving(3.7, 0.0123, windows);
    std::int64_t last = Place(t.motion, 0).window(t.motion);
    for (std::int64_t step = 1; step < 2000; ++step) {
      const Place place(t.motion, step);
      const std::int64_t window = place.window(t.motion);
      ASSERT_TRUE(window == last || window == last + 1);
      // roundings of theta windows and of the offset itself
      ASSERT_LE(std::abs(place.offset), 0.5 * t.motion.window_width * (1 + 0x1p-50));
      last = window;
    }
    EXPECT_EQ(last, std::floor((3.7 + 1999 * 0.0123) * windows));
  }
}

TEST(Place, MovingOnIsTheSameAsStandingThere) {
  // To the last bit: results must not depend on where a list began.
  const SceneTables t = moving(3.7, 0.00123, 5);
  for (std::int64_t step = 0; step < 3000; ++step) {
    const Place here(t.motion, step);
    for (std::int64_t next = step; next < step + 200; next += 13) {
      const Place there(t.motion, next);
      if (there.window(t.motion) != here.window(t.motion)) break;
      Place moved = here;
      moved.move_to(t.motion, next);
      ASSERT_EQ(moved.position, there.position);
      ASSERT_EQ(moved.theta, there.theta);
      ASSERT_EQ(moved.offset, there.offset);
      ASSERT_EQ(moved.window(t.motion), there.window(t.motion));
    }
  }
}

TEST(Place, ManyStepsAreRoundedOnce) {
  // A product and a sum, one rounding: half an ulp, whatever the number of steps.
  const SceneTables t = moving(1234.567, 1.0 / 3e5);
  for (const std::int64_t step : {1LL, 99'999'999LL, 1'234'567'891LL}) {
    const long double exact = static_cast<long double>(step) * t.motion.advance + t.motion.position;
    const Place place(t.motion, step);
    EXPECT_LE(std::abs(place.position - exact),
              0.5000001L * (std::nextafter(place.position, 1e9) - place.position));
  }
}

// ---- GroupPlace -------------------------------------------------------------------------------

struct Wide {
  static constexpr int width = 32;
};

template <class Lanes>
void every_node_lies_on_its_patch() {
  for (int patch_nodes = 1; patch_nodes <= 70; ++patch_nodes) {
    SceneTables t;
    t.patches.nodes = patch_nodes;
    t.patches.inverse_nodes = 1.0 / patch_nodes;
    const double radius = 0.5 * (patch_nodes + Lanes::width) + 1;
    t.patches.inverse_radius = 1 / radius;
    for (int base = 0; base < 3 * patch_nodes; ++base)
      for (const double theta : {0.0, 0.5, 1 - 0x1p-40})
        for (int group = 0; group < 4; ++group) {
          t.motion.position = base + theta;
          const GroupPlace<Lanes> at(t.patches, Place(t.motion, 0), group);
          ASSERT_GE(at.patch, 0);
          const double first = base + theta + group * Lanes::width - (at.patch + 0.5) * patch_nodes;
          ASSERT_NEAR(at.eta * radius, first, 4 * 0x1p-52 * radius);  // four roundings
          // the group's first and last node, and the resonator's next node behind the last
          ASSERT_GE(at.eta, -1);
          ASSERT_LE(at.eta + Lanes::width * t.patches.inverse_radius, 1 + 0x1p-50);
        }
  }
}

TEST(GroupPlace, EveryNodeLiesOnItsPatch) {
  every_node_lies_on_its_patch<HostLanes>();
  every_node_lies_on_its_patch<Wide>();
}

TEST(GroupPlace, PatchUnderTheGroupsMiddle) {
  SceneTables t;
  t.patches.nodes = 10;
  t.patches.inverse_nodes = 0.1;
  t.patches.inverse_radius = 0.125;
  t.motion.position = 20 - width / 2;  // the middle stands on node 20: the first of patch 2
  const GroupPlace<HostLanes> at(t.patches, Place(t.motion, 0), 0);
  EXPECT_EQ(at.patch, 2);
  EXPECT_EQ(at.eta, (t.motion.position - 25) / 8);
  t.motion.position = 19 - width / 2;
  EXPECT_EQ(GroupPlace<HostLanes>(t.patches, Place(t.motion, 0), 0).patch, 1);
}

TEST(GroupPlace, PatchOfAnyNodeOfALongBeam) {
  // a product with the inverse, for speed, and yet the whole quotient: right and left of every edge
  SceneTables t;
  for (const int patch_nodes : {1, 3, 7, 10, 49, 304, 1023}) {
    t.patches.nodes = patch_nodes;
    t.patches.inverse_nodes = 1.0 / patch_nodes;
    for (int patch = 1; patch < 1000000; patch += 997)
      for (const int side : {-1, 0}) {
        const int node = patch * patch_nodes + side;
        t.motion.position = node - width / 2;
        if (t.motion.position < 0) continue;
        ASSERT_EQ(GroupPlace<HostLanes>(t.patches, Place(t.motion, 0), 0).patch,
                  node / patch_nodes);
      }
  }
}

// ---- the faces --------------------------------------------------------------------------------

/// Two groups of slider nodes over a resonator with heights that are whole numbers: all sums are
/// exact.
struct Faces {
  std::vector<double> height1, height2;
  SceneTables t;

  Faces() {
    t.faces.groups = 2;
    for (int n = 0; n < 2 * width; ++n) height1.push_back(-100 - n);
    for (int n = 0; n < 2 * width + 4; ++n) height2.push_back(n * n);
    t.faces.height1 = height1.data();
    t.faces.height2 = height2.data();
  }
};

TEST(StaticOverlap, TakesTheResonatorBetweenItsNodes) {
  Faces faces;
  for (const double theta : {0.0, 0.25, 0.75})
    for (int group = 0; group < 2; ++group) {
      faces.t.motion.position = 3 + theta;
      const StaticOverlap<HostLanes> overlap(lanes, faces.t.faces, Place(faces.t.motion, 0), group);
      std::array<double, width> height, rise;
      lanes.store(height.data(), overlap.height);
      lanes.store(rise.data(), overlap.rise);
      for (int lane = 0; lane < width; ++lane) {
        const int n = group * width + lane, at = 3 + n;
        EXPECT_EQ(rise[lane], 2 * at + 1);
        EXPECT_EQ(height[lane], -gap(100.0, -1.0 * n, 0.0,
                                     {faces.height2[at], faces.height2[at + 1], theta}, 0.0));
      }
    }
}

TEST(StaticOverlap, IsTheGapOfTheFacesToWhatRoundingsAreAllowed) {
  // Both forms that the march evaluates, by groups and at single nodes, against the gap in long
  // double.
  test::Dice dice(3);
  double worst = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const double scale1 = dice.ratio(1e-3, 1), scale2 = dice.ratio(1e-3, 1);
    const double delta = dice.one_in(3) ? 0.0 : dice.uniform(-1, 1);
    std::vector<double> h1(width), height1, height2(width + 2);
    double most1 = 0, most2 = 0;
    for (double& h : h1) {
      h = dice.uniform(-scale1, scale1);
      height1.push_back(h - delta);  // as the tables hold it
      most1 = std::max(most1, std::abs(height1.back()));
    }
    for (double& h : height2) {
      h = dice.uniform(-scale2, scale2);
      most2 = std::max(most2, std::abs(h));
    }
    const double bound = face_rounding(most1 + most2);
    SceneTables t = moving(dice.uniform(0, 1), 0);
    t.faces.groups = 1;
    t.faces.height1 = height1.data(), t.faces.height2 = height2.data();
    const Place place(t.motion, 0);
    std::array<double, width> height;
    lanes.store(height.data(), StaticOverlap<HostLanes>(lanes, t.faces, place, 0).height);
    for (int n = 0; n < width; ++n) {
      std::array<double, 2> face{height1[n] + height2[n], height2[n + 1] - height2[n]};
      SceneState s;
      s.caches.node_face = face.data();
      const auto contact = test::node_contact_of<1>(t, s);
      const long double exact =
          -gap<long double>(delta, h1[n], 0, {height2[n], height2[n + 1], place.theta}, 0);
      for (const double overlap : {height[n], contact.face(0, place.theta)}) {
        const auto off = static_cast<double>(std::abs(overlap - exact));
        ASSERT_LE(off, bound) << "trial " << trial << ", node " << n;
        worst = std::max(worst, off / bound);
      }
    }
  }
  // of the 16 roundings they make five, the march's own sums the others
  EXPECT_GT(worst, 1.0 / 16);
  RecordProperty("worst", std::to_string(worst));
}

TEST(SliderDisplacement, AddsModeByMode) {
  SceneTables t;
  t.slider.row = 2 * width;
  t.slider.first_lane = 1;
  t.slider.modes = 2;
  std::vector<double> shape;
  for (int k = 0; k < 2; ++k)
    for (int n = 0; n < 2 * width; ++n) shape.push_back(k == 0 ? 1 : n);
  t.slider.shape = shape.data();
  const double amplitude[] = {1e6, 0.5, 0.25};  // the resonator's stands first and is not its own
  for (int group = 0; group < 2; ++group) {
    std::array<double, width> out;
    lanes.store(out.data(), add_slider_displacement(lanes, t.slider, amplitude, group, Real(4.0)));
    for (int lane = 0; lane < width; ++lane)
      EXPECT_EQ(out[lane], 4.5 + 0.25 * (group * width + lane));
  }
}

// ---- edges, through the march -----------------------------------------------------------------

/// Two steel strips at rest, a millimetre between their nodes. Heights in whole 2^-20 m are exact.
constexpr double unit_height = 0x1p-20;

Scene strips(Nodes nodes) {
  Scene s;
  s.spacing = 0x1p-10;
  s.time.step = 1e-9;
  s.duration = 20e-9;
  s.output.rate = 1e9;
  s.start = 16 * s.spacing;
  s.gap = 0;
  s.contact.stiffness = 1e12;
  s.time.nodes = nodes;
  s.resonator.support = Support::free;
  s.resonator.length = 256 * s.spacing;
  s.resonator.thickness = 0.002;
  s.resonator.width = 0.02;
  s.resonator.young = 210e9;
  s.resonator.density = 7800;
  s.resonator.modes = 3;
  s.slider = s.resonator;
  s.slider.support = Support::rigid;
  s.slider.length = 20 * s.spacing;
  return s;
}

SurfaceSpec one_peak(double at, double height, double half_width) {
  SurfaceSpec surface;
  surface.kind = SurfaceKind::peaks;
  surface.peaks = {{at, height, half_width}};
  return surface;
}

class Edges : public testing::TestWithParam<Nodes> {};
INSTANTIATE_TEST_SUITE_P(Gap, Edges, testing::Values(Nodes::all, Nodes::candidates),
                         [](const auto& info) {
                           return info.param == Nodes::all ? "AllNodes" : "Candidates";
                         });

TEST_P(Edges, OpenGapIsNoContact) {
  Scene s = strips(GetParam());
  s.gap = std::numeric_limits<double>::denorm_min();
  const test::Recording run = test::simulate(s);
  EXPECT_EQ(run.end.contact_steps, 0);
  EXPECT_EQ(run.end.most_nodes, 0);
  EXPECT_EQ(run.end.shocks_begun, 0);
}

TEST_P(Edges, TouchingAtExactlyZeroIsContactWithoutForce) {
  const test::Recording run = test::simulate(strips(GetParam()));
  EXPECT_EQ(run.end.contact_steps, 20);
  EXPECT_EQ(run.end.most_nodes, 21) << "all nodes";
  ASSERT_EQ(run.end.open_shocks.size(), 1);
  EXPECT_EQ(run.end.open_shocks[0].peak, 0);
  EXPECT_EQ(run.end.open_shocks[0].start, 0);
  EXPECT_EQ(run.end.energy, 0);
  for (const double nodes : run.samples.nodes) EXPECT_EQ(nodes, 21);
  for (const double force : run.samples.force) EXPECT_EQ(force, 0);
}

/// The first sample's force and number of nodes; the shock's place in chi after one step.
struct FirstContact {
  double force, nodes, place, stiffness;
};
FirstContact first_contact(Scene s) {
  s.duration = s.time.step;
  const test::Recording run = test::simulate(s);
  EXPECT_EQ(run.end.open_shocks.size(), 1);
  const OpenShock shock = run.end.open_shocks.empty() ? OpenShock{} : run.end.open_shocks[0];
  return {run.samples.force.at(0), run.samples.nodes.at(0), shock.moment / shock.impulse,
          run.model.node_stiffness};
}

TEST_P(Edges, OneNode) {
  Scene s = strips(GetParam());
  s.slider.surface = one_peak(7 * s.spacing, 3 * unit_height, 0.5 * s.spacing);
  s.gap = unit_height;
  const FirstContact contact = first_contact(s);
  EXPECT_EQ(contact.nodes, 1);
  EXPECT_EQ(contact.force, contact.stiffness * 2 * unit_height);
  EXPECT_EQ(contact.place, 16 + 7);
}

TEST_P(Edges, FirstNodeOfBoth) {
  Scene s = strips(GetParam());
  s.start = 0;
  s.slider.surface = one_peak(0, 3 * unit_height, 0.5 * s.spacing);
  s.gap = unit_height;
  const FirstContact contact = first_contact(s);
  EXPECT_EQ(contact.nodes, 1);
  EXPECT_EQ(contact.force, contact.stiffness * 2 * unit_height);
  EXPECT_EQ(contact.place, 0);
}

TEST_P(Edges, LastNodeOfTheResonator) {
  // The slider's last node over the resonator's: behind it there is no next node to interpolate to.
  Scene s = strips(GetParam());
  s.start = s.resonator.length - s.slider.length;
  s.resonator.surface = one_peak(s.resonator.length, 3 * unit_height, 0.5 * s.spacing);
  s.gap = unit_height;
  const FirstContact contact = first_contact(s);
  EXPECT_EQ(contact.nodes, 1);
  EXPECT_EQ(contact.force, contact.stiffness * 2 * unit_height);
  EXPECT_EQ(contact.place, 256);
}

TEST_P(Edges, BetweenTwoNodesOfTheResonator) {
  // A peak of the resonator a quarter of chi behind the slider's node: a quarter of it is lost.
  Scene s = strips(GetParam());
  s.start = 16.25 * s.spacing;
  s.resonator.surface = one_peak(20 * s.spacing, 8 * unit_height, 0.5 * s.spacing);
  s.gap = 4 * unit_height;
  const FirstContact contact = first_contact(s);
  EXPECT_EQ(contact.nodes, 1);
  EXPECT_EQ(contact.force, contact.stiffness * 2 * unit_height);
  EXPECT_EQ(contact.place, 20.25);
}

}  // namespace
