// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>

namespace ra2d {

/// Steps to a launch, from how long the last one took: a fifth of a second unless asked otherwise,
/// so that progress and interrupts are prompt.
class LaunchLength {
 public:
  explicit LaunchLength(double seconds = 0.2) : seconds_{seconds} {}
  std::int64_t steps() const { return steps_; }
  void took(std::int64_t steps, double seconds) {
    if (steps <= 0) return;
    const double wanted = seconds_ * static_cast<double>(steps) / std::max(seconds, 1e-6);
    steps_ = static_cast<std::int64_t>(
        std::clamp(wanted, 0.25 * static_cast<double>(steps_), 4.0 * static_cast<double>(steps_)));
    steps_ = std::max<std::int64_t>(steps_, 1);
  }

 private:
  double seconds_;
  std::int64_t steps_ = 10000;
};

}  // namespace ra2d
