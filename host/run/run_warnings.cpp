// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

constexpr double much_energy = 0.05;  // of the largest term of the balance

/// The likely reason of a balance that does not close.
std::string energy_text(const Scene& scene, const EnergyBalance& energy) {
  const std::string far =
      fmt::format("{:.0f} % of the energy is unaccounted for: ", 100 * energy.closure());
  if (scene.contact.law == ContactLaw::multiplier && energy.residual < 0)
    return far + "under multipliers each impact takes some, and is meant to";
  if (is_adaptive(scene)) return far + "a smaller time.tolerance is needed";
  return far + fmt::format("steps of {:g} s are too long here; try a tenth, or another time.scheme",
                           scene.time.step);
}

/// The tolerance counts for the motion of both bodies together. Where contact holds next to nothing
/// of its energy, as under a light slider on a plate that other forces bend, it says little about
/// contact forces: they are off by some tolerance/sqrt(share) and, after many shocks, more. Empty
/// where that is little.
std::string tolerance_text(const Scene& scene, double contact_share) {
  constexpr double much = 0.01, little = 1e-4;  // of a force
  constexpr double best = 1e-12;                // tolerance, about
  if (!is_adaptive(scene) || !(contact_share > 0)) return {};
  const double tolerance = scene.time.tolerance.value_or(usual_tolerance),
               part = std::sqrt(contact_share);
  const double better = std::max(best, std::pow(10, std::floor(std::log10(little * part))));
  if (!(tolerance > much * part) || !(better < tolerance)) return {};
  return fmt::format(
      "contacts hold {:.1g} of the energy, beside which time.tolerance = {:g} says little about "
      "them: forces and shocks may be off by {:.0f} % and more. Try {:.0e}",
      contact_share, tolerance, std::min(100.0, 100 * tolerance / part), better);
}

/// Empty where the resonator moves by as little as its equations take for granted. A plate that is
/// bent by its thickness is stretched as much; a beam may draw in its ends.
std::string displacement_text(const BodySpec& resonator, double displacement) {
  const bool is_plate = resonator.kind == BodyKind::plate;
  const double large = is_plate ? 0.5 * resonator.thickness : 0.05 * resonator.length;
  if (!(displacement > large)) return {};
  return fmt::format(
      "the resonator vibrates by some {:.2g} m (root mean square), and its {} is {:g} m: the model "
      "is for small displacements, so check units and values of the scene",
      displacement, is_plate ? "thickness" : "length",
      is_plate ? resonator.thickness : resonator.length);
}

}  // namespace

std::vector<std::string> warnings_of_figures(const Scene& scene, const RunReport& report) {
  std::vector<std::string> warnings;
  if (report.energy.closure() > much_energy) warnings.push_back(energy_text(scene, report.energy));
  if (std::string text = tolerance_text(scene, report.contact_share_of_energy); !text.empty())
    warnings.push_back(std::move(text));
  if (std::string text = displacement_text(scene.resonator, report.displacement_rms); !text.empty())
    warnings.push_back(std::move(text));
  return warnings;
}

std::vector<std::string> warnings_of(const RunReport& report, const SceneSound& sound) {
  std::vector<std::string> warnings = report.warnings;
  for (std::size_t i = 0; i < sound.microphones.size(); ++i)
    if (const std::string text = warning_of(sound.microphones[i]); !text.empty())
      warnings.push_back(fmt::format("microphone {}: {}", i + 1, text));
  return warnings;
}

}  // namespace ra2d
