// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/body/beam.hpp"

namespace ra2d {

/// Shape of one mode of a plate or a block: psi(x, y) = along(x) across(y), with
///   across(y) = sin(wave y), or, where wave is 0, offset + tilt y.
/// `along` has the bounds of the product: |across| <= 1.
struct ArealShape final : ModeShape {
  BeamShape along;    // 1/m
  double width = 0;   // m, y from 0 to here
  double wave = 0;    // 1/m, a whole number of pi/width
  double offset = 1;  // where wave is 0
  double tilt = 0;    // 1/m

  void evaluate(double x, int derivatives, double* out) const override;
  void evaluate_across(double y, int derivatives, double* out) const override;
  double across_rate() const override;
  double largest() const override { return along.largest(); }
  double size() const override { return along.size(); }
  double wave_number() const override { return along.wave_number(); }
  double change_rate() const override { return along.change_rate(); }
  double largest_slope(double beyond) const override { return along.largest_slope(beyond); }
  double largest_curvature(double beyond) const override { return along.largest_curvature(beyond); }
  double growth(double beyond) const override { return along.growth(beyond); }
  CubicRemainder cubic_remainder(double radius) const override {
    return along.cubic_remainder(radius);
  }
  double fourth_derivative_factor(double unit) const override {
    return along.fourth_derivative_factor(unit);
  }
  double mean_square(int nodes, double spacing) const override;
  void append_parameters(std::vector<double>& out) const override;
};

/// Closed form of a mode of a plate or a block. Throws std::bad_cast where the body is of another
/// kind.
const ArealShape& areal_shape(const BodyMode& mode);

}  // namespace ra2d
