// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <cstring>

/// Ends a portable build on a processor without the instructions that it is compiled for, before it
/// meets the first of them. This file is compiled for any x86-64 processor (host/CMakeLists.txt).
namespace {

__attribute__((constructor(101))) void require_processor() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
      __builtin_cpu_supports("bmi2"))
    return;
  const char* const message =
      "ra2d: this processor lacks AVX2, FMA or BMI2, which this build needs (processors since 2013 "
      "to 2015 have them). A build from the source, on this machine, does without\n";
  if (write(STDERR_FILENO, message, std::strlen(message)) < 0) _exit(4);
  _exit(3);
}

}  // namespace
