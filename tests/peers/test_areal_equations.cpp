// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/peers/areal_equations.hpp"
#include "bench/peers/evaluated_nodes.hpp"
#include "bench/peers/peers.hpp"
#include "host/base/errors.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/dice.hpp"
#include "tests/numbers.hpp"

/// The peers' equations of areal scenes against direct evaluation of every sum, psi by psi, and
/// dopri5 on them against the reference in long double.
namespace {

using namespace ra2d;
using namespace ra2d::peers;

using test::eps;

struct Case {
  std::string name;
  test::ArealScene scene;
};

class PeerArealEquations : public testing::TestWithParam<Case> {
 protected:
  PeerArealEquations() : model_{test::areal_march(GetParam().scene, 1e-6, 0.01).model} {}

  /// A state of some tenths of a micrometre, most of them in the first modes.
  std::vector<double> state(test::Dice& dice) const {
    std::vector<double> y;
    for (const Body* body : {&model_.resonator, &model_.slider})
      for (const BodyMode& mode : body->modes)
        y.push_back(dice.uniform(-2e-7, 2e-7) / (mode.shape->largest() * (1.0 + y.size())));
    const std::size_t modes = y.size();
    for (std::size_t k = 0; k < modes; ++k) y.push_back(3000 * dice.uniform(-1, 1) * y[k]);
    return y;
  }
  Model at_time(double t) const {
    Model model = model_;
    model.position += t * model.scene.speed / model.scene.spacing;
    return model;
  }
  std::vector<double> host_overlaps(double t, const std::vector<double>& y) const {
    const auto modes2 = static_cast<std::ptrdiff_t>(model_.resonator.modes.size());
    const auto modes1 = static_cast<std::ptrdiff_t>(model_.slider.modes.size());
    return overlaps(at_time(t), {y.begin(), y.begin() + modes2},
                    {y.begin() + modes2, y.begin() + modes2 + modes1});
  }
  /// Bound on the roundings of an overlap: of the phase of each factor of a psi, of the sum of so
  /// many, and of the faces and of the position in chi between two heights.
  double overlap_roundings(const std::vector<double>& y) const {
    double sum = 4 * (model_.delta + 4e-5), rise = 0;
    const std::size_t modes = y.size() / 2, modes2 = model_.resonator.modes.size();
    for (std::size_t k = 0; k < modes; ++k) {
      const ModeShape& shape =
          *(k < modes2 ? model_.resonator.modes[k] : model_.slider.modes[k - modes2]).shape;
      sum += std::abs(y[k]) * shape.largest() *
             (4 * shape.wave_number() * model_.resonator.length +
              4 * shape.across_rate() * model_.scene.resonator.width + 16 +
              static_cast<double>(modes));
    }
    for (std::size_t i = 1; i < model_.resonator_height.size(); ++i)
      rise = std::max(rise, std::abs(model_.resonator_height[i] - model_.resonator_height[i - 1]));
    return eps * (sum + 2 * model_.row_heights() * rise);
  }
  /// Within windows, at a crossing, back again, and with the block's end behind the plate's
  /// heights.
  std::vector<double> times() const {
    const double window = model_.scene.spacing / model_.scene.speed;
    const double room = model_.row_heights() - model_.row_nodes() - model_.position;
    return {0,      0.3 * window,       17.6 * window, 18 * window, (room - 1.5) * window,
            window, (room + 2) * window};
  }

  const Model model_;
};
INSTANTIATE_TEST_SUITE_P(Scenes, PeerArealEquations,
                         testing::Values(Case{"Rigid", test::rigid_block()},
                                         Case{"Free", test::free_block()},
                                         Case{"SixtyModes", test::sixty_modes()},
                                         Case{"ManyNodes", test::many_nodes()}),
                         [](const auto& info) { return info.param.name; });

TEST_P(PeerArealEquations, OverlapsAreThoseOfTheHost) {
  ArealEquations all(model_), some(model_);
  test::Dice dice(1);
  ASSERT_EQ(all.nodes(), model_.nodes());
  const int row = model_.row_nodes();
  const std::vector<int> list = {0, 3, row - 1, row, 2 * row + 5, model_.nodes() - 1};
  some.evaluate_only(list);
  for (const double t : times()) {
    const std::vector<double> y = state(dice), expected = host_overlaps(t, y);
    const double tolerance = overlap_roundings(y);
    const Eigen::VectorXd& overlap = all.overlaps(t, y.data());
    ASSERT_EQ(overlap.size(), model_.nodes());
    for (int n = 0; n < model_.nodes(); ++n)
      ASSERT_NEAR(overlap[n], expected[n], tolerance) << "node " << n << " at " << t << " s";
    const Eigen::VectorXd& few = some.overlaps(t, y.data());
    ASSERT_EQ(few.size(), list.size());
    for (std::size_t i = 0; i < list.size(); ++i)
      ASSERT_NEAR(few[static_cast<Eigen::Index>(i)], expected[list[i]], tolerance) << list[i];
  }
}

TEST_P(PeerArealEquations, ForcesAreTheSumsThatDefineThem) {
  ArealEquations equations(model_);
  test::Dice dice(2);
  const double chi = model_.scene.spacing;
  const std::size_t modes2 = model_.resonator.modes.size();
  int touched = 0;
  for (const double t : times()) {
    const std::vector<double> y = state(dice);
    const std::vector<double> overlap = host_overlaps(t, y);
    const std::size_t modes = y.size() / 2;
    std::vector<double> force(modes, 0.0), expected(modes, 0.0);
    equations.evaluate_only({});
    equations.contact(t, y.data(), force.data());
    EXPECT_EQ(force, expected) << "no node is evaluated";
    std::vector<int> list;
    double sum = 0, sums = 0;  // N, of the forces; of those by which roundings may move them
    for (int n = 0; n < model_.nodes(); ++n) {
      if (n % 3 == 1) continue;
      list.push_back(n);
      if (!(overlap[n] > 0)) continue;
      ++touched;
      const double f = model_.node_stiffness * overlap[n];
      sum += f;
      sums += model_.node_stiffness * overlap_roundings(y);
      const int row = n / model_.row_nodes(), i = n % model_.row_nodes();
      for (std::size_t k = 0; k < modes; ++k)
        expected[k] -=
            f * (k < modes2 ? shape_at(model_.resonator.modes[k], (at_time(t).position + i) * chi,
                                       model_.side + model_.eta(row))
                            : shape_at(model_.slider.modes[k - modes2], i * chi, model_.eta(row)));
    }
    equations.evaluate_only(list);
    equations.contact(t, y.data(), force.data());
    for (std::size_t k = 0; k < modes; ++k) {
      const ModeShape& shape =
          *(k < modes2 ? model_.resonator.modes[k] : model_.slider.modes[k - modes2]).shape;
      const double phase = shape.wave_number() * model_.resonator.length +
                           shape.across_rate() * model_.scene.resonator.width;
      EXPECT_NEAR(force[k], expected[k], shape.largest() * (sums + eps * (4 * phase + 64) * sum))
          << k;
    }
  }
  EXPECT_GT(touched, 20);
}

TEST_P(PeerArealEquations, EveryNodeThatTouchesIsEvaluated) {
  ArealEquations equations(model_);
  test::Dice dice(3);
  std::int64_t listed = 0, touching = 0;
  constexpr int states = 20;
  for (int s = 0; s < states; ++s) {
    const std::vector<double> y = state(dice);
    const std::size_t modes = y.size() / 2;
    const double t = times()[4] * dice.uniform(0, 1), time = 2e-5;
    EvaluatedNodes evaluated(equations, Nodes::candidates);
    EXPECT_TRUE(evaluated.prepare(t, y.data(), time));
    listed += static_cast<std::int64_t>(evaluated.list().size());
    EXPECT_TRUE(std::is_sorted(evaluated.list().begin(), evaluated.list().end()));
    for (const double share : {0.0, 0.1, 0.5, 1.0}) {
      // on along the velocities, faster than they are now, as far as the list promises
      std::vector<double> later = y;
      for (std::size_t k = 0; k < modes; ++k) later[k] += 1.5 * share * time * y[modes + k];
      ASSERT_TRUE(evaluated.covered(t, y.data(), t + share * time, later.data()));
      const std::vector<double> overlap = host_overlaps(t + share * time, later);
      for (int n = 0; n < model_.nodes(); ++n) {
        if (overlap[n] <= 0) continue;
        ++touching;
        EXPECT_TRUE(std::binary_search(evaluated.list().begin(), evaluated.list().end(), n)) << n;
      }
    }
  }
  EXPECT_GT(touching, 20);
  EXPECT_LT(listed, states * std::int64_t{model_.nodes()} / 2) << "most can be left out";
}

constexpr double duration = 5e-4;  // s

struct Solution {
  test::ArealState end;
  double steps;
};
Solution solve(const test::ArealScene& scene, double tolerance, Nodes nodes) {
  const test::Started started = test::areal_march(scene, 1e-6, duration);
  const PeerResult r = march_peer(started.model, started.start,
                                  {.integrator = Integrator::dopri5,
                                   .nodes = nodes,
                                   .tolerance = tolerance,
                                   .until = duration});
  Solution out{{}, static_cast<double>(r.steps)};
  out.end.plate_u = r.resonator_u, out.end.plate_v = r.resonator_v;
  out.end.block_u = r.slider_u, out.end.block_v = r.slider_v;
  return out;
}

/// How far a scene amplifies what is off at its beginning: measured by a gap that differs by one
/// part in 1e9.
double amplification(const test::ArealScene& scene, const test::ArealReference& reference) {
  test::ArealScene moved = scene;
  moved.gap *= 1 + 1e-9;
  const test::ArealReference other = test::areal_reference(moved, {duration});
  return test::state_distance(scene, reference.states[0], other.states[0]) / 1e-9;
}

class PeerArealMarch : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Scenes, PeerArealMarch,
                         testing::Values(Case{"Rigid", test::rigid_block()},
                                         Case{"Free", test::free_block()},
                                         Case{"OneBump", test::one_bump()}),
                         [](const auto& info) { return info.param.name; });

/// Every step makes the error that it may, amplified.
TEST_P(PeerArealMarch, ErrorsFallWithTheTolerance) {
  const test::ArealScene& scene = GetParam().scene;
  const test::ArealReference reference = test::areal_reference(scene, {duration});
  EXPECT_GT(reference.closings, 10);
  const double amplified = std::max(1.0, amplification(scene, reference));
  for (const double tolerance : {1e-6, 1e-8, 1e-10})
    for (const Nodes nodes : {Nodes::candidates, Nodes::all}) {
      const Solution s = solve(scene, tolerance, nodes);
      EXPECT_LT(test::state_distance(scene, reference.states[0], s.end),
                s.steps * tolerance * amplified)
          << tolerance;
    }
}

/// A force crosses the plate, under a block that touches nothing.
TEST(PeerAreal, MovingForcesAndLoadsDriveTheModes) {
  test::ArealScene scene = test::free_block();
  scene.gap = 1;
  scene.forces = {{.force = 3, .speed = 20, .start = 0.01, .y = 0.011},
                  {.force = -2, .speed = -8, .start = 0.005, .y = 0.03}};
  const test::ArealReference reference = test::areal_reference(scene, {duration});
  EXPECT_EQ(reference.closings, 0);
  for (const double tolerance : {1e-6, 1e-9}) {
    const Solution s = solve(scene, tolerance, Nodes::candidates);
    EXPECT_LT(test::state_distance(scene, reference.states[0], s.end), s.steps * tolerance);
  }
  // once both have left the plate, the block's load is all
  const Model model = test::areal_march(scene, 1e-6, 5e-3).model;
  const ArealEquations equations(model);
  std::vector<double> force(equations.modes()), expected(model.resonator.modes.size(), 0.0);
  equations.outer_force(3e-3, force.data());
  expected.insert(expected.end(), model.slider.load.begin(), model.slider.load.end());
  EXPECT_EQ(force, expected);
}

TEST(PeerAreal, OnlyDopri5TakesThem) {
  const test::Started started = test::areal_march(test::rigid_block(), 1e-6, duration);
  for (const Integrator integrator : {Integrator::cvode_adams, Integrator::cvode_bdf})
    EXPECT_THROW(march_peer(started.model, started.start,
                            {.integrator = integrator, .tolerance = 1e-6, .until = duration}),
                 RequestError);
}

}  // namespace
