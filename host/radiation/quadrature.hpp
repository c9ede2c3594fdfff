// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>
#include <vector>

/// Gauss's rule on panels that follow an integrand: short where it oscillates and near a pole.
namespace ra2d {

/// Places and weights of a sum that stands for an integral.
struct Points {
  std::vector<double> at, weight;
  std::size_t size() const { return at.size(); }
};

/// Gauss and Legendre's rule on [-1, 1], of 1 to `most_points_of_rule`.
const Points& gauss_rule(int points);
inline constexpr int most_points_of_rule = 32;

/// How fine the panels are. The usual ones leave errors below 1e-9 of a pressure, 5e-9 of a power.
struct Fineness {
  int points = 16;    // of a panel
  double phase = 10;  // rad, by which an integrand turns within half a panel
  double near = 0.8;  // half a panel, over its distance from a pole
};

/// A pole of an integrand: over the place `at`, at a distance from the line that may be 0 outside
/// of the interval alone.
struct Pole {
  double at = 0, distance = 0;  // m
};

/// Points from `low` to `high` for an integrand that turns by `turning` [rad/m] and has a pole.
Points graded_points(double low, double high, double turning, const Pole& pole,
                     const Fineness& fineness = {});
/// Without a pole.
Points even_points(double low, double high, double turning, const Fineness& fineness = {});

/// Where a place stands among Gauss's points of even panels, and the weights by which a smooth
/// function follows from its values there (barycentric). To interpolate takes panels five times as
/// short as to integrate.
class Interpolation {
 public:
  Interpolation(double high, double turning, const Fineness& fineness = {});

  const Points& points() const { return points_; }
  std::size_t order() const { return barycentric_.size(); }
  /// For a place from 0 to `high`: the number of the first point of its panel; the weights of the
  /// panel's points come to `weights`.
  std::size_t weigh(double place, double* weights) const;

 private:
  Points points_;
  double panel_;  // its width
  std::vector<double> barycentric_;
};

}  // namespace ra2d
