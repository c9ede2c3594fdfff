// SPDX-License-Identifier: BSD-3-Clause
#include "bench/baselines.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/schemes/backward_euler.hpp"

namespace ra2d::bench {

BaselineModes::BaselineModes(const Body& body, const std::vector<double>& u0,
                             const std::vector<double>& v0, double tau)
    : u{u0}, v{v0}, square(body.modes.size()), load{body.load} {
  u.resize(body.modes.size());
  v.resize(body.modes.size());
  load.resize(body.modes.size());
  for (const BodyMode& mode : body.modes) {
    const ModeStep step = BackwardEuler::prepare(mode, tau);
    c0.push_back(step.v_v);
    c1.push_back(step.v_u);
    c2.push_back(step.v_f[0]);
  }
}

void BaselineModes::advance(const double* force, double tau) {
  for (std::size_t k = 0; k < u.size(); ++k) {
    v[k] = c0[k] * v[k] + c1[k] * u[k] + c2[k] * force[k];
    u[k] += tau * v[k];
    square[k] += v[k] * v[k];
  }
}

Plain::Plain(const Model& model, const ModalStart& start)
    : resonator{model.resonator, start.resonator_u, start.resonator_v, model.scene.time.step},
      slider{model.slider, start.slider_u, start.slider_v, model.scene.time.step},
      tau_{model.scene.time.step},
      spacing_{model.scene.spacing},
      position_{model.position},
      advance_{model.advance},
      delta_{model.delta},
      stiffness_{model.node_stiffness},
      amplitude_{std::sqrt(2.0 / model.resonator.length)},
      height1_{model.slider_height},
      height2_{model.resonator_height},
      force1_(model.slider.modes.size()),
      force2_(model.resonator.modes.size()) {
  if (model.scene.resonator.support != Support::pinned)
    throw std::invalid_argument("the baselines are for pinned resonators");
  for (const BodyMode& mode : model.resonator.modes) wave_.push_back(mode.shape->wave_number());
  for (const BodyMode& mode : model.slider.modes)
    for (int n = 0; n < model.nodes(); ++n) shapes1_.push_back(shape_at(mode, n * spacing_));
}

void Plain::march(std::int64_t steps) {
  const int nodes = static_cast<int>(height1_.size());
  const int modes1 = static_cast<int>(force1_.size()), modes2 = static_cast<int>(force2_.size());
  for (std::int64_t end = step + steps; step < end; ++step) {
    const double position = position_ + static_cast<double>(step) * advance_;
    const int base = static_cast<int>(position);
    const double theta = position - base;
    force1_ = slider.load;
    force2_ = resonator.load;
    bool touches = false;
    for (int n = 0; n < nodes; ++n) {
      const double x = (position + n) * spacing_;
      double overlap = height1_[n] - delta_ + (1.0 - theta) * height2_[base + n] +
                       theta * height2_[base + n + 1];
      for (int k = 0; k < modes2; ++k)
        overlap += resonator.u[k] * amplitude_ * std::sin(wave_[k] * x);
      for (int k = 0; k < modes1; ++k) overlap += slider.u[k] * shapes1_[k * nodes + n];
      if (overlap < 0.0) continue;
      touches = true;
      const double f = stiffness_ * overlap;
      for (int k = 0; k < modes2; ++k) force2_[k] -= f * amplitude_ * std::sin(wave_[k] * x);
      for (int k = 0; k < modes1; ++k) force1_[k] -= f * shapes1_[k * nodes + n];
    }
    contact_steps += touches;
    resonator.advance(force2_.data(), tau_);
    slider.advance(force1_.data(), tau_);
  }
}

Tables::Tables(const Model& model, const ModalStart& start)
    : resonator{model.resonator, start.resonator_u, start.resonator_v, model.scene.time.step},
      slider{model.slider, start.slider_u, start.slider_v, model.scene.time.step},
      tau_{model.scene.time.step},
      position_{model.position},
      advance_{model.advance},
      stiffness_{model.node_stiffness} {
  const auto tabulate = [&](const Body& body, std::size_t nodes) {
    Eigen::MatrixXd shapes(nodes, body.modes.size());
    for (Eigen::Index k = 0; k < shapes.cols(); ++k)
      for (Eigen::Index n = 0; n < shapes.rows(); ++n)
        shapes(n, k) = shape_at(body.modes[k], static_cast<double>(n) * model.scene.spacing);
    return shapes;
  };
  shapes1_ = tabulate(model.slider, model.slider_height.size());
  shapes2_ = tabulate(model.resonator, model.resonator_height.size());
  height1_ = Eigen::VectorXd::Map(model.slider_height.data(), model.nodes()).array() - model.delta;
  height2_ = Eigen::VectorXd::Map(model.resonator_height.data(),
                                  static_cast<Eigen::Index>(model.resonator_height.size()));
  lower_.resize(model.nodes() + 1);
  overlap_.resize(model.nodes());
  touching_.resize(model.nodes());
}

void Tables::march(std::int64_t steps) {
  const Eigen::Index nodes = overlap_.size();
  const auto vector = [](auto& values) {
    return Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
  };
  const auto u1 = vector(slider.u), u2 = vector(resonator.u);
  for (std::int64_t end = step + steps; step < end; ++step) {
    const double position = position_ + static_cast<double>(step) * advance_;
    const auto base = static_cast<Eigen::Index>(position);
    const double theta = position - static_cast<double>(base);
    const auto shapes2 = shapes2_.middleRows(base, nodes + 1);
    lower_ = height2_.segment(base, nodes + 1);
    lower_.noalias() += shapes2 * u2;
    overlap_ = height1_ + (1.0 - theta) * lower_.head(nodes) + theta * lower_.tail(nodes);
    if (u1.size() > 0) overlap_.noalias() += shapes1_ * u1;
    force1_ = vector(slider.load);
    force2_ = vector(resonator.load);
    if (overlap_.maxCoeff() >= 0.0) {
      ++contact_steps;
      // listed first: a loop that does nothing else is the faster one
      int count = 0;
      for (Eigen::Index n = 0; n < nodes; ++n) {
        touching_[count] = n;
        count += overlap_[n] >= 0.0;
      }
      for (int e = 0; e < count; ++e) {
        const Eigen::Index n = touching_[e];
        const double f = stiffness_ * overlap_[n];
        force2_ -= (f * (1.0 - theta)) * shapes2.row(n).transpose();
        force2_ -= (f * theta) * shapes2.row(n + 1).transpose();
        force1_ -= f * shapes1_.row(n).transpose();
      }
    }
    resonator.advance(force2_.data(), tau_);
    slider.advance(force1_.data(), tau_);
  }
}

}  // namespace ra2d::bench
