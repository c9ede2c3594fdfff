// SPDX-License-Identifier: BSD-3-Clause
#include "host/result/record.hpp"

#include <cmath>
#include <limits>

namespace ra2d {

bool is_finite(const SampleBlock& block) {
  constexpr double most = std::numeric_limits<double>::max();
  unsigned faults = 0;
  for (const auto column :
       {&SampleBlock::resonator_displacement, &SampleBlock::resonator_velocity,
        &SampleBlock::slider_displacement, &SampleBlock::slider_velocity, &SampleBlock::force,
        &SampleBlock::probe_displacement, &SampleBlock::probe_velocity,
        &SampleBlock::slider_probe_displacement, &SampleBlock::slider_probe_velocity,
        &SampleBlock::kinetic, &SampleBlock::elastic, &SampleBlock::contact,
        &SampleBlock::damping_loss, &SampleBlock::sliding_work, &SampleBlock::load_work})
    // no early end: so the compiler takes many at once
    for (const double value : block.*column) faults |= !(std::abs(value) <= most);
  return faults == 0;
}

}  // namespace ra2d
