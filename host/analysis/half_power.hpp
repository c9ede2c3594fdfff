// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>

/// The half-power damping of a mode, from the lines of its own velocity over the whole stretch.
namespace ra2d {

/// Why a mode has no half-power damping (docs/analysis.md).
enum class NoDamping { found, short_run, shape, lost, mesh };
/// "the run is too short"
const char* reason_of(NoDamping why);
/// One word for tables and JSON: "short".
const char* word_of(NoDamping why);

/// The power of a mode's velocity, line by line from 0 Hz.
struct ModeLines {
  double resolution = 0;  // Hz
  std::span<const double> power;
  double independent = 1;  // share of the lines that chance moves by itself
};

/// The frequencies in which a mode is sought.
struct ModePlace {
  double natural = 0;        // Hz
  double low = 0, high = 0;  // Hz
  double damping = 0;        // expected; NaN where nothing is
};

struct HalfPower {
  double frequency = 0;  // Hz, of the top; NaN where there is none
  double damping = 0;    // (f2 - f1) / (2 f); NaN where it cannot be found
  double error = 0;      // its standard error, were the force stationary Gaussian noise
  NoDamping why = NoDamping::found;
};

/// The velocity of a mode under a force of even density has the resonance curve
///     S(f) = top / (1 + x^2),   x = (f/f0 - f0/f) / (2 zeta),
/// which is exactly 2 zeta f0 wide where it has half its height. A periodogram's lines are S times
/// exponential variables, each its own: the curve is the one under which the lines are most likely.
/// With lines over four times the width on both sides, zeta is known to 1.5/sqrt(pi width stretch).
HalfPower half_power(const ModeLines& lines, const ModePlace& place);

/// The place of mode k: half way to its neighbours, and no further than a tenth of its own
/// frequency. `damping`: the expected one.
ModePlace place_of_mode(std::span<const double> natural, std::size_t k, double damping);

/// A damping with a larger relative standard error is not reported.
inline constexpr double most_uncertain = 0.25;

}  // namespace ra2d
