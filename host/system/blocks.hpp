// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <functional>

namespace ra2d {

/// Calls work(block, first, last) for the blocks of `size` that 0, ..., count - 1 fall into, the
/// last one shorter, on the threads that the caller may use (host/system/host_threads.hpp), four at
/// the most. Rethrows the first exception once all have ended.
void in_blocks(
    std::size_t count, std::size_t size,
    const std::function<void(std::size_t block, std::size_t first, std::size_t last)>& work);

}  // namespace ra2d
