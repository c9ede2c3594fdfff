// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/machine_memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

namespace ra2d {

std::int64_t machine_memory() {
  std::int64_t most = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  for (const char* file :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"})
    if (std::int64_t limit = 0; std::ifstream(file) >> limit && limit > 0)  // or the word "max"
      most = std::min(most, limit);
  return most;
}

std::int64_t available_memory() {
  std::int64_t most = machine_memory();
  std::ifstream system("/proc/meminfo");
  for (std::string word; system >> word;)
    if (std::int64_t kibibytes = 0; word == "MemAvailable:" && system >> kibibytes)
      most = std::min(most, 1024 * kibibytes);
  // That limit counts addresses, also those of memory that is never touched. (A run of 6.25 million
  // nodes, 0.68 GB by areal_memory, needs 0.89 GB of them.) Where none are left HDF5 may crash.
  constexpr double touched = 0.7;
  rlimit limit{};
  std::int64_t pages = 0;
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      std::ifstream("/proc/self/statm") >> pages) {
    const auto taken = static_cast<double>(pages * sysconf(_SC_PAGESIZE));
    const double left = touched * (static_cast<double>(limit.rlim_cur) - taken);
    most = std::min(most, std::max<std::int64_t>(0, std::llround(left)));
  }
  return most;
}

}  // namespace ra2d
