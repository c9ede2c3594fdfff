// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/power_balance.hpp"

#include <numeric>

#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

double mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double rise(std::span<const double> values) { return values.back() - values.front(); }

}  // namespace

PowerBalance power_balance(const EnergyColumns& e, double seconds, ContactLaw law) {
  if (e.kinetic.size() < 2) {
    return {quiet_nan, quiet_nan, quiet_nan, quiet_nan, quiet_nan,
            quiet_nan, quiet_nan, quiet_nan, quiet_nan};
  }
  PowerBalance b;
  b.sliding = rise(e.sliding_work) / seconds;
  b.load = rise(e.load_work) / seconds;
  b.damping = rise(e.damping_loss) / seconds;
  b.storing = (rise(e.kinetic) + rise(e.elastic) + rise(e.contact)) / seconds;
  b.missing = b.storing + b.damping - b.sliding - b.load;
  b.given = law == ContactLaw::penalty
                ? b.sliding - rise(e.contact) / seconds
                : (rise(e.kinetic) + rise(e.elastic)) / seconds + b.damping - b.load;
  b.kinetic = mean(e.kinetic);
  b.elastic = mean(e.elastic);
  b.contact = mean(e.contact);
  return b;
}

}  // namespace ra2d
