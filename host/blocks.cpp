// SPDX-License-Identifier: BSD-3-Clause
#include "host/blocks.hpp"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace ra2d {
namespace {

constexpr int most_threads = 4;

int processors() {
  cpu_set_t mine;
  return sched_getaffinity(0, sizeof mine, &mine) == 0 ? CPU_COUNT(&mine) : 1;
}

}  // namespace

void in_blocks(
    std::size_t count, std::size_t size,
    const std::function<void(std::size_t block, std::size_t first, std::size_t last)>& work) {
  const std::size_t blocks = (count + size - 1) / size;
  std::atomic<std::size_t> next = 0;
  std::exception_ptr fault;
  std::mutex one_fault;
  const auto take_blocks = [&] {
    try {
      for (std::size_t block; (block = next++) < blocks;)
        work(block, block * size, std::min(count, (block + 1) * size));
    } catch (...) {
      next = blocks;
      const std::lock_guard lock(one_fault);
      if (!fault) fault = std::current_exception();
    }
  };
  std::vector<std::jthread> threads;
  if (blocks > 1) try {
      const std::size_t wanted =
          std::min<std::size_t>(blocks, std::min(processors(), most_threads));
      while (threads.size() + 1 < wanted) threads.emplace_back(take_blocks);
    } catch (const std::system_error&) {  // no more than these
    }
  take_blocks();
  threads.clear();
  if (fault) std::rethrow_exception(fault);
}

}  // namespace ra2d
