// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <vector>

#include "host/model/model.hpp"
#include "kernels/schemes/mode_step.hpp"

/// Bounds on the motion of modes and on the heights of faces. The proofs that no contact is missed
/// (kernels/candidates.hpp, kernels/adaptive/overlaps.hpp) rest on them and on the bounds on shapes
/// (host/body/body.hpp).
namespace ra2d {

/// Bound on |(omega U, V)'| over |(omega U, V)| of a free mode [1/s].
double fastest_rate(const Mode& mode);

/// Fastest rate of all modes of both bodies, with the contact spring of one node.
double fastest_rate(const Model& model);

/// Bound on the fourth time derivative of what a mode adds to the overlap of a node that passes
/// over it, over the mode's energy norm sqrt(V^2 + omega^2 U^2), for omega > 0 [m^(-1/2)/s^3]. With
/// |d^j psi/dt^j| <= passing_rate^j largest_shape, |U^(j)| <= fastest_rate^(j-1) E for j >= 1 and
/// |U| <= E/omega: (d/dt + passing_rate)^4, term by term.
double fourth_derivative(const Mode& mode, double largest_shape, double passing_rate);

/// Bounds on sum_k weight_k psi_k^2 anywhere on a body, for two sets of weights, none negative.
/// `width` [m], of an areal body. They are far below the sums of the largest terms: the modes'
/// crests stand at different places.
std::array<double, 2> largest_square_sums(const Body& body,
                                          const std::array<std::vector<double>, 2>& weights,
                                          double width);

/// The largest rise of a face from a node to the next [m].
double steepest_rise(const double* height, int count);

/// Bound on the slope of a smooth face times the spacing, and its largest curvature times the
/// square of the spacing [m]: it departs from straight lines by no more than an eighth of that.
double steepest_rise(const double* height, const double* curvature, int count);
double largest_face_curvature(const double* curvature, int count);

/// highest[n] = the highest of height[n] and the `ahead` after it (FaceTables::highest2).
void fill_highest(const double* height, int count, int ahead, double* highest);

/// Smooth faces: sag[n] = an eighth of the largest -curvature from the `before` nodes before n to
/// the `ahead` after it (FaceTables::sag1, sag2).
void fill_sag(const double* curvature, int count, int before, int ahead, double* sag);
/// Smooth faces: heights raised so that the higher of two neighbours is above the spline between
/// them, and above all that CandidateGroups::find takes for it: by a sixth of the curvature.
void fill_raised(const double* height, const double* curvature, int count, double* raised);

/// Bound on the rounding of the rough faces' part of a gap whose terms add up to at most `scale`
/// [m]. There are five roundings of half an ulp, of smooth faces some twenty; 32, or 128, leave
/// room for the sums that they go into.
double face_rounding(double scale, bool smooth = false);

}  // namespace ra2d
