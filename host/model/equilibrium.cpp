// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "host/errors.hpp"
#include "host/model/contact_program.hpp"
#include "host/model/model.hpp"

/// Static equilibrium under load and contact: the minimum of the convex potential
///   sum_k m omega_k^2 U_k^2 / 2 - load_k U_k  +  sum_n kappa chi w max(0, -g_n)^2 / 2,
/// by Newton's method on its piecewise quadratic form. The contact springs are stiffened from soft
/// to the asked value, each stage starting from the one before: a slider first settles as a whole,
/// then onto its two or three highest asperities.
///
/// Springs that are too stiff for that (the roundings of an overlap are forces then), and multipliers,
/// whose springs do not yield at all, are solved as the quadratic programme that the minimum is.
namespace ra2d {
namespace {

/// How Newton's Hessian is kept regular: by the same stiffness for all modes, or by a share of each
/// one's own, where the stiff modes' would be more than what holds the rigid ones.
enum class Shift { common, own };

class Potential {
 public:
  explicit Potential(const Model& model) {
    const auto add = [&](const Beam& beam) {
      for (std::size_t k = 0; k < beam.modes.size(); ++k) {
        stiffness_.push_back(beam.mass_per_length * beam.modes[k].omega * beam.modes[k].omega);
        load_.push_back(beam.load[k]);
      }
    };
    add(model.resonator);
    add(model.slider);
    const int modes = static_cast<int>(stiffness_.size());
    const double chi = model.scene.spacing;
    shapes_.resize(model.nodes(), modes);
    for (int n = 0; n < model.nodes(); ++n) {
      int column = 0;
      for (const ModeShape& mode : model.resonator.modes)
        evaluate(mode, model.resonator.length, (model.position + n) * chi, 1,
                 &shapes_(n, column++));
      for (const ModeShape& mode : model.slider.modes)
        evaluate(mode, model.slider.length, n * chi, 1, &shapes_(n, column++));
    }
    const std::vector<double> faces = overlaps(model, {}, {});
    faces_ = Eigen::Map<const Eigen::VectorXd>(faces.data(), model.nodes());
  }

  /// The same minimum as a programme, the springs' compliance in m/N.
  ContactProgram program(double compliance) const {
    return {.stiffness = Eigen::Map<const Eigen::VectorXd>(stiffness_.data(), modes()),
            .load = Eigen::Map<const Eigen::VectorXd>(load_.data(), modes()),
            .shapes = shapes_,
            .faces = faces_,
            .compliance = compliance};
  }

  int modes() const { return static_cast<int>(stiffness_.size()); }
  Eigen::VectorXd overlap(const Eigen::VectorXd& u) const { return faces_ + shapes_ * u; }

  /// Negative gradient, Hessian and the size of the terms that the gradient is made of.
  void expand(const Eigen::VectorXd& u, double spring, Eigen::VectorXd& force,
              Eigen::MatrixXd& hessian, double& scale) const {
    force.resize(modes());
    hessian = Eigen::MatrixXd::Zero(modes(), modes());
    scale = 0;
    for (int k = 0; k < modes(); ++k) {
      force[k] = load_[k] - stiffness_[k] * u[k];
      hessian(k, k) = stiffness_[k];
      scale += std::abs(load_[k]) + std::abs(stiffness_[k] * u[k]);
    }
    const Eigen::VectorXd over = overlap(u);
    for (int n = 0; n < over.size(); ++n) {
      if (over[n] <= 0) continue;
      force.noalias() -= spring * over[n] * shapes_.row(n).transpose();
      hessian.noalias() += spring * shapes_.row(n).transpose() * shapes_.row(n);
      scale += spring * over[n] * shapes_.row(n).cwiseAbs().sum();
    }
  }

  /// The length along `step` at which the potential is least, from the sign of its slope: that,
  /// unlike its value, is known to the last digits. The slope never falls, since the potential is
  /// convex.
  double best_length(const Eigen::VectorXd& u, const Eigen::VectorXd& step, double spring) const {
    const Eigen::VectorXd over = overlap(u), change = shapes_ * step;
    const auto slope = [&](double length) {
      double sum = 0;
      for (int k = 0; k < modes(); ++k)
        sum += (stiffness_[k] * (u[k] + length * step[k]) - load_[k]) * step[k];
      return sum + spring * (over + length * change).cwiseMax(0.0).dot(change);
    };
    double low = 0.0, high = 1.0;
    while (slope(high) < 0 && high < 1e6) {
      low = high;
      high *= 2;
    }
    if (low == 0.0 && slope(1.0) <= 1e-12 * std::abs(slope(0.0))) return 1.0;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = 0.5 * (low + high);
      (slope(middle) < 0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  /// Minimises from `u`; false when it does not settle.
  bool minimise(Eigen::VectorXd& u, double spring, Shift shift) const {
    Eigen::VectorXd force, best_u = u;
    Eigen::MatrixXd hessian;
    double best =
        std::numeric_limits<double>::infinity();  // residual over the forces it is made of
    int stalled = 0;
    for (int round = 0; round < 1000 && stalled < 30; ++round) {
      double scale = 0;
      expand(u, spring, force, hessian, scale);
      const double residual = scale > 0 ? force.lpNorm<Eigen::Infinity>() / scale : 0.0;
      ++stalled;
      if (residual < best) {
        if (residual < 0.5 * best) stalled = 0;
        best = residual;
        best_u = u;
      }
      if (best <= 1e-16) break;
      // the shift keeps directions finite that nothing holds: a slider on one asperity may still
      // tilt; of a mode that nothing holds at all yet, it is that of all nodes together
      const double most = hessian.diagonal().maxCoeff();
      for (int k = 0; k < modes(); ++k) {
        const double own =
            hessian(k, k) > 0 ? hessian(k, k) : spring * shapes_.col(k).squaredNorm();
        hessian(k, k) += 1e-14 * (shift == Shift::common && most > 0 ? most : own) + 1e-300;
      }
      const Eigen::VectorXd step = hessian.ldlt().solve(force);
      u += best_length(u, step, spring) * step;
    }
    u = best_u;
    return best <= 1e-10;
  }

 private:
  std::vector<double> stiffness_, load_;
  Eigen::MatrixXd shapes_;  // (node, mode)
  Eigen::VectorXd faces_;   // overlap of the faces alone
};

/// Settles on springs that are stiffened to `spring`. Nothing when it does not.
std::optional<Eigen::VectorXd> settle(const Potential& potential, double spring, Shift shift) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(potential.modes());
  for (double soft = 1e-10; soft < 0.5; soft *= 10)
    if (!potential.minimise(u, soft * spring, shift)) return std::nullopt;
  if (!potential.minimise(u, spring, shift)) return std::nullopt;
  return u;
}

}  // namespace

ModalStart make_start(const Model& model) {
  const int modes2 = static_cast<int>(model.resonator.modes.size());
  const int modes1 = static_cast<int>(model.slider.modes.size());
  const bool multipliers = model.scene.contact.law == ContactLaw::multiplier;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(modes2 + modes1), forces;
  if (model.scene.initial == Initial::statics && u.size() > 0) {
    const Potential potential(model);
    std::optional<Eigen::VectorXd> settled;
    if (!multipliers)
      for (const Shift shift : {Shift::common, Shift::own})
        if (!settled) settled = settle(potential, model.node_stiffness, shift);
    if (settled) {
      u = *settled;
    } else {
      const auto rest = solve(potential.program(multipliers ? 0.0 : 1 / model.node_stiffness));
      if (!rest || !rest->feasible)
        throw refusal(
            model.scene, "scene.initial",
            fmt::format(
                "\"static\", and {} under this load and contact. {}",
                rest ? "no displacement of the kept modes keeps the faces apart: there is no "
                       "static equilibrium"
                     : "no static equilibrium was found",
                multipliers ? "Widen scene.gap, or keep more modes (max_frequency)"
                            : "Start from \"rest\", or lower contact.stiffness"));
      u = rest->u;
      forces = rest->forces;
    }
  }
  ModalStart start;
  start.resonator_u.assign(u.data(), u.data() + modes2);
  start.slider_u.assign(u.data() + modes2, u.data() + modes2 + modes1);
  start.resonator_v.assign(modes2, 0.0);
  start.slider_v.assign(modes1, 0.0);
  const auto elastic = [](const Beam& beam, const std::vector<double>& amplitude) {
    double sum = 0;
    for (std::size_t k = 0; k < amplitude.size(); ++k) {
      const double stretch = beam.modes[k].omega * amplitude[k];
      sum += 0.5 * beam.mass_per_length * stretch * stretch;
    }
    return sum;
  };
  start.energy =
      elastic(model.resonator, start.resonator_u) + elastic(model.slider, start.slider_u);
  if (multipliers) {
    for (int n = 0; n < forces.size(); ++n)
      if (forces[n] > 0) start.loaded_nodes.push_back(n);
    start.contact_force = forces.sum();
    return start;
  }
  const std::vector<double> overlap = overlaps(model, start.resonator_u, start.slider_u);
  for (int n = 0; n < model.nodes(); ++n) {
    if (overlap[n] < 0) continue;
    start.loaded_nodes.push_back(n);
    start.contact_force += model.node_stiffness * overlap[n];
    start.contact_energy += 0.5 * model.node_stiffness * overlap[n] * overlap[n];
  }
  start.energy += start.contact_energy;
  return start;
}

}  // namespace ra2d
