// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "host/scene_file/scene_file.hpp"
#include "kernels/schemes/rk4.hpp"
#include "kernels/schemes/rk8.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"
#include "tests/schemes.hpp"
#include "tests/simulate.hpp"
#include "tests/step_matrices.hpp"

/// Stability of the schemes, on the march: both sides of every limit, and the rate of growth beyond
/// it.
///
/// The motion that a step multiplies most has an amplitude that no other motion adds to (Dominant):
/// it is multiplied by the spectral radius at each step, to roundings. So the rate is tested, and
/// not only its sign.
namespace ra2d::test {
namespace {

/// |R| of a Runge-Kutta scheme for y' = z y.
template <class Tableau>
double factor(std::complex<double> z) {
  std::complex<double> at[Tableau::stages], end = 1;
  for (int i = 0; i < Tableau::stages; ++i) {
    at[i] = 1;
    for (int j = 0; j < i; ++j) at[i] += z * Tableau::a(i, j) * at[j];
    end += z * Tableau::b(i) * at[i];
  }
  return std::abs(end);
}

/// The first x from 0.05 on at which `grows` is true.
template <class Grows>
double first(const Grows& grows) {
  double low = 0, high = 0.05;
  for (; !grows(high); high += 0.01) low = high;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (grows(middle) ? high : low) = middle;
  }
  return low;
}

/// omega tau up to which a free mode stays bounded, as the headers of the schemes have it.
double limit_of(SchemeKind kind, double zeta) {
  const auto at = [&](double x) {
    return x * std::complex<double>(-zeta, std::sqrt(1 - zeta * zeta));
  };
  switch (kind) {
    case SchemeKind::explicit_euler:
      return 2 * zeta;
    case SchemeKind::midpoint:
      return 2;
    case SchemeKind::heun:
      return zeta == 0 ? 0 : first([&](double x) {
        return x * x * x / 4 - zeta * x * x + 2 * zeta * zeta * x - 2 * zeta > 0;
      });
    case SchemeKind::rk4:
      return first([&](double x) { return factor<Rk4>(at(x)) > 1 + 1e-13; });
    case SchemeKind::rk8:
      return first([&](double x) { return factor<Rk8>(at(x)) > 1 + 1e-13; });
    default:
      return std::numeric_limits<double>::infinity();
  }
}

constexpr double dampings[] = {0.0, 0.02, 0.3, 0.9};

struct Trial {
  Scheme scheme;
  double zeta, x;
  bool stable;
};

std::vector<Trial> trials() {
  std::vector<Trial> out;
  for (const Scheme& scheme : schemes)
    for (const double zeta : dampings) {
      const double limit = limit_of(scheme.time.scheme, zeta);
      if (scheme.time.scheme == SchemeKind::gautschi) {  // samples have a velocity up to pi
        for (const double x : {0.1, 1.0, 3.0}) out.push_back({scheme, zeta, x, true});
      } else if (std::isinf(limit)) {
        for (const double x : {0.1, 1.0, 10.0, 1e3}) out.push_back({scheme, zeta, x, true});
      } else if (limit == 0) {
        for (const double x : {0.05, 0.2, 1.0}) out.push_back({scheme, zeta, x, false});
      } else {
        out.push_back({scheme, zeta, 0.99 * limit, true});
        out.push_back({scheme, zeta, 1.01 * limit, false});
      }
    }
  return out;
}

/// A start whose (omega U, V) of the resonator are given.
ModalStart start_with(const Model& model, const Eigen::VectorXd& y) {
  ModalStart start = make_start(model);
  const std::size_t n = model.resonator.modes.size();
  for (std::size_t k = 0; k < n; ++k) {
    start.resonator_u[k] += y[static_cast<Eigen::Index>(k)] / model.resonator.modes[k].omega;
    start.resonator_v[k] += y[static_cast<Eigen::Index>(n + k)];
  }
  count_energy(model, start);
  return start;
}
/// (omega U, V) of the resonator in a sample, less those of `rest`.
Eigen::VectorXd sampled(const Recording& run, std::size_t sample, const std::vector<double>& rest) {
  const std::size_t n = run.model.resonator.modes.size();
  Eigen::VectorXd y(2 * n);
  for (std::size_t k = 0; k < n; ++k) {
    const double u =
        run.samples.resonator_displacement[sample * n + k] - (rest.empty() ? 0 : rest[k]);
    y[static_cast<Eigen::Index>(k)] = u * run.model.resonator.modes[k].omega;
    y[static_cast<Eigen::Index>(n + k)] = run.samples.resonator_velocity[sample * n + k];
  }
  return y;
}

/// Steps until a motion of this radius has grown by `growth`.
std::int64_t steps_to_grow(double radius, double growth) {
  return std::max<std::int64_t>(8, std::llround(std::log(growth) / std::log(radius)));
}

TEST(FreeModes, StayBoundedBelowTheLimitAndGrowAtTheRateOfTheoryBeyond) {
  constexpr std::int64_t many = 1'000'000;
  const std::vector<Trial> all = trials();
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  std::vector<Dominant> theory;
  for (const Trial& t : all) {
    Scene s = with(lone_beam(1, t.zeta), t.scheme);
    const double omega = make_body(s.resonator).modes[0].omega;
    const Mode mode{omega, t.zeta, 1};
    theory.emplace_back(step_matrix(t.scheme, alone(mode), t.x / omega));
    std::int64_t steps = many, samples = 1000;
    if (!t.stable) {
      // twenty times the amplitude, 400 times the energy: the march ends it before
      steps = steps_to_grow(theory.back().radius, 20.0);
      samples = std::min<std::int64_t>(steps, 100);
      steps = steps / samples * samples;
    }
    set_steps(s, t.x / omega, steps, samples);
    models.push_back(make_model(s));
    starts.push_back(start_with(models.back(), 1e-3 * theory.back().shape));
  }
  const std::vector<Recording> runs = simulate(models, starts);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Trial& t = all[i];
    const Dominant& d = theory[i];
    const Recording& run = runs[i];
    SCOPED_TRACE(testing::Message() << t.scheme.name << ", zeta " << t.zeta << ", x " << t.x);
    if (t.stable) {
      EXPECT_LE(d.radius, 1 + 4 * eps);
    } else {
      EXPECT_GT(d.radius, 1);
    }
    EXPECT_EQ(run.end.status, t.stable ? Status::done : Status::unstable);
    const Eigen::VectorXd first = sampled(run, 0, {});
    const double amplitude = d.amplitude(first);
    const double every = static_cast<double>(run.model.steps) / (run.model.samples - 1);
    ASSERT_GE(run.samples.time.size(), 4u);
    double largest = 0;
    for (std::size_t j = 1; j < run.samples.time.size(); ++j) {
      const Eigen::VectorXd y = sampled(run, j, {});
      const double n = static_cast<double>(j) * every;
      // |M^n| <= condition radius^n
      EXPECT_LE(y.norm(), d.condition * std::pow(d.radius, n) * first.norm() * (1 + 1e-6) + 1e-300);
      const double expected = amplitude * std::pow(d.radius, n);
      largest = std::max(largest, y.norm() / first.norm());
      // eight roundings a step (a weight's and two sums'), of the state's norm; the angle of a
      // large step is itself rounded
      const double share = 4 * eps * (n + 10) * d.condition * (1 + t.x);
      if (share > 1e-3 || expected < 1e-200) continue;
      EXPECT_NEAR(d.amplitude(y) / expected, 1, share) << n << " steps";
    }
    if (!t.stable) {
      EXPECT_GT(largest, 2) << "nothing is seen to grow";
    }
  }
}

TEST(FreeModes, ExplicitEulerAndHeunGrowWithoutDampingAsTheHeadersSay) {
  // the energy by x^2 and by x^4/4 a step
  for (const double x : {0.01, 0.1, 1.0}) {
    const Mode mode{1, 0, 1};
    const auto growth = [&](SchemeKind kind) {
      return std::pow(radius(scheme_of(kind), alone(mode), x), 2) - 1;
    };
    EXPECT_NEAR(growth(SchemeKind::explicit_euler), x * x, 8 * eps);
    EXPECT_NEAR(growth(SchemeKind::heun), std::pow(x, 4) / 4, 8 * eps);
  }
}

// ---- in contact

Joined joined_of(const Scene& s, const std::vector<int>& nodes) {
  const Body beam = make_body(s.resonator);
  Joined j;
  j.spring = s.contact.stiffness * s.spacing * std::min(s.resonator.width, s.slider.width);
  const auto count = static_cast<Eigen::Index>(nodes.size());
  j.phi.resize(count, static_cast<Eigen::Index>(beam.modes.size()));
  for (std::size_t k = 0; k < beam.modes.size(); ++k) {
    j.modes.push_back(beam.modes[k]);
    for (Eigen::Index n = 0; n < count; ++n)
      beam.modes[k].shape->evaluate(s.start + nodes[n] * s.spacing, 1,
                                    &j.phi(n, static_cast<Eigen::Index>(k)));
  }
  return j;
}
/// The kappa at which the sum of all springs has (omega_c tau)^2 = 1.
double unit_stiffness(const Scene& s, const std::vector<int>& nodes) {
  Joined j = joined_of(s, nodes);
  j.spring = 1;
  double sum = 0;
  for (Eigen::Index k = 0; k < j.size(); ++k) sum += j.phi.col(k).squaredNorm() / j.modes[k].mass;
  return 1 / (sum * s.time.step * s.time.step * s.spacing *
              std::min(s.resonator.width, s.slider.width));
}

/// A radius that is one, but for the roundings of eigenvalues that lie close together.
constexpr double barely = 1 + 1e-6;

/// The kappa up to which the pressed plate is stable; 0 when at none.
double contact_limit_of(const Scheme& scheme, Scene s, const std::vector<int>& nodes) {
  const double unit = unit_stiffness(s, nodes);
  const auto grows = [&](double turn) {
    s.contact.stiffness = turn * turn * unit;
    return radius(scheme, joined_of(s, nodes), s.time.step) > barely;
  };
  if (grows(1e-3)) return 0;
  const double turn = first([&](double x) { return x > 10 || grows(x); });
  return turn < 9 ? turn * turn * unit : std::numeric_limits<double>::infinity();
}

/// One node, or flat faces.
struct Place {
  const char* name;
  Scene scene;
  std::vector<int> nodes;
};
std::vector<Place> places() {
  std::vector<Place> out;
  Scene one = pressed_plate();
  one.time.step = 5e-6;
  out.push_back({"one node", one, {50}});
  // eleven nodes of a short flat slider at the middle of the plate, where it bends so little under
  // them that all stay in contact; with large steps, so that the springs at the limit are not too
  // stiff for that
  Scene many = pressed_plate();
  many.resonator.modes = 3;
  many.slider.length = 4e-4;
  many.start = 0.0298;
  many.slider.surface = {};
  many.gap = -5e-6;
  many.time.step = 0.1 / make_body(many.resonator).modes[0].omega;
  std::vector<int> nodes(11);
  for (int n = 0; n < 11; ++n) nodes[n] = n;
  out.push_back({"eleven nodes", many, nodes});
  return out;
}

/// Nudges the pressed plate along the motion that grows most, and follows it.
void expect_growth(const Scheme& scheme, Scene s, const std::vector<int>& nodes, bool stable) {
  s = with(s, scheme);
  const Joined joined = joined_of(s, nodes);
  const Dominant d(step_matrix(scheme, joined, s.time.step));
  EXPECT_EQ(d.radius <= barely, stable) << d.radius;
  const Model at_rest = make_model(s);
  const ModalStart rest = make_start(at_rest);
  // contact at these nodes, and at no others
  const std::vector<double> over = overlaps(at_rest, rest.resonator_u, {});
  double least = 1e300, most = 0;
  for (std::size_t n = 0; n < over.size(); ++n)
    if (std::find(nodes.begin(), nodes.end(), static_cast<int>(n)) != nodes.end())
      least = std::min(least, over[n]);
    else
      most = std::max(most, over[n]);
  ASSERT_GT(least, 0);
  ASSERT_LE(most, 0);
  // so small that the nodes stay closed under any of the other motions
  Eigen::VectorXd y = d.shape;
  double moved = 0;
  for (Eigen::Index n = 0; n < joined.phi.rows(); ++n) {
    double sum = 0;
    for (Eigen::Index k = 0; k < joined.size(); ++k)
      sum += std::abs(joined.phi(n, k)) * y.norm() / joined.modes[k].omega;
    moved = std::max(moved, sum);
  }
  constexpr double growth = 20;
  y *= least / moved / d.condition / (stable ? 2 : 2 * growth);

  const std::int64_t steps =
      stable ? 100'000 : std::min<std::int64_t>(100'000, steps_to_grow(d.radius, growth));
  const std::int64_t samples = std::min<std::int64_t>(steps, 50);
  set_steps(s, s.time.step, steps / samples * samples, samples);
  const Model model = make_model(s);
  const Recording run = simulate({model}, {start_with(model, y)})[0];
  EXPECT_EQ(run.end.status, Status::done);
  EXPECT_EQ(run.end.contact_steps, run.end.step);
  const double amplitude = d.amplitude(y);
  // a gap is rounded to a few ulps of the faces' heights: that is added to the motion at each step
  const double noise = 16 * eps * (1e-5 + std::abs(model.delta)) / (least / d.condition / 40);
  double largest = 0;
  for (std::size_t j = 1; j < run.samples.time.size(); ++j) {
    const Eigen::VectorXd now = sampled(run, j, rest.resonator_u);
    const double n = static_cast<double>(j) * static_cast<double>(model.steps / samples);
    EXPECT_LE(now.norm(), (d.condition * std::pow(std::max(1.0, d.radius), n) + noise * n) *
                              y.norm() * (1 + 1e-6));
    largest = std::max(largest, d.amplitude(now) / amplitude);
    const double expected = amplitude * std::pow(d.radius, n);
    const double share = noise * n * amplitude / expected * d.condition;
    if (share > 0.01) continue;
    EXPECT_NEAR(d.amplitude(now) / expected, 1, share + 1e-9) << n << " steps";
  }
  if (!stable) {
    EXPECT_GT(largest, std::min(0.5 * growth, 1 + 0.5 * (std::pow(d.radius, model.steps) - 1)));
  }
}

class ContactLimit : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, ContactLimit, testing::ValuesIn(schemes),
                         [](const auto& info) { return info.param.name; });

TEST_P(ContactLimit, BothSides) {
  // Two per cent of the spring are one of the step. Forces that are held over a step, and Heun's,
  // have no limit without damping: their motion grows at any step.
  const Scheme& scheme = GetParam();
  const bool weak = scheme.time.scheme == SchemeKind::explicit_euler ||
                    scheme.time.scheme == SchemeKind::heun ||
                    scheme.time.scheme == SchemeKind::exact;
  for (const Place& place : places())
    for (const double zeta : {0.0, 0.02, 0.5}) {
      SCOPED_TRACE(testing::Message() << place.name << ", zeta " << zeta);
      Scene s = place.scene;
      s.resonator.damping = zeta;
      const double limit = weak && zeta == 0 ? 0 : contact_limit_of(scheme, s, place.nodes);

      ASSERT_LT(limit, 1e300);
      if (limit == 0) {
        for (const double turn : {0.3, 0.6}) {
          s.contact.stiffness = turn * turn * unit_stiffness(s, place.nodes);
          expect_growth(scheme, s, place.nodes, false);
        }
        continue;
      }
      s.contact.stiffness = 0.98 * limit;
      expect_growth(scheme, s, place.nodes, true);
      s.contact.stiffness = 1.02 * limit;
      expect_growth(scheme, s, place.nodes, false);
    }
}

TEST(ContactLimit, OfManyNodesIsThatOfOneWithAllTheirSprings) {
  const Place many = places()[1];
  for (const Scheme& scheme : {schemes[1], schemes[2], schemes[4], schemes[5]}) {
    Scene s = many.scene;
    const double of_many = contact_limit_of(scheme, s, many.nodes);
    const double single = contact_limit_of(scheme, s, {5});
    // the modes' shapes differ by a per cent over the slider's length
    EXPECT_NEAR(of_many * 11 / single, 1, 0.02) << scheme.name;
  }
}

TEST(FullyImplicit, IsStableAtAThousandTimesTheExplicitLimit) {
  const Scheme implicit = schemes_and_implicit().back(), old = schemes[2];
  for (const Place& place : places())
    for (const double zeta : {0.0, 0.02}) {
      Scene s = place.scene;
      s.resonator.damping = zeta;
      const double limit = s.time.step;
      s.contact.stiffness = contact_limit_of(old, s, place.nodes);
      for (const double beyond : {1.1, 10.0, 1000.0}) {
        SCOPED_TRACE(testing::Message() << place.name << ", zeta " << zeta << ", " << beyond);
        s.time.step = beyond * limit;
        EXPECT_GT(radius(old, joined_of(s, place.nodes), s.time.step), barely);
        expect_growth(implicit, s, place.nodes, true);
      }
    }
}

// ---- what backward Euler's step costs

/// The plate of the paper, which nothing touches.
Scene lone_plate_of_the_paper() {
  Scene s = read_scene(scene_file("dang2012"));
  s.resonator.surface = s.slider.surface = {};
  s.slider = rigid(s.slider);
  s.slider.load_is_weight = false;
  s.slider.load = 0;
  s.gap = 1;
  s.speed = 0;
  s.initial = Initial::rest;
  s.output.probes.clear();
  return s;
}

TEST(BackwardEulerDamping, OfTheHighestModeAtTheStepOfThePaper) {
  // The eigenvalues of a step, with s = 1 + 2 zeta x + x^2, x = omega tau: modulus s^(-1/2), angle
  // arctan(x sqrt(1 - zeta^2)/(1 + zeta x)). So a free mode has the damping ratio
  //   ln(s)/(2 x) = zeta + x/2 - zeta^2 x + O(x^2)
  // and its period is longer by zeta x + O(x^2) of itself.
  //
  // At tau = 10 ns the plate's highest audible mode, number 19 at 18.9 kHz, has x/2 = 5.9e-4: 3 %
  // on top of zeta = 0.02, and a period that is 2.4e-5 too long. Small as this is, it adds up:
  // after 1 ms the mode's amplitude is 7 % too low. After 10 ms, when its own damping has long
  // ended it, the amplitude is half of what it should be.
  Scene s = lone_plate_of_the_paper();
  const Body beam = make_body(s.resonator);
  const std::size_t modes = beam.modes.size(), last = modes - 1;
  EXPECT_EQ(modes, 19u);
  const double omega = beam.modes[last].omega, zeta = beam.modes[0].zeta;
  EXPECT_EQ(s.time.step, 1e-8);
  const double x = omega * s.time.step;
  EXPECT_NEAR(x / 2, 5.9e-4, 0.1e-4);

  set_steps(s, s.time.step, 1'000'000, 1000);  // 10 ms, 10 us a sample: a fifth of a period
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  start.resonator_u[last] = 1e-9;
  count_energy(model, start);
  const Recording run = simulate({model}, {start})[0];
  ASSERT_EQ(run.end.status, Status::done);
  const auto state = [&](std::size_t i) {
    return Eigen::Vector2d(run.samples.resonator_displacement[i * modes + last] * omega,
                           run.samples.resonator_velocity[i * modes + last]);
  };
  // Three samples give the two eigenvalues: y2 = trace y1 - determinant y0.
  for (const std::size_t i : {0u, 100u, 500u}) {
    Eigen::Matrix2d columns;
    columns << state(i + 1), -state(i);
    const Eigen::Vector2d found = columns.inverse() * state(i + 2);
    const double time = 1e-5, trace = found[0], determinant = found[1];
    const double damping = -std::log(determinant) / (2 * omega * time);
    const double turn = std::acos(trace / (2 * std::sqrt(determinant))) / time;
    // against theory's first order, and against the closed form to the last digit: a sample is 1000
    // steps, whose roundings turn and damp the mode by a thousandth of themselves each
    const double roundings = 1e3 * eps * 10;
    EXPECT_NEAR(damping, zeta + x / 2 - zeta * zeta * x, x * x);
    EXPECT_NEAR(damping, std::log1p(2 * zeta * x + x * x) / (2 * x), roundings);
    const double exact = omega * std::sqrt(1 - zeta * zeta);
    EXPECT_NEAR(exact / turn - 1, zeta * x, x * x);
    EXPECT_NEAR(turn, std::atan2(x * std::sqrt(1 - zeta * zeta), 1 + zeta * x) / s.time.step,
                roundings * turn);
  }
  // energy norms at 1 ms and 10 ms, against the mode's own decay
  const auto left = [&](std::size_t i) {
    return state(i).norm() / state(0).norm() / std::exp(-zeta * omega * run.samples.time[i]);
  };
  // the norm swings by zeta about its mean while the mode turns
  EXPECT_NEAR(left(100), std::exp(-x / 2 * omega * 1e-3), 2 * zeta);
  EXPECT_NEAR(left(100), 0.93, 2 * zeta);
  EXPECT_NEAR(left(1000), std::exp(-x / 2 * omega * 1e-2), 2 * zeta);
  EXPECT_NEAR(left(1000), 0.50, 2 * zeta);
}

}  // namespace
}  // namespace ra2d::test
