// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/model/smooth_contact.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/surface/spline.hpp"
#include "tests/adaptive.hpp"
#include "tests/compare.hpp"
#include "tests/effort.hpp"
#include "tests/numbers.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// Smooth faces (scene.faces): contact is integrated along splines, so no answer depends on where
/// nodes stand.
namespace ra2d::test {
namespace {

Variant smooth(const Scheme& scheme, double turn = 0) {
  return {.scheme = scheme, .turn = turn, .adapt = [](Scene& s) { s.faces = Faces::smooth; }};
}

struct SmoothFaces : testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, SmoothFaces, testing::ValuesIn(schemes),
                         [](const auto& tested) { return tested.param.name; });

TEST_P(SmoothFaces, RandomScenesAreTheSameBitForBitOverAllCellsAndCandidates) {
  Seen seen;
  for (int seed = 1; seed <= draws(6); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Started c = random_scene(4000 + 7 * seed, smooth(GetParam()));
    const Outcome all = march(c.model, c.start, Nodes::all);
    const Outcome some = march(c.model, c.start, Nodes::candidates);
    EXPECT_TRUE(same(all, some));
    seen.count(all.end.contact_steps, all.end.shocks_begun);
  }
  if (!draws_enough()) return;
  EXPECT_GE(seen.touching, seen.scenes / 2);
  EXPECT_GE(seen.with_shocks, seen.scenes / 6);
}

TEST_P(SmoothFaces, LaunchesAndSavedStatesGiveTheSameBits) {
  for (const int seed : {3, 5}) {
    const Started c = random_scene(4000 + 7 * seed, smooth(GetParam()));
    const Outcome whole = march(c.model, c.start, c.model.scene.time.nodes);
    EXPECT_TRUE(same(whole, march_from_saved_states(c.model, c.start, 1)));
  }
}

/// A parabola of radius R pressed by d into a rigid flat face: kappa w 4/3 d sqrt(2 R d), wherever
/// its summit stands between the nodes of either face.
TEST(SmoothContact, OfAParabolaIsItsClosedFormWhereverItsSummitStands) {
  constexpr double radius = 0.02, depth = 3e-9;
  Scene s = plate_scene(1, 0.004, 0.004);
  s.resonator = rigid(s.resonator);
  s.faces = Faces::smooth;
  s.spacing = 8e-6;
  s.start = 0.01;
  s.gap = 0;
  s.contact.stiffness = 1e15;
  s.time = {SchemeKind::exact};
  s.time.step = 1e-7;
  s.duration = 2e-7;
  const double exact =
      s.contact.stiffness * s.slider.width * 4 / 3 * depth * std::sqrt(2 * radius * depth);
  for (const double share : {0.0, 0.1, 0.5, 0.77})
    for (const double behind : {0.0, 0.3, 0.9}) {
      s.start = (1250 + behind) * s.spacing;
      Model m = make_model(s);
      for (int n = 0; n < m.nodes(); ++n) {
        const double x = (n - 250 - share) * s.spacing;
        m.slider_height.edit()[n] = depth - x * x / (2 * radius);
      }
      m.slider_curvature = spline_curvatures(m.slider_height);
      const ModalStart start = make_start(m);
      // roundings: of heights of up to 1e-4 m, over the depth
      const double bound = 64 * eps * 1e-4 / depth * exact;
      EXPECT_NEAR(start.contact_force, exact, bound) << share << " " << behind;
      EXPECT_NEAR(start.contact_energy, 0.4 * exact * depth, depth * bound);
      const Outcome run = march(m, start, Nodes::candidates);
      ASSERT_GE(run.rows.size(), 2 * run.lanes + sample::columns);
      const double* sample = run.rows.data() + 2 * run.lanes;
      EXPECT_NEAR(sample[sample::force], exact, bound) << share << " " << behind;
      EXPECT_NEAR(sample[sample::contact_energy], 0.4 * exact * depth, depth * bound);
    }
}

/// Where the spacing is fine enough for the faces, hardly more is evaluated than between linear
/// ones.
TEST(SmoothContact, OnlyCellsThatCanTouchAreEvaluated) {
  Scene s = rough_scene(Support::free);
  s.spacing = 4e-6;
  s.time = {SchemeKind::exact};
  s.time.step = 1e-7;
  double evaluated[2];
  for (const Faces faces : {Faces::linear, Faces::smooth}) {
    s.faces = faces;
    const Model model = make_model(s);
    const Outcome run = march(model, make_start(model), Nodes::candidates);
    ASSERT_EQ(run.end.status, Status::done);
    EXPECT_GT(run.end.contact_steps, 0);
    evaluated[faces == Faces::smooth] = static_cast<double>(run.end.evaluated);
  }
  EXPECT_LT(evaluated[1], 1.5 * evaluated[0]);
}

/// Let go in equilibrium, nothing moves.
TEST(SmoothContact, AStaticStartStaysAtRest) {
  Scene s = plate_scene(8, 0.012, 0.012);
  s.faces = Faces::smooth;
  s.start = 0.021;
  s.initial = Initial::statics;
  s.slider.support = Support::free;
  s.slider.load_is_weight = true;
  s.contact.stiffness = 1e15;
  s.resonator.surface = gaussian(2e-6, 8e-4, 3);
  s.slider.surface = gaussian(2e-6, 8e-4, 4);
  s.time = {SchemeKind::rk8};
  s.time.step = 2e-7;
  s.duration = 2e-3;
  s.output.rate = 1e5;
  const Recording run = simulate(s);
  ASSERT_EQ(run.end.status, Status::done);
  const double load = run.model.slider.load_force;
  EXPECT_NEAR(run.start.contact_force, load, 1e-9 * load);
  ASSERT_FALSE(run.samples.force.empty());
  for (const double force : run.samples.force) EXPECT_NEAR(force, load, 1e-8 * load);
}

/// Faces that only touch carry nothing: a summit that slides along a flat face, and a block without
/// a load that slides over summits. Contacts as deep as roundings begin and end there, and must not
/// hold the march.
TEST(SmoothContact, FacesThatOnlyTouchDoNotHoldTheMarch) {
  for (const bool free : {false, true})
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      Scene s = adaptive(plate_scene(3, 0.006, 0.005), 1e-8);
      s.faces = Faces::smooth;
      s.speed = 1;
      s.duration = 1e-3;
      s.output.rate = 1e5;
      s.contact.stiffness = 1e14;
      if (free) s.slider.support = Support::free;
      (free ? s.resonator : s.slider).surface = gaussian(1e-6, 6e-4, seed);
      const Recording run = simulate(s);
      SCOPED_TRACE(std::string(free ? "free" : "rigid") + ", " + std::to_string(seed) + ", " +
                   std::to_string(run.end.steps_made) + " steps");
      ASSERT_EQ(run.end.status, Status::done);
      EXPECT_LT(run.end.steps_made, 20'000);
      for (const double force : run.samples.force) EXPECT_LT(force, 1e-15);
    }
}

/// So does the highest summit of a face on which a flat slider slides: it keeps its height, but
/// moves on from cell to cell.
TEST(SmoothContact, ASummitThatSlidesAlongAFlatFaceDoesNotHoldTheMarch) {
  constexpr const char* plane = R"(
    scene = { duration = 0.01, speed = 0.1, start = 0.02, spacing = 1e-4, faces = "smooth" }
    slider = { support = "rigid", length = 0.01, width = 0.01 }
    contact.stiffness = 1e13
    time = { scheme = "adaptive" }
    output.rate = 1e3
    [resonator]
    support = "pinned"
    length = 0.05
    width = 0.01
    thickness = 0.002
    young = 2e11
    density = 7800
    damping = 0.02
    modes = 1
    surface = { kind = "gaussian", rq = 1e-6, rsm = 2e-3, seed = 1 }
  )";
  constexpr const char* areal = R"(
    slider = { support = "rigid", length = 0.00016, width = 8e-6 }
    contact.stiffness = 1e13
    time = { scheme = "adaptive" }
    output.rate = 46300.0
    [scene]
    kind = "areal"
    duration = 0.000216
    speed = 0.1
    start = 4.659e-6
    spacing = 8e-6
    spacing_y = 4e-6
    faces = "smooth"
    [resonator]
    support = "pinned"
    length = 0.0002
    width = 2.4e-5
    thickness = 1e-5
    young = 200e9
    density = 7800
    damping = 0.02
    modes = 1
    surface = { kind = "gaussian", rq = 1e-7, rsm = 4e-5, seed = 1 }
  )";
  for (const char* text : {plane, areal}) {
    SCOPED_TRACE(text);
    const Recording run = simulate(parse_scene(text, "flat.toml"));
    ASSERT_EQ(run.end.status, Status::done);
    EXPECT_LT(run.end.steps_made, 20'000);
  }
}

/// The energy closes better and better with shorter steps, through a contact that opens and closes.
TEST(SmoothContact, EnergyCloses) {
  Scene s = plate_scene(6, 0.004, 0.004, 0.0);
  s.faces = Faces::smooth;
  s.spacing = 2e-5;
  s.speed = 2;
  s.start = 0.0203;
  s.gap = 1.995e-5;
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 7e-4}});
  s.resonator.surface = peaks({{.at = 0.0230, .height = 1e-5, .half_width = 7e-4},
                               {.at = 0.0238, .height = 1e-5, .half_width = 7e-4}});
  s.contact.stiffness = 1e14;
  s.time = {SchemeKind::rk4};
  s.duration = 2e-3;
  s.output.rate = 1e5;
  std::vector<double> residual;
  for (const double step : {1e-7, 2.5e-8, 6.25e-9}) {
    s.time.step = step;
    const Recording run = simulate(s);
    ASSERT_EQ(run.end.status, Status::done);
    EXPECT_GE(run.end.contact_steps, 100);
    residual.push_back(std::abs(run.energy.relative()));
  }
  // the record's sums of forces at the steps are of second order where a contact begins and ends
  EXPECT_LT(residual[0], 1e-4);
  EXPECT_LT(residual[2], 0.05 * residual[0]);
  EXPECT_LT(residual[2], 1e-6);
}

/// Coarse faces, and one with a spike, about which alone cells must be evaluated.
TEST(SmoothContact, CandidatesAreTheSameBitForBitAtAnySpacing) {
  for (const double spacing : {4e-6, 8e-6, 16e-6, 32e-6})
    for (const bool spike : {false, true}) {
      SCOPED_TRACE(std::to_string(1e6 * spacing) + (spike ? " um, with a spike" : " um"));
      Scene s = rough_scene(Support::free);
      s.faces = Faces::smooth;
      s.spacing = spacing;
      s.time = {SchemeKind::exact};
      s.time.step = 1e-7;
      Model m = make_model(s);
      if (spike) {
        const double top = *std::max_element(m.resonator_height.begin(), m.resonator_height.end());
        m.resonator_height.edit()[m.resonator_height.size() / 2] = top + 1e-6;
        m.resonator_curvature = spline_curvatures(m.resonator_height);
      }
      const ModalStart start = make_start(m);
      const Outcome some = march(m, start, Nodes::candidates);
      EXPECT_TRUE(same(march(m, start, Nodes::all), some));
      EXPECT_GT(some.end.contact_steps, 0);
    }
}

}  // namespace
}  // namespace ra2d::test
