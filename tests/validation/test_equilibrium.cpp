// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "host/base/decompositions.hpp"
#include "host/base/errors.hpp"
#include "tests/effort.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

/// scene.initial = "static": the start is an equilibrium under load and contact, and stays one.
namespace ra2d::test {
namespace {

constexpr double ulp = std::numeric_limits<double>::epsilon();

Scene resting_block() {
  Scene s = plate_scene(8, 0.012, 0.012);
  s.start = 0.021;
  s.output.rate = 1e5;
  s.initial = Initial::statics;
  s.slider.support = Support::free;
  s.slider.load_is_weight = true;
  s.contact.stiffness = 1e14;
  return s;
}

/// Forces at rest, computed here independently.
struct Balance {
  double worst = 0;     // N m^(-1/2), largest residual of a mode's equation
  double rounding = 0;  // N m^(-1/2), what the roundings of the gaps make of it
  double force = 0;     // N, of contact
  double moment = 0;    // N m, of the contact forces about the slider's middle
  int nodes = 0;
};

Balance balance(const Model& m, const ModalStart& start) {
  const double chi = m.scene.spacing;
  Balance b;
  std::vector<double> residual2, residual1;
  double size = 0, heights = std::abs(m.delta), psi_sum = 0;
  const auto elastic = [&](const Body& beam, const std::vector<double>& u,
                           std::vector<double>& residual) {
    for (std::size_t k = 0; k < u.size(); ++k) {
      const double elastic_force =
          beam.modes[k].mass * beam.modes[k].omega * beam.modes[k].omega * u[k];
      residual.push_back(beam.load[k] - elastic_force);
      size += std::abs(beam.load[k]) + std::abs(elastic_force);
      heights += std::abs(u[k]) * beam.modes[k].shape->largest();
    }
  };
  elastic(m.resonator, start.resonator_u, residual2);
  elastic(m.slider, start.slider_u, residual1);
  for (const double h : m.slider_height) heights = std::max(heights, std::abs(h));
  const std::vector<double> over = overlaps(m, start.resonator_u, start.slider_u);
  for (int n = 0; n < m.nodes(); ++n) {
    if (over[n] <= 0) continue;
    const double f = m.node_stiffness * over[n];
    ++b.nodes;
    b.force += f;
    b.moment += f * (n * chi - m.scene.slider.length / 2);
    double psi = 0;
    const auto add_contact_force = [&](const Body& beam, double x, std::vector<double>& residual) {
      for (std::size_t k = 0; k < residual.size(); ++k) {
        beam.modes[k].shape->evaluate(x, 1, &psi);
        residual[k] -= f * psi;
        psi_sum += std::abs(psi);
      }
    };
    add_contact_force(m.resonator, m.scene.start + n * chi, residual2);
    add_contact_force(m.slider, n * chi, residual1);
  }
  for (const auto* residual : {&residual2, &residual1})
    for (const double r : *residual) b.worst = std::max(b.worst, std::abs(r));
  // every gap in contact is right to 8 roundings of what it is the difference of, every sum to 64
  // of its terms
  b.rounding = 8 * ulp * heights * m.node_stiffness * psi_sum + 64 * ulp * size;
  return b;
}

void expect_balanced(const Model& model, const ModalStart& start) {
  const Balance b = balance(model, start);
  ASSERT_GT(b.nodes, 0);
  EXPECT_EQ(static_cast<int>(start.loaded_nodes.size()), b.nodes);
  EXPECT_NEAR(start.contact_force, b.force, 1e-12 * b.force);
  // Newton's method ends when the potential no longer feels a step: what is left of a residual is
  // then within 1e-9 of the forces, or their roundings.
  EXPECT_LT(b.worst, b.rounding + 1e-9 * b.force * model.resonator.modes[0].shape->largest());
  if (model.scene.slider.support != Support::free) return;
  const double weight = model.slider.load_force, length = model.slider.length;
  // the rigid modes' residuals are force and moment, but for their norms
  const double bound = b.rounding * std::sqrt(length) + 1e-9 * weight;
  EXPECT_LT(bound, 1e-6 * weight) << "the roundings leave nothing to test";
  EXPECT_NEAR(b.force, weight, bound);
  EXPECT_NEAR(b.moment, 0, bound * length);
}

TEST(Equilibrium, FreeSliderCarriesItsWeightOnRoughFaces) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
    for (const double stiffness : {1e11, 1e13, 1e15}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", kappa " << stiffness);
      Scene s = resting_block();
      s.contact.stiffness = stiffness;
      s.resonator.surface = gaussian(5e-6, 1e-3, 2 * seed);
      s.slider.surface = gaussian(5e-6, 1e-3, 2 * seed + 1);
      const Model model = make_model(s);
      const ModalStart start = make_start(model);
      expect_balanced(model, start);
      if (stiffness == 1e13) {
        EXPECT_NEAR(start.contact_force, model.slider.load_force, 1e-9 * model.slider.load_force);
      }
    }
}

/// Every kind of face on every kind of face.
Scene resting_scene(int index, std::mt19937_64& random) {
  Scene s = resting_block();
  s.resonator.modes = 1 + static_cast<int>(random() % 20);
  s.slider.modes = static_cast<int>(random() % 13);
  if (random() % 4 == 0) s.resonator.support = Support::rigid;
  s.slider.thickness = std::vector<double>{1e-4, 1e-3, 0.012, 0.05}[random() % 4];
  const auto face = [&](int kind) {
    switch (kind) {
      case 0:
        return SurfaceSpec{};
      case 1:
        return peaks(
            {{.at = 1e-3 * static_cast<double>(random() % 12), .height = 1e-5, .half_width = 2e-4},
             {.at = 6e-3, .height = 1e-5, .half_width = 4e-4}});
      default:
        return gaussian(5e-6, 5e-4, random());
    }
  };
  s.resonator.surface = face(index % 3);
  s.slider.surface = face(index / 3 % 3);
  s.slider.load_is_weight = index % 2 == 0;
  if (random() % 3 == 0) s.gap = std::pow(10.0, -static_cast<double>(random() % 6));  // to fall
  s.slider.load = std::pow(10.0, static_cast<double>(random() % 7) - 3);
  return s;
}

TEST(Equilibrium, BeginsWithTheEnergyOfItsModesAndItsSprings) {
  Scene s = resting_block();
  s.gap.reset();
  s.contact.stiffness = 1e12;
  s.resonator.surface = gaussian(1e-6, 5e-4, 3);
  const Model m = make_model(s);
  const ModalStart start = make_start(m);
  double elastic = 0, springs = 0;
  for (std::size_t k = 0; k < start.resonator_u.size(); ++k)
    elastic += 0.5 * m.resonator.modes[0].mass *
               std::pow(m.resonator.modes[k].omega * start.resonator_u[k], 2);
  for (const double over : overlaps(m, start.resonator_u, start.slider_u))
    springs += 0.5 * m.node_stiffness * std::pow(std::max(0.0, over), 2);
  EXPECT_GT(springs, 1e-3 * elastic);
  EXPECT_NEAR(start.contact_energy, springs, 1e-9 * springs);
  EXPECT_NEAR(start.energy, elastic + springs, 1e-9 * springs + 1e-12 * elastic);
}

TEST(Equilibrium, IsFoundUnderMultipliersOnAnyFaces) {
  std::mt19937_64 random(5);
  for (int i = 0; i < draws(180); ++i) {
    SCOPED_TRACE(i);
    Scene s = resting_scene(i, random);
    s.contact.law = ContactLaw::multiplier;
    const Model model = make_model(s);
    const ModalStart start = make_start(model);
    const double load = model.slider.load_force;
    EXPECT_NEAR(start.contact_force, load, 1e-9 * load);
    const std::vector<double> over = overlaps(model, start.resonator_u, start.slider_u);
    double size = std::abs(model.delta);
    for (std::size_t k = 0; k < start.resonator_u.size(); ++k)
      size += std::abs(start.resonator_u[k]) * model.resonator.modes[k].shape->largest();
    for (std::size_t k = 0; k < start.slider_u.size(); ++k)
      size += std::abs(start.slider_u[k]) * model.slider.modes[k].shape->largest();
    // flat on flat nothing moves: a hundredth of an atom's nucleus will do
    EXPECT_LE(*std::max_element(over.begin(), over.end()), 1e-12 * size + 1e-17);
  }
}

TEST(Equilibrium, IsFoundUnderSpringsOfAnyStiffness) {
  std::mt19937_64 random(6);
  int refused = 0;
  for (int i = 0; i < draws(90); ++i) {
    Scene s = resting_scene(i, random);
    s.contact.stiffness = std::pow(10.0, 10.0 + static_cast<double>(random() % 13));
    SCOPED_TRACE(testing::Message() << i << ", kappa " << s.contact.stiffness);
    // stiffer ones, whose roundings are forces like the load, are refused
    Model model;
    try {
      model = make_model(s);
    } catch (const RequestError&) {
      ++refused;
      continue;
    }
    const ModalStart start = make_start(model);
    const double load = model.slider.load_force;
    // from overlaps that are right to the roundings of what they are the difference of
    double size = std::abs(model.delta);
    for (std::size_t k = 0; k < start.slider_u.size(); ++k)
      size += std::abs(start.slider_u[k]) * model.slider.modes[k].shape->largest();
    const double rounding =
        64 * ulp * size * model.node_stiffness *
        static_cast<double>(std::max<std::size_t>(1, start.loaded_nodes.size()));
    EXPECT_NEAR(start.contact_force, load, 1e-7 * load + rounding);
  }
  EXPECT_LT(refused, draws(90) / 3);
}

TEST(Equilibrium, BendingSlidersOfAnySupportSettle) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    for (const Support support : {Support::free, Support::pinned, Support::rigid}) {
      SCOPED_TRACE(testing::Message()
                   << "seed " << seed << ", support " << static_cast<int>(support));
      Scene s = resting_block();
      s.slider.support = support;
      s.slider.thickness = 5e-4;
      s.slider.modes = support == Support::rigid ? 0 : 4;
      s.slider.load_is_weight = false;
      s.slider.load = support == Support::rigid ? 0 : 3;
      s.gap = 4e-6;
      s.resonator.surface = gaussian(2e-6, 4e-4, 100 + 2 * seed);
      s.slider.surface = gaussian(2e-6, 4e-4, 101 + 2 * seed);
      const Model model = make_model(s);
      expect_balanced(model, make_start(model));
    }
}

TEST(Equilibrium, SmallScenesThatWereHardToSettle) {
  // A block on the plate's end, over all but rigid and over soft contact; an equilibrium always
  // exists, the weight acting between the block's ends.
  for (const double kappa_chi_w : {1e4, 1e5, 1e7, 1e9})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(testing::Message() << kappa_chi_w << " N/m, seed " << seed);
      Scene s = resting_block();
      s.spacing = 5e-5;
      s.resonator.length = 0.0155;
      s.resonator.thickness = 7.6e-4;
      s.resonator.modes = 1;
      s.resonator.surface = gaussian(3e-7, 1e-3, seed);
      s.slider.length = 0.0015;
      s.slider.thickness = 2e-4;
      s.slider.width = 0.01;
      s.slider.modes = 2;
      s.slider.load_is_weight = false;
      s.slider.load = 0.1;
      s.slider.surface =
          peaks({{.at = 2e-4 * static_cast<double>(seed), .height = 3e-7, .half_width = 2e-4}});
      s.start = 0.01389;
      s.contact.stiffness = kappa_chi_w / s.spacing / s.slider.width;
      const Model model = make_model(s);
      try {
        expect_balanced(model, make_start(model));
      } catch (const RequestError& e) {
        ADD_FAILURE() << e.what();
      }
    }
}

TEST(Equilibrium, PinnedSliderDeflectsAsABeamUnderEvenLoad) {
  Scene s = resting_block();
  s.gap = 1;  // m: nothing to lean on
  s.slider.support = Support::pinned;
  s.slider.thickness = 1e-3;
  s.slider.load_is_weight = false;
  s.slider.load = 7;
  const double inertia = s.slider.width * std::pow(s.slider.thickness, 3) / 12;
  const double scale = s.slider.load * std::pow(s.slider.length, 3) / (s.slider.young * inertia);
  for (const int modes : {1, 2, 5, 60}) {
    SCOPED_TRACE(modes);
    s.slider.modes = modes;
    const Model model = make_model(s);
    const ModalStart start = make_start(model);
    EXPECT_EQ(start.loaded_nodes.size(), 0u);
    double middle = 0, psi = 0, series = 0;
    for (std::size_t k = 0; k < start.slider_u.size(); ++k) {
      model.slider.modes[k].shape->evaluate(s.slider.length / 2, 1, &psi);
      middle += start.slider_u[k] * psi;
    }
    for (int n = 1; n <= modes; n += 2)
      series += (n % 4 == 1 ? 4 : -4) / std::pow(std::numbers::pi * n, 5) * scale;
    EXPECT_NEAR(middle, series, 64 * ulp * series);
    // what a series of alternating, falling terms leaves out is below the first one left out
    const int next = modes % 2 == 0 ? modes + 1 : modes + 2;
    EXPECT_NEAR(middle, 5.0 / 384 * scale,
                4 * scale / std::pow(std::numbers::pi * next, 5) + 64 * ulp * scale);
  }
}

TEST(Equilibrium, PlateUnderOneContactDeflectsAsABeamUnderAPointForce) {
  Scene s = resting_block();
  s.start = 0.024;  // the block's middle over the plate's
  s.resonator.modes = 101;
  // two peaks next to the middle, so that the slider stands
  s.slider.surface = peaks({{.at = 0.006 - 4e-5, .height = 1e-5, .half_width = 3e-5},
                            {.at = 0.006 + 4e-5, .height = 1e-5, .half_width = 3e-5}});
  const Model model = make_model(s);
  const ModalStart start = make_start(model);
  expect_balanced(model, start);
  EXPECT_EQ(start.loaded_nodes.size(), 2u);
  double middle = 0, psi = 0;
  for (std::size_t k = 0; k < start.resonator_u.size(); ++k) {
    model.resonator.modes[k].shape->evaluate(s.resonator.length / 2, 1, &psi);
    middle += start.resonator_u[k] * psi;
  }
  const double inertia = s.resonator.width * std::pow(s.resonator.thickness, 3) / 12;
  const double expected = -model.slider.load_force * std::pow(s.resonator.length, 3) /
                          (48 * s.resonator.young * inertia);
  // the forces stand d = 4e-5 m off the middle: w = P L^3/48EI (1 - 6 (d/L)^2 + ...); 101 modes
  // leave out 2/pi^4 sum 1/n^4 < 1/(3 pi^4 100^3) of P L^3/EI
  EXPECT_NEAR(middle / expected, 1,
              7 * std::pow(4e-5 / 0.06, 2) + 48 / (3 * std::pow(std::numbers::pi, 4) * 1e6));
}

TEST(Equilibrium, NothingMovesWhenNothingSlides) {
  for (const Support support : {Support::free, Support::pinned})
    for (const double stiffness : {1e12, 1e14}) {
      SCOPED_TRACE(testing::Message()
                   << "support " << static_cast<int>(support) << ", kappa " << stiffness);
      Scene s = resting_block();
      s.contact.stiffness = stiffness;
      s.slider.support = support;
      s.slider.thickness = support == Support::free ? 0.012 : 5e-4;
      s.slider.modes = 2;
      s.gap = 8e-6;
      s.resonator.surface = gaussian(3e-6, 1e-3, 31);
      s.slider.surface = gaussian(3e-6, 1e-3, 32);
      const Recording run = simulate(s);
      ASSERT_EQ(run.end.status, Status::done);
      ASSERT_FALSE(run.start.loaded_nodes.empty());
      EXPECT_EQ(run.end.contact_steps, run.end.step);
      // Each step's gaps are rounded anew; the force that this leaves accelerates the modes. At
      // worst it adds up over the whole run without anything to bring them back.
      const Balance b = balance(run.model, run.start);
      const double smallest_mass =
          std::min(run.model.resonator.modes[0].mass, run.model.slider.modes[0].mass);
      const double time = s.duration;
      const double drift = 0.5 * b.rounding / smallest_mass * time * time;
      const auto expect_still = [&](const std::vector<double>& u0, const std::vector<double>& u,
                                    const std::vector<double>& v) {
        for (std::size_t k = 0; k < u.size(); ++k) {
          EXPECT_NEAR(u[k], u0[k], drift);
          EXPECT_NEAR(v[k], 0, b.rounding / smallest_mass * time);
        }
      };
      expect_still(run.start.resonator_u, run.end.resonator_u, run.end.resonator_v);
      expect_still(run.start.slider_u, run.end.slider_u, run.end.slider_v);
      // and that is negligible against the deflection
      EXPECT_LT(drift, 1e-3 * std::abs(run.start.resonator_u[0]));
      EXPECT_LT(run.end.energy - run.start.energy, 1e-9 * run.start.energy);
      // the contact force is still the same
      EXPECT_NEAR(run.samples.force.back(), run.start.contact_force,
                  1e-6 * run.start.contact_force);
    }
}

TEST(Equilibrium, UnderMultipliersNothingOverlapsAndTheLoadedNodesAloneCarry) {
  for (const Support support : {Support::free, Support::pinned})
    for (const int seed : {31, 41, 51}) {
      SCOPED_TRACE(testing::Message()
                   << "support " << static_cast<int>(support) << ", seed " << seed);
      Scene s = resting_block();
      s.contact.law = ContactLaw::multiplier;
      s.slider.support = support;
      s.slider.thickness = support == Support::free ? 0.012 : 5e-4;
      s.slider.modes = 2;
      s.gap = 8e-6;
      s.resonator.surface = gaussian(3e-6, 1e-3, seed);
      s.slider.surface = gaussian(3e-6, 1e-3, seed + 1);
      const Model m = make_model(s);
      const ModalStart start = make_start(m);
      ASSERT_FALSE(start.loaded_nodes.empty());
      EXPECT_EQ(start.contact_energy, 0.0);

      // a gap's roundings: its terms' sum, and one for each mode
      double highest = 0;
      for (const double h : m.slider_height) highest = std::max(highest, std::abs(h));
      double heights = std::abs(m.delta) + highest, size = 0;
      std::vector<double> residual;
      const auto elastic = [&](const Body& beam, const std::vector<double>& u) {
        for (std::size_t k = 0; k < u.size(); ++k) {
          const double elastic_force =
              beam.modes[k].mass * beam.modes[k].omega * beam.modes[k].omega * u[k];
          residual.push_back(beam.load[k] - elastic_force);
          size = std::max({size, std::abs(beam.load[k]), std::abs(elastic_force)});
          heights += std::abs(u[k]) * beam.modes[k].shape->largest();
        }
      };
      elastic(m.resonator, start.resonator_u);
      elastic(m.slider, start.slider_u);
      const double rounding = 32 * ulp * heights;
      const std::vector<double> over = overlaps(m, start.resonator_u, start.slider_u);
      EXPECT_LE(*std::max_element(over.begin(), over.end()), rounding);

      // what the modes miss is made up by forces at the loaded nodes, all pushing
      const Eigen::Index nodes = static_cast<Eigen::Index>(start.loaded_nodes.size());
      Eigen::MatrixXd shapes(residual.size(), nodes);
      for (Eigen::Index e = 0; e < nodes; ++e) {
        const int n = start.loaded_nodes[e];
        EXPECT_NEAR(over[n], 0, rounding);
        Eigen::Index k = 0;
        for (const BodyMode& mode : m.resonator.modes)
          shapes(k++, e) = shape_at(mode, (m.position + n) * s.spacing);
        for (const BodyMode& mode : m.slider.modes) shapes(k++, e) = shape_at(mode, n * s.spacing);
      }
      const Eigen::Map<const Eigen::VectorXd> missing(residual.data(), residual.size());
      const Eigen::VectorXd forces = LeastSquares(shapes).solve(Eigen::VectorXd(missing));
      EXPECT_LE((shapes * forces - missing).cwiseAbs().maxCoeff(), 1e-9 * size);  // Newton's end
      EXPECT_GE(forces.minCoeff(), -1e-9 * forces.maxCoeff());
      EXPECT_NEAR(forces.sum(), start.contact_force, 1e-9 * start.contact_force);
      if (support == Support::free) {
        EXPECT_NEAR(start.contact_force, m.slider.load_force, 1e-9 * m.slider.load_force);
      }
    }
}

TEST(Equilibrium, WithoutLoadOrOverlapNothingIsDeformed) {
  Scene s = resting_block();
  s.slider.support = Support::rigid;
  s.slider.load_is_weight = false;
  s.gap = 1e-6;
  const ModalStart start = make_start(make_model(s));
  for (const double u : start.resonator_u) EXPECT_EQ(u, 0.0);
  EXPECT_EQ(start.energy, 0.0);
  EXPECT_EQ(start.loaded_nodes.size(), 0u);
}

// Shapes that were found for a scene serve the next one of equal bodies, and no other.
TEST(Equilibrium, OfScenesInTurnIsThatOfEachAlone) {
  std::vector<Scene> scenes(8, resting_block());
  scenes[1].start += 0.1 * scenes[1].spacing;
  scenes[2].spacing *= 1.5;
  scenes[3].slider.support = Support::pinned;
  scenes[4].resonator.length *= 1.01;
  scenes[5].slider.length *= 0.5;
  scenes[6].resonator.modes = 5;
  scenes[7].resonator.density *= 2;  // the shapes of the first one
  int touching = 0;
  for (int turn = 0; turn < 2; ++turn)
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const Model m = make_model(scenes[turn == 0 ? i : scenes.size() - 1 - i]);
      const ModalStart start = make_start(m);
      double force = 0;
      for (const double over : overlaps(m, start.resonator_u, start.slider_u))
        if (over >= 0) force += m.node_stiffness * over;
      touching += force > 0;
      EXPECT_EQ(start.contact_force, force) << "scene " << i << ", turn " << turn;
    }
  EXPECT_EQ(touching, 14);  // all but the pinned slider, which no load presses
}

}  // namespace
}  // namespace ra2d::test
