// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene/hertz.hpp"

#include <algorithm>
#include <numbers>

namespace ra2d {

double contact_modulus(const Scene& scene) {
  double compliance = 0;  // 1/Pa
  for (const BodySpec* body : {&scene.resonator, &scene.slider}) {
    const double nu = body->poisson.value_or(usual_poisson);
    if (body->young != 0) compliance += (1 - nu * nu) / body->young;
  }
  return 1 / compliance;
}

double plate_contact_modulus(const Scene& scene) {
  if (scene.slider.young != 0) return contact_modulus(scene);
  Scene alike = scene;
  alike.slider.young = scene.resonator.young;
  alike.slider.poisson = scene.resonator.poisson;
  return contact_modulus(alike);
}

double hertz_stiffness(const Scene& scene) {
  return contact_modulus(scene) /
         (std::numbers::sqrt2 * std::min(scene.resonator.width, scene.slider.width));
}

double stiffest_half_space(const Scene& scene) {
  constexpr double line_contact = 3 * std::numbers::pi / 8;
  return line_contact * contact_modulus(scene) / (scene.spacing / 2);
}

}  // namespace ra2d
