// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "bench/report.hpp"

/// Interface of a benchmark program. main.cpp is linked with one of them. In a bundle it is linked
/// with all, and its first argument names the one to run.
namespace ra2d::bench {

struct Program {
  std::string name;
  void (*add_cases)();
  bool (*ready)() = nullptr;                             // before anything is timed; false ends it
  std::string (*table)(const RatioReporter&) = nullptr;  // printed at the end
};

std::vector<Program>& programs();

/// Adds a program to those that main.cpp finds.
struct Added {
  explicit Added(const Program& program) { programs().push_back(program); }
};

}  // namespace ra2d::bench
