// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/plan/stability.hpp"

/// The methods of a chart of accuracy: schemes under contact laws, with steps or tolerances.
namespace ra2d {

/// A scheme under a contact law. With a step or, of the adaptive scheme, with a tolerance it is
/// also called a setting.
struct Method {
  TimeSettings time;
  ContactLaw law = ContactLaw::penalty;
  bool operator==(const Method&) const = default;
};

/// Every method that can march the scene, penalty first. Without a contact stiffness there is no
/// penalty.
std::vector<Method> methods_of(const Scene& scene);

/// The setting of a method whose step [s] is `size`, or, of the adaptive scheme, whose tolerance
/// is.
Method sized(Method method, double size);

/// The scene as the method marches it. What the method does not say, it keeps: its step, or its
/// tolerance.
Scene with(Scene scene, const Method& method);

/// The scene with a setting, up to `time` alone, on a whole number of steps next to the setting's
/// own, with samples at its beginning and its end.
Scene ending_at(Scene scene, const Method& setting, double time);

/// For people, e.g. "midpoint, multiplier".
std::string text(const Method& method);
/// "1e-08 s" or "tolerance 1e-08".
std::string size_text(const Method& setting);

}  // namespace ra2d
