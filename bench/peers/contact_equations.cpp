// SPDX-License-Identifier: BSD-3-Clause
#include "bench/peers/contact_equations.hpp"

#include <cmath>

namespace ra2d::peers {
namespace {

template <class Heights>
double mean_square(const Heights& heights) {
  double mean = 0, square = 0;
  for (const double h : heights) mean += h;
  mean /= static_cast<double>(heights.size());
  for (const double h : heights) square += (h - mean) * (h - mean);
  return square / static_cast<double>(heights.size());
}

}  // namespace

ContactEquations::ContactEquations(const Model& model)
    : node_stiffness{model.node_stiffness},
      spacing{model.scene.spacing},
      speed{model.scene.speed},
      roughness{std::sqrt(mean_square(model.resonator_height) + mean_square(model.slider_height))},
      position_{model.position},
      rate_{model.scene.speed / model.scene.spacing},
      modes2_{static_cast<Eigen::Index>(model.resonator.modes.size())},
      modes1_{static_cast<Eigen::Index>(model.slider.modes.size())},
      moving_{model.scene.resonator.moving_forces} {
  for (Eigen::ArrayXd* each : {&omega, &damping, &mass, &largest, &steepest, &load_})
    *each = Eigen::ArrayXd::Zero(modes2_ + modes1_);
  Eigen::Index k = 0;
  for (const Body* body : {&model.resonator, &model.slider})
    for (std::size_t i = 0; i < body->modes.size(); ++i, ++k) {
      const BodyMode& mode = body->modes[i];
      omega[k] = mode.omega;
      damping[k] = 2 * mode.zeta * mode.omega;
      mass[k] = mode.mass;
      largest[k] = mode.shape->largest();
      load_[k] = body->load[i];
      if (k < modes2_) steepest[k] = mode.shape->largest_slope(0);
    }
}

void ContactEquations::state_rate(const double* y, const double* force, double* rate) const {
  const Eigen::Index count = omega.size();
  const double *w = omega.data(), *c = damping.data(), *m = mass.data();
  const double *u = y, *v = y + count;
  for (Eigen::Index k = 0; k < count; ++k) {
    rate[k] = v[k];
    rate[count + k] = force[k] / m[k] - c[k] * v[k] - w[k] * w[k] * u[k];
  }
}

}  // namespace ra2d::peers
