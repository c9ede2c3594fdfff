// SPDX-License-Identifier: BSD-3-Clause
#include "host/body/block.hpp"

#include <cmath>
#include <limits>
#include <memory>

#include "host/base/errors.hpp"
#include "host/body/areal_shape.hpp"

namespace ra2d {

Body make_block(const BodySpec& spec) {
  if (spec.support == Support::pinned)
    throw RequestError("a block cannot be pinned; use \"rigid\" or \"free\"");
  if (spec.modes.value_or(0) > 0)
    throw RequestError("a block has no elastic modes; leave modes out, or set it to 0");
  const double area = spec.length * spec.width, mass_per_area = spec.density * spec.thickness;
  Body block;
  block.length = spec.length;
  block.mass = mass_per_area * area;
  block.load_force = load_force(spec, block.mass);
  if (spec.support == Support::rigid) return block;

  const double even = 1 / std::sqrt(area), tilted = std::sqrt(3 / area);  // at an edge
  ArealShape heave;
  heave.along.length = spec.length;
  heave.width = spec.width;
  ArealShape pitch = heave, roll = heave;
  heave.along.constant = heave.along.highest = even;
  pitch.along.constant = -tilted;
  pitch.along.slope = 2 * tilted / spec.length;
  pitch.along.highest = tilted * (1 + 8 * std::numeric_limits<double>::epsilon());  // roundings
  roll.along.constant = roll.along.highest = tilted;
  roll.offset = -1;
  roll.tilt = 2 / spec.width;
  for (const ArealShape& shape : {heave, pitch, roll})
    block.modes.push_back({{0, spec.damping, mass_per_area}, std::make_shared<ArealShape>(shape)});
  block.load = {block.load_force / std::sqrt(area), 0, 0};
  return block;
}

}  // namespace ra2d
