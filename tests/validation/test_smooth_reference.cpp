// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/run/timed_run.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/schemes.hpp"
#include "tests/smooth_reference.hpp"

/// Smooth faces against a reference in long double, whose steps end at every event.
namespace ra2d::test {
namespace {

struct Case {
  std::string name;
  Scene (*scene)();
};

Scene with_peaks() {
  Scene s = plate_scene(8, 0.004, 0.004);
  s.spacing = 2e-5;
  s.speed = 2;
  s.start = 0.0203;
  s.gap = 1.995e-5;
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 7e-4}});
  s.resonator.surface = peaks({{.at = 0.0230, .height = 1e-5, .half_width = 7e-4},
                               {.at = 0.0238, .height = 1e-5, .half_width = 7e-4}});
  s.contact.stiffness = 1e14;
  s.duration = 4e-4;
  return s;
}
/// Corners of a profile: its spline rings between nodes.
Scene with_corners() {
  Scene s = with_peaks();
  for (Peak& peak : s.resonator.surface.peaks) peak.half_width = 3e-5;
  s.slider.surface.peaks[0].half_width = 4e-5;
  s.gap = 1.9e-5;
  s.start = 0.02095;
  s.duration = 1e-4;
  return s;
}
Scene rough(Support slider) {
  Scene s = rough_scene(slider);
  s.duration = 1e-4;
  return s;
}
Scene pinned_slider() { return rough(Support::pinned); }
Scene free_slider() {
  Scene s = with_peaks();
  s.slider.support = Support::free;
  s.slider.modes = 0;  // it falls and turns
  s.slider.load = 5;
  s.duration = 2e-4;
  return s;
}
Scene with_moving_force() {
  Scene s = rough(Support::rigid);
  s.resonator.moving_forces.push_back({.force = 3, .speed = 20, .start = 0.01});
  return s;
}
Scene resting() {
  Scene s = rough(Support::free);
  s.slider.modes = 0;
  s.initial = Initial::statics;
  s.contact.stiffness = 1e13;
  s.duration = 5e-6;
  return s;
}

const std::vector<Case> cases{{"Peaks", with_peaks},
                              {"Corners", with_corners},
                              {"PinnedSlider", pinned_slider},
                              {"FreeSlider", free_slider},
                              {"MovingForce", with_moving_force},
                              {"StaticStart", resting}};

class SmoothReference : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Scenes, SmoothReference, testing::ValuesIn(cases),
                         [](const auto& info) { return info.param.name; });

Scene smooth(Scene s, const TimeSettings& time, double step) {
  s.faces = Faces::smooth;
  s.time = time;
  s.time.step = step;
  s.output.rate = 1 / s.duration;  // a sample at the end
  return s;
}

State end_of(const Reference& r) {
  const ReferenceState& s = r.states.back();
  return {s.resonator_u, s.resonator_v, s.slider_u, s.slider_v};
}

/// Of the reference itself: other steps give the same to the last digits of a double, and it loses
/// no energy.
TEST_P(SmoothReference, HasConverged) {
  const Scene s = smooth(GetParam().scene(), {SchemeKind::exact}, 1e-7);
  const Model model = make_model(s);
  const ModalStart start = make_start(model);
  const Reference a = smooth_reference(model, start, {s.duration});
  const Reference b =
      smooth_reference(model, start, {s.duration}, {.tolerance = 3e-17, .longest = 0.6});
  EXPECT_LT(state_error(model, end_of(b), end_of(a)), 1e-13);
  const ReferenceState& e = a.states.back();
  const double most = std::max({start.energy, e.kinetic + e.elastic + e.contact, e.load_work});
  EXPECT_NEAR(e.kinetic + e.elastic + e.contact + e.damping_loss - e.sliding_work - e.load_work,
              start.energy, 1e-13 * most);
  EXPECT_GE(a.shocks.size(), 1);
  ASSERT_EQ(a.shocks.size(), b.shocks.size());
  for (std::size_t i = 0; i < a.shocks.size(); ++i) {
    EXPECT_NEAR(a.shocks[i].start, b.shocks[i].start, 1e-13 * s.duration);
    EXPECT_NEAR(a.shocks[i].end, b.shocks[i].end, 1e-13 * s.duration);
    EXPECT_NEAR(a.shocks[i].impulse, b.shocks[i].impulse, 1e-12 * a.shocks[i].impulse);
  }
}

TEST_P(SmoothReference, SchemesComeToItWithTheirOrder) {
  const Scene scene = GetParam().scene();
  const Model first = make_model(smooth(scene, {SchemeKind::exact}, 1e-8));
  const Reference r = smooth_reference(first, make_start(first), {scene.duration});
  for (const Scheme& scheme : schemes) {
    if (scheme.time.scheme == SchemeKind::explicit_euler && !first.slider.modes.empty())
      continue;  // unstable on modes so fast
    std::vector<double> errors;
    for (const double step : {4e-8, 2e-8, 1e-8, 5e-9}) {
      const Model model = make_model(smooth(scene, scheme.time, step));
      const TimedRun run = timed_run(model, make_start(model));
      ASSERT_EQ(run.status, Status::done) << scheme.name;
      errors.push_back(state_error(model, run.state, end_of(r)));
    }
    // Of the third order and above what is left is of the steps in which contact begins and ends:
    // step^2.5, and where in a step that falls is chance.
    const bool is_high = scheme.table().order > 2;
    const double order = is_high ? 2.5 : scheme.table().order, chance = is_high ? 16 : 2;
    const double roundings = 1e-11;
    EXPECT_LT(errors.back(), chance * errors.front() / std::pow(8, order) + roundings)
        << scheme.name << ": " << testing::PrintToString(errors);
    if (is_high) {
      EXPECT_LT(errors.back(), 1e-7) << scheme.name;
    }
  }
}

TEST_P(SmoothReference, AdaptiveKeepsItsTolerance) {
  Scene scene = smooth(GetParam().scene(), {SchemeKind::adaptive}, 0);
  Reference r;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    scene.time.tolerance = tolerance;
    Model model;
    try {
      model = make_model(scene);
    } catch (const RequestError& refused) {
      GTEST_SKIP() << refused.what();  // of a program whose adaptive scheme wants linear faces
    }
    const ModalStart start = make_start(model);
    if (r.states.empty()) r = smooth_reference(model, start, {scene.duration});
    const TimedRun run = timed_run(model, start);
    ASSERT_EQ(run.status, Status::done) << tolerance;
    // a shock amplifies what came before it by up to some ten times
    const double bound = 100 * tolerance + 1e-9;
    EXPECT_LT(state_error(model, run.state, end_of(r)), bound) << tolerance;
    ASSERT_EQ(run.shocks.size(), r.shocks.size()) << tolerance;
    for (std::size_t i = 0; i < r.shocks.size(); ++i) {
      const ReferenceShock& shock = r.shocks[i];
      EXPECT_NEAR(run.shocks[i].start, shock.start, bound * scene.duration) << tolerance;
      EXPECT_NEAR(run.shocks[i].impulse, shock.impulse, 10 * bound * shock.impulse) << tolerance;
    }
  }
}

}  // namespace
}  // namespace ra2d::test
