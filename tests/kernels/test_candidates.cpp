// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "kernels/candidates.hpp"
#include "kernels/fixed/contact_step.hpp"
#include "kernels/limits.hpp"
#include "tests/bodies_by_hand.hpp"
#include "tests/kernels_of.hpp"

/// Forecasts of contact against motions that are known in closed form. Each case needs one part of
/// the proof.
namespace {

using namespace ra2d;
using test::Amplitudes, test::BodiesByHand, test::Packs, test::lanes;
using test::K, test::modes, test::width;

/// Two groups of slider nodes with wide gaps but for those that a test is about. Steps of a second.
constexpr int nodes = 2 * width;

ContactForecast forecast_contact(BodiesByHand& bodies, const Amplitudes& u, const Amplitudes& v,
                                 double last_force = 0) {
  auto candidates = test::candidates_of<K>(bodies.t, bodies.s);
  return candidates.forecast_contact(Packs(u).u, Packs(v).u, 0, 1 << 20, last_force);
}

/// Whether a node that first touches at that step is evaluated there.
testing::AssertionResult evaluates(const BodiesByHand& bodies, const ContactForecast& plan,
                                   int node, int step) {
  if (plan.kind == ContactForecast::search || plan.steps <= step)
    return testing::AssertionSuccess();
  if (plan.kind == ContactForecast::listed && bodies.lists(node, plan.count))
    return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << (plan.kind == ContactForecast::flight ? "flies " : "lists others for ") << plan.steps
         << " steps; node " << node << " touches at " << step;
}

TEST(Candidates, ANodeThatComesCloserThanTheCubicsTellIsEvaluated) {
  // Free flight at a constant rate: of a wave cos z about the patch's centre the cubics leave out
  // z^4/24, and each step comes nearer by as much more.
  for (int node = 0; node < nodes; ++node)
    for (const int step : {50, 500, 2000}) {
      const int patch = 8 + node / width * width + width / 2;
      BodiesByHand bodies({{1 / BodiesByHand::radius, patch + 0.5}}, {}, nodes);
      bodies.t.motion.position = 8;
      bodies.t.bounds.valid_steps = 4000;
      Amplitudes u{}, v{}, there{};
      v[0] = 1e-9;
      there[0] = step * v[0];
      for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? 0 : -1, there, 8);
      EXPECT_TRUE(evaluates(bodies, forecast_contact(bodies, u, v), node, step));
    }
}

TEST(Candidates, ANodeThatPassesATroughIsEvaluated) {
  // Bodies at rest: from the trough of a wave on, the deflected beam rises to the node, faster and
  // faster. The slider passes a node in so many steps, and touches half way.
  constexpr double beta = 0.02, size = 1e-3;
  for (const int steps : {60, 600, 4000})
    for (int node = 0; node < nodes; ++node) {
      BodiesByHand bodies({{beta, 8.0 + node}}, {}, nodes);
      bodies.t.motion.position = 8;
      bodies.t.motion.advance = 1.0 / steps;
      bodies.t.bounds.valid_steps = 2 * steps;
      Amplitudes u{}, v{};
      u[0] = -size;
      for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? 0 : -1, u, 8.5);
      EXPECT_TRUE(evaluates(bodies, forecast_contact(bodies, u, v), node, steps / 2));
    }
}

TEST(Candidates, AListUnderForcesYetToBeFoundCoversNoStepAtWhichAnotherNodeTouches) {
  // The slider comes down with acceleration a, and contact at node 0 tilts it, so that its last
  // node comes down with f more. Backward Euler from rest: n (n + 1)/2 (a + f) after n steps. The
  // list may be used as far as both together allow, not each by itself. The guess of the force is
  // too small.
  constexpr double a = 1e-9;
  constexpr int longest = 200, last = nodes - 1;
  std::vector<double> tilt(nodes, 0.0);
  tilt[0] = 1, tilt[last] = -1;
  int covered_by_others = 0;
  for (double share = 0.1; share < 4; share *= 1.1) {
    const double f = share * a;
    BodiesByHand bodies({}, {std::vector<double>(nodes, 1.0), tilt}, nodes);
    bodies.t.motion.position = 8;
    bodies.t.scheme.form = Form::implicit;
    bodies.t.bounds.valid_steps = longest;
    bodies.outer_acceleration[0] = a;
    bodies.t.bounds.acceleration_per_newton = 1;  // this force turns it and does no more
    const Amplitudes u{}, v{};
    for (int step = 20; step <= longest; step += 20) {
      const double distance = 0.5 * step * (step + 1.0) * (a + f);
      for (int n = 0; n < nodes; ++n) bodies.height1[n] = n == 0 ? 0 : n == last ? -distance : -1;
      const ContactForecast plan = forecast_contact(bodies, u, v, 0.2 * a);
      if (plan.kind != ContactForecast::listed || bodies.lists(last, plan.count)) continue;
      ++covered_by_others;
      ListedNodes<true> listed(plan);
      bool covered = plan.steps >= step;
      for (int n = 1; n <= step; ++n) covered = listed.covers(f, f) && covered;
      EXPECT_FALSE(covered) << "step " << step << ", force " << share;
    }
  }
  EXPECT_GT(covered_by_others, 20);
}

// ---- the constants of the proof, each where it is reached (proofs.md)

const std::vector<double> up(1, 1.0);  // shape of a slider of one node that moves as a whole
constexpr int often = 1000;            // steps until the node touches
/// Flights end a little before that: a step or two, or what squares of the distance make.
constexpr double nearly = 0.95 * often;

/// That a flight ends before the node touches, and not long before.
testing::AssertionResult ends_in_time(const ContactForecast& plan, double least = nearly) {
  if (plan.kind == ContactForecast::flight && plan.steps >= least && plan.steps <= often)
    return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << (plan.kind == ContactForecast::flight ? "flies " : "does not fly, ") << plan.steps
         << " steps, it touches at " << often;
}

/// A slider of one node over a flat face, which moves as a whole, the last mode, and waves of the
/// beam.
struct OneNode : BodiesByHand {
  std::vector<double> omega = std::vector<double>(modes, 0.0), per_norm = omega;

  explicit OneNode(std::vector<Wave> waves = {}, int wide = 1)
      : BodiesByHand(std::move(waves), {up}, 1, wide) {
    t.motion.position = 8;
    t.bounds.valid_steps = 4 * often;
    t.modes.omega = omega.data(), t.bounds.acceleration_per_energy_norm = per_norm.data();
  }
};

TEST(CandidatesProof, TheAccelerationIsReachedFromRest) {
  // n (n + 1)/2 a after n steps that take the new velocity along
  constexpr double a = 1e-9;
  OneNode bodies;
  bodies.outer_acceleration[0] = a;
  const Amplitudes still{};
  bodies.set_overlap(0, -0.5 * often * (often + 1.0) * a, still, 8);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, still, still)));
}

TEST(CandidatesProof, TheAccelerationIsReachedByAModeThatSwingsBack) {
  // V' = -omega^2 U is per_norm times the energy norm where V = 0
  constexpr double omega = 1e-5;
  OneNode bodies;
  bodies.omega[0] = bodies.per_norm[0] = omega;
  Amplitudes u{}, v{};
  u[0] = -1;
  bodies.set_overlap(0, std::cos(omega * often) - 1, u, 8);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, u, v)));
}

TEST(CandidatesProof, TheAccelerationIsReachedByAModeThatIsTurnedRound) {
  // V' = per_norm |V|; it moves away from the face at first
  constexpr double per_norm = 0.01, speed = 1e-6;
  OneNode bodies;
  bodies.per_norm[0] = per_norm;
  Amplitudes u{}, v{};
  v[0] = -speed;
  bodies.set_overlap(0, often * speed - 0.5 * often * (often + 1.0) * per_norm * speed, u, 8);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, u, v)));
}

TEST(CandidatesProof, TheWaysCurvatureIsReachedInATrough) {
  constexpr double beta = 1e-3, size = 1, distance = 0.25;
  OneNode bodies({{beta, 8}});
  bodies.t.motion.advance = distance / often;
  Amplitudes u{}, v{};
  u[0] = -size;
  bodies.set_overlap(0, 0, u, 8 + distance);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, u, v)));
}

TEST(CandidatesProof, TheWaysCurvatureIsReachedOnAFlankThatGrows) {
  // a wave that begins to swing about a place where it is 0: 2 V psi' U' is all of its acceleration
  constexpr double beta = 0.02, rate = 1e-6, distance = 0.25;
  OneNode bodies({{beta, 8 + M_PI_2 / beta}});
  bodies.t.motion.advance = distance / often;
  Amplitudes u{}, v{}, there{};
  v[0] = rate;
  there[0] = often * rate;
  bodies.set_overlap(0, 0, there, 8 + distance);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, u, v)));
}

/// A wave about the middle of a wide patch, and a node a chi short of the radius that the bounds on
/// its cubic are for.
constexpr int wide = 256;
const double radius = BodiesByHand::radius_of(wide), beta_of_wide = 0.25 / radius;
const double z = beta_of_wide * (0.5 * wide + width / 2), left_out = std::cos(z) - (1 - z * z / 2);
struct NodeAtTheEdge : OneNode {
  NodeAtTheEdge() : OneNode({{beta_of_wide, 1.5 * wide}}, wide) {
    t.motion.position = wide - width / 2;
    EXPECT_EQ(GroupPlace<HostLanes>(t.patches, Place(t.motion, 0), 0).patch, 1);
  }
};

TEST(CandidatesProof, WhatACubicLeavesOutIsReachedAtTheEdgeOfAPatch) {
  // the beam is bent and rests, the slider comes down
  NodeAtTheEdge bodies;
  Amplitudes u{}, v{};
  u[0] = 1;
  const double gap = 0.2 * bodies.tail[0];
  v[1] = gap / often;
  bodies.set_overlap(0, -gap, u, bodies.t.motion.position);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, u, v), 0.5 * often));
  // a search for the nodes that touch has to see it, too
  bodies.t.bounds.searched = Nodes::all;
  for (const double open : {0.0, 0.11 * bodies.tail[0]}) {
    bodies.set_overlap(0, -open, u, bodies.t.motion.position);
    auto candidates = test::candidates_of<K>(bodies.t, bodies.s);
    EXPECT_EQ(candidates.find_contacts(Packs(u).u, Packs(v).u, Place(bodies.t.motion, 0)),
              open == 0 ? 1 : 0);
  }
}

TEST(CandidatesProof, WhatACubicLeavesOutOfARateIsReachedAtTheEdgeOfAPatch) {
  // the slider goes away as fast as the beam is seen to come
  NodeAtTheEdge bodies;
  Amplitudes u{}, v{};
  v[0] = 1e-3;
  v[1] = -v[0] * (1 - z * z / 2);
  bodies.set_overlap(0, -often * v[0] * left_out, u, bodies.t.motion.position);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, u, v), 0.9 * often));
}

TEST(CandidatesProof, WhatACubicLeavesOutOfASlopeIsReachedAtTheEdgeOfAPatch) {
  // The beam rests, the slider goes away as fast as the slope under it is seen to raise the node.
  // What the cubic leaves out of the place itself is told apart: the node is seen where it is.
  constexpr double distance = 0.1;
  NodeAtTheEdge bodies;
  bodies.tail[0] = 0;
  bodies.t.motion.advance = distance / often;
  Amplitudes u{}, v{};
  u[0] = -1;
  const double begin = bodies.t.motion.position, seen_rise = -distance * beta_of_wide * z;
  v[1] = -seen_rise / often;
  const double rises =
      bodies.overlap(u, begin + distance, 0) - bodies.overlap(u, begin, 0) + often * v[1];
  EXPECT_GT(rises, 0);
  bodies.set_overlap(0, -rises - left_out, u, begin);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, u, v), 0.9 * often));
}

TEST(CandidatesProof, AFlightEndsWithTheRangeOfTheCandidateGroups) {
  // The list is made for 500 steps at the slider's speed, and holds for twice the travel. A longer
  // flight still uses it, and must not pass a node that stands just beyond.
  constexpr double speed = 1e-6;
  OneNode bodies;
  Amplitudes u{}, v{};
  v[0] = speed;
  bodies.t.bounds.valid_steps = often / 2;
  bodies.set_overlap(0, -often * speed * (1 + 1e-6), u, 8);
  auto candidates = test::candidates_of<K>(bodies.t, bodies.s);
  EXPECT_EQ(candidates.forecast_contact(Packs(u).u, Packs(v).u, 0, 1 << 20, 0).steps, often / 2);
  bodies.t.bounds.valid_steps = 4 * often;
  EXPECT_TRUE(ends_in_time(candidates.forecast_contact(Packs(u).u, Packs(v).u, 0, 1 << 20, 0)));
}

TEST(CandidatesProof, AListLastsUntilItsForcesUseUpTheMargin) {
  // Node 0 is pressed, f = kappa times its overlap, which tilts the slider: the last node comes
  // down by f n (n + 1)/2. It stands just beyond what the list was made for.
  constexpr double stiffness = 1e-6, overlap = 1, guess = 0.01 * stiffness;
  constexpr int last = nodes - 1;
  std::vector<double> tilt(nodes, 0.0);
  tilt[0] = 1, tilt[last] = -1;
  BodiesByHand bodies({}, {tilt}, nodes);
  bodies.t.motion.position = 8, bodies.t.bounds.valid_steps = 4 * often;
  bodies.t.contact.node_stiffness = stiffness, bodies.t.bounds.least_range = 0.01;
  const Amplitudes still{};
  for (int n = 0; n < nodes; ++n) bodies.height1[n] = n == 0 ? overlap : -9;
  double listed = 0, not_listed = 1;
  ContactForecast plan{};
  for (int i = 0; i < 60; ++i) {
    const double open = 0.5 * (listed + not_listed);
    bodies.height1[last] = -open;
    const ContactForecast found = forecast_contact(bodies, still, still, guess);
    ASSERT_EQ(found.kind, ContactForecast::listed);
    if (bodies.lists(last, found.count))
      listed = open;
    else
      not_listed = open, plan = found;
  }
  const double force = stiffness * overlap;
  const auto comes = [&](double n) { return 0.5 * n * (n + 1) * force; };
  EXPECT_GT(plan.steps, 20);
  EXPECT_LE(comes(plan.steps), not_listed) << "it touches while the list holds";
  EXPECT_GE(comes(plan.steps + 2), not_listed) << "the list could last longer";
}

TEST(CandidatesProof, AListUnderForcesYetToBeFoundCoversJustItsMargin) {
  // Where the force is found with the end of a step, the list counts the forces of the steps so
  // far.
  constexpr double force = 1e-6, guess = 0.01 * force, acceleration = 1e-9;
  constexpr int last = nodes - 1;
  std::vector<double> tilt(nodes, 0.0);
  tilt[0] = 1, tilt[last] = -1;
  BodiesByHand bodies({}, {tilt}, nodes);
  bodies.t.motion.position = 8, bodies.t.bounds.valid_steps = 4 * often,
  bodies.t.bounds.least_range = 0.01;
  bodies.t.scheme.form = Form::implicit;
  const Amplitudes still{};
  for (int n = 0; n < nodes; ++n) bodies.height1[n] = n == 0 ? 0 : -9;
  double listed = 0, not_listed = 1;
  ContactForecast plan{};
  for (int i = 0; i < 60; ++i) {
    const double open = 0.5 * (listed + not_listed);
    bodies.height1[last] = -open;
    const ContactForecast found = forecast_contact(bodies, still, still, guess);
    ASSERT_EQ(found.kind, ContactForecast::listed);
    if (bodies.lists(last, found.count))
      listed = open;
    else
      not_listed = open, plan = found;
  }
  ListedNodes<true> nodes_listed(plan);
  int n = 0;
  while (nodes_listed.covers(force, force)) ++n;
  EXPECT_GT(n, 20);
  EXPECT_LE(0.5 * n * (n + 1) * force, not_listed) << "it touches at a step that is covered";
  EXPECT_GE(0.5 * (n + 1) * (n + 2) * force, not_listed) << "more would have been covered";
  // and the motion under outer forces, in the same units
  bodies.outer_acceleration[0] = acceleration;
  const ContactForecast pushed = forecast_contact(bodies, still, still, guess);
  ASSERT_EQ(pushed.kind, ContactForecast::listed);
  EXPECT_NEAR(pushed.free_departure / pushed.departure_per_newton, 0.5 * acceleration,
              1e-12 * acceleration);
  for (const bool of_free_motion : {true, false}) {
    constexpr int exactly = 30;
    ContactForecast forecast{ContactForecast::listed, 100, 1};
    (of_free_motion ? forecast.free_departure : forecast.departure_per_newton) =
        (1 - 1e-9) / (exactly * (exactly + 1.0)) / (of_free_motion ? 1 : 0.5 * force);
    ListedNodes<true> by_hand(forecast);
    int covered = 0;
    while (by_hand.covers(of_free_motion ? 0 : force, of_free_motion ? 0 : force)) ++covered;
    EXPECT_EQ(covered, exactly);
  }
}

TEST(CandidatesProof, AListHasTheNodesThatThePathsCurvatureBrings) {
  // A node in a trough, beside one that is listed: it rises by (beta way)^2/2 until the list
  // ends.
  constexpr double beta = 1e-3, size = 1, distance = 0.25;
  constexpr int last = nodes - 1;
  BodiesByHand bodies({{beta, 8.0 + last}}, {}, nodes);
  bodies.t.motion.position = 8, bodies.t.bounds.valid_steps = 4 * often;
  bodies.t.motion.advance = distance / most_listed_steps, bodies.t.bounds.least_margin = 1e-12;
  Amplitudes u{}, v{};
  u[0] = -size;
  for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == 0 ? 1e-3 : -1, u, 8);
  const double risen = size * (1 - std::cos(beta * distance));
  for (const double open : {risen, 1.1 * risen}) {
    bodies.set_overlap(last, -open, u, 8);
    const ContactForecast plan = forecast_contact(bodies, u, v);
    ASSERT_EQ(plan.kind, ContactForecast::listed);
    EXPECT_EQ(plan.steps, most_listed_steps);
    EXPECT_EQ(bodies.lists(last, plan.count), open == risen);
  }
}

TEST(CandidatesProof, RoundingsReachHalfTheirBound) {
  // A sum over all modes loses half an ulp for each (OverlapsProof has one that does), and so does
  // each step that adds to a displacement.
  constexpr double size = 1;
  EXPECT_NEAR(rounding(0) * size / (most_modes * 0x1p-53), 2, 1e-12);
  double displacement = size;
  for (int n = 0; n < often; ++n) displacement += 0x1p-53;
  EXPECT_EQ(displacement, size);
  EXPECT_NEAR((rounding(often) - rounding(0)) * size / (often * 0x1p-53), 2, 1e-12);
}

TEST(CandidatesProof, AForecastCountsTheRoundingsOfThePosition) {
  // a steep face under a place that is off by its roundings
  OneNode bodies;
  bodies.t.faces.steepest_rise = 0x1p50;
  const Amplitudes still{};
  Amplitudes v{};
  v[0] = 1e-3;
  const double off = position_rounding(Place(bodies.t.motion, 0)) * bodies.t.faces.steepest_rise;
  bodies.set_overlap(0, -often * v[0] - off, still, 8);
  EXPECT_TRUE(ends_in_time(forecast_contact(bodies, still, v)));
}

TEST(CandidatesProof, AStretchEndsAStepBeforeANodeIsPassed) {
  OneNode bodies;
  bodies.t.motion.advance = 1.0 / often;
  const Amplitudes u{};
  Amplitudes v{};
  v[0] = 1e-9;  // so that the candidate groups hold for a while
  bodies.set_overlap(0, -1, u, 8);
  const ContactForecast plan = forecast_contact(bodies, u, v);
  EXPECT_EQ(plan.kind, ContactForecast::flight);
  EXPECT_EQ(plan.steps, often - 2) << "a step, and the roundings of the place";
}

}  // namespace
