// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/analysis/sound_pressure.hpp"

namespace ra2d {

/// Sound power that the resonator radiates to one side of its baffle, as much again to the other.
struct RadiatedPower {
  double watts = 0;                            // W, to one side; NaN: the stretch is too short
  double shortest = 0;                         // s, of a stretch with a power
  SharesAbove above;                           // of the last mode's band
  double lw = 0, lw_a = 0;                     // dB re 1 pW; A-weighted
  double efficiency = 0;                       // watts over density c area <v^2>
  std::vector<int> number;                     // of third octaves
  std::vector<double> level, level_a, spread;  // dB re 1 pW
  std::vector<double> band_efficiency;
  std::vector<double> mode_frequency, mode_efficiency;  // Hz, each elastic mode at its own
  std::vector<double> mode_damping;  // the ratio that the air on both sides would add to its own
  double damping_power = 0;          // W, that the resonator's damping takes
  double share_of_damping = 0;       // of both sides' power
  double inertia = 0;                // bound: share by which air lowers a mode's frequency

  /// Whether the air, which takes nothing of the motion, would have changed it.
  bool air_matters() const;
};

/// Power of the stretch from the modes' lines and their resistances, cross terms included.
RadiatedPower radiated_power(const ResultReader& reader, const SoundingResonator& resonator,
                             const Stretch& stretch);

/// The level of a sound power [dB re 1 pW].
double power_level(double watts);

/// The sound of a result in four numbers, for a table of many.
struct SoundLevels {
  double lp, lp_a;       // dB re 20 uPa, by the mean squared pressure over the scene's microphones
  double lw, lw_a;       // dB re 1 pW, of the power to one side
  std::string why_none;  // empty where all of them are there
  std::vector<std::string> warnings;
};
/// `scene`: that of the result. What there is not is NaN.
SoundLevels sound_levels(const Scene& scene, const std::filesystem::path& file);

}  // namespace ra2d
