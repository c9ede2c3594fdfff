// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/body/body.hpp"

/// Euler-Bernoulli beams and their modes (docs/model.md; paper, equations 1 to 6).
namespace ra2d {

/// Shape of one mode of a beam, in a form that stays accurate for high mode numbers:
///   psi(x) = sine sin(beta x) + cosine cos(beta x) + left exp(-beta x) + right exp(-beta (L - x))
///            + constant + slope x.
struct BeamShape final : ModeShape {
  double length = 0;  // m, L
  double beta = 0;    // 1/m, 0 of a rigid mode
  double sine = 0, cosine = 0, left = 0, right = 0;
  double constant = 0, slope = 0;
  double highest = 0;  // max |psi| over the beam (an upper bound, tight to a few per cent)

  void evaluate(double x, int derivatives, double* out) const override;
  double largest() const override { return highest; }
  double size() const override;
  double wave_number() const override { return beta; }
  double change_rate() const override;
  double largest_slope(double beyond) const override;
  double largest_curvature(double beyond) const override;
  double growth(double beyond) const override;
  CubicRemainder cubic_remainder(double radius) const override;
  double fourth_derivative_factor(double unit) const override;  // psi'''' = beta^4 psi
  void append_parameters(std::vector<double>& out) const override;

  /// The largest |psi'|/beta and |psi''|/beta^2 of the elastic part up to `beyond` [m] behind the
  /// far end, where the exponential of a free beam grows on [m^(-1/2)].
  double largest_wave(double beyond) const;
};

/// The beam that a scene describes: its modes (Support; max_frequency or modes), and its modal
/// load. The elastic modes of a free beam solve cosh(beta L) cos(beta L) = 1, to full precision for
/// any number. Standard gravity 9.80665 m/s^2 for load = "weight".
Body make_beam(const BodySpec& spec);

/// mode_count and elastic_frequency of a beam (host/body/body.hpp).
int beam_mode_count(const BodySpec& spec, int most);
double beam_frequency(const BodySpec& spec, int k);

/// Closed form of a beam's mode. Throws std::bad_cast where the body is of another kind.
const BeamShape& beam_shape(const BodyMode& mode);

}  // namespace ra2d
