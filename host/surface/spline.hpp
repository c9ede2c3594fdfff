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

}  // namespace ra2d
