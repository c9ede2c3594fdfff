// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/model/bounds.hpp"
#include "host/surface/spline.hpp"
#include "kernels/adaptive/flight.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/group_sweep.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/dice.hpp"
#include "tests/filled.hpp"
#include "tests/kernels_of.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

/// The tables that the march reads, as the host fills them: that they are fine, long and wide
/// enough for what the kernels make of them.
namespace {

using namespace ra2d;
using test::Dice, test::Filled, test::lanes, test::packs, test::width;

using test::eps;
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
  // Through patches, series and windows, as the march goes, against the modes themselves. Each
  // shape meets the roundings of its series (four for every term, and three of its place, which
  // turn it by beta radius), two ulp that the window leaves out, and on the other side those of
  // beta x.
  Dice dice(1);
  for (const Support support : {Support::pinned, Support::free})
    for (const double spacing : {2e-5, 1e-4, 1e-3}) {
      const Filled f(strip(support, 16, spacing));
      std::vector<double> shape(4 * packs * width), face(2);
      for (int trial = 0; trial < 300; ++trial) {
        const int node = dice.pick(f.t.faces.nodes);
        SceneTables at = f.t;
        at.motion.position =
            dice.uniform(0, f.model.resonator_height.size() - f.t.faces.nodes - 1.0);
        const Place place(at.motion, 0);
        expand_node<HostLanes, packs>(lanes, at.faces, at.slider, at.patches, place, node,
                                      shape.data(), face.data());
        for (const double side : {-0.5, 0.5}) {
          const double o = side * at.motion.window_width;
          const double x =
              (place.base + node + (place.part + 0.5) * at.motion.window_width + o) * spacing;
          for (int k = 0; k < f.modes(); ++k) {
            const auto c = [&](int m) { return shape[m * packs * width + k]; };
            const double exact = shape_at(f.mode(k), x);
            const double roundings =
                4 * f.t.patches.terms + 3 + 8 + 16 + 2 * f.mode(k).shape->wave_number() * x;
            ASSERT_NEAR(c(0) + o * (c(1) + o * (c(2) + o * c(3))), exact,
                        roundings * eps * f.size(k))
                << "mode " << k << ", spacing " << spacing << ", x " << x;
          }
        }
      }
    }
}

TEST(FilledTables, OfRowsGiveTheOverlapsOfTheModel) {
  // By groups, to what the cubics of the patches leave out, and at single nodes, to roundings: of
  // each mode's shape as in MakeANodesShapesToRoundings, and of one more product.
  Dice dice(4);
  for (const Support support : {Support::rigid, Support::free})
    for (int trial = 0; trial < 10; ++trial) {
      test::ArealScene scene = test::small_areal_scene(support, trial % 2 == 0 ? 20 : 1);
      scene.start = dice.uniform(0, 0.04);  // of one mode a patch holds a whole row, mostly
      scene.side = dice.uniform(0, 0.03);
      scene.block_heights = test::rough_map(10, 1 + 2 * width + trial % 3 * (width - 1), 1e-6, 7);
      scene.block.length = (static_cast<double>(scene.block_heights[0].size()) - 1) * scene.spacing;
      const Filled f(test::areal_march(scene, test::schemes[1], 1e-8, 1).model);
      const int row = static_cast<int>(f.n.padded_row()), nodes = f.model.row_nodes();
      ASSERT_GT(row, nodes) << "the last node of a row is no neighbour of the next row's first";
      ASSERT_LE(row, nodes + width);
      ASSERT_LT(f.n.row_heights + static_cast<int>(f.model.position),
                f.model.row_heights() + row + 2 * width + std::max(tile_nodes, width))
          << "what lies behind the slider is left out";
      std::vector<double> resonator_u, slider_u;
      std::array<double, packs * width> all{};
      for (int k = 0; k < f.modes(); ++k)
        resonator_u.push_back(all[k] = dice.uniform(-1, 1) * 1e-7);
      for (std::size_t k = 0; k < f.model.slider.modes.size(); ++k)
        slider_u.push_back(all[f.modes() + k] = dice.uniform(-1, 1) * 1e-8);
      Real u[packs];
      double size = 0, left_out = 0;
      for (int p = 0; p < packs; ++p) u[p] = lanes.load(all.data() + p * width);
      for (int k = 0; k < packs * width; ++k) {
        size += f.t.bounds.largest_shape[k] * std::abs(all[k]);
        left_out += f.t.bounds.cubic_remainder[k] * std::abs(all[k]);
      }
      const std::vector<double> expected = overlaps(f.model, resonator_u, slider_u);
      const double roundings = 300 * eps * size + f.t.faces.rounding;
      const Place place(f.t.motion, 0);
      std::vector<double> amplitudes(2 * packs * width);
      GroupSweep<HostLanes, packs> sweep(lanes, f.t.faces, f.t.slider, f.t.patches, place,
                                         amplitudes.data(), u);
      SceneState s;
      std::vector<double> shape(4 * packs * width), face(2);
      for (int group = 0; group < f.t.faces.groups; ++group) {
        std::array<double, width> seen;
        lanes.store(seen.data(), sweep.overlap(group).overlap);
        for (int lane = 0; lane < width; ++lane) {
          const int node = group * width + lane, j = node / row, i = node % row;
          ASSERT_EQ(lane < nodes_left(f.t.faces, group, width), i < nodes);
          if (i >= nodes) {
            EXPECT_LT(seen[lane], -1e29) << "padding";
            continue;
          }
          ASSERT_NEAR(seen[lane], expected[j * nodes + i], left_out + roundings)
              << "row " << j << ", node " << i;
          expand_node<HostLanes, packs>(lanes, f.t.faces, f.t.slider, f.t.patches, place, node,
                                        shape.data(), face.data());
          double sum = face[0] + place.theta * face[1];
          for (int k = 0; k < packs * width; ++k) {
            const auto c = [&](int m) { return shape[m * packs * width + k]; };
            sum += all[k] *
                   (c(0) + place.offset * (c(1) + place.offset * (c(2) + place.offset * c(3))));
          }
          ASSERT_NEAR(sum, expected[j * nodes + i], roundings);
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
        ASSERT_EQ(f.t.faces.nodes, nodes);
        const int last = static_cast<int>(f.model.resonator_height.size()) - nodes;
        for (int base = 0; base <= last; ++base) {
          SceneTables at = f.t;
          at.motion.position = base;
          for (int group = 0; group < f.t.faces.groups; ++group)
            ASSERT_LT(GroupPlace<HostLanes>(at.patches, Place(at.motion, 0), group).patch,
                      f.n.patches)
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
  const auto flight = test::flight_of<packs>(f.t);
  for (int k = 0; k < f.modes(); ++k) {
    std::array<double, packs * width> amplitude{};
    amplitude[k] = 1e-6;
    Real u[packs], v[packs];
    for (int p = 0; p < packs; ++p) u[p] = lanes.load(amplitude.data() + p * width), v[p] = 0.0;
    const double half_a_period = std::numbers::pi / f.mode(k).omega;
    const MotionBounds bounds = flight.bounds(u, v, half_a_period);
    const double distance = 2 * amplitude[k] * f.t.bounds.largest_shape[k];
    EXPECT_GE(bounds.travel, distance * (1 - 8 * eps)) << "mode " << k;
    EXPECT_LE(bounds.travel, distance * (1 + 8 * eps)) << "mode " << k << ": it can be no more";
  }
}

// ---- the constants of the proofs, each where it is reached (proofs.md)

Scene adaptive_strip(int modes, double spacing) {
  Scene s = strip(Support::pinned, modes, spacing);
  s.time.scheme = SchemeKind::adaptive;
  s.speed = 0.5;
  return s;
}

TEST(FilledProof, OneWindowLessWouldLeaveOutTooMuch) {
  // of cos(beta x) over half a window: (beta width/2)^4/24
  struct Case {
    double tolerance;  // 0: fixed steps
    Faces faces;
    double allowed;
  };
  for (const Case& each : {Case{0.0, Faces::linear, 0x1p-51}, Case{1e-3, Faces::linear, 1e-13},
                           Case{1e-8, Faces::linear, 1e-13}, Case{1e-12, Faces::linear, 0x1p-51},
                           Case{0.0, Faces::smooth, 0x1p-51}, Case{1e-3, Faces::smooth, 1e-11},
                           Case{1e-7, Faces::smooth, 1e-12}, Case{1e-10, Faces::smooth, 1e-14}}) {
    SCOPED_TRACE(testing::Message() << "tolerance " << each.tolerance);
    Scene s = strip(Support::pinned, 16, 2e-3);
    if (each.tolerance > 0) {
      s = adaptive_strip(16, 2e-3);
      s.time.tolerance = each.tolerance;
    }
    s.faces = each.faces;
    const Filled f(s);
    const auto left_out = [&](int windows) {
      return std::pow(0.5 * f.mode(f.modes() - 1).shape->wave_number() * s.spacing / windows, 4) /
             24;
    };
    ASSERT_GE(f.t.motion.windows, 20) << "so many that one of them is little";
    EXPECT_LE(left_out(f.t.motion.windows), each.allowed);
    EXPECT_GT(left_out(f.t.motion.windows - 1), each.allowed);
    EXPECT_EQ(f.t.motion.window_width * f.t.motion.windows, 1);
  }
}

TEST(FilledProof, FourTermsLessWouldLeaveOutTooMuch) {
  // of a patch's series at its edge: z^terms/terms!, against half an ulp
  for (const double spacing : {2e-5, 1e-4, 1e-3}) {
    const Filled f(strip(Support::pinned, 16, spacing));
    const double z =
        f.mode(f.modes() - 1).shape->wave_number() * spacing / f.t.patches.inverse_radius;
    const auto left_out = [&](int terms) { return std::pow(z, terms) / std::tgamma(terms + 1.0); };
    EXPECT_LE(left_out(f.t.patches.terms), 0x1p-53);
    EXPECT_GT(left_out(f.t.patches.terms - 4), 0x1p-53);
    // the outermost node of a group stands a chi short of it
    EXPECT_EQ(1 / f.t.patches.inverse_radius, 0.5 * (f.t.patches.nodes + width) + 1);
  }
}

TEST(FilledProof, ACubicsExcessIsReachedByAnExponentialBehindTheEnd) {
  // exp(beta (x - L)) is 1 at the most on the beam. A patch about L + radius reaches to L + 2
  // radius, and its cubic there to nearly exp(2 beta radius). On the beam itself no cubic and no
  // derivative of one is more than exp(beta radius): there the excess, 1.65 where nodes are fine,
  // is wide by its root. That is 6 % of a step's length.
  for (const double spacing : {2e-5, 1e-4, 1e-3}) {
    const Filled f(adaptive_strip(16, spacing));
    const double z =
        f.mode(f.modes() - 1).shape->wave_number() * spacing / f.t.patches.inverse_radius;
    const double at_the_edge = std::exp(z) * (1 + z * (1 + z / 2 * (1 + z / 3)));
    EXPECT_GE(f.t.adaptive.cubic_excess, at_the_edge);
    EXPECT_LE(f.t.adaptive.cubic_excess, at_the_edge * (1 + z * z * z * z / 24));
    double on_the_beam = 0;
    for (int i = 0; i <= 100; ++i)
      for (int j = 0; j <= 100; ++j) {
        // a centre so far behind the end, and from it back to a place on the beam
        const double behind = z * i / 100, d = -z + (z - behind) * j / 100, e = std::exp(behind);
        for (const double size :
             {e * (1 + d * (1 + d / 2 * (1 + d / 3))), e * (1 + d * (1 + d / 2)), e * (1 + d), e})
          on_the_beam = std::max(on_the_beam, std::abs(size));
      }
    EXPECT_NEAR(on_the_beam, std::exp(z), 1e-9);
    EXPECT_NEAR(f.t.adaptive.cubic_excess / (on_the_beam * on_the_beam), 1, 1e-9);
  }
}

TEST(FilledProof, WhatCubicsLeaveOutIsReachedAboutACrest) {
  // of a wave cos z, z = beta radius at the edge of a patch: z^4/24, and of its slope z^3/6, but
  // for z^2/30 and z^2/20 of that
  for (const double spacing : {2e-5, 1e-4}) {
    const Filled f(strip(Support::pinned, 16, spacing));
    for (int k = 8; k < f.modes(); ++k) {
      const double beta = f.mode(k).shape->wave_number(),
                   z = beta * spacing / f.t.patches.inverse_radius;
      const double size = f.t.bounds.largest_shape[k];
      const double value = size * (std::cos(z) - (1 - z * z / 2));
      const double slope = size * beta * (z - std::sin(z));
      EXPECT_GE(f.t.bounds.cubic_remainder[k], value * (1 - 1e-9)) << "mode " << k;
      EXPECT_LE(f.t.bounds.cubic_remainder[k], value * (1 + z * z / 29)) << "mode " << k;
      EXPECT_GE(f.t.bounds.cubic_slope_remainder[k], slope * (1 - 1e-9)) << "mode " << k;
      EXPECT_LE(f.t.bounds.cubic_slope_remainder[k], slope * (1 + z * z / 19)) << "mode " << k;
    }
  }
}

TEST(FilledProof, SlopeAndCurvatureOfTheBeamAreReached) {
  for (const Support support : {Support::pinned, Support::free}) {
    const Filled f(strip(support, 6, 1e-3));
    for (int k = 0; k < f.modes(); ++k) {
      double slope = 0, curvature = 0;
      for (int i = 0; i <= 4000; ++i) {
        double d[3];
        f.mode(k).shape->evaluate(f.model.resonator.length * i / 4000, 3, d);
        slope = std::max(slope, std::abs(d[1])), curvature = std::max(curvature, std::abs(d[2]));
      }
      EXPECT_GE(f.t.bounds.largest_slope[k], slope * (1 - 16 * eps)) << "mode " << k;
      EXPECT_GE(f.t.bounds.largest_curvature[k], curvature * (1 - 16 * eps)) << "mode " << k;
      // A free mode's parts are largest apart, and its exponential grows on behind the end:
      // LargestParts has each alone.
      const bool exact = support == Support::pinned || f.mode(k).shape->wave_number() == 0;
      const double behind =
          2 * f.mode(k).shape->wave_number() * f.t.motion.spacing / f.t.patches.inverse_radius;
      const double parts = exact ? 1 + 1e-5 : 2.5 * std::exp(behind);
      EXPECT_LE(f.t.bounds.largest_slope[k], slope * parts) << "mode " << k;
      EXPECT_LE(f.t.bounds.largest_curvature[k], curvature * parts) << "mode " << k;
    }
  }
}

TEST(FilledProof, AccelerationsPerEnergyAndNewtonAreReachedByTheFirstStep) {
  // Semi-implicit, from rest: U is a force's u_f after a step, which the bound has as tau^2 of it.
  // Of a slow mode that is 1/m, but for omega tau.
  Scene s = strip(Support::pinned, 4, 1e-3);
  s.time.scheme = SchemeKind::backward_euler;
  s.resonator.load = 3;
  s.resonator.moving_forces = {{.force = -7, .speed = 30, .start = 0}};
  const Filled f(s);
  for (int k = 0; k < f.modes(); ++k) {
    const BodyMode& mode = f.mode(k);
    const double turn = mode.omega * s.time.step, largest = mode.shape->size();
    ASSERT_LT(turn, 0.02);
    const double per_force = 1 / (mode.mass * (1 + 2 * mode.zeta * turn + turn * turn));
    const double force = std::abs(f.model.resonator.load[k]) + 7 * largest;
    EXPECT_GE(f.t.bounds.outer_acceleration[k], force * per_force * (1 - 16 * eps)) << "mode " << k;
    EXPECT_LE(f.t.bounds.outer_acceleration[k], force * per_force * 1.03) << "mode " << k;
  }
  // Where the force and the node stand at the same place of both bodies. Between the places that
  // are looked at the bound adds up to a 32nd of all modes, which are twice what is reached.
  double per_newton = 0, jerk = 0;
  std::size_t lane = 0;
  for (const Body* body : {&f.model.resonator, &f.model.slider}) {
    double most = 0, most_jerk = 0;
    for (int i = 0; i <= 1000; ++i) {
      double sum = 0, sum_jerk = 0;
      for (std::size_t k = 0; k < body->modes.size(); ++k) {
        const BodyMode& mode = body->modes[k];
        const double turn = mode.omega * s.time.step;
        const double one = std::pow(shape_at(mode, i * body->length / 1000), 2) /
                           (mode.mass * (1 + 2 * mode.zeta * turn + turn * turn));
        sum += one;
        sum_jerk += one * f.t.bounds.acceleration_per_energy_norm[lane + k];
      }
      most = std::max(most, sum), most_jerk = std::max(most_jerk, sum_jerk);
    }
    per_newton += most, jerk += most_jerk;
    lane += body->modes.size();
  }
  EXPECT_GE(f.t.bounds.acceleration_per_newton, per_newton * (1 - 16 * eps));
  EXPECT_LE(f.t.bounds.acceleration_per_newton, per_newton * 1.06);
  EXPECT_GE(f.t.bounds.jerk_per_newton, jerk * (1 - 16 * eps));
  EXPECT_LE(f.t.bounds.jerk_per_newton, jerk * 1.06);
}

TEST(FilledProof, TheFourthDerivativeOfWhatALoadBendsIsReached) {
  // at rest under its load a pinned mode is a wave that the node passes: (beta speed)^4 of it at
  // its crest
  Scene s = adaptive_strip(1, 1e-3);
  s.resonator.load = 3;
  const Filled f(s);
  const double rest = f.model.resonator.load[0] / (f.mode(0).mass * std::pow(f.mode(0).omega, 2));
  const double crest = shape_at(f.mode(0), 0.5 * s.resonator.length);
  const double fourth_derivative =
      std::pow(f.mode(0).shape->wave_number() * s.speed, 4) * std::abs(rest * crest);
  EXPECT_GT(fourth_derivative, 0);
  EXPECT_NEAR(f.t.flight.fourth_derivative_at_rest, fourth_derivative,
              64 * eps * fourth_derivative);
  EXPECT_NEAR(f.t.flight.rest[0], rest, 8 * eps * std::abs(rest));
}

TEST(FilledProof, FacesCountAsHighAsTheyAre) {
  Scene s = strip(Support::pinned, 2, 1e-3);
  s.gap = 0.25;
  const Filled f(s);  // flat: h_1 - delta is all that there is
  EXPECT_EQ(f.t.faces.rounding, face_rounding(0.25));
  EXPECT_EQ(f.t.contact.tolerance, f.t.faces.rounding);
  // Five roundings of half an ulp are counted: of h_1 - delta, a face's two terms, its rise, and
  // the sum of both faces. A bound of 32 leaves six times that to the sums that a displacement is
  // added in.
  EXPECT_NEAR(face_rounding(1) / (5 * 0x1p-53), 6.4, 1e-12);
  EXPECT_EQ(f.t.faces.highest_overlap, -0.25);
}

/// The bound on what a cell exceeds both its nodes by is reached.
TEST(FilledProof, TheSagOfACellIsReached) {
  Scene s = test::plate_scene(3, 0.004, 0.004);
  s.faces = Faces::smooth;
  s.time = {SchemeKind::exact};
  s.time.step = 1e-7;
  s.gap = 0;
  Model m = make_model(s);
  // both faces parabolas of curvature -2: each stands 1/4 above its chord half way
  for (int n = 0; n < m.nodes(); ++n) m.slider_height.edit()[n] = -1e-7 * std::pow(n - 50.5, 2);
  m.slider_curvature = spline_curvatures(m.slider_height);
  const Filled f(m);
  const double summit = 0, ends = -1e-7 * 0.25;
  EXPECT_GE(f.t.faces.sag1[50], summit - ends);
  EXPECT_LT(0.9 * f.t.faces.sag1[50], summit - ends);
  // a mode's, of a sine at its crest: its curvature over an eighth of a cell's square
  const double beta = f.mode(2).shape->wave_number();
  const double sag = 0.125 * std::pow(beta * s.spacing, 2);
  EXPECT_NEAR(f.t.bounds.cell_sag[2], sag * f.mode(2).shape->largest(),
              1e-6 * f.t.bounds.cell_sag[2]);
  EXPECT_GE(f.t.faces.sag_per_travel, sag);
}

}  // namespace
