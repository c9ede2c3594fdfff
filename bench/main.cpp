// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>

#include "bench/program.hpp"
#include "bench/timing.hpp"
#include "host/device/backend.hpp"

namespace ra2d::bench {

std::vector<Program>& programs() {
  static std::vector<Program> all;
  return all;
}

namespace {

/// The only one that there is, or the one that the first argument names, which is taken away.
const Program* chosen(int& argc, char** argv) {
  if (programs().size() == 1) return &programs()[0];
  const std::string name = argc > 1 ? argv[1] : "";
  std::string names;
  for (const Program& program : programs()) {
    if (program.name == name) {
      for (int i = 1; i + 1 < argc; ++i) argv[i] = argv[i + 1];
      argv[--argc] = nullptr;
      return &program;
    }
    names += " " + program.name;
  }
  fmt::print(stderr, "{}: the first argument names one of{}\n", argv[0], names);
  return nullptr;
}

int run(const Program& program, int argc, char** argv) {
  const Backend backend;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  add_context();
  if (program.ready && !program.ready()) return 1;
  program.add_cases();
  RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  if (program.table) fmt::print(stderr, "{}", program.table(reporter));
  return reporter.failed() ? 1 : 0;
}

}  // namespace
}  // namespace ra2d::bench

int main(int argc, char** argv) {
  const ra2d::bench::Program* program = ra2d::bench::chosen(argc, argv);
  if (program == nullptr) return 2;
  try {
    return ra2d::bench::run(*program, argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
