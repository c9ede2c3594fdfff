// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/chart/accuracy_chart.hpp"
#include "host/chart/chart_files.hpp"
#include "host/chart/peers.hpp"
#include "host/chart/stability_chart.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/print.hpp"
#include "host/device/backend.hpp"
#include "host/plot/draw.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"
#include "paper_scene.hpp"

namespace ra2d {

namespace {

void check_prefix(const std::string& prefix, const char* example) {
  const std::filesystem::path target(prefix);
  if (!target.has_filename() || std::filesystem::is_directory(target))
    throw RequestError(
        fmt::format("-o {}: a folder: expected the beginning of the files' names, like {}{}",
                    prefix, target.has_filename() ? prefix + "/" : prefix, example));
}

/// Before anything is run: every file that will be written. `inputs` must not be among them.
void require_outputs(std::vector<std::string> outputs,
                     const std::vector<std::filesystem::path>& inputs, bool plot,
                     const std::string& picture) {
  if (plot) outputs.push_back(picture);
  for (const std::string& output : outputs) require_derived_output(output, inputs);
}

/// The scene that was asked for, or the paper's own.
Scene chart_scene(const CommonOptions& common) {
  return common.scene.empty() ? parse_scene(paper_scene, "dang2012.toml", common.overrides)
                              : read_scene(common.scene, common.overrides);
}

/// Names of a chart's tables.
std::vector<std::string> table_names(const ChartKind& kind, const std::string& prefix) {
  std::vector<std::string> names;
  for (const std::filesystem::path& file : chart_files(kind, prefix))
    names.push_back(file.string());
  return names;
}

/// Draws a picture of tables that have been written.
void draw_chart(const ChartKind& kind, const std::vector<std::string>& tables,
                const std::string& picture, const std::string& texts) try {
  draw_picture(kind.script, tables, picture);
} catch (const FileError& fault) {
  throw FileError(
      fmt::format("the picture {} was not made: {}. The table is in {}; --no-plot asks for no "
                  "picture",
                  picture, fault.what(), texts));
}

void print_written(const CommonOptions& common, const std::string& texts, bool plot,
                   const std::string& picture) {
  if (!common.quiet)
    print("\nwritten: {}{}\n", printable(texts),
          plot ? "; the picture: " + printable(picture) : "");
}

}  // namespace

int chart_stability_command(const CommonOptions& common, const std::string& prefix, bool plot) {
  check_prefix(prefix, "stability");
  const Scene scene = chart_scene(common);
  if (!(scene.time.step > 0))
    throw refusal(scene, "time.step",
                  "missing: the chart places the scene's modes by its step, which time.scheme = "
                  "\"adaptive\" does without (add one, or --set time.step=1e-8)");
  const std::vector<std::string> tables = table_names(stability_tables(), prefix);
  const std::string picture = prefix + ".png";
  require_outputs(tables, files_of(scene), plot, picture);
  const Model model = make_model(scene);
  say_doubts(model.doubts, common.quiet);
  const std::string modes = modes_csv(model);
  const Backend backend(common.threads, common.device);
  const std::vector<Limit> limits = make_limits();
  print_text(describe(limits));

  write_text(tables[0], limits_csv(limits));
  write_text(tables[1], regions_csv());
  write_text(tables[2], modes);
  const std::string texts = fmt::format("{}, {} and {}", tables[0], tables[1], tables[2]);
  if (plot) draw_chart(stability_tables(), tables, picture, texts);
  print_written(common, texts, plot, picture);
  return done;
}

int chart_accuracy_command(const CommonOptions& common, const std::string& prefix, bool plot,
                           double budget, const std::filesystem::path& peers) {
  check_prefix(prefix, "accuracy");
  AccuracyOptions options;
  options.budget = budget;
  options.peers = peers.empty() ? find_peers() : peers;
  if (!peers.empty() && access(peers.c_str(), X_OK) != 0)
    throw RequestError(
        fmt::format("--peers {}: no program that can be run: expected ra2d_peers, as "
                    "the build makes it in bench/peers",
                    peers.string()));
  const bool shown = isatty(STDERR_FILENO) != 0 && !common.quiet;
  if (shown) options.progress = [](const std::string& what) { show(what + " ..."); };
  const Scene scene = chart_scene(common);
  const std::vector<std::string> tables = table_names(accuracy_tables(), prefix);
  const std::string picture = prefix + ".png";
  std::vector<std::filesystem::path> inputs = files_of(scene);
  if (!options.peers.empty()) inputs.push_back(options.peers);
  require_outputs(tables, inputs, plot, picture);
  say_doubts(make_model(scene).doubts, common.quiet);
  const Backend backend(common.threads, common.device);
  const AccuracyChart chart = measure_accuracy(scene, options);
  if (shown) show({});
  print_text(describe(chart));

  const Context context = chart_context(scene, chart);
  write_text(tables[0], points_csv(chart, context));
  write_text(tables[1], long_runs_csv(chart, context));
  const std::string texts = fmt::format("{} and {}", tables[0], tables[1]);
  if (plot) draw_chart(accuracy_tables(), tables, picture, texts);
  print_written(common, texts, plot, picture);
  return done;
}

}  // namespace ra2d
