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
    if (law == ContactLaw::penalty && !(scene.stiffness > 0)) continue;
    for (const SchemeChoice& choice : choices_under(law)) methods.push_back({choice, law});
    if (law == ContactLaw::penalty)
      methods.push_back({{SchemeKind::adaptive, ForceTime::old_time}, law});
  }
  return methods;
}

Scene with(Scene scene, const Setting& setting) {
  scene.scheme = setting.method.choice.scheme;
  scene.force_time = setting.method.choice.force_time;
  scene.law = setting.method.law;
  if (takes_tolerance(scene.scheme))
    scene.tolerance = setting.tolerance;
  else
    scene.step = setting.step;
  return scene;
}

Scene ending_at(Scene scene, const Setting& setting, double time) {
  scene = with(scene, setting);
  scene.duration = time;
  scene.rate = 1 / time;
  if (!takes_tolerance(scene.scheme))
    scene.step = time / std::max(1.0, std::round(time / scene.step));
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
