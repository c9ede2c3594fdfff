// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "host/surface/spline.hpp"
#include "tests/compare.hpp"
#include "tests/effort.hpp"
#include "tests/numbers.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// Contact forces between smooth faces that are found with the end of the step: multipliers, and
/// the penalty force of the new time.
namespace ra2d::test {
namespace {

const Scheme new_force{{{SchemeKind::backward_euler, ForceTime::new_time}}, "FullyImplicit"};
const Scheme old_force{{{SchemeKind::backward_euler}}, "BackwardEuler"};

const std::vector<Scheme> kinds = {
    {{{SchemeKind::backward_euler}, ContactLaw::multiplier}, "BackwardEuler"},
    {{{SchemeKind::midpoint}, ContactLaw::multiplier}, "Midpoint"},
    {{{SchemeKind::rk4}, ContactLaw::multiplier}, "Rk4"},
    {{{SchemeKind::exact}, ContactLaw::multiplier}, "Exact"},
    new_force};

struct HeldOnSmoothFaces : testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, HeldOnSmoothFaces, testing::ValuesIn(kinds),
                         [](const auto& tested) { return tested.param.name; });

Started random_smooth_scene(std::uint64_t seed, const Scheme& kind, double stiffer) {
  return random_scene(seed,
                      {kind, 0, [&](Scene& s) {
                         s.faces = Faces::smooth;
                         s.contact.stiffness *= stiffer;
                         // springs as stiff as that have no equilibrium that is found
                         if (s.contact.law == ContactLaw::multiplier || s.contact.stiffness > 1e20)
                           s.initial = Initial::rest;
                       }});
}

TEST_P(HeldOnSmoothFaces, RandomScenesAreTheSameBitForBitOverAllCellsAndCandidates) {
  Seen seen;
  int in_two_or_more = 0;
  for (const double stiffer : {1.0, 1e4})
    for (int seed = 1; seed <= draws(5); ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", stiffer " + std::to_string(stiffer));
      const Started c = random_smooth_scene(6000 + 7 * seed, GetParam(), stiffer);
      const Outcome all = march(c.model, c.start, Nodes::all);
      const Outcome some = march(c.model, c.start, Nodes::candidates);
      EXPECT_TRUE(same(all, some));
      seen.count(all.end.contact_steps, all.end.shocks_begun);
      in_two_or_more += all.end.most_nodes > 1;
    }
  if (!draws_enough()) return;
  EXPECT_GE(seen.touching, seen.scenes / 2);
  EXPECT_GE(seen.with_shocks, seen.scenes / 6);
  EXPECT_GE(in_two_or_more, seen.scenes / 10);
}

TEST_P(HeldOnSmoothFaces, LaunchesAndSavedStatesGiveTheSameBits) {
  for (const int seed : {3, 5}) {
    const Started c = random_smooth_scene(6000 + 7 * seed, GetParam(), 100);
    const Outcome whole = march(c.model, c.start, c.model.scene.time.nodes);
    EXPECT_TRUE(same(whole, march_from_saved_states(c.model, c.start, 1)));
  }
}

/// Modes that do not fill the lanes leave no trace.
TEST_P(HeldOnSmoothFaces, PaddingGivesTheSameBits) {
  Scene s = with(rough_scene(Support::free), GetParam());
  s.faces = Faces::smooth;
  s.initial = Initial::statics;
  s.duration = 1e-4;
  s.time.step = 1e-7;
  s.output.rate = 1e6;
  const Recording whole = simulate(s);
  ASSERT_EQ(whole.end.status, Status::done);
  EXPECT_GT(whole.end.contact_steps, 100);
  for (const int packs : {3, 8}) {
    const Recording padded = simulate(s, {.batch = {.least_packs = packs}});
    EXPECT_EQ(whole.samples.force, padded.samples.force) << packs;
    EXPECT_EQ(whole.end.slider_v, padded.end.slider_v) << packs;
  }
}

// ---- the conditions of multipliers
// ---------------------------------------------------------------

/// Overlaps between the nodes by direct evaluation, and a bound on their roundings.
class SmoothOverlaps {
 public:
  SmoothOverlaps(const Model& model, std::int64_t step, const double* u2, const double* u1)
      : m_{model},
        u2_{u2},
        u1_{u1},
        position_{std::fma(static_cast<double>(step), m_.advance, m_.position)} {}

  double at(int cell, double share) const {
    const double s = cell + share, x = position_ + s, chi = m_.scene.spacing;
    long double sum = static_cast<long double>(spline(m_.slider_height, m_.slider_curvature, s)) -
                      m_.delta + spline(m_.resonator_height, m_.resonator_curvature, x);
    for (std::size_t k = 0; k < m_.resonator.modes.size(); ++k)
      sum += static_cast<long double>(shape_at(m_.resonator.modes[k], x * chi)) * u2_[k];
    for (std::size_t k = 0; k < m_.slider.modes.size(); ++k)
      sum += static_cast<long double>(shape_at(m_.slider.modes[k], s * chi)) * u1_[k];
    return static_cast<double>(sum);
  }
  /// The largest of a cell: of nine places, and of a search between the neighbours of the best.
  double highest(int cell) const {
    constexpr int parts = 8;
    int best = 0;
    double most = -1e300;
    for (int i = 0; i <= parts; ++i)
      if (const double over = at(cell, static_cast<double>(i) / parts); over > most) {
        most = over;
        best = i;
      }
    if (most < -1e-7) return most;
    double low = std::max(0, best - 1) / static_cast<double>(parts),
           high = std::min(parts, best + 1) / static_cast<double>(parts);
    for (int i = 0; i < 60; ++i) {
      const double left = low + (high - low) / 3, right = high - (high - low) / 3;
      (at(cell, left) < at(cell, right) ? low : high) =
          at(cell, left) < at(cell, right) ? left : right;
    }
    return std::max(most, at(cell, 0.5 * (low + high)));
  }
  /// ContactTables::tolerance and the roundings here; of the modes' sums; of the position, which
  /// the face's slope turns into heights; and what cubics along a cell leave out of the modes.
  double bound() const {
    double highest = std::abs(m_.delta), highest2 = 0, steepest = 0, modes = 0, left_out = 0;
    for (const double h : m_.slider_height) highest = std::max(highest, std::abs(h - m_.delta));
    for (std::size_t n = 0; n < m_.resonator_height.size(); ++n) {
      highest2 = std::max(highest2, std::abs(m_.resonator_height[n]));
      if (n > 0)
        steepest =
            std::max(steepest, std::abs(m_.resonator_height[n] - m_.resonator_height[n - 1]));
    }
    for (const Body* body : {&m_.resonator, &m_.slider})
      for (std::size_t k = 0; k < body->modes.size(); ++k) {
        const ModeShape& shape = *body->modes[k].shape;
        const double size = shape.largest() * std::abs((body == &m_.resonator ? u2_ : u1_)[k]);
        modes += size;
        left_out += size * std::pow(0.5 * shape.wave_number() * m_.scene.spacing, 4) / 24;
      }
    const double positions = static_cast<double>(m_.resonator_height.size());
    return eps * (128 * (highest + highest2) + 320 * modes + 4 * positions * steepest) +
           2 * left_out;
  }

 private:
  const Model& m_;
  const double *u2_, *u1_;
  double position_;

  static double spline(const std::vector<double>& height, const std::vector<double>& curvature,
                       double x) {
    const std::size_t left = std::min(static_cast<std::size_t>(x), height.size() - 2);
    const double b = x - static_cast<double>(left), a = 1 - b;
    return a * height[left] + b * height[left + 1] +
           ((a * a * a - a) * curvature[left] + (b * b * b - b) * curvature[left + 1]) / 6;
  }
};

struct MultipliersOnSmoothFaces : testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, MultipliersOnSmoothFaces,
                         testing::ValuesIn(kinds.begin(), kinds.end() - 1),
                         [](const auto& tested) { return tested.param.name; });

/// The rough scene under a load, sampled at every step.
Scene pressed_scene(Support slider, const Scheme& kind) {
  Scene s = with(rough_scene(slider), kind);
  s.faces = Faces::smooth;
  s.spacing = 2e-5;
  s.time.step = 1e-7;
  s.resonator.modes = 6;
  if (s.slider.modes == 2) s.slider.modes = 1;
  if (s.gap) s.gap = 0;
  s.duration = 3e-4;
  s.output.rate = 1e7;
  s.initial = slider == Support::rigid ? Initial::rest : Initial::statics;
  return s;
}

TEST_P(MultipliersOnSmoothFaces, NothingOverlapsAnywhereAndForcesOnlyPushWhereFacesTouch) {
  for (const Support support : {Support::free, Support::pinned}) {
    SCOPED_TRACE(static_cast<int>(support));
    const Recording r = simulate(pressed_scene(support, GetParam()));
    ASSERT_EQ(r.end.status, Status::done);
    const Model& m = r.model;
    const SampleBlock& s = r.samples;
    const std::size_t modes2 = m.resonator.modes.size(), modes1 = m.slider.modes.size();
    double turnover = 0;
    int pushed = 0;
    for (std::size_t i = 0; i < s.time.size(); ++i) {
      const double stored = s.kinetic[i] + s.elastic[i] + s.contact[i] + s.damping_loss[i];
      const double paid = s.sliding_work[i] + s.load_work[i] + r.start.energy;
      turnover =
          std::max({turnover, stored, std::abs(s.sliding_work[i]), std::abs(s.load_work[i])});
      // the contact gives nothing: up to the square of a step's way, as between linear faces
      ASSERT_LE(stored - paid, m.advance * m.advance * turnover) << "sample " << i;
      ASSERT_EQ(s.contact[i], 0);
      if (i % 20 != 0) continue;
      const SmoothOverlaps overlaps(m, static_cast<std::int64_t>(i),
                                    s.resonator_displacement.data() + i * modes2,
                                    s.slider_displacement.data() + i * modes1);
      const double bound = overlaps.bound();
      int touching = 0;
      for (int cell = 0; cell + 1 < m.nodes(); ++cell) {
        const double over = overlaps.highest(cell);
        ASSERT_LE(over, bound) << "sample " << i << " cell " << cell;
        touching += over >= -bound;
      }
      ASSERT_GE(touching, s.nodes[i]) << "sample " << i << ": force across a gap";
      ASSERT_EQ(s.force[i] > 0, s.nodes[i] > 0) << "sample " << i;
      ASSERT_GE(s.force[i], 0) << "sample " << i;
      pushed += s.force[i] > 0;
    }
    EXPECT_GE(r.end.shocks_begun, 2);
    EXPECT_GE(pushed, 5);
    if (support == Support::free) {
      EXPECT_GE(r.end.most_nodes, 2);
    }
  }
}

/// A free slider with the face of a parabola on a rigid flat body.
Scene bump_scene(const Scheme& kind) {
  Scene s = plate_scene(1, 0.004, 0.004);
  s.resonator = rigid(s.resonator);
  s.faces = Faces::smooth;
  s.spacing = 8e-6;
  s.start = 0.01;
  s.gap = 0;
  s.slider.support = Support::free;
  s.slider.modes = 0;
  s.slider.load = 2;
  s.contact.stiffness = 1e15;
  s.time.step = 1e-6;
  s.duration = 2e-3;
  s.output.rate = 1e5;
  return with(s, kind);
}
constexpr double bump_radius = 0.02;
constexpr double bump_rounding = 256 * eps * 1e-4;  // m, of overlaps: of heights of up to 1e-4 m
/// With the summit `share` of a cell off the middle node; the slider does not turn.
Started with_bump(const Scene& s, double share) {
  Started c{make_model(s), {}};
  Model& m = c.model;
  for (int n = 0; n < m.nodes(); ++n) {
    const double x = (n - 250 - share) * s.spacing;
    m.slider_height.edit()[n] = -x * x / (2 * bump_radius);
  }
  m.slider_curvature = spline_curvatures(m.slider_height);
  m.slider.modes.pop_back();
  m.slider.load.pop_back();
  c.start = make_start(m);
  return c;
}
Recording run_of(const Started& c) {
  return simulate(std::vector{c.model}, std::vector{c.start}).front();
}

/// It slides on its summit, wherever that stands between the nodes of either face: neither height
/// nor force know of them. On its nodes alone it would fall by spacing^2/(8 R), 0.4 nm.
TEST_P(MultipliersOnSmoothFaces, ABumpThatSlidesDoesNotFeelTheNodes) {
  Scene s = bump_scene(GetParam());
  s.speed = 1;  // an eighth of a cell a step
  s.output.rate = 1e6;
  for (const double share : {0.0, 0.3, 0.77}) {
    SCOPED_TRACE(share);
    const Recording run = run_of(with_bump(s, share));
    ASSERT_EQ(run.end.status, Status::done);
    // roundings of a gap move the slider's mass in a step, twice as fast where the step before had
    // the other sign
    const double shaken = 4 * run.model.slider.mass * bump_rounding / (s.time.step * s.time.step);
    // midpoint begins half a step before
    for (std::size_t i = 2; i < run.samples.time.size(); ++i) {
      ASSERT_NEAR(run.samples.slider_displacement[i], 0, 2 * bump_rounding) << "sample " << i;
      ASSERT_NEAR(run.samples.force[i], s.slider.load, shaken) << "sample " << i;
    }
    EXPECT_EQ(run.end.contact_steps, run.model.steps);
    EXPECT_EQ(run.end.shocks_begun, 1);
  }
}

/// It flies onto the flat face and hits it `theta` steps away: the summit lies between two nodes.
TEST_P(MultipliersOnSmoothFaces, AnImpactGivesBackWhatTheSchemeSays) {
  const bool stops = is_semi_implicit(GetParam().time.scheme);
  constexpr double speed = 0.1;
  for (const double theta : {0.1, 0.4, 0.8}) {
    Scene s = bump_scene(GetParam());
    s.slider.load = 0;
    s.duration = 20 * s.time.step;
    s.output.rate = 1 / s.time.step;
    s.gap = (7 + theta) * speed * s.time.step;
    Started c = with_bump(s, 0.3);
    c.start.slider_v[0] = speed * std::sqrt(s.slider.length);
    count_energy(c.model, c.start);
    const Recording run = run_of(c);
    ASSERT_EQ(run.end.status, Status::done);
    const double back = run.end.slider_v[0] / c.start.slider_v[0];
    EXPECT_NEAR(back, stops ? 0.0 : -std::abs(1 - 2 * theta),
                4 * bump_rounding / (speed * s.time.step))
        << "theta " << theta;
  }
}

/// Let go in equilibrium, a rough slider stays where it is.
TEST_P(MultipliersOnSmoothFaces, AStaticStartStaysAtRest) {
  Scene s = plate_scene(8, 0.012, 0.012);
  s.faces = Faces::smooth;
  s.start = 0.021;
  s.initial = Initial::statics;
  s.slider.support = Support::free;
  s.slider.load_is_weight = true;
  s.resonator.surface = gaussian(2e-6, 8e-4, 3);
  s.slider.surface = gaussian(2e-6, 8e-4, 4);
  s.time.step = 1e-6;
  s.duration = 5e-4;
  s.output.rate = 1e6;
  s = with(s, GetParam());
  const Recording run = simulate(s);
  ASSERT_EQ(run.end.status, Status::done);
  const double load = run.model.slider.load_force;
  EXPECT_NEAR(run.start.contact_force, load, 1e-12 * load);
  EXPECT_GE(run.start.loaded_nodes.size(), 2u);
  const SmoothOverlaps overlaps(run.model, 0, run.start.resonator_u.data(),
                                run.start.slider_u.data());
  const double bound = overlaps.bound();
  for (int cell = 0; cell + 1 < run.model.nodes(); ++cell) EXPECT_LE(overlaps.highest(cell), bound);
  for (const int cell : run.start.loaded_nodes) EXPECT_GE(overlaps.highest(cell), -bound);
  const double shaken = 4 * run.model.slider.mass * bound / (s.time.step * s.time.step);
  for (const double force : run.samples.force) ASSERT_NEAR(force, load, shaken);
}

/// The second mode alone, pushed up against a flat body that stands on both sides of its node.
TEST_P(MultipliersOnSmoothFaces, ABlockedSceneIsReported) {
  Scene s = plate_scene(2, 0.02, 1e-3);
  s.faces = Faces::smooth;
  s.gap = 1e-9;
  s.duration = 2e-5;
  s.resonator.moving_forces = {{.force = 1, .speed = 0, .start = 0.015}};
  s = with(s, GetParam());
  Started c{make_model(s), {}};
  c.model.resonator.modes.erase(c.model.resonator.modes.begin());
  c.model.resonator.load.pop_back();
  c.start = make_start(c.model);
  const Recording open = run_of(c);
  EXPECT_EQ(open.end.status, Status::done);
  EXPECT_GT(open.end.contact_steps, 0);
  c.model.delta = -1e-9;  // what overlaps can go to neither side
  const Recording blocked = run_of(c);
  EXPECT_EQ(blocked.end.status, Status::blocked);
  EXPECT_EQ(blocked.end.step, 0);
}

// ---- the penalty force of the new time ----------------------------------------------------------

/// Damped by its own implicit force it comes to rest where the integrated force is the load, 4/3
/// kappa w d sqrt(2 R d), wherever its summit stands. So it approaches the multiplier, which has no
/// depth, as kappa^(-2/3).
TEST(NewForceOnSmoothFaces, AParabolaComesToRestInItsClosedForm) {
  for (const double kappa : {1e14, 1e15, 1e17})
    for (const double share : {0.0, 0.3, 0.77}) {
      SCOPED_TRACE(fmt::format("{} Pa/m, {}", kappa, share));
      Scene s = bump_scene(new_force);
      s.contact.stiffness = kappa;
      Started c = with_bump(s, share);
      const double factor = kappa * s.slider.width * 4 / 3 * std::sqrt(2 * bump_radius);
      const double depth = std::pow(s.slider.load / factor, 2.0 / 3);
      c.start.slider_u[0] = 0.5 * depth * std::sqrt(s.slider.length);
      count_energy(c.model, c.start);
      const Recording run = run_of(c);
      ASSERT_EQ(run.end.status, Status::done);
      const double bound = bump_rounding / depth + 1e-9;
      EXPECT_NEAR(run.samples.force.back(), s.slider.load, bound * s.slider.load);
      EXPECT_NEAR(run.samples.contact.back(), 0.4 * s.slider.load * depth,
                  2 * bound * s.slider.load * depth);
      EXPECT_NEAR(run.end.slider_u[0] / std::sqrt(s.slider.length), depth, bound * depth);
    }
}

/// The force that the record shows is the one that moved the slider.
TEST(NewForceOnSmoothFaces, ForcesOfTheRecordAreThoseOfTheMotion) {
  for (const double kappa : {1e12, 1e14, 1e16}) {
    SCOPED_TRACE(kappa);
    Scene s = pressed_scene(Support::free, new_force);
    s.contact.stiffness = kappa;
    const Recording r = simulate(s);
    ASSERT_EQ(r.end.status, Status::done);
    const std::size_t modes1 = r.model.slider.modes.size();
    const double inertia =
        r.model.slider.modes[0].mass * std::sqrt(r.model.slider.length) / s.time.step;
    const double load = r.model.slider.load[0] * std::sqrt(r.model.slider.length);
    for (std::size_t i = 1; i < r.samples.time.size(); i += 7) {
      const double v0 = r.samples.slider_velocity[(i - 1) * modes1],
                   v1 = r.samples.slider_velocity[i * modes1];
      const double force = load - inertia * (v1 - v0);
      // roundings of velocities, and of an overlap on the springs in contact
      const double springs = kappa * s.slider.width * s.spacing * r.samples.nodes[i];
      const SmoothOverlaps overlaps(
          r.model, static_cast<std::int64_t>(i),
          r.samples.resonator_displacement.data() + i * r.model.resonator.modes.size(),
          r.samples.slider_displacement.data() + i * modes1);
      ASSERT_NEAR(
          r.samples.force[i], force,
          8 * eps * (load + inertia * (std::abs(v0) + std::abs(v1))) + overlaps.bound() * springs)
          << "sample " << i;
    }
    EXPECT_GE(r.end.contact_steps, 1000);
  }
}

/// The end of a motion through contacts that begin and end: (omega U, V) of the plate.
std::vector<double> end_of(const Scheme& kind, double step) {
  Scene s = pressed_scene(Support::free, kind);
  s.contact.stiffness = 1e13;
  s.duration = 1e-4;
  s.time.step = step;
  s.output.rate = 1e4;
  const Recording r = simulate(s);
  EXPECT_EQ(r.end.status, Status::done);
  EXPECT_GE(r.end.shocks_begun, 2);
  std::vector<double> y = r.end.resonator_v;
  y.insert(y.end(), r.end.slider_v.begin(), r.end.slider_v.end());
  return y;
}

/// Both forces of backward Euler go to the same motion, to first order in the step.
TEST(NewForceOnSmoothFaces, ConvergesToTheMotionOfTheOldForce) {
  const std::vector<double> exact = end_of({{{SchemeKind::rk4}, ContactLaw::penalty}, "Rk4"}, 1e-8);
  const auto error = [&](const Scheme& kind, double step) {
    const std::vector<double> found = end_of(kind, step);
    double sum = 0, size = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) {
      sum += std::pow(found[k] - exact[k], 2);
      size += std::pow(exact[k], 2);
    }
    return std::sqrt(sum / size);
  };
  for (const Scheme& kind : {old_force, new_force}) {
    const double coarse = error(kind, 4e-8), fine = error(kind, 1e-8);
    EXPECT_LT(fine, 0.05) << kind.name;
    EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.4) << kind.name;
  }
}

}  // namespace
}  // namespace ra2d::test
