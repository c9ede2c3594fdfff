// SPDX-License-Identifier: BSD-3-Clause
#include "host/body/body.hpp"

#include <algorithm>

#include "host/body/beam.hpp"

namespace ra2d {

// Every body of a scene is a beam so far. Another kind is chosen here.
Body make_body(const BodySpec& spec) { return make_beam(spec); }
int mode_count(const BodySpec& spec, int most) { return beam_mode_count(spec, most); }
double elastic_frequency(const BodySpec& spec, int k) { return beam_frequency(spec, k); }

double ModeShape::mean_square(int nodes, double spacing) const {
  double square = 0;
  for (int n = 0; n < nodes; ++n) {
    double psi = 0;
    evaluate(n * spacing, 1, &psi);
    square += psi * psi;
  }
  return square / nodes;
}

double highest_wave_number(const Body& body) {
  double highest = 0;
  for (const BodyMode& mode : body.modes) highest = std::max(highest, mode.shape->wave_number());
  return highest;
}

double shape_at(const BodyMode& mode, double x) {
  double psi = 0;
  mode.shape->evaluate(x, 1, &psi);
  return psi;
}

}  // namespace ra2d
