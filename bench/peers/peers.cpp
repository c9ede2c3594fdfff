// SPDX-License-Identifier: BSD-3-Clause
#include "bench/peers/peers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>

#include "bench/peers/areal_equations.hpp"
#include "bench/peers/integrators.hpp"
#include "host/base/errors.hpp"

namespace ra2d::peers {
namespace {

void check(const Model& model, const PeerOptions& options) {
  if (model.scene.contact.law != ContactLaw::penalty)
    throw RequestError(
        "contact.law = \"multiplier\": the peers solve differential equations, which multipliers "
        "do not give. Set contact.law=penalty");
  if (!(options.tolerance >= 1e-15 && options.tolerance <= 0.1))
    throw RequestError(
        fmt::format("tolerance = {}: expected a number from 1e-15 to 0.1", options.tolerance));
  if (model.has_smooth_faces())
    throw RequestError("the peers know linear faces alone: expected scene.faces = \"linear\"");
  if (model.is_areal && options.integrator != Integrator::dopri5)
    throw RequestError("of areal scenes the peers know dopri5 alone: expected --integrator dopri5");
  const double end = model.scene.duration * (1 + 1e-12);
  if (!(options.until > 0 && options.until <= end))
    throw RequestError(fmt::format(
        "until = {} s: expected a time in the scene, above 0 and up to scene.duration = {} s",
        options.until, model.scene.duration));
}

}  // namespace

Eigen::VectorXd natural_scale(const ContactEquations& equations) {
  const Eigen::Index modes = equations.modes();
  double lowest = std::numeric_limits<double>::infinity();
  for (const double omega : equations.omega)
    if (omega > 0) lowest = std::min(lowest, omega);
  // a lone rigid body: a time in which it moves by its roughness at 1 mm/s
  const double roughness = equations.roughness > 0 ? equations.roughness : 1e-6;
  if (!std::isfinite(lowest)) lowest = 1e-3 / roughness;
  Eigen::VectorXd scale(2 * modes);
  for (Eigen::Index k = 0; k < modes; ++k) {
    scale[modes + k] = roughness * lowest / equations.largest[k];
    scale[k] = scale[modes + k] / std::max(lowest, equations.omega[k]);
  }
  return scale;
}

double longest_step(const ContactEquations& equations) {
  const double stiffest =
      equations.node_stiffness * (equations.largest.square() / equations.mass).sum();
  return 2 / std::sqrt(equations.omega.square().maxCoeff() + stiffest);
}

PeerResult march_peer(const Model& model, const ModalStart& start, const PeerOptions& options) {
  check(model, options);
  std::unique_ptr<PlaneEquations> plane;
  std::unique_ptr<ArealEquations> areal;
  if (model.is_areal)
    areal = std::make_unique<ArealEquations>(model);
  else
    plane = std::make_unique<PlaneEquations>(model);
  const auto modes =
      static_cast<Eigen::Index>(model.resonator.modes.size() + model.slider.modes.size());
  Eigen::VectorXd y(2 * modes);
  const auto copy = [&](Eigen::Index at, const std::vector<double>& from) {
    std::copy(from.begin(), from.end(), y.data() + at);
  };
  const auto modes2 = static_cast<Eigen::Index>(model.resonator.modes.size());
  copy(0, start.resonator_u);
  copy(modes2, start.slider_u);
  copy(modes, start.resonator_v);
  copy(modes + modes2, start.slider_v);

  PeerResult result;
  const auto begin = std::chrono::steady_clock::now();
  if (modes > 0) {
    if (areal)
      march_dopri5(*areal, options, y, result);
    else if (options.integrator == Integrator::dopri5)
      march_dopri5(*plane, options, y, result);
    else
      march_cvode(*plane, options, y, result);
  }
  result.march_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  const auto part = [&](Eigen::Index from, Eigen::Index to) {
    return std::vector<double>(y.data() + from, y.data() + to);
  };
  result.resonator_u = part(0, modes2);
  result.slider_u = part(modes2, modes);
  result.resonator_v = part(modes, modes + modes2);
  result.slider_v = part(modes + modes2, 2 * modes);
  return result;
}

}  // namespace ra2d::peers
