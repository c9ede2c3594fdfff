// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "host/model/model.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {

/// Ticks to a launch, from how long the last one took. The first is short: nobody knows yet what a
/// tick costs, and --max-wall and checkpoints wait for the end of a launch.
class LaunchLength {
 public:
  explicit LaunchLength(const Model& model)
      : steps_{(is_adaptive(model.scene) ? std::llround(1e-6 / model.tick) : 10000) /
               (1 + std::ssize(model.scene.resonator.moving_forces))},  // each as costly as a step
        most_{std::max<std::int64_t>(model.steps, 1)} {
    steps_ = std::clamp<std::int64_t>(steps_, 1, most_);
  }
  std::int64_t steps() const { return steps_; }
  /// A launch took so long; the next one is to take about `wanted` seconds.
  void took(std::int64_t steps, double seconds, double wanted) {
    if (steps <= 0) return;
    const double next = wanted * static_cast<double>(steps) / std::max(seconds, 1e-6);
    steps_ = static_cast<std::int64_t>(
        std::clamp(next, 0.25 * static_cast<double>(steps_), 4.0 * static_cast<double>(steps_)));
    steps_ = std::clamp<std::int64_t>(steps_, 1, most_);
  }

 private:
  std::int64_t steps_, most_;
};

}  // namespace ra2d
