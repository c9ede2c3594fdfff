// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "host/scene_file/scene_file.hpp"
#include "kernels/gap.hpp"
#include "tests/effort.hpp"
#include "tests/outcomes.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"

/// Contact forces that are solved for with the end of the step: Lagrange multipliers with every
/// scheme that allows them, and backward Euler with the penalty force of the new time.
namespace ra2d::test {
namespace {

using Vector = Eigen::VectorXd;
constexpr double ulp = std::numeric_limits<double>::epsilon();

const std::vector<Scheme> kinds = {
    {{{SchemeKind::backward_euler}, ContactLaw::multiplier}, "BackwardEuler"},
    {{{SchemeKind::midpoint}, ContactLaw::multiplier}, "Midpoint"},
    {{{SchemeKind::heun}, ContactLaw::multiplier}, "Heun"},
    {{{SchemeKind::rk4}, ContactLaw::multiplier}, "Rk4"},
    {{{SchemeKind::rk8}, ContactLaw::multiplier}, "Rk8"},
    {{{SchemeKind::exact}, ContactLaw::multiplier}, "Exact"},
    {{{SchemeKind::gautschi}, ContactLaw::multiplier}, "Gautschi"},
    {{{SchemeKind::backward_euler, ForceTime::new_time}}, "FullyImplicit"}};
constexpr int multipliers = 7, all_kinds = 8;  // the first seven are multipliers
const Scheme &backward_euler = kinds[0], &heun = kinds[2], &exact = kinds[5], &implicit = kinds[7];

/// U1 - U0 of a force is tau (V1 - V0), and not half of it.
bool stops_on_the_face(const Scheme& kind) { return is_semi_implicit(kind.time.scheme); }

class Multipliers : public testing::TestWithParam<int> {
 protected:
  const Scheme& kind() const { return kinds[GetParam()]; }
};
class HeldForces : public Multipliers {};
const auto kind_name = [](const auto& info) { return std::string(kinds[info.param].name); };
INSTANTIATE_TEST_SUITE_P(Schemes, Multipliers, testing::Range(0, multipliers), kind_name);
INSTANTIATE_TEST_SUITE_P(Schemes, HeldForces, testing::Range(0, all_kinds), kind_name);

/// The rough scene under a load, sampled at every step.
Scene pressed_scene(Support slider, const Scheme& kind) {
  Scene s = with(rough_scene(slider), kind);
  s.resonator.modes = 12;
  if (s.slider.modes == 2) s.slider.modes = 1;  // the second is too fast for Heun
  if (s.gap) s.gap = 0;
  s.duration = 3e-4;
  s.output.rate = 1e7;
  s.initial = Initial::statics;
  return s;
}

// ---- the conditions, over whole runs ------------------------------------------------------------

/// Gaps by direct evaluation, and a bound on their roundings.
class Gaps {
 public:
  explicit Gaps(const Model& model) : m_{model} {
    double highest = 0, highest2 = 0;
    for (const double h : m_.slider_height) highest = std::max(highest, std::abs(h - m_.delta));
    for (const double h : m_.resonator_height) highest2 = std::max(highest2, std::abs(h));
    highest_ = highest + highest2;
    for (std::size_t n = 0; n + 1 < m_.resonator_height.size(); ++n)
      steepest_ =
          std::max(steepest_, std::abs(m_.resonator_height[n + 1] - m_.resonator_height[n]));
    for (int n = 0; n < m_.nodes(); ++n)
      for (const BodyMode& mode : m_.slider.modes) {
        slider_.push_back(0);
        mode.shape->evaluate(n * m_.scene.spacing, 1, &slider_.back());
      }
  }
  /// Largest overlap, and the number of nodes that touch to within `bound`.
  double largest(std::int64_t step, const double* u2, const double* u1, double bound,
                 int& touching) const {
    const double position = std::fma(static_cast<double>(step), m_.advance, m_.position);
    const int base = static_cast<int>(position);
    const long double theta = position - base;
    const std::size_t modes1 = m_.slider.modes.size();
    double largest = -1e300;
    touching = 0;
    for (int n = 0; n < m_.nodes(); ++n) {
      const std::size_t next = std::min<std::size_t>(base + n + 1, m_.resonator_height.size() - 1);
      long double u1_n = 0, u2_n = 0;
      for (std::size_t k = 0; k < m_.resonator.modes.size(); ++k) {
        const double psi = shape_at(m_.resonator.modes[k], (position + n) * m_.scene.spacing);
        u2_n += static_cast<long double>(psi) * u2[k];
      }
      for (std::size_t k = 0; k < modes1; ++k)
        u1_n += static_cast<long double>(slider_[n * modes1 + k]) * u1[k];
      const FaceBetweenNodes<long double> h2{m_.resonator_height[base + n],
                                             m_.resonator_height[next], theta};
      const auto overlap =
          static_cast<double>(-gap<long double>(m_.delta, m_.slider_height[n], u1_n, h2, u2_n));
      largest = std::max(largest, overlap);
      touching += std::abs(overlap) <= bound;
    }
    return largest;
  }
  /// 16 roundings of the faces (ContactTables::tolerance), 64 of the sum over the modes, of
  /// polynomials there and of sines here, and two of the position, which the face's slope turns
  /// into heights.
  double bound(const std::vector<double>& ends) const {
    double sum = 0;
    for (std::size_t k = 0; k < m_.resonator.modes.size(); ++k)
      sum += m_.resonator.modes[k].shape->largest() * ends[k];
    for (std::size_t k = 0; k < m_.slider.modes.size(); ++k)
      sum += m_.slider.modes[k].shape->largest() * ends[m_.resonator.modes.size() + k];
    const double positions = static_cast<double>(m_.resonator_height.size());
    return ulp * (16 * highest_ + 64 * sum + 2 * positions * steepest_);
  }

 private:
  const Model& m_;
  double highest_ = 0, steepest_ = 0;
  std::vector<double> slider_;  // (node, mode)
};

/// Checks the samples of a run, all of them or one in `every`. Samples are taken at whole steps.
void expect_conditions(const Recording& r, std::size_t every) {
  const Model& m = r.model;
  const Gaps gaps(m);
  const SampleBlock& s = r.samples;
  const std::size_t modes2 = m.resonator.modes.size(), modes1 = m.slider.modes.size();
  const std::int64_t steps = std::llround(m.steps_per_sample);
  std::vector<double> ends(modes2 + modes1);
  for (std::size_t i = 0; i < s.time.size(); i += every) {
    const double* u2 = s.resonator_displacement.data() + i * modes2;
    const double* u1 = s.slider_displacement.data() + i * modes1;
    for (std::size_t k = 0; k < modes2 + modes1; ++k)
      ends[k] = std::abs(k < modes2 ? u2[k] : u1[k - modes2]);
    const double bound = gaps.bound(ends);
    int touching = 0;
    const double over = gaps.largest(steps * static_cast<std::int64_t>(i), u2, u1, bound, touching);
    ASSERT_LE(over, bound) << "sample " << i;
    ASSERT_GE(touching, s.nodes[i]) << "sample " << i << ": force across a gap";
    ASSERT_EQ(s.force[i] > 0, s.nodes[i] > 0) << "sample " << i;
    ASSERT_GE(s.force[i], 0) << "sample " << i;
  }
}

/// The force by the free slider's translation, m (V1 - V0) = tau (load - f)/sqrt(L): nothing else
/// acts on it. Roundings of the two velocities.
void expect_momentum(const Recording& r) {
  const Model& m = r.model;
  const SampleBlock& s = r.samples;
  const std::size_t modes1 = m.slider.modes.size();
  const double inertia = m.slider.modes[0].mass * std::sqrt(m.slider.length) / m.scene.time.step;
  const double load = m.slider.load[0] * std::sqrt(m.slider.length);
  // a velocity half a step before: samples without contact hold that of their own time
  const double lead =
      scheme_table(m.scene.time.scheme).velocity_lag > 0 ? 0.5 * load / inertia : 0.0;
  const auto velocity = [&](std::size_t i) {
    return s.slider_velocity[i * modes1] - (s.force[i] > 0 ? 0.0 : lead);
  };
  for (std::size_t i = 1; i < s.time.size(); ++i) {
    const double v0 = velocity(i - 1), v1 = velocity(i);
    const double force = load - inertia * (v1 - v0);
    ASSERT_NEAR(s.force[i], force,
                8 * ulp * (load + s.force[i] + inertia * (std::abs(v0) + std::abs(v1))))
        << "sample " << i;
  }
}

/// Stored energy and losses never exceed the work put in: the contact takes f times the gap before
/// the step, and gives nothing. The work of the imposed motion is summed from the rise of the faces
/// at the end of each step, which leaves an error of the square of the step's way.
void expect_no_energy_from_nowhere(const Recording& r) {
  const SampleBlock& s = r.samples;
  double turnover = 0;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    const double stored = s.kinetic[i] + s.elastic[i] + s.contact[i] + s.damping_loss[i];
    const double paid = s.sliding_work[i] + s.load_work[i] + r.start.energy;
    turnover = std::max({turnover, stored, std::abs(s.sliding_work[i]), std::abs(s.load_work[i])});
    ASSERT_LE(stored - paid, r.model.advance * r.model.advance * turnover) << "sample " << i;
  }
}

/// Nothing touches: the law has no effect. Every scheme of second order or more falls exactly.
TEST(MultipliersInFlight, MidpointFallsAsItDoesUnderPenalty) {
  for (const ContactLaw law : {ContactLaw::penalty, ContactLaw::multiplier}) {
    SCOPED_TRACE(law == ContactLaw::penalty ? "penalty" : "multiplier");
    Scene s = plate_scene(3, 0.012, 0.012);
    s.contact.law = law;
    s.contact.stiffness = 1e12;
    s.time.scheme = SchemeKind::midpoint;
    s.slider.support = Support::free;
    s.slider.load = 3;
    s.gap = 1;
    s.output.rate = 1e5;
    const Recording r = simulate(s);
    const double acceleration = r.model.slider.load[0] / r.model.slider.modes[0].mass;
    const std::size_t modes = r.model.slider.modes.size();
    ASSERT_GT(r.samples.time.size(), 2u);
    for (std::size_t i = 0; i < r.samples.time.size(); ++i) {
      const double t = r.samples.time[i], steps = t / s.time.step;
      // a rounding a step, of each of the two
      EXPECT_NEAR(r.samples.slider_velocity[i * modes], acceleration * t,
                  (8 + steps) * ulp * acceleration * t);
      EXPECT_NEAR(r.samples.slider_displacement[i * modes], 0.5 * acceleration * t * t,
                  (8 + steps) * ulp * acceleration * t * t);
    }
  }
}

TEST_P(Multipliers, NothingOverlapsAndForcesOnlyPushWhereFacesTouch) {
  for (const Support support : {Support::free, Support::pinned, Support::rigid}) {
    SCOPED_TRACE(static_cast<int>(support));
    const Recording r = simulate(pressed_scene(support, kind()));
    ASSERT_EQ(r.end.status, Status::done);
    expect_conditions(r, 4);
    expect_no_energy_from_nowhere(r);
    EXPECT_GE(r.end.shocks_begun, 2);
    if (support != Support::free) continue;
    EXPECT_GE(r.end.contact_steps, 2000);
    EXPECT_GE(r.end.most_nodes, 2);
    expect_momentum(r);
  }
}

TEST(MultipliersOfThePaper, NothingOverlapsInTheScenesOfThePaper) {
  for (const char* file : {"dang2012", "dang2012-pinned"})
    for (const Scheme& kind : {backward_euler, exact}) {
      SCOPED_TRACE(std::string(file) + " " + kind.name);
      Scene s = read_scene(scene_file(file));
      s = with(s, kind);
      s.duration = 4e-4;
      s.output.rate = 2.5e5;                      // one in 400 steps
      if (s.slider.support == Support::pinned) {  // to meet within this time
        s.gap = 1.2e-5;
        s.start = 0.099;  // uphill
        s.speed = 2;
      }
      const Recording r = simulate(s);
      ASSERT_EQ(r.end.status, Status::done);
      expect_conditions(r, 1);
      EXPECT_GE(r.end.shocks_begun, 1);
    }
}

// ---- rest -------------------------------------------------------------------------------------

/// A free slider that rests on a plate, on these nodes alone (none: flat on flat).
Scene resting_scene(const std::vector<int>& nodes, const Scheme& kind) {
  Scene s = plate_scene(6, 0.004, 1e-3);
  s.spacing = 2e-4;  // 21 nodes
  s.slider.support = Support::free;
  s.slider.modes = kind.time.scheme == SchemeKind::heun ? 0 : 1;  // see MultipliersOfHeun
  s.slider.load_is_weight = true;
  s.initial = Initial::statics;
  s.duration = 1e-3;
  s.output.rate = 1e7;
  s.contact.stiffness = 1e13;
  std::vector<Peak> list;
  for (const int n : nodes)
    list.push_back({.at = n * s.spacing, .height = 1e-6, .half_width = 0.5 * s.spacing});
  if (!list.empty()) s.slider.surface = peaks(list);
  return with(s, kind);
}

/// Bounds on the effect of roundings of the gaps on a resting slider. Force: an overlap off by e
/// moves the slider's mass by e in a step, at most 2 M e/tau^2; twice that when the step before had
/// the other sign. Kinetic energy: such a force f gives a mode (tau f phi)^2/2m in a step.
void expect_rest(const Recording& r) {
  ASSERT_EQ(r.end.status, Status::done);
  const Model& m = r.model;
  const Gaps gaps(m);
  std::vector<double> ends;
  for (const double u : r.start.resonator_u) ends.push_back(std::abs(u));
  for (const double u : r.start.slider_u) ends.push_back(std::abs(u));
  const double off = gaps.bound(ends), tau = m.scene.time.step;
  const double mass = m.slider.mass;
  const double weight = m.slider.load[0] * std::sqrt(m.slider.length);
  const double shaken = 4 * mass * off / (tau * tau);
  const double compliance = largest_shape(m.slider) + largest_shape(m.resonator);
  for (std::size_t i = 0; i < r.samples.time.size(); ++i) {
    ASSERT_NEAR(r.samples.force[i], weight, shaken) << "sample " << i;
    ASSERT_LE(r.samples.kinetic[i], 0.5 * std::pow(tau * shaken, 2) * compliance) << "sample " << i;
  }
  EXPECT_EQ(r.end.contact_steps, m.steps);
}

TEST_P(Multipliers, RestingSliderKeepsItsWeightAtEveryStep) {
  for (const std::vector<int>& nodes : {std::vector<int>{10}, {3, 16}, {2, 11, 12, 19}, {}}) {
    SCOPED_TRACE(std::to_string(nodes.size()) + " nodes");
    expect_rest(simulate(resting_scene(nodes, kind())));
  }
}

TEST_P(Multipliers, RestingSliderStaysAtRest) {
  Scene s = resting_scene({3, 16}, kind());
  s.duration = 1e5 * s.time.step;
  s.output.rate = 1e5;
  expect_rest(simulate(s));
}

TEST(MultipliersOfHeun, StiffModeShakesARestingSlider) {
  // The velocity of the node that is held grows by x^2/2 - 2 zeta x a step, x = omega tau of the
  // slider's mode, which yields the most (kernels/schemes/heun.hpp). That ends where the slider
  // leaves the face, at rates of g tau.
  Scene s = resting_scene({10}, heun);
  s.slider.modes = 1;
  s.duration = 3e-3;
  const Recording shaken = simulate(s);
  ASSERT_EQ(shaken.end.status, Status::done);
  const Body& slider = shaken.model.slider;
  EXPECT_GT(slider.modes[2].omega * s.time.step, 8 * slider.modes[0].zeta);
  const double mass = slider.mass;
  const double rate = slider.load[0] * std::sqrt(slider.length) / mass * s.time.step;
  const auto& kinetic = shaken.samples.kinetic;
  const double most = *std::max_element(kinetic.begin(), kinetic.end());
  EXPECT_GE(most, 0.05 * mass * rate * rate);
  EXPECT_LE(most, 10 * mass * rate * rate);

  s.time.step = 1e-8;
  s.output.rate = 1e7;
  EXPECT_LT(slider.modes[2].omega * s.time.step, 2 * slider.modes[0].zeta);
  expect_rest(simulate(s));
}

// ---- impacts ----------------------------------------------------------------------------------

constexpr double impact_speed = 0.1;  // m/s

/// A free slider without load that flies onto a body that does not move, and hits it with the node
/// in its middle from `theta` steps away.
Started mass_on_a_wall(double theta, const Scheme& kind) {
  Scene s = plate_scene(0, 0.004, 1e-3);
  s.resonator = rigid(s.resonator);
  s.spacing = 2e-4;
  s.slider.support = Support::free;
  s.slider.modes = 0;
  s.slider.surface = peaks({{.at = 10 * s.spacing, .height = 1e-6, .half_width = 0.5 * s.spacing}});
  s.duration = 20 * s.time.step;
  s.output.rate = 1 / s.time.step;
  s.contact.stiffness = 1e13;
  s = with(s, kind);
  s.gap = 1e-6 + (7 + theta) * impact_speed * s.time.step;
  Started c{make_model(s), {}};
  c.start = make_start(c.model);
  c.start.slider_v[0] = impact_speed * std::sqrt(s.slider.length);
  count_energy(c.model, c.start);
  return c;
}

TEST_P(Multipliers, ImpactOfAMassGivesBackWhatTheSchemeSays) {
  constexpr int offsets = 64;
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  for (int i = 0; i < offsets; ++i) {
    const Started c = mass_on_a_wall((i + 0.5) / offsets, kind());
    models.push_back(c.model);
    starts.push_back(c.start);
  }
  Batch batch(models, starts);
  batch.march(models[0].steps);
  double mean = 0;
  for (int i = 0; i < offsets; ++i) {
    const Snapshot end = batch.snapshot(i);
    ASSERT_EQ(end.status, Status::done);
    const double theta = (i + 0.5) / offsets, back = end.slider_v[0] / starts[i].slider_v[0];
    mean += back * back / offsets;
    // it leaves at once, or turns round in the next step, which begins on the face
    const double expected = stops_on_the_face(kind()) ? 0.0 : -std::abs(1 - 2 * theta);
    // roundings of the gap, over the way of a step
    const double off = 8 * ulp * 2e-6 / (impact_speed * models[i].scene.time.step);
    EXPECT_NEAR(back, expected, off) << "theta " << theta;
    EXPECT_NEAR(end.slider_v[1], 0, off * starts[i].slider_v[0]) << "it turns";
  }
  // the mean of (1 - 2 theta)^2 over these offsets
  const double third = (1 - 1.0 / (offsets * offsets)) / 3;
  EXPECT_NEAR(mean, stops_on_the_face(kind()) ? 0.0 : third, 1e-12);
}

/// A plate that swings up onto one peak of a rigid body, undamped, without gravity.
Started plate_on_a_peak(int modes, double duration, int steps, const Scheme& kind) {
  Scene s = plate_scene(modes, 0.004, 0.004, 0.0);
  s.spacing = 2e-4;
  s.slider.surface = peaks({{.at = 10 * s.spacing, .height = 1e-5, .half_width = 0.5 * s.spacing}});
  s.start = 0.017;  // the peak stands at 19 mm of 60
  s.gap = 1.01e-5;
  s.duration = duration;
  s.time.step = duration / steps;
  s.output.rate = 1 / duration;
  s.contact.stiffness = 1e13;
  s = with(s, kind);
  Started c{make_model(s), {}};
  c.start = make_start(c.model);
  c.start.resonator_v[0] = 0.02 / c.model.resonator.modes[0].shape->largest();
  count_energy(c.model, c.start);
  return c;
}
Vector shape_at_the_peak(const Model& m) {
  Vector phi(m.resonator.modes.size());
  for (int k = 0; k < phi.size(); ++k)
    m.resonator.modes[k].shape->evaluate(m.scene.start + 10 * m.scene.spacing, 1, &phi[k]);
  return phi;
}
/// (omega U, V) at the end.
Vector end_of(const Started& c) {
  Batch batch({c.model}, {c.start});
  do {  // every bounce is a shock to be handed out
    batch.march(c.model.steps);
    batch.drain(0);
  } while (batch.snapshot(0).status == Status::running);
  const Snapshot end = batch.snapshot(0);
  EXPECT_EQ(end.status, Status::done);
  const int modes = static_cast<int>(c.model.resonator.modes.size());
  Vector y(2 * modes);
  for (int k = 0; k < modes; ++k) {
    y[k] = c.model.resonator.modes[k].omega * end.resonator_u[k];
    y[modes + k] = end.resonator_v[k];
  }
  return y;
}

/// Kinetic and elastic energy at the end, over that at the start.
double energy_left(const Started& c) {
  return end_of(c).squaredNorm() / std::pow(c.start.resonator_v[0], 2);
}

TEST_P(Multipliers, ImpactOfAPlateKeepsWhatTheProjectionLeaves) {
  // Backward Euler and midpoint converge, to first order, to the impact that stops the node: of
  // the velocities the part along phi is lost, (phi . V)^2/(phi . phi), the less the more modes
  // there are to carry the rest on. Then the node stays on the peak and nothing is lost. With the
  // others, the share that comes back depends on where in the step it meets the peak.
  constexpr double duration = 3e-5;
  double before = 0;
  for (const int modes : {1, 3, 6, 12}) {
    SCOPED_TRACE(std::to_string(modes) + " modes");
    double left[2];
    for (const int level : {0, 1})
      left[level] = energy_left(plate_on_a_peak(modes, duration, 32'000 << level, kind()));
    const Started c = plate_on_a_peak(modes, duration, 1000, kind());
    const Vector phi = shape_at_the_peak(c.model);
    const double omega = c.model.resonator.modes[0].omega, rate = c.start.resonator_v[0];
    // sine of the first mode's phase when it meets the peak: so much of its energy is elastic
    const double sine = omega * (*c.model.scene.gap - 1e-5) / (phi[0] * rate);
    const double expected = 1 - (1 - sine * sine) * phi[0] * phi[0] / phi.squaredNorm();
    for (const double share : left) EXPECT_LE(share, 1 + 1e-6);
    if (!stops_on_the_face(kind())) continue;
    // taken to tau = 0 along the first order; the second is a hundredth of that here
    EXPECT_NEAR(2 * left[1] - left[0], expected, 0.01 * std::abs(left[1] - left[0]) + 1e-7);
    EXPECT_GT(expected, before);
    before = expected;
  }
}

TEST(ImplicitPenalty, BecomesTheMultiplier) {
  // One impact of a plate of six modes, at a fixed step: with the compliance c = 1/(kappa chi w)
  // against W of the node, f = o/(W + c), so the difference falls like c/W, as 1/kappa.
  constexpr double duration = 1.2e-4;
  const Vector hard = end_of(plate_on_a_peak(6, duration, 1200, backward_euler));
  double softer = 0;
  for (int decade = 3; decade <= 8; ++decade) {
    Started c = plate_on_a_peak(6, duration, 1200, implicit);
    const Vector phi = shape_at_the_peak(c.model);
    const double compliance =
        std::pow(c.model.scene.time.step, 2) / c.model.resonator.modes[0].mass * phi.squaredNorm();
    const double ratio = std::pow(10.0, -decade);
    c.model.node_stiffness = 1 / (ratio * compliance);
    const double error = (end_of(c) - hard).norm() / hard.norm();
    // the next term is c/W smaller, with the number of steps in contact before it
    if (decade > 3) {
      EXPECT_NEAR(std::log10(softer / error), 1.0, 20 * ratio + 0.01) << "c/W " << ratio;
    }
    softer = error;
  }
}

// ---- blocked ----------------------------------------------------------------------------------

/// The second mode alone, pushed up against a flat body that stands on both sides of its node.
Started pinched(const Scheme& kind) {
  Scene s = plate_scene(2, 0.02, 1e-3);
  s.gap = 1e-9;
  s.duration = 2e-5;
  s.contact.stiffness = 1e13;
  s.resonator.moving_forces = {{.force = 1, .speed = 0, .start = 0.015}};
  s = with(s, kind);
  Started c{make_model(s), {}};
  c.model.resonator.modes.erase(c.model.resonator.modes.begin());
  c.model.resonator.load.pop_back();
  c.start = make_start(c.model);
  return c;
}

TEST_P(Multipliers, BlockedSceneIsReportedAndTheOthersGoOn) {
  const Started free = [&] {
    Scene s = pressed_scene(Support::free, kind());
    s.duration = 2e-5;
    Started c{make_model(s), {}};
    c.start = make_start(c.model);
    return c;
  }();
  const Started open = pinched(kind());  // the gap leaves room
  Started tight = open;                  // ... and here what overlaps could go to neither side
  tight.model.delta = -1e-9;
  const std::vector<Started> cases = {free, tight, open, free};
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  for (const Started& c : cases) {
    models.push_back(c.model);
    starts.push_back(c.start);
  }
  Batch batch(models, starts);
  batch.march(free.model.steps);
  EXPECT_EQ(batch.snapshot(1).status, Status::blocked);
  EXPECT_EQ(batch.snapshot(1).step, 0);
  EXPECT_EQ(batch.snapshot(2).status, Status::done);
  EXPECT_GT(batch.snapshot(2).contact_steps, 0);
  Batch alone({free.model}, {free.start});
  alone.march(free.model.steps);
  for (const int scene : {0, 3}) {
    EXPECT_EQ(batch.snapshot(scene).status, Status::done);
    EXPECT_TRUE(
        same("slider displacement", alone.snapshot(0).slider_u, batch.snapshot(scene).slider_u));
    EXPECT_TRUE(same("resonator velocity", alone.snapshot(0).resonator_v,
                     batch.snapshot(scene).resonator_v));
  }
}

// ---- bits -------------------------------------------------------------------------------------

TEST_P(HeldForces, RandomScenesAreTheSameBitForBit) {
  // at rest, creeping, up to several nodes a step; schemes within their limits and far beyond
  const int scenes = draws(60);
  int touching = 0, in_two_or_more = 0;
  double evaluated = 0, steps_nodes = 0;
  for (int seed = 1; seed <= scenes; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // from equilibrium start the scenes below
    const auto adapt = [&](Scene& s) {
      s.initial = Initial::rest;
      if (s.contact.law == ContactLaw::penalty)
        s.contact.stiffness *= 1e4;  // far beyond the limit of the old time
    };
    const Started c = random_scene(1000 * GetParam() + seed, {kind(), 0, adapt});
    const Outcome all = march(c.model, c.start, Nodes::all);
    const Outcome some = march(c.model, c.start, Nodes::candidates);
    EXPECT_TRUE(same(all, some));
    touching += all.end.contact_steps > 0;
    in_two_or_more += all.end.most_nodes > 1;
    if (all.end.status != Status::done) continue;
    evaluated += static_cast<double>(some.end.evaluated);
    steps_nodes += static_cast<double>(all.end.evaluated);
  }
  if (!draws_enough()) return;
  EXPECT_GE(touching, scenes / 2);
  EXPECT_GE(in_two_or_more, scenes / 5);
  EXPECT_LT(evaluated, 0.7 * steps_nodes);
}

TEST_P(HeldForces, ImpactThatThrowsTheOtherEndDownIsTheSameBitForBit) {
  // A bar that falls flat, one end first: that throws its other end down, at up to twice the speed.
  // The list of nodes made before the impact, for up to 256 steps, does not hold it then.
  for (const double steps_apart : {100.0, 200.0, 260.0, 300.0, 340.0, 400.0, 460.0, 520.0, 700.0})
    for (const double steps_before : {0.5, 3.3, 20.7, 90.2}) {
      SCOPED_TRACE(std::to_string(steps_apart) + " apart, " + std::to_string(steps_before));
      Scene s = with(plate_scene(3, 0.004, 1e-3), kind());
      s.slider.support = Support::free;
      s.slider.modes = 0;
      const double step_length = impact_speed * s.time.step;
      s.slider.surface = peaks({{.at = 0, .height = 1e-5, .half_width = 0.5 * s.spacing},
                                {.at = 0.004,
                                 .height = 1e-5 - steps_apart * step_length,
                                 .half_width = 0.5 * s.spacing}});
      s.gap = 1e-5 + steps_before * step_length;
      s.duration = 1000 * s.time.step;
      s.output.rate = 1 / s.duration;
      s.contact.stiffness = 1e15;
      const Model model = make_model(s);
      ModalStart start = make_start(model);
      start.slider_v[0] = impact_speed * std::sqrt(s.slider.length);
      count_energy(model, start);
      const Outcome all = expect_both_same(model, start);
      EXPECT_EQ(all.end.status, Status::done);
      EXPECT_GE(all.end.shocks_begun, 2);
    }
}

TEST_P(HeldForces, NodesPassingAtAnySpeedAreTheSameBitForBit) {
  for (const double nodes_per_step : {1e-9, 1e-6, 0.0031, 0.3, 0.97, 1.0, 1.37, 3.7}) {
    SCOPED_TRACE(nodes_per_step);
    std::int64_t contact = 0;
    for (const Support support : {Support::free, Support::pinned, Support::rigid}) {
      Scene s = pressed_scene(support, kind());
      s.speed = nodes_per_step * s.spacing / s.time.step;
      s.duration = std::min(2e-4, 0.03 / s.speed);
      s.output.rate = 1e7 / 13.7;
      const Model model = make_model(s);
      contact += expect_both_same(model, make_start(model)).end.contact_steps;
    }
    EXPECT_GT(contact, 10);
  }
}

TEST_P(HeldForces, FlatFacesAreTheSameBitForBit) {
  // all the nodes touch or nearly do, and what roundings leave decides
  for (const double speed : {0.0, 1.0}) {
    SCOPED_TRACE(speed);
    Scene s = pressed_scene(Support::free, kind());
    s.resonator.surface = s.slider.surface = SurfaceSpec{};
    s.speed = speed;
    s.duration = 1e-4;
    s.initial = Initial::rest;
    const Model model = make_model(s);
    ModalStart start = make_start(model);
    start.slider_v[0] = -0.01 * std::sqrt(s.slider.length);  // up, and back under its load
    count_energy(model, start);
    const Outcome all = expect_both_same(model, start);
    EXPECT_EQ(all.end.status, Status::done);
    EXPECT_GT(all.end.most_nodes, 1);
  }
}

/// Pressed, under a slider of each support.
std::vector<Scene> pressed_scenes(const Scheme& kind) {
  std::vector<Scene> scenes;
  for (const Support support : {Support::free, Support::pinned, Support::rigid})
    scenes.push_back(pressed_scene(support, kind));
  for (Scene& s : scenes) s.duration = 2.5e-4;
  scenes[0].output.rate = 1e7 / 3.7;  // not a whole number of steps
  scenes[1].resonator.moving_forces = {{.force = 3, .speed = 40, .start = 0.01}};
  return scenes;
}

TEST_P(HeldForces, LaunchesBuffersAndPaddingGiveTheSameBits) {
  for (const Scene& scene : pressed_scenes(kind())) {
    SCOPED_TRACE(static_cast<int>(scene.slider.support));
    const Recording whole = simulate(scene);
    ASSERT_EQ(whole.end.status, Status::done);
    EXPECT_GT(whole.end.contact_steps, 0);
    for (const std::int64_t steps : draws_enough() ? std::vector<std::int64_t>{1, 7, 97, 1000}
                                                   : std::vector<std::int64_t>{7, 1000})
      EXPECT_TRUE(same(whole, simulate(scene, {.steps = steps, .batch = {}}))) << steps;
    for (const int packs : {3, 8})
      EXPECT_TRUE(same(whole, simulate(scene, {.batch = {.least_packs = packs}})))
          << packs << " packs";
    const BatchOptions small{.capacity = {.samples = 2, .shocks = 1}};
    EXPECT_TRUE(same(whole, simulate(scene, {.steps = 1'000'000, .batch = small})));
  }
}

TEST_P(HeldForces, OtherScenesBesideItChangeNothing) {
  const std::vector<Scene> scenes = pressed_scenes(kind());
  const std::vector<Recording> batch = simulate(scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    EXPECT_TRUE(same(simulate(scenes[i]), batch[i])) << "scene " << i;
}

}  // namespace
}  // namespace ra2d::test
