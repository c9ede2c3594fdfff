// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/blocks.hpp"

#include <algorithm>

#include "host/system/host_threads.hpp"

namespace ra2d {

void in_blocks(
    std::size_t count, std::size_t size,
    const std::function<void(std::size_t block, std::size_t first, std::size_t last)>& work) {
  constexpr int most_threads = 4;
  on_threads(most_threads, (count + size - 1) / size, [&](std::size_t block) {
    work(block, block * size, std::min(count, (block + 1) * size));
  });
}

}  // namespace ra2d
