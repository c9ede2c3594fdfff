// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a march has room for. Scenes that ask for more are refused, or end saying so.
namespace ra2d {

/// Modes of both bodies together, rigid ones among them.
inline constexpr int most_modes = 256;

/// Nodes that can carry force at once where their forces are found together: the penalty force of the
/// new time, and the adaptive scheme.
inline constexpr int most_sprung_nodes = 512;

}  // namespace ra2d
