// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>

namespace ra2d {

/// Bytes of memory that this process may use: in a container, or in a job of Slurm, less than the
/// machine has.
std::int64_t machine_memory();

/// The least limit [bytes] of a process's control groups and of the groups that they are in;
/// without one the largest number. `groups` lists them as /proc/self/cgroup does, `root` is where
/// they are.
std::int64_t group_memory(const std::filesystem::path& groups, const std::filesystem::path& root);

/// Of it, what this process could have beside what it holds, were there no other: within its own
/// limit (ulimit -v).
std::int64_t attainable_memory();

/// Of that, what is free now.
std::int64_t available_memory();

/// Bytes of memory that this process holds; 0 where the system does not say.
std::int64_t resident_memory();

}  // namespace ra2d
