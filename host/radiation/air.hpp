// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d {

/// Still air, as sound knows it.
struct Air {
  double density = 0;      // kg/m^3
  double sound_speed = 0;  // m/s
};

inline constexpr double usual_celsius = 20, usual_pascal = 101'325;

/// Dry air as an ideal gas. Moist air of 20 degrees is up to 0.4 % faster and 0.9 % lighter.
/// Throws std::invalid_argument outside of -50 to 100 degrees Celsius and 10 to 1000 kPa.
Air air_of(double celsius, double pascal);

}  // namespace ra2d
