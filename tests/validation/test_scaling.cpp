// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host/result/level.hpp"
#include "host/run/v_rms.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

/// Penalty contact is positively homogeneous: with a held slider, heights and gap times s give
/// displacements, velocities and forces times s (docs/validation.md). A power of two
/// rounds nothing, so it holds to the last bit.
namespace ra2d::test {
namespace {

Scene held_slider(Support support) {
  Scene s = plate_scene(10, 0.006, 1e-3);
  s.speed = 0.5;
  s.gap = 2e-6;
  s.output.rate = 3e5;
  s.resonator.surface = gaussian(1e-6, 4e-4, 2);
  s.slider.support = support;
  s.slider.modes = support == Support::rigid ? 0 : 2;
  s.slider.surface = gaussian(1e-6, 4e-4, 1);
  s.contact.stiffness = 1e13;
  return s;
}

Scene scaled(Scene scene, double factor) {
  scene.gap = *scene.gap * factor;
  for (SurfaceSpec* surface : {&scene.resonator.surface, &scene.slider.surface}) {
    surface->rq *= factor;
    for (Peak& peak : surface->peaks) peak.height *= factor;
  }
  return scene;
}

void expect_times(const std::vector<double>& small, const std::vector<double>& large, double factor,
                  const std::string& what) {
  std::vector<double> scaled = small;
  for (double& x : scaled) x *= factor;
  EXPECT_TRUE(same(what, scaled, large));
}

/// Every number of the run scales with its power of the heights.
void expect_scaled(const Recording& small, const Recording& large, double factor) {
  const double square = factor * factor;
  const SampleBlock &a = small.samples, &b = large.samples;
  expect_times(a.resonator_displacement, b.resonator_displacement, factor,
               "resonator displacement");
  expect_times(a.resonator_velocity, b.resonator_velocity, factor, "resonator velocity");
  expect_times(a.slider_displacement, b.slider_displacement, factor, "slider displacement");
  expect_times(a.slider_velocity, b.slider_velocity, factor, "slider velocity");
  expect_times(a.force, b.force, factor, "force");
  expect_times(a.nodes, b.nodes, 1, "nodes");
  expect_times(a.kinetic, b.kinetic, square, "kinetic energy");
  expect_times(a.elastic, b.elastic, square, "elastic energy");
  expect_times(a.contact, b.contact, square, "contact energy");
  expect_times(a.damping_loss, b.damping_loss, square, "damping loss");
  expect_times(a.sliding_work, b.sliding_work, square, "sliding work");
  expect_times(small.end.resonator_square, large.end.resonator_square, square, "sum of V^2");
  EXPECT_EQ(small.end.contact_steps, large.end.contact_steps);
  ASSERT_EQ(small.shocks.size(), large.shocks.size());
  for (std::size_t i = 0; i < small.shocks.size(); ++i) {
    const ShockRow &x = small.shocks[i], &y = large.shocks[i];
    EXPECT_EQ(x.serial, y.serial);
    EXPECT_EQ(x.start, y.start);
    EXPECT_EQ(x.last, y.last);
    EXPECT_EQ(x.peak * factor, y.peak);
    EXPECT_EQ(x.impulse * factor, y.impulse);
    EXPECT_EQ(x.moment * factor, y.moment);
  }
}

TEST(Scaling, HeightsAndGapByAPowerOfTwoScaleEverythingToTheLastBit) {
  for (const Support support : {Support::pinned, Support::rigid}) {
    for (const Nodes nodes : {Nodes::all, Nodes::candidates}) {
      Scene scene = held_slider(support);
      scene.time.nodes = nodes;
      const Recording once = simulate(scene);
      ASSERT_GT(once.shocks.size(), 5u);
      for (const double factor : {2.0, 64.0, 0x1p-7}) {
        SCOPED_TRACE(factor);
        const Recording more = simulate(scaled(scene, factor));
        expect_scaled(once, more, factor);
        // levels of about 120 dB, each with a few roundings
        EXPECT_NEAR(level(v_rms(more.model, more.end)) - level(v_rms(once.model, once.end)),
                    20 * std::log10(factor), 8 * 120 * std::numeric_limits<double>::epsilon());
      }
    }
  }
}

TEST(Scaling, TheAdaptiveSchemeToo) {
  // its tolerance is relative, its search for contacts is one for signs
  for (const Support support : {Support::pinned, Support::rigid}) {
    Scene scene = held_slider(support);
    scene.time.scheme = SchemeKind::adaptive;
    scene.time.tolerance = 1e-8;
    const Recording once = simulate(scene);
    ASSERT_GT(once.shocks.size(), 5u);
    for (const double factor : {2.0, 64.0, 0x1p-7})
      expect_scaled(once, simulate(scaled(scene, factor)), factor);
  }
}

TEST(Scaling, PeaksAndAMovingForceToo) {
  Scene scene = held_slider(Support::rigid);
  scene.gap = 1.9e-5;
  scene.resonator.surface = peaks({{.at = 0.0234, .height = 1e-5, .half_width = 2e-4}});
  scene.slider.surface = peaks({{.at = 0.003, .height = 1e-5, .half_width = 2e-4}});
  scene.resonator.moving_forces = {{.force = 0.25, .speed = 20, .start = 0.0}};
  Scene twice = scaled(scene, 2);
  twice.resonator.moving_forces[0].force *= 2;
  const Recording once = simulate(scene), more = simulate(twice);
  ASSERT_GT(once.shocks.size(), 0u);
  expect_scaled(once, more, 2);
  expect_times(once.samples.load_work, more.samples.load_work, 4, "work of the force");
}

TEST(Scaling, AFactorOfThreeScalesToRoundOff) {
  // it rounds the heights: compared before chaos, with the growth of a change of the gap
  Scene scene = held_slider(Support::pinned);
  scene.duration = 3e-4;
  Scene nudged = scene;
  const double nudge = 1e-10 * *scene.gap;
  nudged.gap = *scene.gap + nudge;
  const Recording once = simulate(scene), more = simulate(scaled(scene, 3)),
                  other = simulate(nudged);
  ASSERT_GT(once.end.contact_steps, 0);
  double growth = 0, worst = 0, size = 0;
  for (std::size_t i = 0; i < once.samples.resonator_displacement.size(); ++i) {
    const double u = once.samples.resonator_displacement[i];
    growth = std::max(growth, std::abs(other.samples.resonator_displacement[i] - u) / nudge);
    worst = std::max(worst, std::abs(more.samples.resonator_displacement[i] / 3 - u));
    size = std::max(size, std::abs(u));
  }
  // each gap is wrong by a few roundings of the heights, by others at every step; the state by two
  // a step
  const double ulp = std::numeric_limits<double>::epsilon();
  const double bound = growth * 64 * ulp * *scene.gap + 2.0 * once.end.step * ulp * size;
  EXPECT_LT(bound, 1e-6 * size) << "too chaotic to compare";
  EXPECT_LT(worst, bound);
  EXPECT_GT(worst, 0) << "a factor of three was expected to round";
}

TEST(Scaling, AFreeSliderUnderItsWeightDoesNotScale) {
  Scene scene = held_slider(Support::free);
  scene.slider.load_is_weight = true;
  scene.slider.thickness = 0.006;
  scene.gap = 2e-6;
  const Recording once = simulate(scene), more = simulate(scaled(scene, 2));
  ASSERT_GT(once.end.contact_steps, 0);
  double worst = 0, size = 0;
  for (std::size_t i = 0; i < once.samples.slider_displacement.size(); ++i) {
    const double twice = 2 * once.samples.slider_displacement[i];
    worst = std::max(worst, std::abs(more.samples.slider_displacement[i] - twice));
    size = std::max(size, std::abs(twice));
  }
  EXPECT_GT(worst, 0.05 * size);
  EXPECT_NE(once.end.contact_steps, more.end.contact_steps);
}

}  // namespace
}  // namespace ra2d::test
