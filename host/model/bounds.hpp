// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/model/model.hpp"
#include "kernels/schemes/mode_step.hpp"

/// Bounds on what modes and faces can do. The proofs that no contact is missed
/// (kernels/candidates.hpp, kernels/adaptive/overlaps.hpp) rest on them.
namespace ra2d {

/// |(omega U, V)'| over |(omega U, V)| of a free mode is no more [1/s].
double fastest_rate(const Mode& mode);

/// ... of all modes of both bodies, with the contact spring of one node.
double fastest_rate(const Model& model);

/// The largest beta of a beam's modes [1/m]; 0 without any.
double highest_beta(const Beam& beam);

/// max |psi| over the beam, from the sizes of the shape's parts [m^(-1/2)].
double largest_shape(const ModeShape& shape, double length);

/// The largest |psi'|/beta and |psi''|/beta^2 of the elastic part over the beam and as far as
/// `beyond` [m] behind its far end, where the exponential of a free beam grows on and patches reach
/// [m^(-1/2)].
double largest_wave(const ModeShape& shape, double beyond);

/// What a mode's cubic about the centre of a stretch leaves out within `radius` [m] of it, where
/// the beam is or behind its far end. The centre may be up to `radius` behind that end.
struct CubicRemainder {
  double value;  // of psi, m^(-1/2)
  double slope;  // of psi', m^(-3/2)
};
CubicRemainder cubic_remainder(const ModeShape& shape, double radius);

/// The largest wave number of a mode, rigid ones included, times the speed of the node that passes
/// over it: |d^j psi/dt^j| <= rate^j largest_shape [1/s].
double passing_rate(const ModeShape& shape, double length, double speed);

/// The fourth time derivative of what a mode adds to the overlap of a node that passes over it,
/// over the mode's energy norm sqrt(V^2 + omega^2 U^2), for omega > 0 [m^(-1/2)/s^3]. With |U^(j)|
/// <= fastest_rate^(j-1) E for j >= 1, |U| <= E/omega: (d/dt + passing_rate)^4, term by term.
double fourth_derivative(const Mode& mode, double largest_shape, double passing_rate);

/// The largest rise of a face from a node to the next [m].
double steepest_rise(const double* height, int count);

/// highest[n] = the highest of height[n] and the `ahead` after it (FaceTables::highest2).
void fill_highest(const double* height, int count, int ahead, double* highest);

/// Bound on the rounding of the rough faces' part of a gap whose terms add up to `scale` [m] at the
/// most. Five roundings of half an ulp are counted; 32 leave room for the sums that they go into.
double face_rounding(double scale);

}  // namespace ra2d
