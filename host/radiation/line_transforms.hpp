// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <vector>

#include "host/radiation/quadrature.hpp"
#include "host/radiation/radiator.hpp"

namespace ra2d {

/// How a shape is mirrored at its middle.
enum class Parity { even, odd, neither };

/// Fourier transforms of shapes of one coordinate, from their middle: at a few wave numbers, and
/// between them by interpolation. That of an even shape is real, that of an odd one imaginary: one
/// number. Where any shape is neither, each has two, its real and its imaginary part.
class LineTransforms {
 public:
  /// For wave numbers from 0 to `highest` [rad/m]; `size`: of the line [m]; `turning`: the largest
  /// of the shapes [rad/m].
  LineTransforms(const std::vector<LineShape>& shapes, double size, double turning, double highest,
                 const Fineness& fineness);

  /// Of each shape; `neither` of all where it is that of one.
  const std::vector<Parity>& parities() const { return parities_; }
  /// Numbers of the transform of a shape.
  std::size_t parts() const { return parts_; }
  /// Real and imaginary parts of all shapes: (part, shape).
  void at(double wave_number, std::vector<double>& parts) const;

 private:
  void add_transforms(double wave_number, const Points& points, double middle,
                      const std::vector<double>& weighted);

  std::vector<Parity> parities_;
  std::size_t parts_ = 1;
  Interpolation between_;
  std::vector<double> found_;  // (point of between_, part, shape)
};

}  // namespace ra2d
