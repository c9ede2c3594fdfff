// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "host/device/flight_tables.hpp"
#include "kernels/adaptive/flight.hpp"
#include "kernels/lanes.hpp"
#include "tests/dice.hpp"
#include "tests/free_motion.hpp"
#include "tests/kernels_of.hpp"
#include "tests/numbers.hpp"

/// Free flight of any length against the closed form in long double.
namespace {

using namespace ra2d;
using test::Dice, test::State, test::fly;

using test::eps;
constexpr int width = HostLanes::width;
constexpr int K = 2, modes = K * width;
using Real = HostLanes::Real;

const HostLanes lanes;

/// Modes of all kinds, one a lane, with the tables that the march would have.
struct Flying {
  std::vector<Mode> mode;
  std::vector<double> load;
  std::vector<double> flight, rest, fall, omega, decay, farthest, largest_shape, fourth_derivative,
      tail;
  SceneTables t;
  double quickest = 0;

  Flying(Dice& dice, bool loaded) {
    const double zetas[] = {0.0, 1e-3, 0.02, 0.3, 0.999, 1.0, 1.001, 3.0};
    for (int k = 0; k < modes; ++k) {
      Mode m{dice.ratio(1e2, 1e6), zetas[k % 8], dice.ratio(0.1, 10)};
      if (k % 5 == 4) m.omega = 0;
      mode.push_back(m);
      load.push_back(loaded ? dice.uniform(-1, 1) : 0.0);
      quickest = std::max(quickest, m.omega * (m.zeta + std::hypot(1.0, m.zeta)));
    }
    t.motion.time_step = 0x1p-51;
    // what host/device/batch.cpp chooses: turn time below 2e-4 on the first level
    t.flight.first_level = std::ilogb(2e-4 / (quickest * t.motion.time_step));
    const int levels = 51 - t.flight.first_level;  // up to a second
    t.flight.levels = levels;
    flight.assign(static_cast<std::size_t>(levels) * flight_rows * modes, 0.0);
    for (int k = 0; k < modes; ++k) {
      const auto rows =
          flight_tables(mode[k], load[k], t.motion.time_step, t.flight.first_level, levels);
      for (int level = 0; level < levels; ++level)
        for (int r = 0; r < flight_rows; ++r)
          flight[(static_cast<std::size_t>(level) * flight_rows + r) * modes + k] = rows[level][r];
      const double w = mode[k].omega, a = load[k] / mode[k].mass;
      rest.push_back(w > 0 ? a / (w * w) : 0.0);
      fall.push_back(w > 0 ? 0.0 : a);
      omega.push_back(w);
      decay.push_back(2 * mode[k].zeta * w);
      farthest.push_back(w > 0 ? 2 / w : 1e300);
      largest_shape.push_back(dice.uniform(0.5, 2));
      tail.push_back(dice.uniform(0, 1e-3));
    }
    fourth_derivative.assign(modes, 0.0);
    t.flight.rows = flight.data(), t.flight.rest = rest.data(),
    t.flight.free_acceleration = fall.data();
    t.modes.omega = omega.data(), t.adaptive.decay = decay.data(),
    t.flight.displacement_per_energy_norm = farthest.data();
    t.bounds.largest_shape = largest_shape.data(),
    t.flight.fourth_derivative_per_energy_norm = fourth_derivative.data(),
    t.bounds.cubic_remainder = tail.data();
  }
  Flying(const Flying&) = delete;

  struct Lanes {
    std::array<double, modes> u{}, v{}, square{};
  };
  Lanes random_state(Dice& dice) const {
    Lanes y;
    for (int k = 0; k < modes; ++k) {
      y.v[k] = dice.one_in(5) ? 0.0 : dice.uniform(-1, 1);
      y.u[k] = dice.one_in(5) ? 0.0 : dice.uniform(-1, 1) / std::max(omega[k], 1.0);
    }
    return y;
  }
  Lanes after(Lanes y, std::int64_t ticks) const {
    Real u[K], v[K], square[K];
    for (int p = 0; p < K; ++p) {
      u[p] = lanes.load(y.u.data() + p * width);
      v[p] = lanes.load(y.v.data() + p * width);
      square[p] = lanes.load(y.square.data() + p * width);
    }
    test::flight_of<K>(t)(u, v, square, ticks);
    for (int p = 0; p < K; ++p) {
      lanes.store(y.u.data() + p * width, u[p]);
      lanes.store(y.v.data() + p * width, v[p]);
      lanes.store(y.square.data() + p * width, square[p]);
    }
    return y;
  }
  MotionBounds bounds(const Lanes& y, double time) const {
    Real u[K], v[K];
    for (int p = 0; p < K; ++p) {
      u[p] = lanes.load(y.u.data() + p * width);
      v[p] = lanes.load(y.v.data() + p * width);
    }
    return test::flight_of<K>(t).bounds(u, v, time);
  }
  /// The norm that free flight does not let grow, of speed.
  double norm(const Lanes& y, int k) const {
    return std::hypot(y.v[k], omega[k] * (y.u[k] - rest[k]));
  }
  /// Leaps of a flight.
  int leaps(std::int64_t ticks) const {
    return std::popcount(static_cast<std::uint64_t>(ticks) >> t.flight.first_level) + 1;
  }

  /// Bound on the roundings of a flight, in units of speed: each leap rounds its four entries and
  /// four products, to a few ulp of the norm, and omega t, to half an ulp.
  double rounding(const Lanes& y, int k, std::int64_t ticks) const {
    const double time = static_cast<double>(ticks) * t.motion.time_step;
    if (omega[k] == 0)
      return eps * (leaps(ticks) + 4) * (std::abs(y.v[k]) + std::abs(fall[k]) * time);
    return eps * (8.0 * leaps(ticks) + (1 + mode[k].zeta) * omega[k] * time) * norm(y, k);
  }
};

std::int64_t random_length(Dice& dice, const Flying& f) {
  // from a tick to a hundredth of a second
  return static_cast<std::int64_t>(dice.ratio(1, 1e-2 / f.t.motion.time_step));
}

TEST(Flight, OfAnyLengthIsTheClosedForm) {
  Dice dice(1);
  for (int trial = 0; trial < 300; ++trial) {
    const Flying f(dice, trial % 2 == 1);
    const Flying::Lanes y = f.random_state(dice);
    const std::int64_t ticks = trial == 0 ? 0 : random_length(dice, f);
    const Flying::Lanes z = f.after(y, ticks);
    const long double time = static_cast<long double>(ticks) * f.t.motion.time_step;
    for (int k = 0; k < modes; ++k) {
      SCOPED_TRACE("trial " + std::to_string(trial) + ", omega " + std::to_string(f.omega[k]) +
                   ", zeta " + std::to_string(f.mode[k].zeta) + ", " + std::to_string(ticks));
      const State exact = fly(f.mode[k], f.load[k], {y.u[k], y.v[k], 0}, time);
      const double off = f.rounding(y, k, ticks), t1 = static_cast<double>(time);
      ASSERT_NEAR(z.v[k], static_cast<double>(exact.v), off);
      // ... and each sum for U rounds to what U is
      const double per = f.omega[k] > 0 ? 1 / f.omega[k] : t1;
      const double largest =
          std::abs(y.u[k]) + (f.omega[k] > 0 ? 2 * f.norm(y, k) / f.omega[k] : 0);
      ASSERT_NEAR(z.u[k], static_cast<double>(exact.u),
                  off * per + eps * (f.leaps(ticks) + 2) * (largest + std::abs(exact.u)));
    }
  }
}

/// Marches of many packs leave out what is zero of elastic modes.
TEST(Flight, OfManyPacksIsThatOfFew) {
  Dice dice(6);
  constexpr int many = 4;
  static_assert(has_many_packs<HostLanes, many>);
  const HostLanes filled(modes);
  for (int trial = 0; trial < 40; ++trial) {
    const Flying f(dice, trial % 2 == 1);
    std::vector<int> order(modes);  // elastic modes first
    std::iota(order.begin(), order.end(), 0);
    const auto rigid =
        std::stable_partition(order.begin(), order.end(), [&](int k) { return f.omega[k] > 0; });
    const auto in_lanes = [&](const double* of) {
      std::vector<double> out(many * width, 1e300);  // of packs without modes nothing is read
      for (int k = 0; k < modes; ++k) out[k] = of[order[k]];
      return out;
    };
    SceneTables t = f.t;
    std::vector<double> rows;
    for (std::size_t row = 0; row < f.flight.size(); row += modes) {
      const std::vector<double> one = in_lanes(f.flight.data() + row);
      rows.insert(rows.end(), one.begin(), one.end());
    }
    const std::vector<double> rest = in_lanes(f.rest.data()), fall = in_lanes(f.fall.data()),
                              omega = in_lanes(f.omega.data()), decay = in_lanes(f.decay.data());
    t.flight.rows = rows.data(), t.flight.rest = rest.data();
    t.flight.free_acceleration = fall.data();
    t.modes.omega = omega.data(), t.adaptive.decay = decay.data();
    t.flight.elastic_packs = static_cast<int>(rigid - order.begin()) / width;
    const Flight<HostLanes, many> flight(filled, t.modes, t.motion, t.bounds, t.adaptive, t.flight);
    const Flying::Lanes y = f.random_state(dice);
    const std::int64_t ticks = random_length(dice, f);
    const Flying::Lanes few = f.after(y, ticks);
    const std::vector<double> u0 = in_lanes(y.u.data()), v0 = in_lanes(y.v.data());
    Real u[many], v[many], square[many];
    for (int p = 0; p < K; ++p) {
      u[p] = lanes.load(u0.data() + p * width);
      v[p] = lanes.load(v0.data() + p * width);
      square[p] = Real(0.0);
    }
    flight(u, v, square, ticks);
    std::array<double, modes> of_u{}, of_v{}, of_square{};
    for (int p = 0; p < K; ++p) {
      lanes.store(of_u.data() + p * width, u[p]);
      lanes.store(of_v.data() + p * width, v[p]);
      lanes.store(of_square.data() + p * width, square[p]);
    }
    const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
    for (int k = 0; k < modes; ++k) {
      SCOPED_TRACE("trial " + std::to_string(trial) + ", mode " + std::to_string(k));
      ASSERT_EQ(bits(of_u[k]), bits(few.u[order[k]]));
      ASSERT_EQ(bits(of_v[k]), bits(few.v[order[k]]));
      ASSERT_EQ(bits(of_square[k]), bits(few.square[order[k]]));
    }
  }
}

TEST(Flight, InPiecesIsTheSameToRoundings) {
  Dice dice(2);
  for (int trial = 0; trial < 300; ++trial) {
    const Flying f(dice, trial % 2 == 1);
    const Flying::Lanes y = f.random_state(dice);
    const std::int64_t a = random_length(dice, f), b = random_length(dice, f);
    const Flying::Lanes one = f.after(y, a + b), two = f.after(f.after(y, a), b);
    for (int k = 0; k < modes; ++k) {
      const double off = f.rounding(y, k, a) + f.rounding(y, k, b) + f.rounding(y, k, a + b);
      ASSERT_NEAR(one.v[k], two.v[k], off) << "trial " << trial << ", mode " << k;
    }
  }
}

TEST(Flight, SumsTheSquareOfTheVelocity) {
  Dice dice(3);
  for (int trial = 0; trial < 60; ++trial) {
    const Flying f(dice, trial % 2 == 1);
    const Flying::Lanes y = f.random_state(dice);
    const std::int64_t ticks =
        static_cast<std::int64_t>(dice.ratio(1, 1e-3 / f.t.motion.time_step));
    const Flying::Lanes z = f.after(y, ticks);
    const double time = static_cast<double>(ticks) * f.t.motion.time_step;
    for (int k = 0; k < modes; ++k) {
      const State exact = fly(f.mode[k], f.load[k], {y.u[k], y.v[k], 0}, time, true);
      const double norm =
          f.omega[k] > 0 ? f.norm(y, k) : std::abs(y.v[k]) + std::abs(f.fall[k]) * time;
      // V is off by rounding() at the most; the form has been doubled some 30 times, with four
      // roundings each; and a little flight leaves out (turn t)^3 of its own, below 2e-4
      const double little =
          std::min(time, std::ldexp(f.t.motion.time_step, f.t.flight.first_level));
      const double off = 2 * f.rounding(y, k, ticks) * norm * time +
                         8 * 30 * eps * norm * norm * time + 8e-12 * norm * norm * little;
      ASSERT_NEAR(z.square[k] * f.t.motion.time_step, static_cast<double>(exact.square), off)
          << "trial " << trial << ", omega " << f.omega[k] << ", zeta " << f.mode[k].zeta << ", "
          << ticks << " ticks";
    }
  }
}

TEST(Flight, OfAModeAtRestStaysThere) {
  Dice dice(4);
  const Flying f(dice, true);
  Flying::Lanes y;
  for (int k = 0; k < modes; ++k) y.u[k] = f.rest[k];
  const Flying::Lanes z = f.after(y, 0x123456789abcd);
  for (int k = 0; k < modes; ++k)
    if (f.omega[k] > 0) {
      EXPECT_EQ(z.u[k], y.u[k]);  // to the bit: there is nothing that it could swing with
      EXPECT_EQ(z.v[k], 0);
      EXPECT_EQ(z.square[k], 0);
    }
}

TEST(Flight, BoundsHold) {
  Dice dice(5);
  double nearest = 0, nearest_fourth = 0;
  for (int trial = 0; trial < 100; ++trial) {
    Flying f(dice, trial % 2 == 1);
    // a node that moves over the modes: psi_k = largest_shape sin(b_k t + phase)
    std::vector<double> b(modes), phase(modes);
    const double speed = dice.one_in(3) ? 0.0 : dice.ratio(1e2, 1e5);
    f.t.flight.fourth_derivative_at_rest = 0;
    for (int k = 0; k < modes; ++k) {
      b[k] = f.omega[k] > 0 ? speed * dice.uniform(0, 1) : 0.0;
      phase[k] = dice.uniform(0, 6.3);
      const double w = f.omega[k], turn = w * (f.mode[k].zeta + std::hypot(1, f.mode[k].zeta));
      // (turn + b)^4 term by term, see host/device/batch.cpp
      if (w > 0)
        f.fourth_derivative[k] =
            f.largest_shape[k] *
            (std::pow(turn, 3) + 4 * turn * turn * b[k] + 6 * turn * b[k] * b[k] +
             4 * std::pow(b[k], 3) + std::pow(b[k], 4) / w);
      f.t.flight.fourth_derivative_at_rest +=
          f.largest_shape[k] * std::pow(b[k], 4) * std::abs(f.rest[k]);
    }
    Flying::Lanes y = f.random_state(dice);
    if (trial % 4 == 3)  // one mode alone, so that the bound can be met
      for (int k = 0; k < modes; ++k)
        if (k != trial / 4 % modes) y.v[k] = 0, y.u[k] = f.rest[k];
    const double time = dice.ratio(1e-8, 1e-3);
    const MotionBounds bounds = f.bounds(y, time);
    double tails = 0, rounding = 0;  // of the derivatives, where all but the rest cancels
    for (int k = 0; k < modes; ++k)
      rounding +=
          16 * eps * f.fourth_derivative[k] * f.omega[k] * (std::abs(y.u[k]) + std::abs(f.rest[k]));
    for (int i = 0; i <= 40; ++i) {
      const long double at = static_cast<long double>(time) * i / 40;
      double travel = 0, size = 0, fourth_derivative = 0, tail = 0;
      for (int k = 0; k < modes; ++k) {
        const long double w = f.omega[k], z = f.mode[k].zeta, a = f.load[k] / f.mode[k].mass;
        // U and its derivatives, U^(n+2) = -2 zeta omega U^(n+1) - omega^2 U^(n) + [n = 0] load/m
        long double d[5];
        const State now = fly(f.mode[k], f.load[k], {y.u[k], y.v[k], 0}, at);
        d[0] = now.u, d[1] = now.v;
        for (int n = 0; n < 3; ++n)
          d[n + 2] = -2 * z * w * d[n + 1] - w * w * d[n] + (n == 0 ? a : 0);
        long double sum = 0;
        const long double angle = b[k] * at + phase[k];
        const long double psi[] = {std::sin(angle), std::cos(angle), -std::sin(angle),
                                   -std::cos(angle), std::sin(angle)};
        const int choose[] = {1, 4, 6, 4, 1};
        for (int n = 0; n <= 4; ++n)
          sum += choose[n] * d[4 - n] * std::pow(static_cast<long double>(b[k]), n) * psi[n];
        fourth_derivative += static_cast<double>(f.largest_shape[k] * sum);
        travel += f.largest_shape[k] * static_cast<double>(std::abs(now.u - y.u[k]));
        size += f.largest_shape[k] * static_cast<double>(std::abs(now.u));
        tail += f.tail[k] * static_cast<double>(std::abs(now.u));
      }
      const double more = 1 + 64 * eps;  // roundings of the bounds themselves
      ASSERT_LE(travel, bounds.travel * more + 4 * eps * bounds.size) << "trial " << trial;
      ASSERT_LE(size, bounds.size * more) << "trial " << trial;
      ASSERT_LE(tail, bounds.cubic_remainder * more) << "trial " << trial;
      ASSERT_LE(std::abs(fourth_derivative), bounds.fourth_derivative * more + rounding)
          << "trial " << trial << " speed " << speed;
      nearest = std::max(nearest, travel / bounds.travel);
      if (bounds.fourth_derivative > rounding)
        nearest_fourth =
            std::max(nearest_fourth, std::abs(fourth_derivative) / bounds.fourth_derivative);
      tails += tail;
    }
    EXPECT_GT(tails, 0);
  }
  // they are not bounds that say nothing
  EXPECT_GT(nearest, 0.9);
  EXPECT_GT(nearest_fourth, 0.3);
}

// ---- the constants of the proof, each where it is reached (proofs.md)

/// At rest, but for what a test moves.
Flying::Lanes at_rest(const Flying& f) {
  Flying::Lanes y;
  for (int k = 0; k < modes; ++k) y.u[k] = f.rest[k];
  return y;
}

TEST(FlightProof, TravelIsReachedByAModeThatPassesItsRest) {
  Dice dice(6);
  Flying f(dice, true);
  std::fill(f.fall.begin(), f.fall.end(), 0.0);
  for (int k = 0; k < modes; ++k) {
    Flying::Lanes y = at_rest(f);
    y.v[k] = -3;
    const double time = 1e-6 / f.quickest;
    const MotionBounds bounds = f.bounds(y, time);
    const auto there = [&](int mode) {
      return fly(f.mode[mode], f.omega[mode] > 0 ? f.load[mode] : 0.0, {y.u[mode], y.v[mode], 0},
                 time);
    };
    const double travelled = std::abs(static_cast<double>(there(k).u - y.u[k]));
    double size = 0, tail = 0;
    for (int mode = 0; mode < modes; ++mode) {
      const double out =
          std::abs(y.u[mode]) + (mode == k ? travelled : 0);  // it may as well go outwards
      size += f.largest_shape[mode] * out, tail += f.tail[mode] * out;
    }
    for (const auto& [bound, reached] : {std::pair{bounds.travel, f.largest_shape[k] * travelled},
                                         {bounds.size, size},
                                         {bounds.cubic_remainder, tail}}) {
      EXPECT_GE(bound, reached * (1 - 64 * eps)) << "mode " << k;
      EXPECT_LE(bound, reached * (1 + 1e-5)) << "mode " << k;
    }
  }
}

TEST(FlightProof, SizeIsReachedByAModeThatFallsFromRest) {
  // a t^2/2, and V t with it; nothing but this moves
  Dice dice(7);
  Flying f(dice, true);
  std::fill(f.rest.begin(), f.rest.end(), 0.0);
  const Flying::Lanes y = [&] {
    Flying::Lanes at = at_rest(f);
    for (int k = 0; k < modes; ++k)
      if (f.omega[k] == 0) at.v[k] = 0.25 * f.fall[k];
    return at;
  }();
  for (const double time : {0.01, 0.5, 20.0}) {
    double travel = 0, tail = 0;
    for (int k = 0; k < modes; ++k) {
      const double travelled = std::abs(f.fall[k]) * time * (0.25 + 0.5 * time);
      travel += f.largest_shape[k] * travelled, tail += f.tail[k] * travelled;
    }
    const MotionBounds bounds = f.bounds(y, time);
    EXPECT_NEAR(bounds.travel, travel, 64 * eps * travel);
    EXPECT_NEAR(bounds.size, travel, 64 * eps * travel);
    EXPECT_NEAR(bounds.cubic_remainder, tail, 64 * eps * tail);
  }
}

TEST(FlightProof, TheFourthDerivativeIsReachedByAModeThatTurnsRound) {
  // Without damping and at a node that does not move it is omega^4 (U - U_s), where U stands still.
  Dice dice(8);
  Flying f(dice, true);
  int reached = 0;
  for (int k = 0; k < modes; ++k) {
    if (f.omega[k] == 0 || f.mode[k].zeta > 0) continue;
    f.fourth_derivative[k] = f.largest_shape[k] * std::pow(f.omega[k], 3);
    Flying::Lanes y = at_rest(f);
    y.u[k] += 1e-3;
    const double fourth_derivative =
        f.largest_shape[k] * std::pow(f.omega[k], 4) * (y.u[k] - f.rest[k]);
    for (int other = 0; other < modes; ++other)
      if (f.omega[other] == 0) y.v[other] = 5;  // rigid ones have none
    f.t.flight.fourth_derivative_at_rest = 0;
    EXPECT_NEAR(f.bounds(y, 1e-9).fourth_derivative, fourth_derivative,
                64 * eps * fourth_derivative)
        << "mode " << k;
    f.t.flight.fourth_derivative_at_rest = fourth_derivative;
    EXPECT_NEAR(f.bounds(y, 1e-9).fourth_derivative, 2 * fourth_derivative,
                64 * eps * fourth_derivative)
        << "mode " << k;
    ++reached;
  }
  EXPECT_GT(reached, 0);
}

}  // namespace
