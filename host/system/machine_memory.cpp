// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/machine_memory.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace ra2d {

std::int64_t machine_memory() {
  std::int64_t most = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  for (const char* file :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"})
    if (std::int64_t limit = 0; std::ifstream(file) >> limit && limit > 0)  // or the word "max"
      most = std::min(most, limit);
  return most;
}

}  // namespace ra2d
