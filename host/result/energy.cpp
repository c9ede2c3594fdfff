// SPDX-License-Identifier: BSD-3-Clause
#include "host/result/energy.hpp"

#include <algorithm>
#include <cmath>

namespace ra2d {

void EnergyAccount::add(const SampleBlock& b) {
  for (std::size_t i = 0; i < b.time.size(); ++i) {
    if (b.time[i] < from_) continue;
    const double stored = b.kinetic[i] + b.elastic[i] + b.contact[i];
    if (!begun_) {
      start_ = stored;
      damping_loss_ = b.damping_loss[i];
      sliding_work_ = b.sliding_work[i];
      load_work_ = b.load_work[i];
    }
    begun_ = true;
    if (b.contact[i] > 0) {
      contact_ += b.contact[i];
      bodies_ += b.kinetic[i] + b.elastic[i];
    }
    balance_.samples = std::min(2, balance_.samples + 1);
    const double lost = b.damping_loss[i] - damping_loss_;
    const double slid = b.sliding_work[i] - sliding_work_, loaded = b.load_work[i] - load_work_;
    balance_.residual = stored + lost - slid - loaded - start_;
    balance_.turnover =
        std::max({balance_.turnover, stored, lost, std::abs(slid), std::abs(loaded)});
  }
}

}  // namespace ra2d
