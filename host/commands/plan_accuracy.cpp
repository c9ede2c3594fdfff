// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "host/accuracy/savings.hpp"
#include "host/commands/commands.hpp"
#include "host/errors.hpp"
#include "host/output_file.hpp"
#include "host/partial_file.hpp"
#include "host/run/batch.hpp"

namespace ra2d {

int plan_accuracy_command(const CommonOptions& common, double accuracy, double budget,
                          std::filesystem::path output) {
  if (!(accuracy > 0 && accuracy < 1))
    throw RequestError(fmt::format(
        "--accuracy {:g}: expected a relative accuracy between 0 and 1, like 0.01", accuracy));
  if (!(budget > 0 && budget < 1e9))
    throw RequestError(
        fmt::format("--budget {:g}: expected seconds of wall time, more than 0 and "
                    "less than 1e9, like 60",
                    budget));
  const Scene scene = read_scene(common.scene, common.overrides);
  if (output.empty()) output = common.scene.stem().string() + "-planned.toml";
  require_output(output, files_of(scene));

  SavingsOptions options;
  options.accuracy = accuracy;
  options.budget = budget;
  const bool terminal = isatty(STDERR_FILENO) != 0 && !common.quiet;
  if (terminal)
    options.progress = [](const std::string& what) {
      fmt::print(stderr, "\r{}\033[K", what);
      std::fflush(stderr);
    };
  const Backend backend(common.threads);
  const Savings savings = find_savings(scene, options);
  if (terminal) fmt::print(stderr, "\r\033[K");
  fmt::print("{}", describe(savings));
  std::fflush(stdout);
  write_text(output, planned_scene(savings));
  if (!common.quiet) fmt::print("written    {}\n", output.string());
  return done;
}

}  // namespace ra2d
