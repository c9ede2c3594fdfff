// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "host/base/decompositions.hpp"
#include "host/device/batch.hpp"
#include "host/result/record.hpp"
#include "host/run/samples.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"
#include "tests/step_matrices.hpp"

/// One node that hits a beam. The motion is linear while the gap is open and, about another
/// equilibrium, while it is closed: pieces in closed form, joined where the gap changes sign.
///
/// There are two references: the exact motion, which backward Euler approaches to first order in
/// the step tau, and that of the scheme's modified equation (Hairer, Lubich, Wanner, Geometric
/// Numerical Integration, chapter IX): with y' = f = (A + B) y + const, A the free modes taken
/// implicitly and B the contact spring taken explicitly,
///   y1 = y0 + tau (A y1 + B y0 + const)   follows   y' = (1 + tau (A - B)/2) f + O(tau^2),
/// again linear in pieces. The error against it is of second order, so it gives the beginning and
/// the end of a shock to a small part of a step.
namespace {

using namespace ra2d;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

using test::pi;

// ---- the scene --------------------------------------------------------------------------------

constexpr double open_gap = 2e-6;  // m
constexpr int peak_node = 10;

/// A pinned strip and, above it, a rigid body that stands still with one node lower than all
/// others.
Scene one_node(int modes, double start, Nodes nodes = Nodes::candidates) {
  Scene s = test::strip_scene(modes, 0.01, start, 0.02);
  s.time.nodes = nodes;
  s.slider.width = 0.02;
  s.slider.surface = test::peaks({{peak_node * s.spacing, 40e-6, 0.5 * s.spacing}});
  s.gap = 40e-6 + open_gap;
  return s;
}

/// The scene as the references see it: everything about the one node.
struct Impactor {
  Vector omega, phi;
  double zeta, mass, gap, spring;
  Vector start;  // (U, V)

  Eigen::Index modes() const { return omega.size(); }
  double overlap(const Vector& y) const { return phi.dot(y.head(modes())) - gap; }
  double closing(const Vector& y) const { return phi.dot(y.tail(modes())); }
  double force(const Vector& y) const { return std::max(0.0, spring * overlap(y)); }
  double norm(const Vector& y) const {
    return std::hypot(y.tail(modes()).norm(), omega.cwiseProduct(y.head(modes())).norm());
  }
};

// ---- motion in pieces -------------------------------------------------------------------------

/// Maps the state at the start of a piece to the state some time later.
using Flow = std::function<Vector(const Vector& y, double time, bool contact)>;

struct Impact {
  double start, end, peak, impulse;
};
struct Path {
  Vector end;
  std::vector<Impact> impacts;
};

/// Follows the pieces. The sign of the gap is looked at every `glance`, far shorter than a shock;
/// the moment is then bisected to the last digit.
Path follow(const Impactor& body, const Flow& flow, double duration, double glance) {
  Path path;
  Vector y = body.start;
  double now = 0;
  bool contact = false;
  EXPECT_LT(body.overlap(y), 0);
  const auto bisect = [](double low, double high, auto&& before) {
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (before(middle) ? low : high) = middle;
    }
    return low;
  };
  while (now < duration) {
    const auto at = [&](double t) { return flow(y, t, contact); };
    const auto crossed = [&](double t) {
      return contact ? body.overlap(at(t)) < 0 : body.overlap(at(t)) > 0;
    };
    double t = glance;  // never at once: a piece begins at overlap 0, give or take a rounding
    while (now + t < duration && !crossed(t)) t += glance;
    if (now + t >= duration) {
      EXPECT_FALSE(contact) << "the run should end in free flight";
      path.end = at(duration - now);
      break;
    }
    const double length = bisect(t - glance, t, [&](double x) { return !crossed(x); });
    if (contact) {
      Impact& impact = path.impacts.back();
      impact.end = now + length;
      // Simpson over the shock: its error is 1e-10 of the impulse
      constexpr int panels = 200;
      for (int i = 0; i <= panels; ++i) {
        const double weight = i == 0 || i == panels ? 1 : i % 2 == 1 ? 4 : 2;
        const double force = body.force(at(length * i / panels));
        impact.impulse += weight * force * length / (3 * panels);
        impact.peak = std::max(impact.peak, force);
      }
      // the largest force: where the node's rate changes sign, around the largest of those
      double best = 0;
      for (int i = 0; i < panels; ++i) {
        const double left = length * i / panels, right = length * (i + 1) / panels;
        if (!(body.closing(at(left)) > 0 && body.closing(at(right)) <= 0)) continue;
        const double top = bisect(left, right, [&](double x) { return body.closing(at(x)) > 0; });
        best = std::max(best, body.force(at(top)));
      }
      impact.peak = std::max(impact.peak, best);
    } else {
      path.impacts.push_back({now + length, 0, 0, 0});
    }
    y = at(length);
    now += length;
    contact = !contact;
  }
  return path;
}

/// Free modes A, contact spring B, and the equilibrium under contact.
struct Linear {
  Matrix free, spring;
  Vector rest;

  explicit Linear(const Impactor& body) {
    const Eigen::Index n = body.modes();
    free = spring = Matrix::Zero(2 * n, 2 * n);
    free.topRightCorner(n, n).setIdentity();
    free.bottomLeftCorner(n, n).diagonal() = -body.omega.cwiseAbs2();
    free.bottomRightCorner(n, n).diagonal() = -2 * body.zeta * body.omega;
    spring.bottomLeftCorner(n, n) = -body.spring / body.mass * body.phi * body.phi.transpose();
    Vector constant_force = Vector::Zero(2 * n);  // of the closed gap: spring gap phi/mass
    constant_force.tail(n) = body.spring / body.mass * body.gap * body.phi;
    rest = -LeastSquares(free + spring).solve(constant_force);
  }
};

/// exp(M t) by eigenvalues.
class Exponential {
 public:
  explicit Exponential(const Matrix& m) : system_{m} {}
  Vector operator()(const Vector& y, double time) const {
    const Eigen::VectorXcd turned = (system_.values * time).array().exp();
    return (system_.vectors * turned.cwiseProduct(system_.inverse * y)).real();
  }

 private:
  test::Eigensystem system_;
};

Flow flow_of(const Matrix& free, const Matrix& contact, const Vector& rest) {
  return [open = Exponential(free), closed = Exponential(contact), rest](
             const Vector& y, double time, bool touches) -> Vector {
    return touches ? Vector(rest + closed(y - rest, time)) : open(y, time);
  };
}
Flow exact_flow(const Impactor& body) {
  const Linear l(body);
  return flow_of(l.free, l.free + l.spring, l.rest);
}
/// Pieces of the modified equation.
Flow modified_flow(const Impactor& body, double tau) {
  const Linear l(body);
  const Matrix one = Matrix::Identity(l.free.rows(), l.free.cols());
  return flow_of((one + tau / 2 * l.free) * l.free,
                 (one + tau / 2 * (l.free - l.spring)) * (l.free + l.spring), l.rest);
}

/// One mode by the formula of the damped oscillator:
///   U'' + 2 zeta omega U' + omega^2 U = 0, and in contact with omega^2 + k phi^2/m about
///   U = k phi gap/(m omega^2 + k phi^2).
Flow one_mode_flow(const Impactor& body) {
  const double omega = body.omega[0], phi = body.phi[0], decay = body.zeta * omega;
  const double stiff = body.spring * phi * phi / body.mass;
  const double rest = body.spring * phi * body.gap / (body.mass * (omega * omega + stiff));
  return [=](const Vector& y, double t, bool contact) -> Vector {
    const double square = omega * omega + (contact ? stiff : 0), middle = contact ? rest : 0;
    const double turn = std::sqrt(square - decay * decay);
    const double c = std::cos(turn * t), s = std::sin(turn * t) / turn, e = std::exp(-decay * t);
    const double u = y[0] - middle, v = y[1];
    return Vector{
        {middle + e * (u * c + (v + decay * u) * s), e * (v * c - (decay * v + square * u) * s)}};
  };
}

// ---- cases and runs ---------------------------------------------------------------------------

struct Case {
  std::string name;
  int modes;
  double start;      // m, of the slider: its node stands 10 mm further
  double stiffness;  // of the spring, over that of the lowest mode at the node
  double amplitude;  // first amplitude, over the gap
  double periods;    // of the lowest mode
};

struct Prepared {
  Scene scene;
  Impactor body;
  ModalStart start;
  double duration;
};

Prepared prepare(const Case& c, int steps, Nodes nodes = Nodes::candidates) {
  Prepared out;
  out.scene = one_node(c.modes, c.start, nodes);
  const Body beam = make_body(out.scene.resonator);
  Impactor& body = out.body;
  body.zeta = beam.modes[0].zeta;
  body.mass = beam.modes[0].mass;
  body.gap = open_gap;
  body.omega.resize(c.modes);
  body.phi.resize(c.modes);
  const double place = c.start + peak_node * out.scene.spacing;
  for (int k = 0; k < c.modes; ++k) {
    body.omega[k] = beam.modes[k].omega;
    beam.modes[k].shape->evaluate(place, 1, &body.phi[k]);
  }
  body.spring = c.stiffness * beam.modes[0].mass * std::pow(body.omega[0] / body.phi[0], 2);
  out.scene.contact.stiffness = body.spring / (out.scene.spacing * out.scene.slider.width);
  // upwards, most of it in the lowest mode
  body.start = Vector::Zero(2 * c.modes);
  for (int k = 0; k < c.modes; ++k)
    body.start[c.modes + k] =
        c.amplitude * open_gap * body.omega[0] / body.phi[0] * std::pow(-0.3, k);
  out.start.resonator_u.assign(c.modes, 0.0);
  out.start.resonator_v.assign(body.start.data() + c.modes, body.start.data() + 2 * c.modes);
  out.start.energy = 0.5 * body.mass * body.start.squaredNorm();

  out.duration = c.periods * 2 * pi / body.omega[0];
  out.scene.duration = out.duration;
  out.scene.time.step = out.duration / steps;
  out.scene.output.rate = 1 / out.duration;
  return out;
}

struct March {
  Vector end;
  std::vector<Shock> shocks;
};
March march(const Prepared& ready) {
  const Model model = make_model(ready.scene);
  EXPECT_NEAR(model.delta - model.slider_height[peak_node], open_gap, 1e-20);
  EXPECT_NEAR(model.node_stiffness, ready.body.spring, 1e-12 * ready.body.spring);
  Batch batch({model}, {ready.start});
  batch.march(model.steps);
  const Snapshot end = batch.snapshot(0);
  EXPECT_EQ(end.status, Status::done);
  EXPECT_EQ(end.most_nodes, 1);
  EXPECT_TRUE(end.open_shocks.empty());
  March out;
  out.end = Vector(2 * ready.body.modes());
  out.end << Eigen::Map<const Vector>(end.resonator_u.data(), ready.body.modes()),
      Eigen::Map<const Vector>(end.resonator_v.data(), ready.body.modes());
  out.shocks = make_shocks(model, batch.drain(0).shocks);
  return out;
}

class SingleContact : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Modes, SingleContact,
                         testing::Values(Case{"OneMode", 1, 0.14, 100, 3, 4.3},
                                         Case{"OneModeStiffSpring", 1, 0.09, 2000, 3, 3.4},
                                         Case{"ThreeModes", 3, 0.08, 20, 2.5, 3.3},
                                         Case{"ThreeModesStiffSpring", 3, 0.11, 60, 2.5, 3.3}),
                         [](const auto& info) { return info.param.name; });

/// The fastest of the modes while in contact [rad/s].
double fastest(const Impactor& body) {
  const Linear l(body);
  return std::sqrt(eigenvalues(l.free + l.spring).cwiseAbs2().maxCoeff());
}
Path exact_path(const Prepared& ready) {
  const Impactor& body = ready.body;
  const Flow flow = body.modes() == 1 ? one_mode_flow(body) : exact_flow(body);
  return follow(body, flow, ready.duration, 0.01 / fastest(body));
}
Path modified_path(const Prepared& ready) {
  const Impactor& body = ready.body;
  return follow(body, modified_flow(body, ready.scene.time.step), ready.duration,
                0.01 / fastest(body));
}

/// Root mean square over the impacts of an error.
template <class Error>
double spread(const std::vector<Shock>& found, const std::vector<Impact>& impacts, Error error) {
  double sum = 0;
  for (std::size_t i = 0; i < impacts.size(); ++i) sum += std::pow(error(found[i], impacts[i]), 2);
  return std::sqrt(sum / static_cast<double>(impacts.size()));
}

constexpr int coarsest = 80'000, levels = 5;  // steps, and how often they are doubled less one

TEST_P(SingleContact, ReferencesAgreeAndBounceSeveralTimes) {
  const Prepared ready = prepare(GetParam(), coarsest);
  const Path path = exact_path(ready);
  ASSERT_GE(path.impacts.size(), 4);
  // By eigenvalues the same, to the roundings of a decomposition that every piece multiplies.
  const Path other =
      follow(ready.body, exact_flow(ready.body), ready.duration, 0.005 / fastest(ready.body));
  ASSERT_EQ(other.impacts.size(), path.impacts.size());
  EXPECT_LE(ready.body.norm(path.end - other.end), 1e-9 * ready.body.norm(path.end));
  // The modified equation becomes the exact one: linearly in tau, so 1e-9 of a step gives 1e-9 of
  // the shift.
  Prepared fine = ready;
  fine.scene.time.step *= 1e-9;
  EXPECT_LE(ready.body.norm(path.end - modified_path(fine).end), 1e-8 * ready.body.norm(path.end));
}

TEST_P(SingleContact, StateConvergesAtFirstOrder) {
  double coarse = 0;
  for (int level = 0, steps = coarsest; level < levels; ++level, steps *= 2) {
    const Prepared ready = prepare(GetParam(), steps);
    const Vector end = march(ready).end;
    const double error = ready.body.norm(end - exact_path(ready).end);
    if (level > 0) {
      EXPECT_NEAR(std::log2(coarse / error), 1.0, 0.1) << steps << " steps";
    }
    coarse = error;
    // What the modified equation leaves over is of second order: another omega tau smaller.
    EXPECT_LE(ready.body.norm(end - modified_path(ready).end),
              fastest(ready.body) * ready.scene.time.step * error)
        << steps << " steps";
  }
}

TEST_P(SingleContact, ForcesOfTheShocksConvergeAtFirstOrder) {
  double coarse_peak = 0, coarse_impulse = 0;
  for (int level = 0, steps = coarsest; level < levels; ++level, steps *= 2) {
    const Prepared ready = prepare(GetParam(), steps);
    const std::vector<Impact> impacts = exact_path(ready).impacts;
    const std::vector<Shock> shocks = march(ready).shocks;
    ASSERT_EQ(shocks.size(), impacts.size());
    const double peak = spread(shocks, impacts, [](const Shock& found, const Impact& exact) {
      return found.peak_force / exact.peak - 1;
    });
    const double impulse = spread(shocks, impacts, [](const Shock& found, const Impact& exact) {
      return found.impulse / exact.impulse - 1;
    });
    if (level > 0) {
      EXPECT_NEAR(std::log2(coarse_peak / peak), 1.0, 0.1) << steps << " steps";
      EXPECT_NEAR(std::log2(coarse_impulse / impulse), 1.0, 0.1) << steps << " steps";
    }
    coarse_peak = peak;
    coarse_impulse = impulse;
  }
}

TEST_P(SingleContact, TimesOfTheShocksConvergeAtFirstOrder) {
  // A shock starts at the first step in contact, up to one step late; the modified equation knows
  // the rest but for parts of second order, less than another step here.
  double coarse = 0;
  for (int level = 0, steps = coarsest; level < levels; ++level, steps *= 2) {
    const Prepared ready = prepare(GetParam(), steps);
    const double tau = ready.scene.time.step;
    const std::vector<Impact> exact = exact_path(ready).impacts;
    const std::vector<Impact> modified = modified_path(ready).impacts;
    const std::vector<Shock> shocks = march(ready).shocks;
    ASSERT_EQ(shocks.size(), exact.size());
    ASSERT_EQ(shocks.size(), modified.size());
    for (std::size_t i = 0; i < shocks.size(); ++i) {
      const Shock& shock = shocks[i];
      EXPECT_EQ(shock.serial, static_cast<long>(i));
      const double late = (shock.start - modified[i].start) / tau;
      EXPECT_GE(late, -1) << "shock " << i;
      EXPECT_LE(late, 2) << "shock " << i;
      const double longer = (shock.duration - (modified[i].end - modified[i].start)) / tau;
      EXPECT_NEAR(longer, 0, 2) << "shock " << i;
      const double place = GetParam().start + peak_node * ready.scene.spacing;
      EXPECT_NEAR(shock.position, place, 1e-12 * place);
    }
    const double error = spread(shocks, exact, [](const Shock& found, const Impact& impact) {
      return found.start - impact.start;
    });
    const double duration = spread(shocks, exact, [](const Shock& found, const Impact& impact) {
      return found.duration - (impact.end - impact.start);
    });
    const double shift = spread(shocks, exact, [&](const Shock& found, const Impact& impact) {
      const Impact& other = modified[static_cast<std::size_t>(found.serial)];
      return (other.end - other.start) - (impact.end - impact.start);
    });
    EXPECT_LE(duration, shift + 2 * tau);
    if (level > 0) {
      EXPECT_NEAR(std::log2(coarse / error), 1.0, 0.1) << steps << " steps";
    }
    coarse = error;
  }
}

TEST_P(SingleContact, EveryNodeOrOnlyCandidatesGiveTheSameBits) {
  const March all = march(prepare(GetParam(), coarsest, Nodes::all));
  const March some = march(prepare(GetParam(), coarsest, Nodes::candidates));
  EXPECT_EQ(all.end, some.end);
  ASSERT_EQ(all.shocks.size(), some.shocks.size());
  for (std::size_t i = 0; i < all.shocks.size(); ++i) {
    EXPECT_EQ(all.shocks[i].start, some.shocks[i].start);
    EXPECT_EQ(all.shocks[i].duration, some.shocks[i].duration);
    EXPECT_EQ(all.shocks[i].peak_force, some.shocks[i].peak_force);
    EXPECT_EQ(all.shocks[i].impulse, some.shocks[i].impulse);
  }
}

}  // namespace
