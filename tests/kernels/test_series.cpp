// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "host/device/gauss.hpp"
#include "host/device/lobatto.hpp"
#include "host/model/model.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/gap.hpp"
#include "tests/dice.hpp"
#include "tests/eight_modes.hpp"
#include "tests/free_motion.hpp"
#include "tests/kernels_of.hpp"

/// The power series of the modes: against the closed form where there is one, else against the
/// equations that it solves.
namespace {

using namespace ra2d;
using test::Dice, test::State, test::fly, test::Amplitudes, test::Real, test::lanes;
using test::K, test::eps, test::modes, test::width;

/// Modes of all kinds, one a lane, and three nodes that slide over them. A node's shapes are the
/// cubics of a cos(beta o + phase), a the largest shape, o its offset; in chi, here 1 m.
struct BodyTables {
  static constexpr int nodes = 3;
  std::vector<Mode> mode;
  std::vector<double> load, mass, omega, decay, inverse_mass, wander, turn, largest_shape, tail;
  std::vector<double> shape, face, series, squares, node_series, closed_shape, scan_shape, scan;
  std::vector<std::int64_t> window = std::vector<std::int64_t>(nodes, 0);
  std::vector<int> closed;
  std::vector<Hull> hulls = std::vector<Hull>(nodes);
  SceneTables t;
  SceneState s;
  Amplitudes u, v;
  double quickest = 0;

  /// `speed` [chi/s], `stiffness` of a node [N/m]; the first `touching` nodes are closed.
  BodyTables(Dice& dice, double tolerance, double speed, double stiffness, int touching) {
    const double zetas[] = {0.0, 0.02, 1e-3, 0.3, 1.0, 2.0};
    for (int k = 0; k < modes; ++k) {
      Mode m{dice.ratio(1e3, 1e5), zetas[dice.pick(6)], dice.ratio(0.1, 10)};
      if (k % 5 == 4) m.omega = 0;
      const double beta = m.omega > 0 ? dice.uniform(0, 0.1) : 0.0;
      mode.push_back(m);
      load.push_back(dice.one_in(2) ? dice.uniform(-1, 1) * m.mass * 1e3 : 0.0);
      mass.push_back(m.mass), inverse_mass.push_back(1 / m.mass);
      omega.push_back(m.omega), decay.push_back(2 * m.zeta * m.omega);
      turn.push_back(m.omega * (m.zeta + std::hypot(1.0, m.zeta)));
      wander.push_back(beta * speed);
      largest_shape.push_back(dice.uniform(0.5, 2)), tail.push_back(1e-6);
      v[k] = dice.uniform(-1, 1);
      u[k] = dice.uniform(-1, 1) / std::max(m.omega, 1e3);
      quickest = std::max(quickest, turn[k]);
      for (int n = 0; n < nodes; ++n) {
        shape.resize(nodes * 4 * modes);
        const double phase = dice.uniform(0, 6.3);
        double power =
            0.99 * largest_shape[k];  // beyond its middle a cubic is a little larger than the wave
        for (int m4 = 0; m4 < 4; ++m4) {
          shape[(n * 4 + m4) * modes + k] = power * std::cos(phase + m4 * M_PI_2);
          power *= beta / (m4 + 1);
        }
      }
    }
    for (int n = 0; n < nodes; ++n) {
      face.push_back(dice.uniform(-1, 1) * 1e-4);
      face.push_back(speed > 0 ? dice.uniform(-1, 1) / speed : 0.0);
    }
    t.motion.time_step = 0x1p-45;
    t.motion.position = 0.25, t.motion.advance = speed * t.motion.time_step, t.motion.spacing = 1;
    t.contact.node_stiffness = stiffness;
    t.adaptive.tolerance = tolerance;
    t.adaptive.order = series_order(tolerance);
    t.modes.load = load.data(), t.modes.mass = mass.data(), t.modes.omega = omega.data(),
    t.adaptive.decay = decay.data();
    t.adaptive.inverse_mass = inverse_mass.data(), t.adaptive.passing_rate = wander.data(),
    t.adaptive.fastest_rate = turn.data();
    t.bounds.largest_shape = largest_shape.data(), t.bounds.cubic_remainder = tail.data();
    series.resize((most_order + 2) * modes), squares.resize(most_order * modes);
    node_series.resize(nodes * 2 * overlap_terms), closed_shape.resize(nodes * 4 * modes);
    scan_shape.resize(4 * modes), scan.resize(overlap_terms);
    for (int n = 0; n < touching; ++n) closed.push_back(n);
    closed.resize(nodes);
    s.caches.node_shape = shape.data(), s.caches.node_face = face.data(),
    s.marks.node_window = window.data();
    s.work.series.modes = series.data(), s.work.series.squares = squares.data();
    s.work.series.nodes = node_series.data(), s.work.series.shapes = closed_shape.data();
    s.work.series.one_shape = scan_shape.data(), s.work.search.polynomial = scan.data();
    s.carried.contacts.nodes = closed.data(), s.carried.contacts.count = touching,
    s.work.spans.hulls = hulls.data();
  }
  BodyTables(const BodyTables&) = delete;

  Place place() const { return {t.motion, 0}; }
};

/// Their motion. The kernels keep addresses, so they come after the tables.
struct Bodies : BodyTables {
  NodeContact<HostLanes, K> contact;
  ModalSeries<HostLanes, K> motion;

  Bodies(Dice& dice, double tolerance, double speed, double stiffness, int touching)
      : BodyTables(dice, tolerance, speed, stiffness, touching),
        contact{test::node_contact_of<K>(t, s)},
        motion{test::series_of<K>(t, s)} {}

  void expand(double scale) {
    Real pu[K], pv[K];
    for (int p = 0; p < K; ++p) {
      pu[p] = lanes.load(u.data() + p * width);
      pv[p] = lanes.load(v.data() + p * width);
    }
    motion.expand(pu, pv, place(), scale);
  }
  struct Lanes {
    Amplitudes u, v;
  };
  Lanes at(double x) const {
    Real pu[K], pv[K];
    motion.state(x, pu, pv);
    Lanes out;
    for (int p = 0; p < K; ++p) {
      lanes.store(out.u.data() + p * width, pu[p]);
      lanes.store(out.v.data() + p * width, pv[p]);
    }
    return out;
  }
  int order() const { return motion.degree() - 3; }
  double coefficient(int j, int k) const { return series[j * modes + k]; }
  /// The d-th derivative of U_k by x.
  long double derivative(int d, int k, double x) const {
    long double sum = 0;
    for (int j = order(); j >= d; --j) {
      long double c = coefficient(j, k);
      for (int i = 0; i < d; ++i) c *= j - i;
      sum = sum * x + c;
    }
    return sum;
  }
  /// psi_k and its slope at a node, x on.
  std::array<long double, 2> shape_at(int node, int k, double x) const {
    const Place here = place();
    const long double o = here.offset + static_cast<long double>(x) * advance();
    const auto c = [&](int m) -> long double { return shape[(node * 4 + m) * modes + k]; };
    return {c(0) + o * (c(1) + o * (c(2) + o * c(3))), c(1) + o * (2 * c(2) + o * 3 * c(3))};
  }
  double advance() const { return t.motion.advance * (motion.scale() / t.motion.time_step); }
  /// A node's overlap from its definition, its change per x that is due to the way alone, and the
  /// size of what they are sums of.
  struct Overlap {
    long double over, sliding_rate, size;
  };
  Overlap overlap(int node, double x) const {
    const long double theta = place().theta + static_cast<long double>(x) * advance();
    const long double rise = face[2 * node + 1];
    Overlap o{0, rise * advance(), std::abs(face[2 * node]) + std::abs(rise)};
    long double modes_part = 0;
    for (int k = 0; k < modes; ++k) {
      const auto [psi, slope] = shape_at(node, k, x);
      const long double now = derivative(0, k, x);
      modes_part += psi * now;
      o.sliding_rate += slope * advance() * now;
      for (int j = 0; j <= t.adaptive.order; ++j)
        o.size += largest_shape[k] * std::abs(coefficient(j, k)) * std::pow(x, j);
    }
    o.over = -gap<long double>(0, face[2 * node], 0, {0, rise, theta}, modes_part);
    return o;
  }
  /// Energy norm of a difference.
  double norm(const Amplitudes& du, const Amplitudes& dv) const {
    double sum = 0;
    for (int k = 0; k < modes; ++k)
      sum += mass[k] * (std::pow(dv[k], 2) + std::pow(omega[k] * du[k], 2));
    return std::sqrt(sum);
  }
};

TEST(GaussRule, IsExactToThe15thPowerAndNearlyOfTheProductsOfAStep) {
  const auto integral = [](auto f) {
    long double sum = 0;
    for (int g = 0; g < gauss_points; ++g)
      sum += gauss_weight[g] * f(static_cast<long double>(gauss_place[g]));
    return static_cast<double>(sum);
  };
  for (int power = 0; power <= 15; ++power)
    EXPECT_NEAR(integral([&](long double x) { return std::pow(x, power); }), 1.0 / (power + 1),
                4 * eps);
  // (n!)^4/((2 n + 1) (2 n)!^2), n = 8
  EXPECT_NEAR(1.0 / 17 - integral([](long double x) { return std::pow(x, 16); }), 3.55e-10, 1e-12);
  // an overlap and its rise as far as a step goes (kernels/tables.hpp): theta = 1.8
  EXPECT_NEAR(integral([](long double x) { return std::sin(1.8L * x) * std::cos(1.8L * x); }),
              std::pow(std::sin(1.8), 2) / 3.6, 1e-13);
}

TEST(ModalSeries, OfFreeModesIsTheClosedFormWithinItsTolerance) {
  Dice dice(1);
  for (int trial = 0; trial < 200; ++trial) {
    const double tolerance = std::pow(10.0, -3 - trial % 11);
    Bodies b(dice, tolerance, dice.one_in(2) ? 0.0 : 1e4, 0, 0);
    b.t.adaptive.most_raised = 4;
    b.s.carried.control.raised = trial % 5;
    b.expand(dice.ratio(0.3, 3) / b.quickest);
    ASSERT_EQ(b.order(), series_order(tolerance) + 2 * (trial % 5));
    const double usable = b.motion.usable_length(tolerance);
    ASSERT_GT(usable, 0);
    double size = b.norm(b.u, b.v);  // the load pulls, too: what the first two terms come to
    for (int k = 0; k < modes; ++k)
      size += std::sqrt(b.mass[k]) * std::abs(b.load[k] / b.mass[k]) / b.quickest;
    for (const double x : {0.0, 0.3 * usable, usable, 2 * usable}) {
      const Bodies::Lanes y = b.at(x);
      Amplitudes du, dv;
      for (int k = 0; k < modes; ++k) {
        const State exact = fly(b.mode[k], b.load[k], {b.u[k], b.v[k], 0},
                                static_cast<long double>(x) * b.motion.scale());
        du[k] = static_cast<double>(y.u[k] - exact.u);
        dv[k] = static_cast<double>(y.v[k] - exact.v);
      }
      const double off = b.norm(du, dv);
      // terms of up to exp(turn x) before they cancel, each rounded a few times
      const double rounding = 16 * eps * std::exp(b.quickest * b.motion.scale() * x) * size;
      if (x <= usable) {
        EXPECT_LE(off, tolerance * size + rounding) << "trial " << trial << " x " << x;
      } else if (usable < 4) {  // it does not stop long before it has to
        EXPECT_GT(off + rounding, tolerance * size) << "trial " << trial;
      }
    }
  }
}

TEST(ModalSeries, IsTheSameInOtherUnits) {
  // in units of a power of two times the other: to the bit
  Dice dice(2);
  for (int trial = 0; trial < 50; ++trial) {
    Bodies b(dice, 1e-8, 0.0, 1e7, trial % 4);
    const double scale = 1 / b.quickest;
    b.expand(scale);
    const std::vector<double> first = b.series;
    const double usable = b.motion.usable_length(1e-8);
    b.expand(4 * scale);
    for (int j = 0; j <= b.t.adaptive.order; ++j)
      for (int k = 0; k < modes; ++k)
        ASSERT_EQ(std::ldexp(first[j * modes + k], 2 * j), b.coefficient(j, k));
    // What the first terms come to over a unit counts for the size of all: 4^4 times in energy at
    // the most, and of that a step sees the root of twice the order.
    if (usable < 4) {
      EXPECT_NEAR(4 * b.motion.usable_length(1e-8) / usable, 1,
                  std::pow(257, 0.5 / (b.t.adaptive.order - 1)) - 1);
    }
  }
}

TEST(ModalSeries, OfOneModeOnASpringIsTheClosedForm) {
  // At rest the slider's node stiffens a mode, omega'^2 = omega^2 + kappa phi^2/m, and presses it
  // by what the faces overlap.
  Dice dice(3);
  for (int trial = 0; trial < 100; ++trial) {
    Bodies b(dice, 1e-12, 0.0, dice.ratio(1e5, 1e10), 1);
    const int only = dice.pick(modes);
    for (int k = 0; k < modes; ++k)
      for (int m = 0; m < 4; ++m)
        if (k != only) b.shape[m * modes + k] = 0;
    const Mode& m = b.mode[only];
    const double phi = static_cast<double>(b.shape_at(0, only, 0)[0]);
    const double kappa = b.t.contact.node_stiffness,
                 w2 = m.omega * m.omega + kappa * phi * phi / m.mass;
    const Mode stiffer{std::sqrt(w2), m.zeta * m.omega / std::sqrt(w2), m.mass};
    const long double start = b.face[0] + phi * static_cast<long double>(b.u[only]);
    const long double press = b.load[only] - kappa * phi * static_cast<long double>(b.face[0]);
    b.expand(1 / (b.turn[only] + std::sqrt(w2)));
    const double rounding =
        450 * eps;  // of twenty terms, each with up to twenty roundings behind it
    for (const double x : {0.0, 0.1, 0.5, 1.0}) {
      const State exact = fly(stiffer, press, {b.u[only], b.v[only], 0}, x * b.motion.scale());
      // the remainder of the motion about its rest, x^19/19! and what follows: below 1e-16 of it
      const double amplitude =
          static_cast<double>(std::abs(exact.u) + std::abs(start)) + std::abs(b.u[only]) +
          (std::abs(b.v[only]) + static_cast<double>(std::abs(press)) / m.mass * b.motion.scale()) *
              b.motion.scale();
      const Bodies::Lanes y = b.at(x);
      EXPECT_NEAR(y.u[only], static_cast<double>(exact.u), rounding * amplitude);
      EXPECT_NEAR(y.v[only], static_cast<double>(exact.v), rounding * amplitude / b.motion.scale());
      const double over = polynomial(b.motion.overlap(0), b.motion.degree(), x);
      EXPECT_NEAR(over, static_cast<double>(b.face[0] + phi * exact.u), rounding * amplitude * 2);
    }
  }
}

TEST(ModalSeries, SolvesTheEquationsOfSlidingContact) {
  Dice dice(4);
  double moved = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const int touching = 1 + trial % 3;
    Bodies b(dice, 1e-13, dice.ratio(1e2, 1e5), dice.ratio(1e6, 1e9), touching);
    // stiff springs turn faster than any mode
    double fastest = b.quickest;
    for (int k = 0; k < modes; ++k)
      fastest = std::max(fastest, std::sqrt(3 * modes * b.t.contact.node_stiffness / b.mass[k]) *
                                      b.largest_shape[k]);
    b.expand(1 / fastest);
    for (const double x : {0.0, 0.05, 0.1}) {  // what is beyond the last term is x^19 of it
      const double scale = b.motion.scale();
      std::vector<Bodies::Overlap> o;
      for (int e = 0; e < touching; ++e) {
        o.push_back(b.overlap(e, x));
        EXPECT_NEAR(polynomial(b.motion.overlap(e), b.motion.degree(), x),
                    static_cast<double>(o[e].over),
                    64 * eps * static_cast<double>(o[e].size) + b.motion.neglected());
      }
      for (int k = 0; k < modes; ++k) {
        const long double rate = b.derivative(1, k, x) / scale;
        const long double second = b.derivative(2, k, x) / (scale * scale);
        long double force = b.load[k], size = std::abs(force);
        for (int e = 0; e < touching; ++e) {
          const auto [psi, slope] = b.shape_at(e, k, x);
          force -= b.t.contact.node_stiffness * psi * o[e].over;
          size += b.t.contact.node_stiffness * b.largest_shape[k] * o[e].size;
        }
        const long double w = b.omega[k];
        const long double acceleration = w * w * b.derivative(0, k, x) + b.decay[k] * rate;
        size = size / b.mass[k] + std::abs(w * w * b.u[k]) + std::abs(b.decay[k] * b.v[k]);
        EXPECT_NEAR(
            static_cast<double>(second), static_cast<double>(force / b.mass[k] - acceleration),
            256 * eps * static_cast<double>(size) +
                b.t.contact.node_stiffness * b.motion.neglected() / b.mass[k] * touching * 2)
            << "trial " << trial << ", mode " << k << ", x " << x;
      }
    }
    moved += b.advance();
  }
  EXPECT_GT(moved, 1e-3);
}

TEST(ModalSeries, KnowsWhatItsOverlapsNeglect) {
  // The modes' series times the shapes along the way, a cubic: the overlap's series is that to the
  // last bit if it takes all terms of the shapes, and within `neglected` if not. Its sliding_rate
  // is the share of the way alone.
  Dice dice(5);
  std::array<int, 5> seen{};
  for (int trial = 0; trial < 200; ++trial) {
    const double speed = dice.ratio(1e3, 1e7);
    Bodies b(dice, std::pow(10.0, -2 - trial % 12), speed, 1e7, 2);
    b.expand(std::min(dice.ratio(0.3, 1) / b.quickest, 1 / speed));
    ++seen[b.motion.wanted_terms()];
    if (b.motion.wanted_terms() == 4) {
      EXPECT_EQ(b.motion.neglected(), 0);
    }
    for (const double x : {0.0, 0.5, 1.0, 2.0})  // as far as `neglected` speaks of
      for (int e = 0; e < 2; ++e) {
        const Bodies::Overlap o = b.overlap(e, x);
        const double rounding = 64 * eps * static_cast<double>(o.size);
        EXPECT_NEAR(polynomial(b.motion.overlap(e), b.motion.degree(), x),
                    static_cast<double>(o.over), b.motion.neglected() + rounding)
            << "trial " << trial << ", x " << x;
        if (b.motion.wanted_terms() == 4) {
          EXPECT_NEAR(polynomial(b.motion.sliding_rate(e), b.motion.degree(), x),
                      static_cast<double>(o.sliding_rate), rounding * std::max(1.0, b.advance()));
        }
        // of any node, closed or not: with all terms
        b.motion.overlap_of(e, b.place(), b.scan.data());
        EXPECT_NEAR(polynomial(b.scan.data(), b.motion.degree(), x), static_cast<double>(o.over),
                    rounding);
      }
    double advance = 0;
    for (int k = 0; k < modes; ++k)
      advance +=
          b.largest_shape[k] * (std::abs(b.coefficient(1, k)) + std::abs(b.coefficient(2, k)));
    EXPECT_LE(b.motion.neglected(), 0.03 * b.t.adaptive.tolerance * advance * (1 + 16 * eps));
  }
  EXPECT_GT(seen[2], 0);
  EXPECT_GT(seen[3], 0);
  EXPECT_GT(seen[4], 0);
}

TEST(ModalSeries, BoundsHold) {
  Dice dice(6);
  double nearest = 0, nearest_fourth = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int touching = trial % 3;  // the last node stays open and is evaluated
    Bodies b(dice, 1e-13, dice.one_in(3) ? 0.0 : dice.ratio(1e2, 1e5), dice.ratio(1e5, 1e8),
             touching);
    b.expand(dice.ratio(0.1, 0.5) / b.quickest);
    const double x = dice.ratio(0.01, 1) * std::min(1.0, b.motion.usable_length(1e-13));
    for (int e = 0; e < touching; ++e) {
      Hull& h = b.hulls[e];
      h = {1e300, -1e300, 1e300, -1e300, 0};
      const double* c = b.motion.overlap(e);
      for (int i = 0; i <= 400; ++i) {
        const double at = x * i / 400;
        double second = 0;
        for (int j = b.motion.degree(); j >= 2; --j) second = second * at + j * (j - 1) * c[j];
        const ValueAndSlope p = polynomial_and_slope(c, b.motion.degree(), at);
        h.least = std::min(h.least, p.value), h.most = std::max(h.most, p.value);
        h.falling = std::min(h.falling, p.slope), h.rising = std::max(h.rising, p.slope);
        h.curvature = std::max(h.curvature, std::abs(second));
      }
      h.curvature *= 1.001;  // between the places evaluated
    }
    const MotionBounds bounds = b.motion.bounds(x);
    b.motion.overlap_of(2, b.place(), b.scan.data());
    const double per4 = std::pow(b.motion.scale(), -4);
    for (int i = 0; i <= 40; ++i) {
      const double at = x * i / 40;
      double travel = 0, size = 0, tail = 0;
      for (int k = 0; k < modes; ++k) {
        const auto now = static_cast<double>(b.derivative(0, k, at));
        travel += b.largest_shape[k] * std::abs(now - b.u[k]);
        size += b.largest_shape[k] * std::abs(now);
        tail += b.tail[k] * std::abs(now);
      }
      double fourth_derivative = 0;
      for (int j = b.motion.degree(); j >= 4; --j)
        fourth_derivative = fourth_derivative * at + j * (j - 1.0) * (j - 2) * (j - 3) * b.scan[j];
      fourth_derivative = std::abs(fourth_derivative) * per4;
      const double more = 1 + 1e-9;  // the series ends, and the sums round
      ASSERT_LE(travel, bounds.travel * more + 8 * eps * bounds.size) << "trial " << trial;
      ASSERT_LE(size, bounds.size * more) << "trial " << trial;
      ASSERT_LE(tail, bounds.cubic_remainder * more) << "trial " << trial;
      ASSERT_LE(fourth_derivative, bounds.fourth_derivative * more)
          << "trial " << trial << " at " << at / x;
      nearest = std::max(nearest, travel / bounds.travel);
      nearest_fourth = std::max(nearest_fourth, fourth_derivative / bounds.fourth_derivative);
    }
  }
  EXPECT_GT(nearest, 0.9);
  EXPECT_GT(nearest_fourth, 0.1);
}

TEST(ModalSeries, BoundOnTheFourthDerivativeOfAModeThatIsPushedFromRest) {
  // U = 0, U' = 0 and U'' = a: of the fourth derivative of U psi, 6 U'' psi'' is all that there is.
  Dice dice(8);
  for (int trial = 0; trial < 50; ++trial) {
    Bodies b(dice, 1e-13, 1e7, 0, 0);
    const int pushed = trial % modes;
    b.u.fill(0), b.v.fill(0);
    std::fill(b.load.begin(), b.load.end(), 0.0);
    b.load[pushed] = b.mass[pushed];
    b.decay[pushed] = b.omega[pushed] = b.turn[pushed] = 0;
    b.wander[pushed] = 0.1 * 1e7;
    for (int m = 0; m < 4; ++m)  // at its top it bends most
      b.shape[(2 * 4 + m) * modes + pushed] =
          m % 2 == 1 ? 0 : b.largest_shape[pushed] * (m == 0 ? 1 : -0.5 * 0.01);
    b.expand(1e-9);
    const double x = 1e-3;
    b.motion.overlap_of(2, b.place(), b.scan.data());
    const double fourth_derivative = 24 * std::abs(b.scan[4]) * std::pow(b.motion.scale(), -4);
    EXPECT_NEAR(fourth_derivative, 6 * b.largest_shape[pushed] * 1e12, 64 * eps * fourth_derivative)
        << "that it is";
    const MotionBounds bounds = b.motion.bounds(x);
    EXPECT_LE(fourth_derivative, bounds.fourth_derivative * (1 + 64 * eps)) << "trial " << trial;
    EXPECT_GE(fourth_derivative, 0.9 * bounds.fourth_derivative) << "trial " << trial;
  }
}

TEST(ModalSeries, SumsTheSquareOfTheVelocity) {
  Dice dice(7);
  for (int trial = 0; trial < 100; ++trial) {
    const double tolerance = std::pow(10.0, -4 - trial % 10);
    Bodies b(dice, tolerance, 1e4, 1e6, trial % 3);
    b.expand(0.5 / b.quickest);
    b.motion.expand_squares();
    const double x = 0.5 * std::min(1.0, b.motion.usable_length(tolerance));
    Real packs[K];
    b.motion.squares(x, packs);
    Amplitudes sum;
    for (int p = 0; p < K; ++p) lanes.store(sum.data() + p * width, packs[p]);
    for (int k = 0; k < modes; ++k) {
      long double exact = 0, largest = 0;  // in ticks
      for (int piece = 0; piece < 4; ++piece)
        for (int g = 0; g < gauss_points; ++g) {
          const long double rate =
              b.derivative(1, k, x * (piece + gauss_place[g]) / 4) / b.motion.scale();
          exact += gauss_weight[g] / 4 * rate * rate;
          largest = std::max(largest, rate * rate);
        }
      const double ticks = x * b.motion.scale() / b.t.motion.time_step;
      // half way to where the last terms are the tolerance of all, 2^-(order - 2) of that is left
      const double left = tolerance * std::ldexp(1, 2 - b.order()) * b.norm(b.u, b.v) *
                          b.norm(b.u, b.v) / b.mass[k];
      EXPECT_NEAR(sum[k], static_cast<double>(exact) * ticks,
                  (64 * eps * static_cast<double>(largest) + 4 * left) * ticks)
          << "trial " << trial << ", mode " << k;
    }
  }
}

TEST(LobattoRules, LeaveOutOfASquareWhatTheyShould) {
  std::vector<double> table(lobatto_rules * lobatto_numbers);
  fill_lobatto(table.data());
  const double theta = 4.3;
  const double shares[] = {most_by_five, most_by_seven, 1.0}, left[] = {1e-9, 1e-9, 2e-8};
  for (int rule = 0; rule < lobatto_rules; ++rule) {
    const int inner = lobatto_inner[rule], n = inner + 2;
    const double* const at = table.data() + rule * lobatto_numbers;
    const double* const weight = at + lobatto_row;
    const auto of_power = [&](int power) {
      double sum = weight[inner] * (power == 0 ? 2.0 : 1.0);
      for (int g = 0; g < inner; ++g) sum += weight[g] * std::pow(at[g], power);
      return sum;
    };
    for (int power = 0; power <= 2 * n - 3; ++power)
      EXPECT_NEAR(of_power(power), 1.0 / (power + 1), 8 * eps) << n << " points, power " << power;
    const double beyond = n * std::pow(n - 1, 3) * std::pow(std::tgamma(n - 1), 4) /
                          ((2 * n - 1) * std::pow(std::tgamma(2 * n - 1), 3));
    EXPECT_NEAR(of_power(2 * n - 2) - 1.0 / (2 * n - 1), beyond * std::tgamma(2 * n - 1), 8 * eps)
        << n << " points";
    const double left_out = beyond * std::pow(2 * theta * shares[rule], 2 * n - 2);
    EXPECT_LT(left_out, 1.1 * left[rule]) << n << " points";
    EXPECT_GT(left_out, 0.5 * left[rule]) << n << " points";
  }
}

TEST(ModalSeries, SumsTheSquareOfTheVelocityPieceByPiece) {
  Dice dice(9);
  std::vector<double> table(lobatto_rules * lobatto_numbers);
  fill_lobatto(table.data());
  for (int trial = 0; trial < 100; ++trial) {
    const double tolerance = std::pow(10.0, -4 - trial % 9);
    Bodies b(dice, tolerance, 1e4, 1e6, trial % 3);
    b.t.adaptive.lobatto = table.data();
    b.t.adaptive.most_raised = 4;
    b.s.carried.control.raised =
        std::min(1 + trial % 4, (most_order - series_order(tolerance)) / 2);
    b.expand(0.5 / b.quickest);
    ASSERT_FALSE(b.motion.has_series_of_squares());
    const double usable = b.motion.usable_length(tolerance);
    // one piece for each rule
    const double ends[] = {0.0, 0.1 * usable, 0.4 * usable, usable};
    Real square[K], v[2][K], u[K];
    for (int p = 0; p < K; ++p) square[p] = Real(0.0);
    b.motion.state(0.0, u, v[0]);
    for (int piece = 0; piece < 3; ++piece) {
      const double begin = ends[piece], end = ends[piece + 1];
      b.motion.state(end, u, v[1]);
      Real before[K];
      for (int p = 0; p < K; ++p) before[p] = square[p];
      b.motion.add_squares(begin, v[0], end, v[1], square);
      Amplitudes sum;
      for (int p = 0; p < K; ++p) lanes.store(sum.data() + p * width, square[p] - before[p]);
      const double ticks = (end - begin) * b.motion.scale() / b.t.motion.time_step;
      for (int k = 0; k < modes; ++k) {
        long double exact = 0;
        for (int part = 0; part < 4; ++part)
          for (int g = 0; g < gauss_points; ++g) {
            const double x = begin + (end - begin) * (part + gauss_place[g]) / 4;
            const long double rate = b.derivative(1, k, x) / b.motion.scale();
            exact += gauss_weight[g] / 4 * rate * rate;
          }
        const double all = std::pow(b.norm(b.u, b.v), 2) / b.mass[k];
        EXPECT_NEAR(sum[k], static_cast<double>(exact) * ticks,
                    (piece < 2 ? 1e-9 : 2e-8) * all * ticks)
            << "trial " << trial << ", mode " << k << ", piece " << piece;
      }
      std::copy(v[1], v[1] + K, v[0]);
    }
  }
}

// ---- the constants of the proof, each where it is reached (proofs.md)

/// One mode alone, without stiffness, damping and load, at a node of one unit of mass. What a test
/// is about it sets itself. Times are in units of a second.
struct OneMode : Bodies {
  std::vector<double> modal_force = std::vector<double>((most_order + 1) * modes, 0.0);
  double largest_shape0;

  explicit OneMode(Dice& dice, int closed_nodes = 0) : Bodies(dice, 1e-13, 0.0, 0, closed_nodes) {
    for (std::vector<double>* row : {&load, &omega, &decay, &turn, &wander, &tail})
      std::fill(row->begin(), row->end(), 0.0);
    std::fill(mass.begin(), mass.end(), 1.0),
        std::fill(inverse_mass.begin(), inverse_mass.end(), 1.0);
    std::fill(shape.begin(), shape.end(), 0.0), std::fill(face.begin(), face.end(), 0.0);
    u.fill(0), v.fill(0);
    s.work.series.forces = modal_force.data();
    largest_shape0 = largest_shape[0];
  }
  /// U = size x^d/d!: from the state, the load, and forces that grow.
  void begin_with(int d, double size) {
    if (d == 0) u[0] = size;
    if (d == 1) v[0] = size;
    if (d == 2) load[0] = size;
    if (d >= 3) t.forces.count = 1, modal_force[(d - 2) * modes] = size / (d == 4 ? 2 : 1);
    expand(1);
  }
  /// Of the force on it, where nodes that are in contact are `hull` deep.
  MotionBounds under(const Hull& hull, double x) {
    t.contact.node_stiffness = 2;
    s.carried.contacts.count = 0;
    expand(1);
    s.carried.contacts.count = 1, hulls[0] = hull;
    std::copy(shape.begin(), shape.begin() + 4 * modes, closed_shape.begin());
    return motion.bounds(x);
  }
};

TEST(SeriesProof, EachTermOfAModeAtANodeThatMovesIsReached) {
  // (d/dx + b)^4 of U psi, where one derivative of U is all there is. psi, a wave, may be as large
  // as its bound in the derivative that it goes with.
  constexpr double b = 0.5, size = 3;
  const double binomial[] = {1, 4, 6, 4, 1};
  for (int d = 0; d <= 4; ++d) {
    Dice dice(20);
    OneMode mode(dice);
    mode.wander[0] = b;
    mode.begin_with(d, size);
    ASSERT_NEAR(static_cast<double>(mode.derivative(d, 0, 0)), size, 8 * eps * size);
    const double x = 1e-9;
    const double fourth_derivative = binomial[d] * std::pow(b, 4 - d) * size * mode.largest_shape0;
    const MotionBounds bounds = mode.motion.bounds(x);
    EXPECT_GE(bounds.fourth_derivative, fourth_derivative * (1 - 64 * eps)) << "derivative " << d;
    EXPECT_LE(bounds.fourth_derivative, fourth_derivative * (1 + 1e-6)) << "derivative " << d;
  }
}

TEST(SeriesProof, TravelIsReachedByAModeWithoutForces) {
  // U = size x^d/d! again, after a while. Each derivative is taken at the end of the stretch: x^d,
  // which is d! times the way itself. It is reached for d = 1, and of a short stretch that is all.
  constexpr double size = 3, x = 0.75;
  for (int d = 1; d <= 4; ++d) {
    Dice dice(21);
    OneMode mode(dice);
    mode.tail[0] = 0.25;
    mode.begin_with(d, size);
    const double advance = size * std::pow(x, d);
    const MotionBounds bounds = mode.motion.bounds(x);
    EXPECT_NEAR(bounds.travel, mode.largest_shape0 * advance, 1e-12) << "derivative " << d;
    EXPECT_NEAR(bounds.size, mode.largest_shape0 * advance, 1e-12) << "derivative " << d;
    EXPECT_NEAR(bounds.cubic_remainder, 0.25 * advance, 1e-12) << "derivative " << d;
  }
}

TEST(SeriesProof, AFreeModesFourthDerivativeIsReachedWhereItTurnsRound) {
  // omega^4 U, at a node that does not move
  Dice dice(22);
  OneMode mode(dice);
  constexpr double omega = 7;
  mode.omega[0] = mode.turn[0] = omega;
  mode.u[0] = 0.5;
  mode.expand(1);
  const double fourth_derivative = std::pow(omega, 4) * 0.5 * mode.largest_shape0;
  EXPECT_NEAR(mode.motion.bounds(0).fourth_derivative, fourth_derivative,
              64 * eps * fourth_derivative);
}

TEST(SeriesProof, EachShareOfAContactForceIsReached) {
  // F'' = -kappa (o psi)'', with kappa = 2: o'' psi, 2 o' psi' and o psi''
  constexpr double x = 0.5;
  const auto fourth_derivative = [&](const Hull& hull, int term, double of_shape) {
    Dice dice(23);
    OneMode mode(dice);
    mode.shape[term * modes] = of_shape;
    return mode.under(hull, x).fourth_derivative / mode.largest_shape0;
  };
  const Hull bent{0, 0, 0, 0, 3}, deep{-5, 4, 0, 0, 0}, high{-4, 5, 0, 0, 0};
  const Hull falls{0, 0, -5, 4, 0}, rises{0, 0, -4, 5, 0};
  EXPECT_NEAR(fourth_derivative(bent, 0, -7), 2 * 3 * 7, 1e-9);
  for (const Hull& hull : {rises, falls})
    EXPECT_NEAR(fourth_derivative(hull, 1, 7), 2 * 2 * 5 * 7, 1e-9);
  for (const Hull& hull : {deep, high}) {
    EXPECT_NEAR(fourth_derivative(hull, 2, -7), 2 * 5 * 2 * 7, 1e-9);
    EXPECT_NEAR(fourth_derivative(hull, 3, 7), 2 * 5 * 6 * 7 * x, 1e-9);
  }
}

TEST(SeriesProof, WhatIsNeglectedIsReachedAtACrestAndOnAFlank) {
  // Over a step of two, a bent beam that rests: of cos(b x) the second term, (2 b)^2/2, of sin(b x)
  // the third, (2 b)^3/6. Another mode moves enough for a tolerance that lets them go.
  for (const int terms : {2, 3}) {
    Dice dice(24);
    OneMode mode(dice, 1);
    constexpr double b = 1e-3, size = 3;
    mode.t.motion.advance = mode.t.motion.time_step;  // a chi a second
    mode.t.motion.position = 0.5;                     // the middle of the window
    mode.wander[0] = b;
    mode.u[0] = size;
    mode.v[1] = 1;
    const double left_out = terms == 2 ? 2 * b * b : 8.0 / 6 * b * b * b;
    mode.shape[0] = terms == 2 ? 1 : 0, mode.shape[modes] = terms == 2 ? 0 : b;
    mode.shape[2 * modes] = terms == 2 ? -0.5 * b * b : 0;
    mode.shape[3 * modes] = terms == 2 ? 0 : -b * b * b / 6;
    const double scale = mode.largest_shape[0];
    for (int m = 0; m < 4; ++m) mode.shape[m * modes] *= scale;
    mode.t.adaptive.tolerance =
        (terms == 2 ? 2.1 : 0.01) * scale * size * b * b / (0.03 * mode.largest_shape[1]);
    mode.expand(1);
    ASSERT_EQ(mode.motion.wanted_terms(), terms);
    const double off = std::abs(polynomial(mode.motion.overlap(0), mode.motion.degree(), 2) -
                                static_cast<double>(mode.overlap(0, 2).over));
    EXPECT_NEAR(off, scale * size * left_out, 1e-3 * off);
    EXPECT_GE(mode.motion.neglected(), off * (1 - 1e-6)) << terms << " terms";
    EXPECT_LE(mode.motion.neglected(), off * (1 + 1e-6)) << terms << " terms";
  }
}

}  // namespace
