// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Usual and possible faces. A profile beyond them was most likely read in the wrong unit.
namespace ra2d::usual_faces {

// Beyond any face. Its root mean square slope of 1 is 45 degrees.
inline constexpr double largest_share = 0.5;  // of the beam's thickness, peak to valley
inline constexpr double steepest = 1;         // root mean square slope
inline constexpr double tallest = 1e3;        // m, peak to valley, of a body of any size
// Beyond most faces:
inline constexpr double large_share = 0.05, steep = 0.2, smooth = 1e-4;
inline constexpr double coarse_nodes = 20;  // of the scene, to a step of the profile

}  // namespace ra2d::usual_faces
