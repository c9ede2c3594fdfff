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

/// Gauss and Legendre's rule on [-1, 1].
Points gauss_rule(int points);

/// How fine the panels are. The usual ones leave errors below 1e-9 of a pressure, 5e-9 of a power.
struct Fineness {
  int points = 16;    // of a panel
  double phase = 10;  // rad, by which an integrand turns within half a panel
  double near = 0.8;  // half a panel, over its distance from a pole
};

/// Where an integrand has a pole: at `at` on the line, or `beside` it, which may be 0 outside of
/// the interval only.
struct Pole {
  double at = 0, beside = 0;  // m
};

/// Points from `low` to `high` for an integrand that turns by `turning` [rad/m] and has a pole.
Points graded_points(double low, double high, double turning, const Pole& pole,
                     const Fineness& fineness = {});
/// Without a pole.
Points even_points(double low, double high, double turning, const Fineness& fineness = {});

/// A smooth function from its values at Gauss's points of even panels: of `turning` as above.
class SmoothTable {
 public:
  template <class Function>
  SmoothTable(double high, double turning, Function f, const Fineness& fineness = {})
      : points_{even_points(0, high, turning, fineness)},
        order_{static_cast<std::size_t>(fineness.points)},
        panel_{high * static_cast<double>(order_) / static_cast<double>(points_.size())} {
    values_.reserve(points_.size());
    for (const double at : points_.at) values_.push_back(f(at));
    weigh(fineness.points);
  }

  /// The value at `x` from 0 to `high`.
  double operator()(double x) const;

 private:
  void weigh(int points);

  Points points_;
  std::size_t order_;
  double panel_;  // its width
  std::vector<double> values_, barycentric_;
};

}  // namespace ra2d
