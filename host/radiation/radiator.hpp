// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "host/body/body.hpp"

/// A flat face in a rigid baffle, whose points move along z in modes.
namespace ra2d {

/// A shape of one coordinate of the face.
using LineShape = std::function<double(double)>;

/// A mode's shape: along(x) times one of the radiator's shapes across(y).
struct RadiatingMode {
  LineShape along;
  std::size_t across = 0;  // its number
};

/// A rectangle: x from 0 to `length`, y from 0 to `width`; z = 0 is its plane.
struct Radiator {
  double length = 0, width = 0;                  // m
  double turning_along = 0, turning_across = 0;  // rad/m, the largest of the shapes
  std::vector<RadiatingMode> modes;
  std::vector<LineShape> across;

  double area() const { return length * width; }
};

/// A beam as a strip of its width, all of which moves alike.
Radiator strip(const Body& body, double width);

/// A rectangular plate, simply supported: shapes sin(m pi x/length) sin(n pi y/width), with m and n
/// from 1. Each of `numbers` is a mode's {m, n}.
struct PlateMode {
  int along = 1, across = 1;
};
Radiator supported_plate(double length, double width, const std::vector<PlateMode>& numbers);

/// The face of a resonator with the modes of its body: a strip, or a plate whose shapes' squares
/// have the integral 1.
Radiator face_of(const Body& body, const BodySpec& spec);

/// Integral of a mode's squared shape over the face: of a strip's mode its width [m].
std::vector<double> squared_shapes(const Radiator& radiator);

}  // namespace ra2d
