// SPDX-License-Identifier: BSD-3-Clause
#include "host/body/body.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "host/base/errors.hpp"
#include "host/body/beam.hpp"
#include "host/body/block.hpp"
#include "host/body/plate.hpp"

namespace ra2d {
namespace {

constexpr double gravity = 9.80665;  // m/s^2, standard

}  // namespace

Body make_body(const BodySpec& spec) {
  switch (spec.kind) {
    case BodyKind::plate:
      return make_plate(spec);
    case BodyKind::block:
      return make_block(spec);
    case BodyKind::beam:
      break;
  }
  return make_beam(spec);
}

int rigid_mode_count(const BodySpec& spec) {
  if (spec.support != Support::free) return 0;
  return spec.kind == BodyKind::block ? 3 : 2;
}

int mode_count(const BodySpec& spec, int most) {
  switch (spec.kind) {
    case BodyKind::plate:
      return static_cast<int>(plate_modes(spec, most).size());
    case BodyKind::block:
      return rigid_mode_count(spec);
    case BodyKind::beam:
      break;
  }
  return beam_mode_count(spec, most);
}

double elastic_frequency(const BodySpec& spec, int k) {
  switch (spec.kind) {
    case BodyKind::plate:
      return plate_frequency(spec, k);
    case BodyKind::block:
      return std::numeric_limits<double>::infinity();
    case BodyKind::beam:
      break;
  }
  return beam_frequency(spec, k);
}

void check_mode_count(int elastic_modes) {
  if (elastic_modes > most_elastic_modes)
    throw RequestError("max_frequency keeps more than " + std::to_string(most_elastic_modes) +
                       " elastic modes; lower it, or give modes");
}

double load_force(const BodySpec& spec, double mass) {
  return spec.load_is_weight ? spec.load_weights * (mass * gravity) : spec.load;
}

void ModeShape::evaluate_across(double, int derivatives, double* out) const {
  std::fill_n(out, derivatives, 0.0);
  out[0] = 1;
}

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

double shape_at(const BodyMode& mode, double x, double y) {
  double across = 0;
  mode.shape->evaluate_across(y, 1, &across);
  return shape_at(mode, x) * across;
}

}  // namespace ra2d
