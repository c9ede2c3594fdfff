// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/threads.hpp"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <latch>
#include <system_error>
#include <thread>
#include <vector>

namespace ra2d {
namespace {

constexpr int most_threads = 512;  // of Kokkos' OpenMP backend, which aborts beyond

/// Processors that this process may use.
int processors_here() {
  cpu_set_t mine;
  return sched_getaffinity(0, sizeof mine, &mine) == 0
             ? CPU_COUNT(&mine)
             : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Threads that the system starts beside this one, up to so many: the runtime of OpenMP ends the
/// program where it gets one less than it wants.
int startable(int wanted) {
  std::latch all_tried(1);
  std::vector<std::thread> threads;
  try {
    while (static_cast<int>(threads.size()) < wanted)
      threads.emplace_back([&] { all_tried.wait(); });
  } catch (const std::system_error&) {  // no more than these
  }
  all_tried.count_down();
  for (std::thread& thread : threads) thread.join();
  return static_cast<int>(threads.size());
}

}  // namespace

int usable_threads(int asked, std::string& why) {
  const int processors = processors_here();
  int threads = std::min({asked, processors, most_threads});
  if (threads < asked)
    why = threads == processors
              ? fmt::format("there {} {} processor{} here", processors == 1 ? "is" : "are",
                            processors, processors == 1 ? "" : "s")
              : fmt::format("a march takes at most {}", most_threads);
  if (const int started = 1 + startable(threads - 1); started < threads) {
    threads = started;
    why = "the system starts no more (ulimit -u)";
  }
  return threads;
}

}  // namespace ra2d
