// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/compare.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// Outcomes of marches over all nodes and over candidates, compared bit for bit; and scenes of any
/// kind to compare them on.
namespace ra2d::test {

/// Everything that a scene hands out.
struct Outcome {
  std::vector<double> rows;  // samples: U, V, force, nodes, energies, works
  std::vector<ShockRow> shocks;
  Snapshot end;
  int lanes = 0;                         // modal displacements of a sample
  double tick = 0, sample_interval = 0;  // s
};

Outcome march(Model model, const ModalStart& start, Nodes nodes, const BatchOptions& options = {});

/// Marches in launches of random length; after each, all but the saved state is thrown away.
Outcome march_from_saved_states(const Model& model, const ModalStart& start, std::uint64_t seed);

/// EXPECT_TRUE(same(a, b)): bit for bit, or what differs.
testing::AssertionResult same(const Outcome& a, const Outcome& b);

/// Marches both ways, compares, and returns the march over all the nodes.
Outcome expect_both_same(const Model& model, const ModalStart& start);

double largest_shape(const Body& body);

/// The kappa with which one node in contact has omega_c tau = z, at the most, anywhere on the
/// bodies.
double stiffness_for(const Scene& scene, double z);

struct Started {
  Model model;
  ModalStart start;
};

/// Whether a march that is saved at a step, in contact, and goes on in another batch comes to the
/// bits of one that was never saved.
testing::AssertionResult goes_on_when_saved(const Started& started, std::int64_t step);

struct Variant {
  Scheme scheme{{{SchemeKind::backward_euler}}, "BackwardEuler"};
  double turn = 0;                    // omega tau of the fastest mode; 0: as it comes, well below 1
  std::function<void(Scene&)> adapt;  // last changes
};

/// A scheme under a contact law.
struct SchemeUnderLaw {
  Scheme scheme;
  ContactLaw law;

  std::string name() const {
    return scheme.name + (law == ContactLaw::multiplier ? "Multiplier" : "Penalty");
  }
  Variant variant() const;
};
/// All that there are.
std::vector<SchemeUnderLaw> schemes_under_laws();

/// Counts over the scenes of a test.
struct Seen {
  int scenes = 0, touching = 0, with_shocks = 0;

  void count(std::int64_t contact_steps, std::int64_t shocks) {
    ++scenes;
    touching += contact_steps > 0;
    with_shocks += shocks >= 3;
  }
};

/// A scene of any kind that the march takes.
Started random_scene(std::uint64_t seed, const Variant& variant = {});

/// Rough faces that meet, under a slider of any support.
Scene rough_scene(Support slider);

}  // namespace ra2d::test
