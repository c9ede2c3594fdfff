// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "host/scene_file/scene_file.hpp"
#include "kernels/march.hpp"
#include "tests/filled.hpp"
#include "tests/free_motion.hpp"
#include "tests/kernels_of.hpp"
#include "tests/places.hpp"

/// How near to the bounds of the proofs the motions of real scenes come: the scenes that come with
/// the program are marched, and each step is done once more beside it, where what is bounded is
/// measured at places in between. Nothing may exceed its bound. RA2D_TEST_TABLE=1 takes longer
/// stretches and prints how near each bound was reached.
namespace ra2d::test {
namespace {

using March = AdaptiveMarch<HostLanes, packs>;
using RealPacks = std::array<HostLanes::Real, packs>;
constexpr int row = packs * width;
constexpr int between = 12;  // places within a step

bool prints() { return std::getenv("RA2D_TEST_TABLE") != nullptr; }

/// A bound of all modes that is only so much of itself: for what its width costs.
void lower(const double* values, int count, double by) {
  for (int k = 0; k < count; ++k) const_cast<double*>(values)[k] *= by;
}

/// Shares of a bound that were met, one of each step.
using Shares = std::map<std::string, std::vector<double>>;

/// A scene on the lanes of the host, and its state at the beginning of a step.
struct Marched : Filled {
  SceneState s;
  std::vector<std::vector<std::max_align_t>> room;

  explicit Marched(const Scene& scene) : Filled(scene) {
    const auto allocate = [&](auto& part) {
      visit_arrays(part, n, [&](const char*, auto*& array, std::size_t count) {
        using Value = std::remove_reference_t<decltype(*array)>;
        room.emplace_back(count * sizeof(Value) / sizeof(std::max_align_t) + 1);
        std::fill_n(reinterpret_cast<char*>(room.back().data()),
                    room.back().size() * sizeof(std::max_align_t), '\0');
        array = reinterpret_cast<Value*>(room.back().data());
      });
    };
    allocate(s.carried), allocate(s.marks), allocate(s.caches);
    allocate(s.work), allocate(s.out);
    fill(s, model, make_start(model), n, HostCopy());
  }
  void forget_what_was_recorded() { s.out.samples.count = s.out.ended_shocks.count = 0; }

  RealPacks load(const double* lanes_of) const {
    RealPacks r;
    for (int p = 0; p < packs; ++p) r[p] = lanes.load(lanes_of + p * width);
    return r;
  }
  double at(const RealPacks& r, int k) const {
    std::array<double, row> one;
    for (int p = 0; p < packs; ++p) lanes.store(one.data() + p * width, r[p]);
    return one[k];
  }
};

/// A motion over a step: the overlap of a node, its rate, and its fourth derivative.
struct Derivatives {
  double value, rate, fourth_derivative;
};

/// Compares a motion over a step with the bounds on it. `overlap(node, share)` gives a node's
/// derivatives after a share of the step; `moved(share)` and so on the sums over the modes.
template <class Overlap, class Moved>
void measure(const Marched& m, const std::string& kind, const MotionBounds& bounds, double rise,
             double time, int stride_of_nodes, const Overlap& overlap, const Moved& moved,
             Shares& shares) {
  double travel = 0, fourth_derivative = 0, cubic = 0, risen = 0;
  for (int i = 1; i <= between; ++i)
    travel = std::max(travel, moved(static_cast<double>(i) / between));
  for (int node = 0; node < m.t.faces.nodes; node += stride_of_nodes) {
    const Derivatives first = overlap(node, 0.0), last = overlap(node, 1.0);
    for (int i = 0; i <= between; ++i) {
      const double x = static_cast<double>(i) / between;
      const Derivatives now = overlap(node, x);
      const double b0 = first.value, b3 = last.value, b1 = b0 + first.rate * time / 3,
                   b2 = b3 - last.rate * time / 3, y = 1 - x;
      const double through =
          y * y * y * b0 + 3 * y * y * x * b1 + 3 * y * x * x * b2 + x * x * x * b3;
      fourth_derivative = std::max(fourth_derivative, std::abs(now.fourth_derivative));
      cubic = std::max(cubic, std::abs(now.value - through));
      risen = std::max(risen, now.value - first.value);
    }
  }
  const double allowed =
      m.t.adaptive.cubic_excess * bounds.fourth_derivative * std::pow(time, 4) / 384;
  // of the sums here
  const double rounding = 64 * eps * (bounds.size + m.t.faces.rounding / eps);
  const auto add = [&](const char* what, double part, double whole) {
    if (!(whole > 1e3 * rounding)) return;
    shares[kind + what].push_back(part / whole);
    ASSERT_LE(part, whole + rounding) << kind << what;
  };
  add("travel", travel, bounds.travel);
  add("rise", risen, rise);
  add("cubic error", cubic, allowed);
  if (allowed > 1e3 * rounding)
    add("fourth derivative", fourth_derivative * std::pow(time, 4) / 384,
        bounds.fourth_derivative * std::pow(time, 4) / 384);
}

/// psi_k at a node and its four derivatives in time as the node passes, and U_k with its own.
struct ModesAt {
  std::array<std::array<double, 5>, row> shape{};

  ModesAt(const Marched& m, double position, int node) {
    for (int k = 0; k < m.modes(); ++k) {
      const BodyMode& mode = m.mode(k);
      mode.shape->evaluate((position + node) * m.t.motion.spacing, 4, shape[k].data());
      const double rigid = mode.shape->wave_number() == 0 ? shape[k][0] : 0;
      shape[k][4] = std::pow(mode.shape->wave_number(), 4) * (shape[k][0] - rigid);
      const double speed = m.t.motion.advance / m.t.motion.time_step * m.t.motion.spacing;
      for (int j = 1; j <= 4; ++j) shape[k][j] *= std::pow(speed, j);
    }
    const std::int64_t stride = std::int64_t{m.t.faces.groups} * width;
    for (int k = 0; k < m.t.slider.modes; ++k)
      shape[m.modes() + k][0] = m.t.slider.shape[k * stride + node];
  }
};

/// The modes in free flight, `ticks` on.
struct FreeModes {
  std::array<std::array<double, 5>, row> u{};

  FreeModes(const Marched& m, const RealPacks& u0, const RealPacks& v0, std::int64_t ticks) {
    RealPacks now = u0, rate = v0, square;
    square.fill(0.0);
    flight_of<packs>(m.t)(now.data(), rate.data(), square.data(), ticks);
    const int all = m.modes() + m.t.slider.modes;
    for (int k = 0; k < all; ++k) {
      const double w = m.t.modes.omega[k];
      u[k][0] = m.at(now, k), u[k][1] = m.at(rate, k);
      u[k][2] = m.t.flight.free_acceleration[k] - m.t.adaptive.decay[k] * u[k][1] -
                w * w * (u[k][0] - m.t.flight.rest[k]);
      for (int j = 3; j <= 4; ++j)
        u[k][j] = -m.t.adaptive.decay[k] * u[k][j - 1] - w * w * u[k][j - 2];
    }
  }
};

/// A flight and what its bounds say of it.
void measure_flight(const Marched& m, std::int64_t step, std::int64_t ticks, const RealPacks& u0,
                    const RealPacks& v0, SceneState& work, Shares& shares) {
  const SliderPath path(m.t.motion);
  const Place place = path.at(step);
  if (static_cast<double>(ticks) * m.t.motion.advance > 1 - place.theta)
    return;  // a node would pass another
  const auto overlaps = overlaps_of<packs>(m.t, work);
  const double time = static_cast<double>(ticks) * m.t.motion.time_step;
  const MotionBounds bounds = flight_of<packs>(m.t).bounds(u0.data(), v0.data(), time);
  std::vector<FreeModes> modes;
  std::vector<double> share;
  for (int i = 0; i <= between; ++i)
    modes.emplace_back(m, u0, v0, ticks / between * i + ticks % between * i / between);
  const int all = m.modes() + m.t.slider.modes;
  const auto of = [&](double x) -> const FreeModes& {
    return modes[static_cast<int>(std::lround(x * between))];
  };
  const auto overlap = [&](int node, double x) {
    const std::int64_t on = static_cast<std::int64_t>(std::lround(x * between));
    const std::int64_t at = ticks / between * on + ticks % between * on / between;
    const Place there = path.moved(place, step + at);
    const ModesAt shape(m, there.base + there.theta, node);
    const FreeModes& now = of(x);
    const double rise =
        m.t.faces.height2[place.base + node + 1] - m.t.faces.height2[place.base + node];
    Derivatives d{
        m.t.faces.height1[node] + m.t.faces.height2[place.base + node] + there.theta * rise,
        m.t.motion.advance / m.t.motion.time_step * rise, 0};
    constexpr int binomial[] = {1, 4, 6, 4, 1};
    for (int k = 0; k < all; ++k) {
      d.value += shape.shape[k][0] * now.u[k][0];
      d.rate += shape.shape[k][0] * now.u[k][1] + shape.shape[k][1] * now.u[k][0];
      for (int j = 0; j <= 4; ++j)
        d.fourth_derivative += binomial[j] * shape.shape[k][j] * now.u[k][4 - j];
    }
    return d;
  };
  const auto moved = [&](double x) {
    double sum = 0;
    for (int k = 0; k < all; ++k)
      sum += m.t.bounds.largest_shape[k] * std::abs(of(x).u[k][0] - m.at(u0, k));
    return sum;
  };
  if (ticks < 1000 * between) return;  // its parts would not be where they are looked for
  measure(m, "flight: ", bounds, overlaps.longest_rise(u0.data(), bounds, ticks).any, time,
          std::max(1, m.t.faces.nodes / 24), overlap, moved, shares);
  // what the cubics over patches leave out, of the groups as they stand
  GroupSweep<HostLanes, packs> sweep(lanes, m.t.faces, m.t.slider, m.t.patches, place,
                                     work.work.amplitudes, u0.data());
  double left_out = 0;
  for (int group = 0; group < m.t.faces.groups; group += std::max(1, m.t.faces.groups / 24)) {
    std::array<double, width> seen;
    lanes.store(seen.data(), sweep.overlap(group).overlap);
    for (int lane = 0; lane < width && group * width + lane < m.t.faces.nodes; ++lane)
      left_out = std::max(left_out, std::abs(seen[lane] - overlap(group * width + lane, 0).value));
  }
  if (bounds.cubic_remainder > 1e3 * 64 * eps * bounds.size + 1e3 * m.t.faces.rounding) {
    shares["flight: cubic remainder"].push_back(left_out / bounds.cubic_remainder);
    ASSERT_LE(left_out, bounds.cubic_remainder + 64 * eps * bounds.size + m.t.faces.rounding);
  }
}

/// A step with contact. The nodes in contact at its beginning are in the state.
void measure_drive(const Marched& m, std::int64_t step, std::int64_t ticks, double scale,
                   const RealPacks& u0, const RealPacks& v0, SceneState& work, Shares& shares) {
  const Place place = SliderPath(m.t.motion).at(step);
  const auto contact = node_contact_of<packs>(m.t, work);
  auto series = series_of<packs>(m.t, work);
  const auto contacts = contacts_of<packs>(work);
  const auto overlaps = overlaps_of<packs>(m.t, work);
  series.expand(u0.data(), v0.data(), place, scale);
  const double end = series.x_at(ticks), time = static_cast<double>(ticks) * m.t.motion.time_step;
  if (!(end > 1e-3)) return;
  contacts.first_end(series, end, overlaps.overlap_rounding(u0.data()));
  const MotionBounds bounds = series.bounds(end);
  std::map<int, std::array<double, overlap_terms>> expanded;
  const auto polynomial_of = [&](int node) -> const double* {
    const auto [found, is_new] = expanded.try_emplace(node);
    if (is_new) {
      contact.expand(place, &node, 1);
      series.overlap_of(node, place, found->second.data());
    }
    return found->second.data();
  };
  const int degree = series.degree();
  const auto overlap = [&](int node, double share) {
    const double* c = polynomial_of(node);
    const double x = share * end;
    const ValueAndSlope p = polynomial_and_slope(c, degree, x);
    double fourth_derivative = 0;
    for (int j = degree; j >= 4; --j)
      fourth_derivative = fourth_derivative * x + j * (j - 1.0) * (j - 2) * (j - 3) * c[j];
    return Derivatives{p.value, p.slope / scale, fourth_derivative * std::pow(scale, -4)};
  };
  const int all = m.modes() + m.t.slider.modes;
  const auto moved = [&](double share) {
    RealPacks u, v;
    series.state(share * end, u.data(), v.data());
    double sum = 0;
    for (int k = 0; k < all; ++k)
      sum += m.t.bounds.largest_shape[k] * std::abs(m.at(u, k) - m.at(u0, k));
    return sum;
  };
  measure(m, "contact: ", bounds, overlaps.longest_rise(u0.data(), bounds, ticks).any, time,
          std::max(1, m.t.faces.nodes / 8), overlap, moved, shares);
  for (int e = 0; e < work.carried.contacts.count; ++e) {
    const double* c = series.overlap(e);
    double curvature = 0, rounding = 0, power = 1;
    for (int j = 0; j <= degree; ++j, power *= end) rounding += 64 * eps * std::abs(c[j]) * power;
    for (int i = 0; i <= between; ++i) {
      double second = 0;
      for (int j = degree; j >= 2; --j)
        second = second * (end * i / between) + j * (j - 1.0) * c[j];
      curvature = std::max(curvature, std::abs(second));
    }
    rounding *= degree * degree / (end * end);
    if (!(work.work.spans.hulls[e].curvature > 1e3 * rounding)) continue;
    shares["contact: curvature of a hull"].push_back(curvature /
                                                     work.work.spans.hulls[e].curvature);
    ASSERT_LE(curvature, work.work.spans.hulls[e].curvature + rounding);
  }
}

/// Marches a scene and measures every `every`-th of so many steps.
Shares use(const Scene& scene, int steps, int every) {
  Marched m(scene);
  Shares shares;
  for (int i = 0; i < steps && m.s.carried.status == Status::running &&
                  m.s.carried.step < m.t.output.total_steps;
       ++i) {
    const std::int64_t step = m.s.carried.step;
    const double scale = m.s.carried.control.series_scale;
    const RealPacks u0 = m.load(m.s.carried.modal.u), v0 = m.load(m.s.carried.modal.v);
    const std::vector<int> closed(m.s.carried.contacts.nodes,
                                  m.s.carried.contacts.nodes + m.s.carried.contacts.count);
    const int shape_terms = m.s.carried.control.shape_terms;
    March(lanes, m.t, m.s).run(step + 1);
    m.forget_what_was_recorded();
    const std::int64_t ticks = m.s.carried.step - step;
    if (i % every != 0 || ticks < 1) continue;
    // as it was before the step, in a state that shares the room for work alone
    SceneState work = m.s;
    std::vector<int> in_contact(closed);
    in_contact.resize(std::max<std::size_t>(1, m.n.contacts));
    work.carried.contacts.nodes = in_contact.data(),
    work.carried.contacts.count = static_cast<int>(closed.size());
    work.carried.control.shape_terms = shape_terms;
    if (closed.empty())
      measure_flight(m, step, ticks, u0, v0, work, shares);
    else
      measure_drive(m, step, ticks, scale, u0, v0, work, shares);
    if (testing::Test::HasFatalFailure()) break;
  }
  return shares;
}

Scene real_scene(const std::string& name) {
  return read_scene(scene_file(name), {"scene.faces=linear", "time.scheme=\"adaptive\"",
                                       "time.tolerance=1e-6", "output.rate=1000"});
}

class BoundsInUse : public testing::TestWithParam<const char*> {};

TEST_P(BoundsInUse, AreNeverExceeded) {
  const bool table = prints();
  const Shares shares = use(real_scene(GetParam()), table ? 40000 : 600, table ? 20 : 7);
  EXPECT_FALSE(shares.empty());
  for (auto [what, met] : shares) {
    ASSERT_FALSE(met.empty());
    std::sort(met.begin(), met.end());
    EXPECT_LE(met.back(), 1 + 1e-3) << what;
    if (table)
      std::cout << fmt::format("| {} | {} | {} | {:.2g} | {:.2g} |\n", GetParam(), what, met.size(),
                               met[met.size() / 2], met.back());
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, BoundsInUse,
                         testing::Values("dang2012", "dang2012-pinned", "peaks", "drop"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// ---- forecasts for steps of fixed length

/// Compares free flight over so many steps with the bounds of a forecast.
void measure_forecast(const Marched& m, int steps, Shares& shares) {
  const double tau = m.t.motion.time_step, time = steps * tau;
  const int all = m.modes() + m.t.slider.modes;
  double acceleration = 0, departed = 0, size = 0;
  std::vector<double> off(all);
  for (int k = 0; k < all; ++k) {
    const double u = m.s.carried.modal.u[k], v = m.s.carried.modal.v[k], w = m.t.modes.omega[k],
                 energy = std::hypot(v, w * u);
    acceleration +=
        m.t.bounds.largest_shape[k] * (m.t.bounds.acceleration_per_energy_norm[k] *
                                           (energy + time * m.t.bounds.outer_acceleration[k]) +
                                       m.t.bounds.outer_acceleration[k]);
    const double zeta = w > 0 ? m.t.modes.damping[k] / (2 * w * m.t.modes.mass[k] * tau) : 0;
    const State there = fly({w, zeta, m.t.modes.mass[k]}, m.t.modes.load[k], {u, v, 0}, time);
    off[k] = static_cast<double>(there.u - u - static_cast<long double>(time) * v);
    size += m.t.bounds.largest_shape[k] * std::abs(u);
  }
  for (int node = 0; node < m.t.faces.nodes; node += std::max(1, m.t.faces.nodes / 24)) {
    const ModesAt shape(
        m, m.t.motion.position + static_cast<double>(m.s.carried.step) * m.t.motion.advance, node);
    double displacement = 0;
    for (int k = 0; k < all; ++k) displacement += shape.shape[k][0] * off[k];
    departed = std::max(departed, std::abs(displacement));
  }
  const double bound = 0.5 * steps * (steps + 1.0) * tau * tau * acceleration;
  if (!(bound > 1e3 * eps * size)) return;
  shares[fmt::format("forecast of {} steps: departure from the line", steps)].push_back(departed /
                                                                                        bound);
  ASSERT_LE(departed, bound * (1 + 1e-9) + 64 * eps * size);
}

template <class Change>
std::int64_t march_fixed(const Scene& scene, std::int64_t steps, int forecasts, Shares* shares,
                         const Change& change) {
  Marched m(scene);
  change(m);
  for (int i = 1; i <= forecasts; ++i) {
    const std::int64_t target = steps * i / forecasts;
    while (m.s.carried.status == Status::running && m.s.carried.step < target) {
      FixedMarch<HostLanes, Form::semi_implicit, packs>(lanes, m.t, m.s).run(target);
      m.forget_what_was_recorded();
    }
    if (shares == nullptr) continue;
    for (const int ahead : {shortest_flight, most_listed_steps, longest_flight})
      measure_forecast(m, ahead, *shares);
  }
  return m.s.carried.sums.evaluated;
}

TEST(BoundsInUse, OfForecastsAreNeverExceeded) {
  const bool table = prints();
  for (const char* name : {"dang2012", "dang2012-pinned", "peaks"}) {
    const Scene scene = read_scene(scene_file(name), {"output.rate=1000"});
    Shares shares;
    const std::int64_t steps = table ? 1000000 : 20000;
    const double now =
        static_cast<double>(march_fixed(scene, steps, 200, &shares, [](Marched&) {}));
    for (auto& [what, met] : shares) {
      std::sort(met.begin(), met.end());
      EXPECT_LE(met.back(), 1) << what;
      if (table)
        std::cout << fmt::format("| {} | {} | {} | {:.2g} | {:.2g} |\n", name, what, met.size(),
                                 met[met.size() / 2], met.back());
    }
    const auto with = [&](const char* what, const auto& change) {
      const auto less = static_cast<double>(march_fixed(scene, steps, 200, nullptr, change));
      if (table) std::cout << fmt::format("| {} | {} | | {:.2f} |\n", name, what, less / now);
    };
    if (!table) continue;
    with("acceleration", [&](Marched& m) {
      lower(m.t.bounds.acceleration_per_energy_norm, row, 0.1),
          lower(m.t.bounds.outer_acceleration, row, 0.1);
    });
    with("cubic remainder", [&](Marched& m) {
      lower(m.t.bounds.cubic_remainder, row, 0.1),
          lower(m.t.bounds.cubic_slope_remainder, row, 0.1);
    });
    with("slope of the beam", [&](Marched& m) { lower(m.t.bounds.largest_slope, row, 0.1); });
  }
}

// ---- what the width of a bound costs

/// Steps and evaluated nodes over the same stretch, with a bound that is changed.
struct Cost {
  double steps, nodes;
};
template <class Change>
Cost cost_of(const Scene& scene, double duration, const Change& change) {
  Marched m(scene);
  change(m);
  const auto stop = static_cast<std::int64_t>(duration / m.t.motion.time_step);
  while (m.s.carried.status == Status::running && m.s.carried.step < stop) {
    March(lanes, m.t, m.s).run(stop);
    m.forget_what_was_recorded();
  }
  return {static_cast<double>(m.s.carried.adaptive_steps),
          static_cast<double>(m.s.carried.sums.evaluated)};
}

TEST(BoundsInUse, WhatTheirWidthCosts) {
  const bool table = prints();
  for (const char* name : {"dang2012", "dang2012-pinned", "peaks"}) {
    const Scene scene = real_scene(name);
    const double duration = table ? 0.02 : 1e-4;
    const Cost now = cost_of(scene, duration, [](Marched&) {});
    const auto with = [&](const char* what, const auto& change) {
      const Cost less = cost_of(scene, duration, change);
      EXPECT_GT(less.steps, 0);
      if (table)
        std::cout << fmt::format("| {} | {} | {:.2f} | {:.2f} |\n", name, what,
                                 less.steps / now.steps, less.nodes / now.nodes);
    };
    with("error of a cubic", [&](Marched& m) { m.t.adaptive.cubic_excess *= 0.1; });
    with("cubic remainder", [&](Marched& m) { lower(m.t.bounds.cubic_remainder, row, 0.1); });
    with("slope of the beam", [&](Marched& m) { lower(m.t.bounds.largest_slope, row, 0.1); });
    with("steepest rise", [&](Marched& m) { m.t.faces.steepest_rise *= 0.1; });
  }
}

}  // namespace
}  // namespace ra2d::test
