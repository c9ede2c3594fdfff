// SPDX-License-Identifier: BSD-3-Clause
#include "host/body/areal_shape.hpp"

#include <cmath>
#include <numbers>

namespace ra2d {

void ArealShape::evaluate(double x, int derivatives, double* out) const {
  along.evaluate(x, derivatives, out);
}

void ArealShape::evaluate_across(double y, int derivatives, double* out) const {
  if (wave == 0) {
    for (int j = 0; j < derivatives; ++j) out[j] = j == 0 ? offset + tilt * y : j == 1 ? tilt : 0;
    return;
  }
  // From the nearer edge, as along a beam: both edges stay equally exact.
  const bool mirrored = y > width / 2;
  const double phase = wave * (mirrored ? width - y : y);
  const double sin = std::sin(phase), cos = std::cos(phase);
  const double derivative[] = {sin, cos, -sin, -cos};
  const bool is_odd = std::lround(wave * width / std::numbers::pi) % 2 == 0;  // about the middle
  double power = mirrored && is_odd ? -1 : 1;
  for (int j = 0; j < derivatives; ++j) {
    out[j] = power * derivative[j % 4] + 0.0;  // no -0
    power *= mirrored ? -wave : wave;
  }
}

double ArealShape::across_rate() const { return wave + std::abs(tilt); }

double ArealShape::mean_square(int, double) const { return 1 / (along.length * width); }

void ArealShape::append_parameters(std::vector<double>& out) const {
  along.append_parameters(out);
  out.insert(out.end(), {width, wave, offset, tilt});
}

const ArealShape& areal_shape(const BodyMode& mode) {
  return dynamic_cast<const ArealShape&>(*mode.shape);
}

}  // namespace ra2d
