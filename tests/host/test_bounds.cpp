// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/bounds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include "host/base/decompositions.hpp"
#include "host/body/beam.hpp"
#include "host/body/block.hpp"
#include "host/body/body.hpp"
#include "host/body/plate.hpp"
#include "host/device/layout.hpp"
#include "tests/dice.hpp"
#include "tests/free_motion.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

/// The bounds that the proofs rest on, each against what it bounds: never exceeded, and reached as
/// nearly as theory says. What is bounded is computed in long double, so the roundings left are
/// those of the bounds themselves: fewer than 16 each.
namespace ra2d::test {
namespace {

constexpr double own = 1 + 16 * eps;  // the bounds' own roundings

// ---- shapes

/// The j-th derivative of a mode, of the form that BeamShape documents, anywhere.
long double derivative(const BeamShape& mode, long double x, int j) {
  const long double beta = mode.beta, phase = beta * x;
  const long double even = mode.sine * std::sin(phase) + mode.cosine * std::cos(phase);
  const long double odd = mode.sine * std::cos(phase) - mode.cosine * std::sin(phase);
  const long double wave[] = {even, odd, -even, -odd};
  const long double left = mode.left * std::exp(-phase) * (j % 2 == 0 ? 1 : -1);
  const long double right = mode.right * std::exp(-beta * (mode.length - x));
  const long double rigid = j == 0 ? mode.constant + mode.slope * x : j == 1 ? mode.slope : 0.0L;
  return std::pow(beta, j) * (wave[j % 4] + left + right) + rigid;
}

/// A flat body of random size.
BodySpec random_body(Dice& dice, Support support) {
  BodySpec body = steel(dice.ratio(0.01, 1), dice.ratio(1e-3, 1e-2), 0.02, 0, 1 + dice.pick(40));
  body.support = support;
  return body;
}

/// Modes of beams of all kinds (rigid ones among them), and some whose parts are drawn at random,
/// as the bounds know nothing of supports.
struct RandomShape {
  double length;
  BeamShape shape;
  enum Kind { pinned, of_free, drawn, kinds } kind;

  explicit RandomShape(Dice& dice) : kind{static_cast<Kind>(dice.pick(kinds))} {
    const Body beam =
        make_beam(random_body(dice, kind == pinned ? Support::pinned : Support::free));
    length = beam.length;
    shape = beam_shape(beam.modes[dice.pick(static_cast<int>(beam.modes.size()))]);
    if (kind != drawn) return;
    shape.sine = dice.uniform(0.1, 1);
    for (double* part : {&shape.cosine, &shape.left, &shape.right})
      *part = dice.one_in(3) ? 0.0 : dice.uniform(-1, 1);
    shape.constant = dice.uniform(-1, 1), shape.slope = dice.uniform(-1, 1) / length;
    if (shape.beta > 0 && dice.one_in(2)) shape.constant = shape.slope = 0;
  }
  bool rigid() const { return shape.beta == 0; }
  bool elastic() const { return shape.beta > 0 && shape.constant == 0 && shape.slope == 0; }
  long double operator()(long double x, int j = 0) const { return derivative(shape, x, j); }
  /// Places so dense that a peak between two of them is missed by less than (beta dx)^2/8, at most
  /// 2e-4 of the wave.
  template <class Each>
  void over(double begin, double end, const Each& each) const {
    const int places = 2 + static_cast<int>(25 * shape.beta * (end - begin));
    for (int i = 0; i <= places; ++i)
      each(begin + (end - begin) * static_cast<long double>(i) / places);
  }
};

TEST(ShapeSize, IsNeverExceeded) {
  Dice dice(1);
  for (int trial = 0; trial < 300; ++trial) {
    const RandomShape psi(dice);
    const double bound = psi.shape.size();
    psi.over(0, psi.length, [&](long double x) {
      ASSERT_LE(std::abs(psi(x)), bound * own) << "trial " << trial << ", x " << x;
    });
  }
}

TEST(ShapeSize, IsReached) {
  Dice dice(2);
  for (int trial = 0; trial < 300; ++trial) {
    const RandomShape psi(dice);
    if (psi.kind == RandomShape::drawn) continue;
    long double most = 0;
    psi.over(0, psi.length, [&](long double x) { most = std::max(most, std::abs(psi(x))); });
    // A pinned or a rigid mode has one part. A free one is 2/sqrt(L) at its ends; its parts are a
    // wave of sqrt(2)/sqrt(L) and two exponentials of 1/sqrt(L), all to exp(-beta L) < 0.009.
    const double parts =
        psi.rigid() || psi.kind == RandomShape::pinned ? 1.0 : 1.009 * (std::sqrt(2.0) + 2) / 2;
    EXPECT_LE(psi.shape.size(), parts * most * (1 + 3e-4)) << "trial " << trial;
  }
}

TEST(LargestWave, BoundsSlopeAndCurvatureOverTheBeamAndBehindIt) {
  Dice dice(3);
  double tightest = 0, tightest_behind = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const RandomShape psi(dice);
    if (!psi.elastic()) continue;
    const double beta = psi.shape.beta, beyond = dice.one_in(4) ? 0.0 : dice.ratio(0.01, 4) / beta;
    const double bound = psi.shape.largest_wave(beyond);
    psi.over(0, psi.length + beyond, [&](long double x) {
      for (const int j : {1, 2}) {
        const long double size = std::abs(psi(x, j)) / std::pow(static_cast<long double>(beta), j);
        ASSERT_LE(size, bound * own) << "trial " << trial << ", x " << x << ", derivative " << j;
        const double share = static_cast<double>(size) / bound;
        tightest = std::max(tightest, share);
        if (x > psi.length && std::abs(psi.shape.right) > 0.5 * std::abs(psi.shape.sine))
          tightest_behind = std::max(tightest_behind, share);
      }
    });
  }
  EXPECT_GT(tightest, 0.999);        // a pinned mode's slope at its end
  EXPECT_GT(tightest_behind, 0.95);  // where the exponential is nearly all that counts
}

TEST(LargestParts, AreEachReachedWhereTheyAreAlone) {
  // A sum of the sizes of a shape's parts: each part by itself comes to its size somewhere, and to
  // that of both where two of them are largest at the same end.
  Dice dice(15);
  for (int trial = 0; trial < 60; ++trial) {
    BeamShape shape;
    const double length = dice.ratio(0.01, 1), beyond = length * dice.ratio(0.01, 0.1),
                 size = dice.uniform(-2, 2);
    shape.length = length, shape.beta = 20 / length;
    const int part = trial % 6;
    (part == 0   ? shape.sine
     : part == 1 ? shape.cosine
     : part == 2 ? shape.left
     : part == 3 ? shape.right
     : part == 4 ? shape.constant
                 : shape.slope) = size;
    if (part == 2 && trial % 4 == 0) shape.cosine = shape.constant = size;  // all three at x = 0
    const double most = part == 5 ? std::abs(size * length)
                                  : std::abs(size) * (shape.constant == size && part == 2 ? 3 : 1);
    EXPECT_NEAR(shape.size(), most, 16 * eps * most) << "part " << part;
    // of the derivatives: what is constant or a slope has no wave; the right exponential grows on
    const double wave = part == 3   ? std::abs(size) * std::exp(shape.beta * beyond)
                        : part >= 4 ? 0
                                    : std::abs(size) * (shape.cosine == size && part == 2 ? 2 : 1);
    EXPECT_NEAR(shape.largest_wave(beyond), wave, 16 * eps * wave) << "part " << part;
    if (part == 3) {  // the right exponential alone: nothing else is bounded
      EXPECT_NEAR(shape.size() * shape.growth(beyond), wave, 16 * eps * wave);
    }
    long double reached = 0, bent = 0;
    const int places = 1000;
    for (int i = 0; i <= places; ++i) {
      reached = std::max(reached, std::abs(derivative(shape, length * i / places, 0)));
      bent = std::max(bent, std::abs(derivative(shape, (length + beyond) * i / places, 4)));
    }
    // the wave's crest is less than (20/1000)^2/8 below what is between two places
    EXPECT_NEAR(static_cast<double>(reached), most, 1e-4 * most) << "part " << part;
    bent /= std::pow(shape.beta, 4);  // the fourth derivative is the wave again
    const double between = part < 2 ? std::pow(shape.beta * (length + beyond) / places, 2) : 1e-9;
    EXPECT_NEAR(static_cast<double>(bent), wave, between * wave) << "part " << part;
  }
}

/// The largest shares of the bound that a mode's Taylor cubics leave out. The centres are those
/// that patches can have: from the beam's beginning to a radius behind its end.
struct LeftOut {
  long double value = 0, slope = 0;

  LeftOut(const RandomShape& psi, double radius) {
    const CubicRemainder bound = psi.shape.cubic_remainder(radius);
    constexpr int centres = 60, places = 8;
    for (int c = 0; c <= centres; ++c) {
      const long double centre = (psi.length + radius) * static_cast<long double>(c) / centres;
      long double d[4];
      for (int j = 0; j < 4; ++j) d[j] = psi(centre, j);
      for (int i = -places; i <= places; ++i) {
        const long double h = static_cast<long double>(radius) * i / places, x = centre + h;
        if (x < 0) continue;  // no node stands there
        const long double cubic = d[0] + h * (d[1] + h * (d[2] / 2 + h * d[3] / 6));
        const long double cubic_slope = d[1] + h * (d[2] + h * d[3] / 2);
        value = std::max(value, std::abs(psi(x) - cubic) / bound.value);
        slope = std::max(slope, std::abs(psi(x, 1) - cubic_slope) / bound.slope);
      }
    }
  }
};

TEST(CubicRemainder, BoundsWhatTheTaylorCubicLeavesOut) {
  Dice dice(5);
  long double value = 0, slope = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const RandomShape psi(dice);
    if (psi.rigid()) continue;
    // from a twentieth of the usual beta radius of 1/4 to the coarsest nodes that are taken
    const LeftOut share(psi, dice.ratio(0.0125, 2) / psi.shape.beta);
    // the remainder, (beta radius)^4/24 > 1e-9 of the shape, is a difference in long double
    ASSERT_LE(share.value, 1 + 1e-8) << "trial " << trial;
    ASSERT_LE(share.slope, 1 + 1e-8) << "trial " << trial;
    value = std::max(value, share.value), slope = std::max(slope, share.slope);
  }
  EXPECT_GT(value, 0.98);
  EXPECT_GT(slope, 0.98);
}

TEST(RigidModes, HaveNoWave) {
  Dice dice(6);
  const Body beam = make_beam(random_body(dice, Support::free));
  for (int k = 0; k < 2; ++k) {
    const ModeShape& shape = *beam.modes[k].shape;
    EXPECT_EQ(shape.wave_number(), 0);
    EXPECT_EQ(shape.largest_curvature(0.1), 0);
    EXPECT_EQ(shape.growth(0.1), 1);
    EXPECT_EQ(shape.fourth_derivative_factor(0.1), 0);
    EXPECT_EQ(shape.cubic_remainder(0.1).value, 0);
    EXPECT_EQ(shape.cubic_remainder(0.1).slope, 0);
  }
}

TEST(ChangeRate, BoundsTheDerivativesAlongTheWay) {
  Dice dice(7);
  int reached = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const RandomShape psi(dice);
    const double speed = dice.ratio(1e-3, 1e2), largest = psi.shape.size();
    const double rate = psi.shape.change_rate() * speed;
    long double most = 0;
    psi.over(0, psi.length, [&](long double x) {
      for (int j = 1; j <= 4; ++j) {
        const long double change =
            std::abs(psi(x, j)) * std::pow(static_cast<long double>(speed), j);
        const long double bound = std::pow(static_cast<long double>(rate), j) * largest;
        if (psi.shape.beta == 0 && psi.shape.slope == 0) {
          ASSERT_EQ(change, 0);
          ASSERT_EQ(bound, 0);
          continue;
        }
        // its own roundings count j times
        ASSERT_LE(change, bound * (1 + 64 * eps)) << "trial " << trial << ", derivative " << j;
        most = std::max(most, change / bound);
      }
    });
    const bool turns = psi.kind == RandomShape::of_free && psi.rigid() && psi.shape.slope != 0;
    if (psi.kind == RandomShape::pinned || turns) {
      EXPECT_GT(most, 0.999) << "trial " << trial;
    }
    reached += turns ? 1 : 0;
  }
  EXPECT_GT(reached, 0) << "bodies that turn";
}

// ---- motions

Mode random_mode(Dice& dice) {
  return {dice.ratio(1e2, 1e6), dice.one_in(3) ? 0.0 : dice.ratio(1e-3, 3), dice.ratio(0.1, 10)};
}

/// U and its first four derivatives at a state, from the equation of motion.
using Derivatives = std::array<long double, 5>;
Derivatives free_derivatives(const Mode& mode, long double u, long double v) {
  const long double w = mode.omega, decay = 2 * static_cast<long double>(mode.zeta) * w;
  Derivatives d{u, v};
  for (int i = 2; i <= 4; ++i) d[i] = -decay * d[i - 1] - w * w * d[i - 2];
  return d;
}

/// The state of energy norm 1 at an angle.
State turned(const Mode& mode, double angle) {
  return {std::cos(static_cast<long double>(angle)) / mode.omega,
          std::sin(static_cast<long double>(angle)), 0};
}

TEST(FastestRate, IsThatOfTheFastestDirection) {
  Dice dice(8);
  constexpr int directions = 2000;
  for (int trial = 0; trial < 300; ++trial) {
    const Mode mode = random_mode(dice);
    const double bound = fastest_rate(mode);
    long double most = 0;
    for (int i = 0; i < directions; ++i) {
      const State y = turned(mode, pi * i / directions);  // the opposite is as fast
      const Derivatives d = free_derivatives(mode, y.u, y.v);
      most = std::max(most, std::hypot(mode.omega * d[1], d[2]));
    }
    ASSERT_LE(most, bound * own) << "zeta " << mode.zeta;
    // the square is a constant and a cosine of twice the angle: between two directions it is higher
    // by less than (pi/directions)^2 of itself
    ASSERT_GE(most, bound * (1 - std::pow(pi / directions, 2))) << "zeta " << mode.zeta;
  }
  EXPECT_EQ(fastest_rate(Mode{0, 0.02, 1}), 0) << "a rigid mode";
}

/// Two bodies of random kinds, joined by the contact spring of one node.
struct RandomJoint {
  Model model;

  /// A spring that is `stiff` times as stiff as the resonator's mass makes of its fastest mode.
  RandomJoint(Dice& dice, double stiff) {
    const auto support = [&] { return dice.one_in(2) ? Support::free : Support::pinned; };
    for (Body* beam : {&model.resonator, &model.slider}) {
      BodySpec body = random_body(dice, support());
      body.modes = 1 + dice.pick(8);
      body.damping = dice.one_in(3) ? 0.0 : dice.ratio(1e-3, 2);
      *beam = make_body(body);
    }
    model.node_stiffness =
        stiff * model.resonator.mass * std::pow(model.resonator.modes.back().omega, 2);
  }
  /// The largest |eigenvalue| of the motion, the node at these places of the two bodies: z^2 + D z
  /// + K has it, with D and K those of the modes' coordinates over sqrt(m).
  double fastest(double x2, double x1) const {
    const auto count =
        static_cast<Eigen::Index>(model.resonator.modes.size() + model.slider.modes.size());
    Eigen::VectorXd phi(count);
    Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(2 * count, 2 * count);
    Eigen::Index k = 0;
    for (const auto& [beam, x] : {std::pair{&model.resonator, x2}, std::pair{&model.slider, x1}})
      for (const BodyMode& mode : beam->modes) {
        phi[k] = shape_at(mode, x) / std::sqrt(mode.mass);
        rate(k, count + k) = 1;
        rate(count + k, k) = -mode.omega * mode.omega;
        rate(count + k, count + k) = -2 * mode.zeta * mode.omega;
        ++k;
      }
    rate.bottomLeftCorner(count, count) -= model.node_stiffness * phi * phi.transpose();
    // in units in which the entries are alike
    const double unit = std::sqrt(rate.cwiseAbs().maxCoeff());
    rate.topRightCorner(count, count) *= unit;
    rate.bottomLeftCorner(count, count) /= unit;
    return eigenvalues(rate).cwiseAbs().maxCoeff();
  }
};

TEST(FastestRate, OfAModelBoundsAllMotionsWithANodeInContact) {
  Dice dice(9);
  double soft = 0, stiff = 0;
  for (int trial = 0; trial < 300; ++trial) {
    // from a spring far softer than the modes to one far stiffer
    const double stiffness = dice.ratio(1e-4, 1e4);
    const RandomJoint joint(dice, stiffness);
    const double bound = fastest_rate(joint.model);
    const double l2 = joint.model.resonator.length, l1 = joint.model.slider.length;
    for (int i = 0; i < 10; ++i) {
      const double fastest =
          i == 0 ? joint.fastest(l2, l1) : joint.fastest(dice.uniform(0, l2), dice.uniform(0, l1));
      // the eigenvalues of a matrix that is not symmetric, to the square root of its roundings
      ASSERT_LE(fastest, bound * (1 + 1e-6)) << "trial " << trial;
      double& most = stiffness < 1 ? soft : stiff;
      most = std::max(most, fastest / bound);
    }
  }
  EXPECT_GT(soft, 0.99);
  // at its end every mode of a free body is as large as anywhere
  EXPECT_GT(stiff, 0.99);
}

/// The fourth derivative of U(t) psi(x0 + V t) at a state, by Leibniz' rule.
long double fourth_of(const RandomShape& psi, long double speed, long double x,
                      const Derivatives& u) {
  constexpr int binomial[] = {1, 4, 6, 4, 1};
  long double sum = 0;
  for (int i = 0; i <= 4; ++i) sum += binomial[i] * u[i] * std::pow(speed, 4 - i) * psi(x, 4 - i);
  return sum;
}

TEST(FourthDerivative, IsLeibnizRuleItself) {
  // what the tests below go by, against differences of the closed form
  Dice dice(10);
  for (int trial = 0; trial < 50; ++trial) {
    const RandomShape psi(dice);
    if (psi.rigid()) continue;
    const Mode mode = random_mode(dice);
    const State y = turned(mode, dice.uniform(0, 2 * pi));
    const double speed = mode.omega / psi.shape.beta * dice.ratio(1e-2, 1e2);
    const long double x = psi.length * dice.uniform(0.3, 0.7);
    const double scale = fourth_derivative(mode, psi.shape.size(), psi.shape.change_rate() * speed);
    // central differences over seven places: off by 7 h^4/240 of the eighth derivative, 3e-10 of
    // what the bound allows
    const long double rate = fastest_rate(mode) + psi.shape.change_rate() * speed;
    const long double h = 0.01L / rate;
    const auto value = [&](int n) { return fly(mode, 0, y, n * h).u * psi(x + speed * n * h); };
    const long double weight[] = {28.0L / 3, -6.5L, 2, -1.0L / 6};
    long double sum = weight[0] * value(0);
    for (int n = 1; n <= 3; ++n) sum += weight[n] * (value(n) + value(-n));
    const long double off = std::abs(sum / (h * h * h * h) -
                                     fourth_of(psi, speed, x, free_derivatives(mode, y.u, y.v)));
    // long double has 1e-19 of U psi, and h^4 divides it by 1e-8
    EXPECT_LE(off / scale, 1e-8) << "trial " << trial;
  }
}

TEST(FourthDerivative, IsNeverExceededInFreeMotion) {
  Dice dice(11);
  for (int trial = 0; trial < 2000; ++trial) {
    const RandomShape psi(dice);
    const Mode mode = random_mode(dice);
    const double speed = dice.one_in(8) ? 0.0
                                        : mode.omega / std::max(psi.shape.beta, 1 / psi.length) *
                                              dice.ratio(1e-3, 1e3);
    const double bound = fourth_derivative(mode, psi.shape.size(), psi.shape.change_rate() * speed);
    for (int i = 0; i < 20; ++i) {
      // a step is bounded by the energy at its beginning
      const State begin = turned(mode, dice.uniform(0, 2 * pi));
      const State y = fly(mode, 0, begin, i == 0 ? 0.0 : dice.ratio(1e-3, 10) / mode.omega);
      const long double derivative_4 =
          fourth_of(psi, speed, dice.uniform(0, psi.length), free_derivatives(mode, y.u, y.v));
      ASSERT_LE(std::abs(derivative_4), bound * own)
          << "trial " << trial << ", zeta " << mode.zeta << ", speed " << speed;
    }
  }
}

TEST(FourthDerivative, IsReachedToAFactorOfTwo) {
  // Of a pinned mode without damping U psi is a sum and a difference of two waves: it reaches the
  // mean of (omega + b)^4 and (omega - b)^4, over omega, where (omega + b)^4 is bounded.
  Dice dice(12);
  for (int trial = 0; trial < 30; ++trial) {
    const Body beam = make_beam(random_body(dice, Support::pinned));
    RandomShape psi(dice);
    psi.length = beam.length,
    psi.shape = beam_shape(beam.modes[dice.pick(static_cast<int>(beam.modes.size()))]);
    const Mode mode{dice.ratio(1e2, 1e6), 0, 1};
    const double turns = dice.ratio(1e-4, 1e4);  // b/omega
    const double speed = turns * mode.omega / psi.shape.beta;
    long double most = 0;
    for (int angle = 0; angle < 8; ++angle) {
      const State y = turned(mode, 2 * pi * angle / 8);
      const Derivatives u = free_derivatives(mode, y.u, y.v);
      psi.over(0, psi.length, [&](long double x) {
        most = std::max(most, std::abs(fourth_of(psi, speed, x, u)));
      });
    }
    const double waves =
        0.5 * (std::pow(1 + turns, 4) + std::pow(1 - turns, 4)) / std::pow(1 + turns, 4);
    const double share = static_cast<double>(most) /
                         fourth_derivative(mode, psi.shape.size(), psi.shape.change_rate() * speed);
    EXPECT_GE(waves, 0.5);
    EXPECT_NEAR(share, waves, 3e-4) << "b/omega " << turns;  // where U is largest, and psi
  }
}

// ---- the clock of free flight

TEST(FirstFlightLevel, IsTheLongestAtWhichATaylorStepLeavesNothingOut) {
  // Flights of less than the first table are a Taylor step of third order
  // (kernels/adaptive/flight.hpp).
  Dice dice(14);
  double of_four_times_the_length = 0;
  for (int trial = 0; trial < 200; ++trial) {
    RandomJoint joint(dice, dice.ratio(1e-6, 1e2));
    joint.model.tick = dice.ratio(0x1p-61, 0x1p-50);
    const int level = first_flight_level(joint.model);
    const auto left_out = [&](int at) {  // over the energy norm, of the modes of both bodies
      const long double t = std::ldexp(joint.model.tick, at);
      double most = 0;
      for (const Body* body : {&joint.model.resonator, &joint.model.slider})
        for (const Mode& mode : body->modes) {
          if (mode.omega == 0) continue;  // U'' is constant
          for (int angle = 0; angle < 8; ++angle) {
            const State y = turned(mode, pi * angle / 8), there = fly(mode, 0, y, t);
            const Derivatives u = free_derivatives(mode, y.u, y.v);
            const Derivatives v = free_derivatives(mode, u[1], u[2]);
            const auto taylor = [&](const Derivatives& d) {
              return d[0] + t * (d[1] + t / 2 * (d[2] + t / 3 * d[3]));
            };
            most = std::max<double>(
                most, std::hypot(mode.omega * (taylor(u) - there.u), taylor(v) - there.v));
          }
        }
      return most;
    };
    ASSERT_LE(left_out(level), eps / 2) << "trial " << trial;
    of_four_times_the_length = std::max(of_four_times_the_length, left_out(level + 2));
  }
  EXPECT_GT(of_four_times_the_length, 4 * eps);
}

// ---- faces

TEST(SteepestRise, BoundsTheFaceBetweenAnyTwoPlaces) {
  Dice dice(13);
  for (int trial = 0; trial < 100; ++trial) {
    const int nodes = 2 + dice.pick(60);
    std::vector<double> height(nodes);
    for (double& h : height) h = dice.uniform(-1, 1);
    const double bound = steepest_rise(height.data(), nodes);
    const auto face = [&](double x) {
      const int left = std::min(static_cast<int>(x), nodes - 2);
      return std::lerp(height[left], height[left + 1], x - left);
    };
    const double rounding = 4 * eps * (1 + nodes);  // of the heights, and of the places
    for (int i = 0; i < 500; ++i) {
      const double a = dice.uniform(0, nodes - 1), b = dice.uniform(0, nodes - 1);
      ASSERT_LE(std::abs(face(a) - face(b)), bound * std::abs(a - b) + rounding);
    }
    double most = 0;
    for (int n = 0; n + 1 < nodes; ++n)
      most = std::max(most, 2 * std::abs(face(n + 0.75) - face(n + 0.25)));
    EXPECT_NEAR(most, bound, rounding) << "trial " << trial;
  }
  const double one = 3;
  EXPECT_EQ(steepest_rise(&one, 1), 0);
}

TEST(FillHighest, LooksAsFarAheadAsItIsTold) {
  std::vector<double> height(20, -1.0), highest(20);
  height[12] = 3, height[19] = 5;
  fill_highest(height.data(), 20, 4, highest.data());
  for (int n = 0; n < 20; ++n)
    EXPECT_EQ(highest[n], n >= 15 ? 5 : n >= 8 && n <= 12 ? 3 : -1) << "node " << n;
}

TEST(FillSag, IsAnEighthOfTheSharpestSummitWithinReach) {
  std::vector<double> curvature(20, 8.0), sag(20);
  curvature[12] = -16;
  fill_sag(curvature.data(), 20, 1, 2, sag.data());
  for (int n = 0; n < 20; ++n) EXPECT_EQ(sag[n], n >= 10 && n <= 13 ? 2 : -1) << "node " << n;
}

TEST(FillRaised, IsAboveAParabolaAndTheBoundOnItsRise) {
  // x (1 - x)/2 C is C/9 high at 1/3, and from there on rises by no more than (2/3)^2/8 C
  constexpr double sharp = 18;
  const std::vector<double> height(6, 1.0), curvature{0, 0, -sharp, -sharp, 0, 0};
  std::vector<double> raised(6);
  fill_raised(height.data(), curvature.data(), 6, raised.data());
  EXPECT_NEAR(raised[2], 1 + sharp / 9 + sharp / 18, 1e-12);
  EXPECT_EQ(raised[1], raised[2]) << "its left piece is curved, too";
  EXPECT_EQ(raised[0], 1);
}

// ---- sums of squares

/// Never exceeded, and no more than a sixteenth of the sum of all modes above what is reached.
TEST(SumOfSquares, IsReachedAlmost) {
  Dice dice(9);
  for (int sample = 0; sample < 12; ++sample) {
    BodySpec spec = random_body(dice, sample % 2 == 0 ? Support::pinned : Support::free);
    const bool areal = sample % 3 == 0;
    if (areal) {
      spec.poisson = 0.3;
      if (spec.support == Support::free) spec.modes = 0;
      spec.width = spec.length * dice.uniform(0.3, 1);
    }
    const Body body = areal ? spec.support == Support::pinned ? make_plate(spec) : make_block(spec)
                            : make_beam(spec);
    std::array<std::vector<double>, 2> weights;
    std::array<double, 2> all{}, reached{};
    for (const BodyMode& mode : body.modes)
      for (int w = 0; w < 2; ++w) {
        weights[w].push_back(dice.uniform(0, 1));
        all[w] += weights[w].back() * std::pow(mode.shape->size(), 2);
      }
    const std::array<double, 2> bound =
        largest_square_sums(body, weights, areal ? spec.width : 0.0);
    const int along = 700, across = areal ? 400 : 0;
    for (int j = 0; j <= across; ++j)
      for (int i = 0; i <= along; ++i) {
        double sum[2] = {};
        for (std::size_t k = 0; k < body.modes.size(); ++k) {
          const double x = i * body.length / along;
          const double psi = areal ? shape_at(body.modes[k], x, j * spec.width / across)
                                   : shape_at(body.modes[k], x);
          for (int w = 0; w < 2; ++w) sum[w] += weights[w][k] * psi * psi;
        }
        for (int w = 0; w < 2; ++w) reached[w] = std::max(reached[w], sum[w]);
      }
    for (int w = 0; w < 2; ++w) {
      EXPECT_GE(bound[w], reached[w] * (1 - 16 * eps));
      EXPECT_LE(bound[w], reached[w] + all[w] / 16);
      EXPECT_LE(bound[w], all[w]);
      if (body.modes.size() > 8 && spec.support == Support::pinned) {
        EXPECT_LT(bound[w], 0.8 * all[w]);
      }
    }
  }
}

}  // namespace
}  // namespace ra2d::test
