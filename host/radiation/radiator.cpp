// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/radiator.hpp"

#include <algorithm>
#include <cmath>

#include "host/body/plate.hpp"
#include "host/radiation/quadrature.hpp"

namespace ra2d {
namespace {

double squared(const LineShape& shape, const Points& points) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double value = shape(points.at[i]);
    sum += points.weight[i] * value * value;
  }
  return sum;
}

}  // namespace

Radiator strip(const Body& body, double width) {
  Radiator radiator;
  radiator.length = body.length;
  radiator.width = width;
  radiator.turning_along = highest_wave_number(body);
  for (const BodyMode& mode : body.modes)
    radiator.modes.push_back({[shape = mode.shape](double x) {
                                double value = 0;
                                shape->evaluate(x, 1, &value);
                                return value;
                              },
                              0});
  radiator.across.emplace_back([](double) { return 1.0; });
  return radiator;
}

Radiator supported_plate(double length, double width, const std::vector<PlateMode>& numbers) {
  Radiator radiator;
  radiator.length = length;
  radiator.width = width;
  int most = 0;
  for (const PlateMode& mode : numbers) {
    most = std::max(most, mode.across);
    const double turning = mode.along * M_PI / length;
    radiator.turning_along = std::max(radiator.turning_along, turning);
    radiator.modes.push_back({[turning](double x) { return std::sin(turning * x); },
                              static_cast<std::size_t>(mode.across - 1)});
  }
  for (int n = 1; n <= most; ++n)
    radiator.across.emplace_back(
        [turning = n * M_PI / width](double y) { return std::sin(turning * y); });
  radiator.turning_across = most * M_PI / width;
  return radiator;
}

Radiator face_of(const Body& body, const BodySpec& spec) {
  if (spec.kind != BodyKind::plate) return strip(body, spec.width);
  std::vector<PlateMode> numbers;
  for (const PinnedPlateMode& mode : plate_modes(spec, static_cast<int>(body.modes.size())))
    numbers.push_back({mode.m, mode.n});
  Radiator radiator = supported_plate(spec.length, spec.width, numbers);
  for (RadiatingMode& mode : radiator.modes)
    mode.along = [along = mode.along, size = 2 / std::sqrt(spec.length * spec.width)](double x) {
      return size * along(x);
    };
  return radiator;
}

std::vector<double> squared_shapes(const Radiator& radiator) {
  const Points x = even_points(0, radiator.length, 2 * radiator.turning_along);
  const Points y = even_points(0, radiator.width, 2 * radiator.turning_across);
  std::vector<double> of_across;
  for (const LineShape& shape : radiator.across) of_across.push_back(squared(shape, y));
  std::vector<double> found;
  for (const RadiatingMode& mode : radiator.modes)
    found.push_back(squared(mode.along, x) * of_across[mode.across]);
  return found;
}

}  // namespace ra2d
