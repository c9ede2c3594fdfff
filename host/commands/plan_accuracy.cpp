// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/print.hpp"
#include "host/device/backend.hpp"
#include "host/savings/savings.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {

int plan_accuracy_command(const CommonOptions& common, double accuracy, double budget,
                          std::filesystem::path output) {
  const Scene scene = read_scene(common.scene, common.overrides);
  if (output.empty()) output = common.scene.stem().string() + "-planned.toml";
  require_derived_output(output, files_of(scene));

  SavingsOptions options;
  options.accuracy = accuracy;
  options.budget = budget;
  const bool terminal = isatty(STDERR_FILENO) != 0 && !common.quiet;
  if (terminal) options.progress = [](const std::string& what) { show(what); };
  say_doubts(make_model(scene).doubts, common.quiet);
  const Backend backend(common.threads, common.device);
  const Savings savings = find_savings(scene, options);
  if (terminal) show({});
  print_text(describe(savings));
  write_text(output, planned_scene(savings));
  if (!common.quiet) print("written    {}\n", printable(output.string()));
  return done;
}

}  // namespace ra2d
