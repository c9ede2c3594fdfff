// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernels/candidates.hpp"
#include "kernels/fixed/contact_step.hpp"
#include "tests/bodies_by_hand.hpp"

/// What a look ahead promises, against motions known in closed form: each case is one that a part of the
/// proof is there for.
namespace {

using namespace ra2d;
using test::Amplitudes, test::BodiesByHand, test::Packs, test::lanes;
using test::K, test::width;

/// Two groups of slider nodes with wide gaps but for those that a test is about. Steps of a second.
constexpr int nodes = 2 * width;

Outlook look_ahead(BodiesByHand& bodies, const Amplitudes& u, const Amplitudes& v,
                   double last_force = 0) {
  Candidates<HostLanes, K> candidates(lanes, bodies.t, bodies.s);
  return candidates.look_ahead(Packs(u).u, Packs(v).u, 0, 1 << 20, last_force);
}

/// Whether a node that touches first at that step is looked at there.
testing::AssertionResult sees(const BodiesByHand& bodies, const Outlook& plan, int node, int step) {
  if (plan.kind == Outlook::look || plan.steps <= step) return testing::AssertionSuccess();
  if (plan.kind == Outlook::watch && bodies.watched(node, plan.count))
    return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << (plan.kind == Outlook::fly ? "flies " : "watches others for ") << plan.steps
         << " steps; node " << node << " touches at " << step;
}

TEST(Candidates, ANodeThatComesNearerThanTheCubicsTellIsSeen) {
  // Free flight at a constant rate: of a wave cos z about the patch's centre the cubics leave out z^4/24,
  // and each step comes nearer by as much more.
  for (int node = 0; node < nodes; ++node)
    for (const int step : {50, 500, 2000}) {
      const int patch = 8 + node / width * width + width / 2;
      BodiesByHand bodies({{1 / BodiesByHand::radius, patch + 0.5}}, {}, nodes);
      bodies.t.position = 8;
      bodies.t.longest_look = 4000;
      Amplitudes u{}, v{}, there{};
      v[0] = 1e-9;
      there[0] = step * v[0];
      for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? 0 : -1, there, 8);
      EXPECT_TRUE(sees(bodies, look_ahead(bodies, u, v), node, step));
    }
}

TEST(Candidates, ANodeThatPassesATroughIsSeen) {
  // Bodies at rest: from the trough of a wave on the bent beam rises to the node, faster and faster. The
  // slider passes a node in so many steps, and touches half way.
  constexpr double beta = 0.02, size = 1e-3;
  for (const int steps : {60, 600, 4000})
    for (int node = 0; node < nodes; ++node) {
      BodiesByHand bodies({{beta, 8.0 + node}}, {}, nodes);
      bodies.t.position = 8;
      bodies.t.advance = 1.0 / steps;
      bodies.t.longest_look = 2 * steps;
      Amplitudes u{}, v{};
      u[0] = -size;
      for (int n = 0; n < nodes; ++n) bodies.set_overlap(n, n == node ? 0 : -1, u, 8.5);
      EXPECT_TRUE(sees(bodies, look_ahead(bodies, u, v), node, steps / 2));
    }
}

TEST(Candidates, AListUnderForcesYetToBeFoundCoversNoStepAtWhichAnotherNodeTouches) {
  // The slider comes down, a everywhere, and contact at node 0 tilts it, so that its last node comes
  // down by f more. Backward Euler from rest: n (n + 1)/2 (a + f) after n steps. The list may be used
  // as far as both together allow, not each by itself. What is guessed of the force is less than comes.
  constexpr double a = 1e-9;
  constexpr int longest = 200, last = nodes - 1;
  std::vector<double> tilt(nodes, 0.0);
  tilt[0] = 1, tilt[last] = -1;
  int watched = 0;
  for (double share = 0.1; share < 4; share *= 1.1) {
    const double f = share * a;
    BodiesByHand bodies({}, {std::vector<double>(nodes, 1.0), tilt}, nodes);
    bodies.t.position = 8;
    bodies.t.form = Form::implicit;
    bodies.t.longest_look = longest;
    bodies.push[0] = a;
    bodies.yield[0] = 0;  // this force turns it and does no more
    const Amplitudes u{}, v{};
    for (int step = 20; step <= longest; step += 20) {
      const double way = 0.5 * step * (step + 1.0) * (a + f);
      for (int n = 0; n < nodes; ++n) bodies.height1[n] = n == 0 ? 0 : n == last ? -way : -1;
      const Outlook plan = look_ahead(bodies, u, v, 0.2 * a);
      if (plan.kind != Outlook::watch || bodies.watched(last, plan.count)) continue;
      ++watched;
      ListedNodes listed(plan);
      bool covered = plan.steps >= step;
      for (int n = 1; n <= step; ++n) covered = listed.covers(f, f) && covered;
      EXPECT_FALSE(covered) << "step " << step << ", force " << share;
    }
  }
  EXPECT_GT(watched, 20);
}

}  // namespace
