// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/host_threads.hpp"

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

std::atomic<int> most_threads = 0;  // 0: none
thread_local int own_share = 0;     // 0: all

int processors() {
  cpu_set_t mine;
  return sched_getaffinity(0, sizeof mine, &mine) == 0 ? std::max(1, CPU_COUNT(&mine)) : 1;
}

}  // namespace

int host_threads() {
  if (own_share > 0) return own_share;
  return most_threads > 0 ? most_threads.load() : processors();
}

void limit_host_threads(int most) { most_threads = most; }

ShareOfThreads::ShareOfThreads(int of_all, int workers) : before_{own_share} {
  own_share = std::max(1, of_all / std::max(1, workers));
}
ShareOfThreads::~ShareOfThreads() { own_share = before_; }

void on_threads(int most, std::size_t count, const std::function<void(std::size_t)>& work) {
  const int all = host_threads();
  const auto wanted = static_cast<int>(std::min<std::size_t>(
      count, static_cast<std::size_t>(std::clamp(all, 1, std::max(1, most)))));
  std::atomic<std::size_t> next = 0;
  std::exception_ptr fault;
  std::mutex one_fault;
  const auto take = [&] {
    const ShareOfThreads share(all, wanted);
    try {
      for (std::size_t i; (i = next++) < count;) work(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(one_fault);
      if (!fault) fault = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    try {
      while (static_cast<int>(threads.size()) + 1 < wanted) threads.emplace_back(take);
    } catch (const std::system_error&) {  // no more than these
    }
    take();
  }
  if (fault) std::rethrow_exception(fault);
}

}  // namespace ra2d
