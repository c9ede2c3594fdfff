// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/plan/stability.hpp"

/// What a chart of accuracy compares: schemes under contact laws, with steps or tolerances.
namespace ra2d {

struct Method {
  SchemeChoice choice;
  ContactLaw law = ContactLaw::penalty;
  bool operator==(const Method&) const = default;
};

/// A method with its step [s]; of a scheme that chooses its own steps, with its tolerance.
struct Setting {
  Method method;
  double step = 0, tolerance = 0;
  bool operator==(const Setting&) const = default;
};

/// Whether a scheme chooses its own steps, to a tolerance.
bool takes_tolerance(SchemeKind scheme);

/// Every method that can march the scene, penalty first. Without a contact stiffness there is no
/// penalty.
std::vector<Method> methods_of(const Scene& scene);

/// The scene as the setting marches it.
Scene with(Scene scene, const Setting& setting);

/// The same up to `time` alone, on a whole number of steps next to the setting's own, with samples
/// at its beginning and its end.
Scene ending_at(Scene scene, const Setting& setting, double time);

/// For people, e.g. "midpoint, multiplier".
std::string text(const Method& method);
/// "1e-08 s" or "tolerance 1e-08".
std::string size_text(const Setting& setting);

}  // namespace ra2d
