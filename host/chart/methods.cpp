// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/methods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/plan/plan.hpp"

namespace ra2d {

bool takes_tolerance(SchemeKind scheme) { return scheme == SchemeKind::adaptive; }

std::vector<Method> methods_of(const Scene& scene) {
  std::vector<Method> methods;
  for (const ContactLaw law : {ContactLaw::penalty, ContactLaw::multiplier}) {
    if (law == ContactLaw::penalty && !(scene.contact.stiffness > 0)) continue;
    for (const SchemeChoice& choice : choices_under(law)) methods.push_back({choice, law});
    if (law == ContactLaw::penalty)
      methods.push_back({{SchemeKind::adaptive, ForceTime::old_time}, law});
  }
  return methods;
}

Scene with(Scene scene, const Setting& setting) {
  scene.time.scheme = setting.method.choice.scheme;
  scene.time.contact_force = setting.method.choice.force_time;
  scene.contact.law = setting.method.law;
  if (takes_tolerance(scene.time.scheme))
    scene.time.tolerance = setting.tolerance;
  else
    scene.time.step = setting.step;
  return scene;
}

Scene ending_at(Scene scene, const Setting& setting, double time) {
  scene = with(scene, setting);
  scene.duration = time;
  scene.output.rate = 1 / time;
  if (!takes_tolerance(scene.time.scheme))
    scene.time.step = time / std::max(1.0, std::round(time / scene.time.step));
  return scene;
}

std::string text(const Method& method) {
  return short_text(method.choice) +
         (method.law == ContactLaw::multiplier ? ", multiplier" : std::string{});
}

std::string size_text(const Setting& setting) {
  return takes_tolerance(setting.method.choice.scheme)
             ? fmt::format("tolerance {:g}", setting.tolerance)
             : fmt::format("{:g} s", setting.step);
}

}  // namespace ra2d
