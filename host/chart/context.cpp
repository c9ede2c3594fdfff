// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/context.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <fstream>
#include <thread>

#include "host/base/version.hpp"
#include "host/device/backend.hpp"

namespace ra2d {
namespace {

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name"))
      if (const std::size_t colon = line.find(": "); colon != std::string::npos)
        return line.substr(colon + 2);
  return "unknown";
}

}  // namespace

std::string compiler_name() {
#if defined(__clang__)
  return "Clang " __clang_version__;
#elif defined(__GNUC__)
  return "GCC " __VERSION__;
#else
  return "unknown";
#endif
}

std::vector<std::pair<std::string, std::string>> timing_context() {
  return {{"ra2d", version() + " (" + commit() + ")"},
          {"compiler", compiler_name()},
          {"processor",
           fmt::format("{}, {} cores", processor_name(), std::thread::hardware_concurrency())},
          {"backend", fmt::format("{}, {} thread{}", backend_name(), backend_threads(),
                                  backend_threads() == 1 ? "" : "s")},
          {"date", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))}};
}

}  // namespace ra2d
