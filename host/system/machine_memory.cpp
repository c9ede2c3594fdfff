// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/machine_memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

namespace ra2d {
namespace {

struct ProcessMemory {
  std::int64_t addresses = 0, resident = 0;  // bytes
};

ProcessMemory memory_of_process() {
  std::int64_t addresses = 0, resident = 0;  // pages
  std::ifstream("/proc/self/statm") >> addresses >> resident;
  const std::int64_t page = sysconf(_SC_PAGESIZE);
  return {addresses * page, resident * page};
}

}  // namespace

std::int64_t resident_memory() { return memory_of_process().resident; }

std::int64_t machine_memory() {
  std::int64_t most = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  return std::min(most, group_memory("/proc/self/cgroup", "/sys/fs/cgroup"));
}

std::int64_t group_memory(const std::filesystem::path& groups, const std::filesystem::path& root) {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  const auto read = [&](const std::filesystem::path& file) {
    if (std::int64_t limit = 0; std::ifstream(file) >> limit && limit > 0)  // or the word "max"
      least = std::min(least, limit);
  };
  const auto read_all = [&](std::filesystem::path group) {
    for (;; group = group.parent_path()) {
      read(root / group / "memory.max");                        // version 2
      read(root / "memory" / group / "memory.limit_in_bytes");  // version 1
      if (group.empty()) return;
    }
  };
  read_all({});  // a container sees its own group as the root, whatever it is called outside
  std::ifstream lines(groups);
  // number:kinds:/path, in version 2 without kinds
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t path = line.find(":/", line.find(':') + 1); path != std::string::npos)
      read_all(std::filesystem::path(line.substr(path + 1)).relative_path());
  return least;
}

std::int64_t attainable_memory() {
  std::int64_t most = machine_memory();
  // That limit counts addresses, also those of memory that is never touched. (A run of 6.25 million
  // nodes, 0.68 GB by areal_memory, needs 0.89 GB of them.) Where none are left HDF5 may crash.
  constexpr double touched = 0.7;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    const auto taken = static_cast<double>(memory_of_process().addresses);
    const double left = touched * (static_cast<double>(limit.rlim_cur) - taken);
    most = std::min(most, std::max<std::int64_t>(0, std::llround(left)));
  }
  return most;
}

std::int64_t available_memory() {
  std::int64_t most = attainable_memory();
  std::ifstream system("/proc/meminfo");
  for (std::string word; system >> word;)
    if (std::int64_t kibibytes = 0; word == "MemAvailable:" && system >> kibibytes)
      most = std::min(most, 1024 * kibibytes);
  return most;
}

}  // namespace ra2d
