// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

namespace ra2d {

/// Bytes of memory that this process may use: in a container less than the machine has.
std::int64_t machine_memory();

/// Of it, what is free now, and within the process's own limit (ulimit -v).
std::int64_t available_memory();

}  // namespace ra2d
