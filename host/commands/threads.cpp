// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/threads.hpp"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <latch>
#include <system_error>
#include <thread>
#include <vector>

#include "host/commands/print.hpp"

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

/// How many threads the system starts besides this one, up to so many. OpenMP ends the program
/// where it gets fewer than it wants.
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

int usable_threads(int wanted, std::string& why) {
  const int processors = processors_here();
  int threads = std::min({wanted, processors, most_threads});
  if (threads < wanted)
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

void limit_threads(int& threads, bool quiet) {
  std::string why;
  threads = usable_threads(threads, why);
  if (!why.empty() && !quiet)
    say(fmt::format("{} thread{}: {}", threads, threads == 1 ? "" : "s", why));
}

}  // namespace ra2d
