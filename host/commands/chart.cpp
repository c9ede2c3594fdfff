// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/chart/accuracy_chart.hpp"
#include "host/chart/chart_files.hpp"
#include "host/chart/peers.hpp"
#include "host/chart/stability_chart.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/python.hpp"
#include "host/commands/threads.hpp"
#include "host/device/backend.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"
#include "paper_scene.hpp"

namespace ra2d {
namespace {

struct ChartRequest {
  SceneOptions common;
  std::string prefix;
  bool no_plot = false;
  double budget = AccuracyOptions{}.budget;  // s of wall time
  /// The program ra2d_peers; empty: the one that was built beside this one, if there is one.
  std::filesystem::path peers;
};

void check_prefix(const std::string& prefix, const char* example) {
  const std::filesystem::path target(prefix);
  if (!target.has_filename() || std::filesystem::is_directory(target))
    throw RequestError(
        fmt::format("-o {}: a folder: expected the beginning of the files' names, like {}{}",
                    prefix, target.has_filename() ? prefix + "/" : prefix, example));
}

/// Before anything is run: whether every file can be written. None may be one of `inputs`.
void require_outputs(std::vector<std::string> outputs,
                     const std::vector<std::filesystem::path>& inputs, bool plot,
                     const std::string& picture) {
  if (plot) outputs.push_back(picture);
  for (const std::string& output : outputs) require_derived_output(output, inputs);
}

/// The scene that the line names, or the paper's own.
Scene chart_scene(const SceneOptions& common) {
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

constexpr const char* tables_are_written = "The tables are written; --no-plot asks for no picture";

/// Draws a picture of tables that have been written. Returns the exit status.
int draw_chart(const ChartKind& kind, const std::vector<std::string>& tables,
               const std::string& picture, bool quiet) try {
  nlohmann::ordered_json request{{"subject", "chart"}, {"chart", kind.name}, {"quiet", quiet}};
  for (const std::string& table : tables) request["files"].push_back(path_text(table));
  const int status = make_picture(std::move(request), picture);
  if (status != exit_status::done) say(tables_are_written);
  return status;
} catch (const FileError& fault) {
  throw FileError(fmt::format("{}. {}", fault.what(), tables_are_written));
}

void print_written(const SceneOptions& common, const std::string& texts, bool plot,
                   const std::string& picture) {
  if (!common.quiet)
    print("\nwritten: {}{}\n", printable(texts),
          plot ? "; the picture: " + printable(picture) : "");
}

int chart_stability(const ChartRequest& request) {
  const SceneOptions& common = request.common;
  const std::string& prefix = request.prefix;
  check_prefix(prefix, "stability");
  const Scene scene = chart_scene(common);
  if (!(scene.time.step > 0))
    throw refusal(scene, "time.step",
                  "missing: the chart places the scene's modes by its step, which time.scheme = "
                  "\"adaptive\" does without (add one, or --set time.step=1e-8)");
  const std::vector<std::string> tables = table_names(stability_tables(), prefix);
  const std::string picture = prefix + ".png";
  require_outputs(tables, files_of(scene), !request.no_plot, picture);
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
  const int status = request.no_plot
                         ? exit_status::done
                         : draw_chart(stability_tables(), tables, picture, common.quiet);
  if (status == exit_status::done) print_written(common, texts, !request.no_plot, picture);
  return status;
}

int chart_accuracy(const ChartRequest& request) {
  const SceneOptions& common = request.common;
  const std::string& prefix = request.prefix;
  const std::filesystem::path& peers = request.peers;
  check_prefix(prefix, "accuracy");
  AccuracyOptions options;
  options.budget = request.budget;
  options.peers = peers.empty() ? find_peers() : peers;
  if (!peers.empty() && access(peers.c_str(), X_OK) != 0)
    throw RequestError(
        fmt::format("--peers {}: no program that can be run: expected ra2d_peers, as "
                    "the build makes it in bench/peers",
                    peers.string()));
  const bool shown = shows_progress(common.quiet);
  if (shown) options.progress = [](const std::string& what) { show(what + " ..."); };
  const Scene scene = chart_scene(common);
  const std::vector<std::string> tables = table_names(accuracy_tables(), prefix);
  const std::string picture = prefix + ".png";
  std::vector<std::filesystem::path> inputs = files_of(scene);
  if (!options.peers.empty()) inputs.push_back(options.peers);
  require_outputs(tables, inputs, !request.no_plot, picture);
  say_doubts(make_model(scene).doubts, common.quiet);
  const Backend backend(common.threads, common.device);
  const AccuracyChart chart = measure_accuracy(scene, options);
  if (shown) show({});
  print_text(describe(chart));

  const Context context = chart_context(scene, chart);
  write_text(tables[0], points_csv(chart, context));
  write_text(tables[1], long_runs_csv(chart, context));
  const std::string texts = fmt::format("{} and {}", tables[0], tables[1]);
  const int status = request.no_plot ? exit_status::done
                                     : draw_chart(accuracy_tables(), tables, picture, common.quiet);
  if (status == exit_status::done) print_written(common, texts, !request.no_plot, picture);
  return status;
}

/// Options of both charts.
void add_chart_options(CLI::App& command, ChartRequest& request) {
  command.add_option("-o,--output", request.prefix, "how the files' names begin")
      ->type_name("PREFIX")
      ->check(path())
      ->capture_default_str();
  command.add_flag("--no-plot", request.no_plot, "leave the picture out");
  add_scene_options(command, request.common);
}

void add_stability(CLI::App& chart, ChosenCommand& chosen) {
  const auto request = std::make_shared<ChartRequest>();
  request->prefix = "stability";
  CLI::App* stability = chart.add_subcommand(
      "stability",
      "limits of stability of every scheme, free and in contact, theory beside measurement: prints "
      "the table; writes PREFIX.csv, PREFIX-regions.csv, PREFIX-modes.csv and, drawn with Python's "
      "matplotlib, PREFIX.png");
  add_scene(*stability, request->common,
            "scene whose modes are shown in the picture: file (TOML) or name [the paper's own]");
  add_chart_options(*stability, *request);
  stability->callback([request, &chosen] {
    chosen.run = [request] {
      limit_threads(request->common.threads, request->common.quiet);
      return chart_stability(*request);
    };
  });
}

void add_accuracy(CLI::App& chart, ChosenCommand& chosen) {
  const auto request = std::make_shared<ChartRequest>();
  request->prefix = "accuracy";
  CLI::App* accuracy = chart.add_subcommand(
      "accuracy",
      "speed against accuracy of every scheme and contact law, with a ladder of steps or "
      "tolerances: prints what reaches an error at the least cost; writes PREFIX.csv, "
      "PREFIX-long.csv (level and shocks over a long stretch) and PREFIX.png");
  add_scene(*accuracy, request->common, "scene to be run: file (TOML) or name [the paper's own]");
  accuracy->add_option("--budget", request->budget, "wall time that it may take, roughly")
      ->type_name("SECONDS")
      ->check(number_from(0.1, 1e6, "from 0.1 to 1e6"))
      ->capture_default_str();
  accuracy
      ->add_option("--peers", request->peers,
                   "program that confirms the reference with other integrators [bench/peers/"
                   "ra2d_peers beside this one, where it was built]")
      ->type_name("PATH")
      ->check(path());
  add_chart_options(*accuracy, *request);
  accuracy->callback([request, &chosen] {
    chosen.run = [request] {
      limit_threads(request->common.threads, request->common.quiet);
      return chart_accuracy(*request);
    };
  });
}

}  // namespace

void add_chart(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* chart = app.add_subcommand("chart", "all schemes side by side");
  chart->require_subcommand(1);
  add_stability(*chart, chosen);
  add_accuracy(*chart, chosen);
}

}  // namespace ra2d
