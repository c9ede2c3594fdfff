// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d {

/// The most modes of both bodies, rigid ones included, that a march takes. Scenes that ask
/// for more are refused.
inline constexpr int most_modes = 256;

/// Steps: the longest flight that a forecast can promise, and the most between two checks of the
/// energy.
inline constexpr int longest_flight = 4096;

/// Energy may exceed what was put in by this factor before the run counts as unstable. The contact
/// energy of a scheme near its limit oscillates by a factor of a few; beyond the limit it grows
/// without bound.
inline constexpr double energy_factor = 10.0;

}  // namespace ra2d
