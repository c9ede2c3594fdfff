// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/peers/peers.hpp"
#include "host/base/errors.hpp"
#include "host/run/samples.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

/// The peers against closed form, against one another and against the march.
namespace {

using namespace ra2d;
using peers::Integrator;
using peers::march_peer;
using peers::PeerOptions;
using peers::PeerResult;

using test::pi;

double norm(const std::vector<double>& a) {
  double sum = 0;
  for (const double x : a) sum += x * x;
  return std::sqrt(sum);
}
/// Distance of two states, relative: of velocities and of displacements, the larger of both.
template <class End, class Reference>
double error(const End& end, const Reference& reference) {
  const auto apart = [](std::vector<double> a, const std::vector<double>& b) {
    EXPECT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) a[k] -= b[k];
    return norm(a) / norm(b);
  };
  return std::max(apart(end.resonator_v, reference.resonator_v),
                  apart(end.resonator_u, reference.resonator_u));
}

Scene peaks_scene() { return read_scene(test::scene_file("peaks")); }

PeerResult solve(const Scene& scene, Integrator integrator, double tolerance,
                 Nodes nodes = Nodes::candidates) {
  const Model model = make_model(scene);
  return march_peer(
      model, make_start(model),
      {.integrator = integrator, .nodes = nodes, .tolerance = tolerance, .until = scene.duration});
}

struct Named {
  std::string name;
  Integrator integrator;
};
class Peer : public testing::TestWithParam<Named> {};
INSTANTIATE_TEST_SUITE_P(Integrators, Peer,
                         testing::Values(Named{"CvodeAdams", Integrator::cvode_adams},
                                         Named{"CvodeBdf", Integrator::cvode_bdf},
                                         Named{"Dopri5", Integrator::dopri5}),
                         [](const auto& info) { return info.param.name; });

/// One undamped mode strikes one node of a slider that stands still: half swings about rest and,
/// in contact, about omega_c^2 U = (kappa chi w/m) phi gap, joined where the gap is 0.
TEST_P(Peer, OneModeAgainstOneNodeIsTheClosedForm) {
  constexpr int node = 10;
  constexpr double gap = 2e-6;
  Scene s = test::strip_scene(1, 0.0, 0.14, 0.02);
  s.slider.surface = test::peaks({{node * s.spacing, 40e-6, 0.5 * s.spacing}});
  s.gap = 40e-6 + gap;
  const Body beam = make_body(s.resonator);
  const double omega = beam.modes[0].omega;
  const double phi = shape_at(beam.modes[0], s.start + node * s.spacing);
  const double spring = 200 * beam.modes[0].mass * std::pow(omega / phi, 2);
  s.contact.stiffness = spring / (s.spacing * 0.2);

  const double touch = gap / phi, speed = 3 * touch * omega;  // U at contact, V at the start
  const double onset = std::asin(touch * omega / speed) / omega;
  const double v = speed * std::cos(omega * onset);
  const double stiff = spring * phi * phi / beam.modes[0].mass;
  const double omega_c = std::sqrt(omega * omega + stiff),
               rest = stiff * touch / (omega_c * omega_c);
  const double away = touch - rest, amplitude = std::hypot(away, v / omega_c);
  const double duration = (pi - 2 * std::atan2(omega_c * away, v)) / omega_c;
  // it leaves as fast as it came; then the free swing goes on, mirrored in time
  const double until = onset + duration + 0.3 / omega;
  const double end_u = touch * std::cos(0.3) - v / omega * std::sin(0.3);
  const double end_v = -v * std::cos(0.3) - omega * touch * std::sin(0.3);

  s.duration = until;
  s.time.step = until / 100;
  s.output.rate = 1 / until;
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  start.resonator_v = {speed};
  for (const Nodes nodes : {Nodes::all, Nodes::candidates})
    for (const double tolerance : {1e-6, 1e-9, 1e-12}) {
      const PeerResult r = march_peer(model, start,
                                      {.integrator = GetParam().integrator,
                                       .nodes = nodes,
                                       .tolerance = tolerance,
                                       .until = until});
      // some hundreds of steps, each with the error that it may make
      const double within = 1e3 * tolerance;
      EXPECT_NEAR(r.resonator_u[0] * omega, end_u * omega, within * speed) << tolerance;
      EXPECT_NEAR(r.resonator_v[0], end_v, within * speed) << tolerance;
      if (GetParam().integrator == Integrator::dopri5) continue;  // it knows of no shocks
      ASSERT_EQ(r.shocks.size(), 1);
      EXPECT_EQ(r.onsets, 1);
      EXPECT_NEAR(r.shocks[0].start, onset, within / omega);
      EXPECT_NEAR(r.shocks[0].duration, duration, within / omega);
      // the largest force is that of a cubic through a step's ends: of fourth order in it
      const double peak = spring * phi * (rest + amplitude - touch);
      EXPECT_NEAR(r.shocks[0].peak_force, peak, 1e-3 * peak);
    }
}

/// Each shock multiplies what came before it: after all six, a gap wrong by 1e-10 of itself has
/// become an end wrong by 2e-8. Three stay within a thousand times the tolerance, and the two
/// integrators have only the equations in common.
TEST_P(Peer, ErrorsFallWithTheTolerance) {
  Scene scene = peaks_scene();
  scene.duration = 0.033;
  const PeerResult reference = solve(
      scene,
      GetParam().integrator == Integrator::dopri5 ? Integrator::cvode_adams : Integrator::dopri5,
      1e-13);
  for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
    const PeerResult r = solve(scene, GetParam().integrator, tolerance);
    EXPECT_LE(error(r, reference), 1e3 * tolerance) << tolerance;
  }
}

TEST_P(Peer, AllNodesOrCandidatesGiveTheSame) {
  Scene scene = peaks_scene();
  scene.duration = 0.022;  // two shocks
  for (const double tolerance : {1e-5, 1e-9}) {
    const PeerResult all = solve(scene, GetParam().integrator, tolerance, Nodes::all);
    const PeerResult some = solve(scene, GetParam().integrator, tolerance);
    EXPECT_LE(error(some, all), 1e2 * tolerance) << tolerance;
    EXPECT_GT(norm(all.resonator_v), 0);
    ASSERT_EQ(all.shocks.size(), some.shocks.size());
    for (std::size_t i = 0; i < all.shocks.size(); ++i)
      EXPECT_NEAR(all.shocks[i].start, some.shocks[i].start, 1e2 * tolerance * scene.duration);
  }
}

/// A free slider under its weight, one node on the flat: what it falls, when it bounces, and that a
/// bounce gives back what it took.
TEST_P(Peer, ARigidBodyFallsAndBounces) {
  Scene s = test::strip_scene(1, 0.0, 0.14, 0.02);
  s.resonator = test::rigid(s.resonator);
  s.slider = test::steel(0.02, 0.02, 0.02, 0, 0);
  s.slider.support = Support::free;
  s.slider.load_is_weight = true;
  s.slider.surface = test::peaks({{0.01, 1e-5, 0.0005}});
  s.gap = 2e-5;
  s.contact.stiffness = 1e12;
  constexpr double g = 9.80665, height = 1e-5;
  const double fall = std::sqrt(2 * height / g);
  const Body slider = make_body(s.slider);
  const double mass = slider.mass;
  const double omega_c = std::sqrt(s.contact.stiffness * s.spacing * 0.02 / mass);
  const double v = g * fall, depth = g / (omega_c * omega_c);
  const double contact = (2 * pi - 2 * std::atan2(v / omega_c, depth)) / omega_c;
  const double until = fall + contact + fall;  // back at the top
  s.duration = until;
  s.time.step = until / 100;
  s.output.rate = 1 / until;
  for (const double tolerance : {1e-7, 1e-10}) {
    const PeerResult r = solve(s, GetParam().integrator, tolerance);
    const double scale = std::sqrt(slider.length), within = 1e3 * tolerance;
    EXPECT_NEAR(r.slider_u[0] / scale, 0, within * height);
    EXPECT_NEAR(r.slider_v[0] / scale, 0, within * v);
    EXPECT_NEAR(r.slider_u[1], 0, 1e-6 * within * height);  // hit in the middle: it does not turn
    if (GetParam().integrator == Integrator::dopri5) continue;
    ASSERT_EQ(r.shocks.size(), 1);
    EXPECT_NEAR(r.shocks[0].start, fall, within * fall);
    EXPECT_NEAR(r.shocks[0].duration, contact, within * fall);
  }
}

TEST(Peers, TheMarchComesToTheSameEnd) {
  // Onset and release fall within steps: of second order there, whatever the scheme.
  Scene scene = peaks_scene();
  const PeerResult reference = solve(scene, Integrator::cvode_adams, 1e-12);
  ASSERT_EQ(reference.shocks.size(), 6);
  scene.time.scheme = SchemeKind::rk8;
  scene.output.rate = 1 / scene.duration;
  double coarse = 0;
  for (int level = 0; level < 4; ++level) {
    scene.time.step = 4e-7 / (1 << level);
    const test::Recording run = test::simulate(scene);
    const double e = error(run.end, reference);
    if (level == 0) {
      coarse = e;
      EXPECT_LE(coarse, 1e-4);
    }
    // where in a step the kinks fall is chance
    EXPECT_LE(e, 4 * coarse / std::pow(4, level)) << scene.time.step;
    ASSERT_EQ(run.shocks.size(), reference.shocks.size());
    for (std::size_t i = 0; i < run.shocks.size(); ++i) {
      const Shock shock = make_shocks(run.model, {run.shocks[i]})[0];
      EXPECT_NEAR(shock.start, reference.shocks[i].start, 2 * scene.time.step);
      EXPECT_NEAR(shock.duration, reference.shocks[i].duration, 3 * scene.time.step);
      EXPECT_NEAR(shock.peak_force, reference.shocks[i].peak_force,
                  1e-3 * reference.shocks[i].peak_force);
    }
  }
}

TEST(Peers, RefuseWhatTheyCannotDo) {
  Scene scene = peaks_scene();
  EXPECT_THROW(solve(scene, Integrator::dopri5, 0.5), RequestError);
  const Model model = make_model(scene);
  EXPECT_THROW(march_peer(model, make_start(model), {.until = 1.0}), RequestError);
  scene.contact.law = ContactLaw::multiplier;
  EXPECT_THROW(solve(scene, Integrator::cvode_adams, 1e-8), RequestError);
  scene = peaks_scene();
  scene.faces = Faces::smooth;
  EXPECT_THROW(solve(scene, Integrator::cvode_adams, 1e-8), RequestError);
}

}  // namespace
