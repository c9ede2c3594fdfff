// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/methods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/plan/plan.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {

std::vector<Method> methods_of(const Scene& scene) {
  std::vector<Method> methods;
  for (const ContactLaw law : {ContactLaw::penalty, ContactLaw::multiplier}) {
    if (law == ContactLaw::penalty && !(scene.contact.stiffness > 0)) continue;
    for (const TimeSettings& choice : choices_under(law)) methods.push_back({choice, law});
    if (law == ContactLaw::penalty) methods.push_back({{SchemeKind::adaptive}, law});
  }
  return methods;
}

Method sized(Method method, double size) {
  if (is_adaptive(method.time))
    method.time.tolerance = size;
  else
    method.time.step = size;
  return method;
}

Scene with(Scene scene, const Method& method) {
  scene.contact.law = method.law;
  scene.time.scheme = method.time.scheme;
  scene.time.contact_force = method.time.contact_force;
  if (method.time.step > 0) scene.time.step = method.time.step;
  if (method.time.tolerance) scene.time.tolerance = method.time.tolerance;
  return scene;
}

Scene ending_at(Scene scene, const Method& setting, double time) {
  scene = with(scene, setting);
  scene.duration = time;
  scene.output.rate = 1 / time;
  if (!is_adaptive(scene.time))
    scene.time.step = time / std::max(1.0, std::round(time / scene.time.step));
  return scene;
}

std::string text(const Method& method) {
  return short_text(method.time) +
         (method.law == ContactLaw::multiplier ? ", multiplier" : std::string{});
}

std::string size_text(const Method& setting) {
  return setting.time.tolerance ? fmt::format("tolerance {:g}", *setting.time.tolerance)
                                : fmt::format("{:g} s", setting.time.step);
}

}  // namespace ra2d
