// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d {

/// Modes of both bodies together, rigid ones among them, that a march has room for. Scenes that ask
/// for more are refused.
inline constexpr int most_modes = 256;

/// Steps: the longest stretch that a look ahead covers, and between two looks at the energy.
inline constexpr int longest_flight = 4096;

}  // namespace ra2d
