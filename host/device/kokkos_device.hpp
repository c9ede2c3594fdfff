// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "host/device/device.hpp"

namespace ra2d {

/// The default execution space that Kokkos was started with, as a device: its memory space, pinned
/// memory of the host, an instance of the execution space for each queue. On a CPU both are the
/// host's memory (for tests: there scenes are marched past it, each by the thread that drains it).
std::unique_ptr<Device> make_kokkos_device();

}  // namespace ra2d
