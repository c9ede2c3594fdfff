// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/peers/evaluated_nodes.hpp"
#include "bench/peers/plane_equations.hpp"
#include "host/body/beam.hpp"
#include "tests/dice.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

/// The peers' equations against direct evaluation of every sum, psi by psi.
namespace {

using namespace ra2d;
using namespace ra2d::peers;

using test::eps;

struct Case {
  std::string name;
  Support resonator, slider;
  double slider_length;  // m, of 4e-5 m nodes: an even or an odd number
};

class PeerEquations : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(
    Supports, PeerEquations,
    testing::Values(Case{"PinnedUnderRigid", Support::pinned, Support::rigid, 0.008},
                    Case{"PinnedUnderFree", Support::pinned, Support::free, 0.00804},
                    Case{"PinnedUnderPinned", Support::pinned, Support::pinned, 0.008},
                    Case{"FreeUnderFree", Support::free, Support::free, 0.008},
                    Case{"FreeUnderPinned", Support::free, Support::pinned, 0.00804},
                    Case{"RigidUnderFree", Support::rigid, Support::free, 0.008},
                    Case{"FreeUnderOneAsLong", Support::free, Support::free, 0.06}),
    [](const auto& info) { return info.param.name; });

Model model_of(const Case& c) {
  Scene s = test::plate_scene(c.resonator == Support::rigid ? 0 : 12, c.slider_length, 1e-3);
  s.resonator.support = c.resonator;
  s.resonator.surface = test::gaussian(8e-6, 1e-3, 2);
  s.slider = test::steel(c.slider_length, 1e-3, 0.02, 0.02, c.slider == Support::rigid ? 0 : 3);
  s.slider.support = c.slider;
  s.slider.surface = test::gaussian(8e-6, 1e-3, 1);
  s.start = 0;
  s.speed = c.slider_length < 0.06 ? 0.3 : 0;
  s.gap = 2e-5;
  s.contact.stiffness = 1e15;
  return make_model(s);
}

/// A state in which every mode of either body displaces it by about a micrometre.
struct State {
  std::vector<double> u2, u1, y;

  State(const Model& model, test::Dice& dice) {
    for (const BodyMode& mode : model.resonator.modes)
      u2.push_back(dice.uniform(-1e-6, 1e-6) / mode.shape->largest());
    for (const BodyMode& mode : model.slider.modes)
      u1.push_back(dice.uniform(-1e-6, 1e-6) / mode.shape->largest());
    y = u2;
    y.insert(y.end(), u1.begin(), u1.end());
    const std::size_t modes = y.size();
    for (std::size_t k = 0; k < modes; ++k) y.push_back(300 * dice.uniform(-1, 1) * y[k]);
  }
};

/// Bound on the roundings of an overlap: of each psi those of its phase beta x, a few more, and one
/// for each term of the sum; of the faces those of their sum and of the position in chi.
double overlap_roundings(const Model& model, const State& state) {
  double sum = 4 * (model.delta + 1e-4);
  const auto add = [&](const Body& beam, const std::vector<double>& u) {
    for (std::size_t k = 0; k < u.size(); ++k)
      sum += std::abs(u[k]) * beam.modes[k].shape->largest() *
             (2 * beam.modes[k].shape->wave_number() * beam.length + 16 +
              static_cast<double>(u.size()));
  };
  add(model.resonator, state.u2);
  add(model.slider, state.u1);
  double rise = 0;
  for (std::size_t i = 1; i < model.resonator_height.size(); ++i)
    rise = std::max(rise, std::abs(model.resonator_height[i] - model.resonator_height[i - 1]));
  return eps * (sum + 2 * static_cast<double>(model.resonator_height.size()) * rise);
}

/// The model with its slider where it is at a time.
Model at_time(Model model, double t) {
  model.position += t * model.scene.speed / model.scene.spacing;
  return model;
}

std::vector<double> times(const Model& model) {
  if (model.scene.speed == 0) return {0};
  const double room = static_cast<double>(model.resonator_height.size()) - model.nodes() - 2;
  const double last = room * model.scene.spacing / model.scene.speed;
  // within windows, at a crossing, back again
  return {0, 1e-7, 3.217e-3, 3.218e-3, 40 * model.scene.spacing / model.scene.speed, last, 1e-3};
}

TEST_P(PeerEquations, OverlapsAreThoseOfTheHost) {
  const Model model = model_of(GetParam());
  PlaneEquations equations(model);
  test::Dice dice(1);
  for (const double t : times(model)) {
    const State state(model, dice);
    const std::vector<double> expected = overlaps(at_time(model, t), state.u2, state.u1);
    const double tolerance = overlap_roundings(model, state);
    Eigen::ArrayXd all;
    equations.overlaps(equations.place(t), state.y.data(), all);
    ASSERT_EQ(all.size(), model.nodes());
    SomeNodes some;
    some.list = {0, model.nodes() / 2, (model.nodes() - 1) / 2, 17, model.nodes() - 1};
    Eigen::VectorXd few;
    equations.overlaps(equations.place(t), some, state.y.data(), few);
    for (int n = 0; n < model.nodes(); ++n)
      ASSERT_NEAR(all[n], expected[n], tolerance) << "node " << n << " at " << t << " s";
    for (int i = 0; i < 5; ++i)
      ASSERT_NEAR(few[i], expected[some.list[i]], tolerance) << "node " << some.list[i];
  }
}

TEST_P(PeerEquations, RatesAndForcesAreTheSumsThatDefineThem) {
  const Model model = model_of(GetParam());
  PlaneEquations equations(model);
  test::Dice dice(2);
  const int modes = equations.modes();
  const auto modes2 = static_cast<int>(model.resonator.modes.size());
  for (const double t : times(model)) {
    const State state(model, dice);
    const double position = at_time(model, t).position, chi = model.scene.spacing;
    SomeNodes some;
    some.list = {3, model.nodes() / 2, model.nodes() - 1};
    const Place& place = equations.place(t);
    Eigen::VectorXd rates;
    const double* v = state.y.data() + modes;
    equations.rates(place, some, state.y.data(), v, rates);
    Rows shapes;
    equations.shapes(place, some, shapes);
    const Eigen::VectorXd node_force = Eigen::Vector3d(1, -2, 3);
    std::vector<double> force(modes, 0.0), one_by_one(modes, 0.0), expected(modes, 0.0);
    equations.project(place, some, node_force, force.data());
    for (int i = 0; i < 3; ++i)
      equations.project(place, some.list[i], node_force[i], one_by_one.data());
    for (int i = 0; i < 3; ++i) {
      const int n = some.list[i];
      const auto left = static_cast<std::size_t>(position + n);
      const std::size_t right = std::min(left + 1, model.resonator_height.size() - 1);
      double rate =
          model.scene.speed / chi * (model.resonator_height[right] - model.resonator_height[left]);
      double size = std::abs(rate);
      for (int k = 0; k < modes; ++k) {
        double psi[2];
        const bool on_slider = k >= modes2;
        const BodyMode& mode =
            on_slider ? model.slider.modes[k - modes2] : model.resonator.modes[k];
        mode.shape->evaluate((on_slider ? n : position + n) * chi, 2, psi);
        const double phase = mode.shape->wave_number() * model.resonator.length;
        const double tolerance = eps * mode.shape->largest() * (2 * phase + 16);
        EXPECT_NEAR(shapes(i, k), psi[0], tolerance);
        expected[k] -= node_force[i] * psi[0];
        rate += v[k] * psi[0];
        if (!on_slider) rate += model.scene.speed * state.y[k] * psi[1];
        size += (16 + phase) * (std::abs(v[k]) * mode.shape->largest() +
                                model.scene.speed * std::abs(state.y[k]) *
                                    (mode.shape->wave_number() * 2 * mode.shape->largest() +
                                     std::abs(beam_shape(mode).slope)));
      }
      EXPECT_NEAR(rates[i], rate, 8 * eps * size);
    }
    for (int k = 0; k < modes; ++k) {
      const double most = k < modes2 ? model.resonator.modes[k].shape->largest()
                                     : model.slider.modes[k - modes2].shape->largest();
      const double beta = k < modes2 ? model.resonator.modes[k].shape->wave_number() : 0;
      const double tolerance = 6 * eps * most * (2 * beta * model.resonator.length + 16);
      EXPECT_NEAR(force[k], expected[k], tolerance);
      EXPECT_NEAR(one_by_one[k], expected[k], tolerance);
    }
  }
}

TEST_P(PeerEquations, EveryNodeThatTouchesIsEvaluated) {
  const Model model = model_of(GetParam());
  PlaneEquations equations(model);
  test::Dice dice(3);
  const int modes = equations.modes();
  int listed = 0, touching = 0;
  for (int i = 0; i < 40; ++i) {
    const State state(model, dice);
    const double t = times(model).back() * dice.uniform(0, 1);
    EvaluatedNodes evaluated(equations, Nodes::candidates);
    const double time = 2e-5;
    EXPECT_TRUE(evaluated.prepare(t, state.y.data(), time));
    listed += static_cast<int>(evaluated.list().size());
    for (const double share : {0.1, 0.5, 1.0}) {
      // on along the velocities, faster than they are now, as far as the list promises
      std::vector<double> later = state.y;
      for (int k = 0; k < modes; ++k) later[k] += 1.5 * share * time * state.y[modes + k];
      ASSERT_TRUE(evaluated.covered(t, state.y.data(), t + share * time, later.data()));
      Eigen::ArrayXd overlap;
      equations.overlaps(equations.place(t + share * time), later.data(), overlap);
      for (int n = 0; n < model.nodes(); ++n) {
        if (overlap[n] <= 0) continue;
        ++touching;
        EXPECT_TRUE(std::binary_search(evaluated.list().begin(), evaluated.list().end(), n));
      }
    }
  }
  EXPECT_GT(touching, 0) << "nothing is tested";
  EXPECT_LT(listed, 40 * model.nodes() / 2) << "a list of all is none";
}

}  // namespace
