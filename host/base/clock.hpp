// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>

namespace ra2d {

/// For durations: it never jumps.
using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace ra2d
