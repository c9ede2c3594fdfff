// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d {

/// The most modes of both bodies, rigid ones included, that a march takes. Scenes that ask
/// for more are refused.
inline constexpr int most_modes = 256;

/// Steps: the longest flight that a forecast can promise, and the most between two checks of the
/// energy.
inline constexpr int longest_flight = 4096;

}  // namespace ra2d
