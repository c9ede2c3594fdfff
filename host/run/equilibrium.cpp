// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "host/errors.hpp"
#include "host/run/model.hpp"

/// Static equilibrium under load and contact: the minimum of the convex potential
///   sum_k m omega_k^2 U_k^2 / 2 - load_k U_k  +  sum_n kappa chi w max(0, -g_n)^2 / 2,
/// by Newton's method on its piecewise quadratic form. The contact springs are stiffened from soft
/// to the asked value, each stage starting from the one before: a slider first settles as a whole,
/// then onto its two or three highest asperities.
namespace ra2d {
namespace {

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

  int modes() const { return static_cast<int>(stiffness_.size()); }
  Eigen::VectorXd overlap(const Eigen::VectorXd& u) const { return faces_ + shapes_ * u; }

  double value(const Eigen::VectorXd& u, double spring) const {
    double sum = 0;
    for (int k = 0; k < modes(); ++k) sum += 0.5 * stiffness_[k] * u[k] * u[k] - load_[k] * u[k];
    return sum + 0.5 * spring * overlap(u).cwiseMax(0.0).squaredNorm();
  }

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

  /// Minimises from `u`; false when it does not settle.
  bool minimise(Eigen::VectorXd& u, double spring) const {
    Eigen::VectorXd force;
    Eigen::MatrixXd hessian;
    double scale = 0, shift = 1e-12, now = value(u, spring);
    for (int round = 0; round < 500; ++round) {
      expand(u, spring, force, hessian, scale);
      if (force.norm() <= 1e-13 * scale || scale == 0) return true;
      bool lower = false;
      for (int attempt = 0; attempt < 60 && !lower; ++attempt) {
        // the shift keeps directions that nothing holds (a slider on one asperity may still tilt)
        // finite
        Eigen::MatrixXd damped = hessian;
        damped.diagonal().array() += shift * (hessian.diagonal().maxCoeff() + 1e-300);
        const Eigen::VectorXd step = damped.ldlt().solve(force);
        const double next = value(u + step, spring);
        if (next < now || step.norm() <= 1e-15 * u.norm()) {
          u += step;
          lower = true;
          // below the roundings of the potential there is nothing left to gain
          if (now - next <= 1e-16 * std::abs(now) && force.norm() <= 1e-9 * scale) return true;
          now = next;
          shift = std::max(shift / 30, 1e-15);
        } else {
          shift *= 10;
        }
      }
      if (!lower) return force.norm() <= 1e-7 * scale;
    }
    return false;
  }

 private:
  std::vector<double> stiffness_, load_;
  Eigen::MatrixXd shapes_;  // (node, mode)
  Eigen::VectorXd faces_;   // overlap of the faces alone
};

}  // namespace

ModalStart make_start(const Model& model) {
  const int modes2 = static_cast<int>(model.resonator.modes.size());
  const int modes1 = static_cast<int>(model.slider.modes.size());
  Eigen::VectorXd u = Eigen::VectorXd::Zero(modes2 + modes1);
  if (model.scene.initial == Initial::statics && u.size() > 0) {
    const Potential potential(model);
    bool settled = true;
    for (double soft = 1e-10; soft < 0.5 && settled; soft *= 10)
      settled = potential.minimise(u, soft * model.node_stiffness);
    settled = settled && potential.minimise(u, model.node_stiffness);
    if (!settled)
      throw RequestError(
          fmt::format("{}: scene.initial = \"static\": no static equilibrium was found under this "
                      "load and contact. Start "
                      "from \"rest\", or lower contact.stiffness",
                      model.scene.file.string()));
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
  for (const double overlap : overlaps(model, start.resonator_u, start.slider_u)) {
    if (overlap < 0) continue;
    ++start.nodes_in_contact;
    start.contact_force += model.node_stiffness * overlap;
    start.energy += 0.5 * model.node_stiffness * overlap * overlap;
  }
  return start;
}

}  // namespace ra2d
