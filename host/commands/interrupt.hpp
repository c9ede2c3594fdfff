// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>

namespace ra2d {

/// From now on the first SIGINT or SIGTERM sets the flag, for a clean end; the second has its usual
/// effect.
const std::atomic<bool>& catch_interrupts();

}  // namespace ra2d
