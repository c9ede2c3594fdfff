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

/// The tolerance counts for the motion of both bodies together. A part of it with a share of the
/// energy is off by some tolerance/sqrt(share) and, after many steps in contact, more. 0 where that
/// is less than `much` of the part; else a tolerance at which it is a hundredth of this.
double better_tolerance(const Scene& scene, double share, double much) {
  constexpr double best = 1e-12;  // about
  if (!is_adaptive(scene) || !(share > 0)) return 0.0;
  const double tolerance = scene.time.tolerance.value_or(usual_tolerance), part = std::sqrt(share);
  const double better = std::max(best, std::pow(10, std::floor(std::log10(0.01 * much * part))));
  return tolerance > much * part && better < tolerance ? better : 0.0;
}

/// Where contact holds next to nothing of the energy, as under a light slider on a plate that other
/// forces bend, the tolerance says little about contact forces. Empty where they are right.
std::string contact_text(const Scene& scene, double share) {
  const double better = better_tolerance(scene, share, 0.01);
  if (!(better > 0)) return {};
  const double tolerance = scene.time.tolerance.value_or(usual_tolerance);
  return fmt::format(
      "contacts hold {:.1g} of the energy, beside which time.tolerance = {:g} says little about "
      "them: forces and shocks may be off by {:.0f} % and more. Try {:.0e}",
      share, tolerance, std::min(100.0, 100 * tolerance / std::sqrt(share)), better);
}

/// Where slow sliding under a load bends the bodies far more than it lets them vibrate, errors of
/// the steps in contact ring in the modes, and the level is too high. It was measured: 2.7 dB where
/// tolerance/sqrt(share) was 0.14. Between smooth faces, plane and areal, the same ratio meant 0.2
/// dB at the most below 15, and 0.4 to 2 dB at 110 to 190. Without contact there is no such error.
std::string level_text(const Scene& scene, const RunReport& report) {
  if (!(report.contact_share > 0)) return {};
  const double share = report.vibration_share_of_energy;
  const double better = better_tolerance(scene, share, scene.faces == Faces::smooth ? 10 : 0.03);
  if (!(better > 0)) return {};
  return fmt::format(
      "the resonator's vibration holds {:.1g} of the energy, beside which time.tolerance = {:g} "
      "says little about it: the level may be that of the steps' errors. Try {:.0e}",
      share, scene.time.tolerance.value_or(usual_tolerance), better);
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
  if (std::string text = contact_text(scene, report.contact_share_of_energy); !text.empty())
    warnings.push_back(std::move(text));
  if (std::string text = level_text(scene, report); !text.empty())
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
