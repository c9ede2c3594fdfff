// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

/// Cubic splines through heights at equal distances: what "smooth" faces are (scene.faces).
namespace ra2d {

/// The second derivatives at the nodes, times the square of their distance [m], of the cubic spline
/// through `height` [m]: continuous to its second derivative, and to its third at the second and
/// the last node but one ("not a knot"). So cubics and parabolas are their own splines. Through two
/// nodes it is a straight line.
std::vector<double> spline_curvatures(const std::vector<double>& height);

/// How far the spline through every other node misses each that it leaves out [m]: some sixteen
/// times what the spline through all of them is off by between them, where the face is smooth on
/// this spacing. Steps and single spikes miss by their own height.
std::vector<double> spline_misses(const std::vector<double>& height);

/// The largest of them [m].
double spline_miss(const std::vector<double>& height);

/// How far a spline through the nodes is off between them [m], about the most: what one through
/// every other node misses, over the factor by which such misses fall when the spacing is halved
/// (16 where the face is smooth, 1 at a step).
double spline_off(const std::vector<double>& height);

/// That over the root mean square height; 0 of a flat face. Rates and durations of shocks are off
/// by about as much (docs/accuracy.md).
double spline_error(const std::vector<double>& height);

/// The largest error at which a spline is said to follow a face. Beside corners, steps and spikes
/// splines ring.
inline constexpr double most_spline_error = 0.02;

}  // namespace ra2d
