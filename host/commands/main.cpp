// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <exception>
#include <new>
#include <string_view>
#include <utility>

#include "host/chart/accuracy_chart.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/interrupt.hpp"
#include "host/errors.hpp"

namespace {

/// Commands of the contract that are not built yet: refused by name.
constexpr std::array<std::string_view, 4> coming{"surface", "analyze", "study", "plot"};

bool is_coming(const std::string& words) {
  return std::find(coming.begin(), coming.end(), words) != coming.end();
}

void add_common(CLI::App& command, ra2d::CommonOptions& common) {
  command
      .add_option("--set", common.overrides,
                  "overrides one value of the scene, e.g. --set contact.stiffness=1e14; repeatable")
      ->type_name("SECTION.KEY=VALUE")
      ->take_all()
      ->expected(1);
  command.add_option("--threads", common.threads, "threads; a single scene keeps one of them busy")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  command.add_flag("--quiet", common.quiet, "print nothing but what was asked for and errors");
}

/// Reads the command line and runs what it asks for.
int dispatch(int argc, char** argv) {
  using namespace ra2d;
  CLI::App app{
      "ra2d: friction noise of rough surfaces. Two beams slide past each other, their asperities "
      "collide, "
      "each collision rings the beams' modes.",
      "ra2d"};
  app.set_version_flag("--version", std::string("ra2d ") + RA2D_VERSION + " (" + RA2D_COMMIT + ")");
  app.require_subcommand(1);
  app.footer(
      "Exit status: 0 done; 2 the request is wrong; 3 the simulation failed; 4 a file could not be "
      "read or "
      "written; 128 + n ended by signal n (130: Ctrl-C).");

  CommonOptions common;
  std::filesystem::path output;
  CLI::App* run = app.add_subcommand("run", "simulates a scene and writes one HDF5 file");
  run->add_option("SCENE", common.scene, "scene file (TOML)")->required();
  add_common(*run, common);
  run->add_option("-o,--output", output,
                  "result file [SCENE's name with .h5, in the current folder]")
      ->type_name("OUT.h5");
  CLI::App* plan =
      app.add_subcommand("plan",
                         "says what would be modelled, and why; runs nothing unless --accuracy "
                         "asks what the scene could do without");
  plan->add_option("SCENE", common.scene, "scene file (TOML)")->required();
  double asked_accuracy = 0, plan_budget = 60;
  std::filesystem::path planned;
  CLI::Option* asked =
      plan->add_option("--accuracy", asked_accuracy,
                       "finds by runs the cheapest scheme and step, the fewest modes and the "
                       "coarsest spacing that keep level, rate of shocks and their median duration "
                       "within this relative accuracy, and writes the scene with them")
          ->type_name("A");
  plan->add_option("--budget", plan_budget, "with --accuracy: wall time it may take, roughly")
      ->type_name("SECONDS")
      ->capture_default_str()
      ->needs(asked);
  plan->add_option("-o,--output", planned,
                   "with --accuracy: the scene it writes [SCENE's name with -planned.toml, in the "
                   "current folder]")
      ->type_name("OUT.toml")
      ->needs(asked);
  add_common(*plan, common);
  CLI::App* chart = app.add_subcommand("chart", "all schemes side by side");
  chart->require_subcommand(1);
  CLI::App* stability = chart->add_subcommand(
      "stability",
      "limits of stability of every scheme, free and in contact, theory beside measurement: prints "
      "the table; writes PREFIX.csv, PREFIX-regions.csv, PREFIX-modes.csv and, drawn with Python's "
      "matplotlib, PREFIX.png");
  stability->add_option("SCENE", common.scene,
                        "scene whose modes are shown in the picture (TOML) [the paper's own]");
  CLI::App* accuracy = chart->add_subcommand(
      "accuracy",
      "speed against accuracy of every scheme and contact law, with a ladder of steps or "
      "tolerances: prints what reaches an error at the least cost; writes PREFIX.csv, "
      "PREFIX-long.csv (level and shocks over a long stretch) and PREFIX.png");
  accuracy->add_option("SCENE", common.scene, "scene to be marched (TOML) [the paper's own]");
  double budget = AccuracyOptions{}.budget;
  accuracy->add_option("--budget", budget, "wall time that it may take, roughly")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();
  std::filesystem::path peers;
  accuracy
      ->add_option("--peers", peers,
                   "program that confirms the reference with other integrators [bench/peers/"
                   "ra2d_peers beside this one, where it was built]")
      ->type_name("PATH");
  std::string stability_prefix = "stability", accuracy_prefix = "accuracy";
  bool no_plot = false;
  for (const auto& [kind, prefix] :
       {std::pair{stability, &stability_prefix}, std::pair{accuracy, &accuracy_prefix}}) {
    kind->add_option("-o,--output", *prefix, "how the files' names begin")
        ->type_name("PREFIX")
        ->capture_default_str();
    kind->add_flag("--no-plot", no_plot, "leave the picture out");
    add_common(*kind, common);
  }

  const std::string command = argc > 1 ? argv[1] : "";
  if (is_coming(command)) {
    fmt::print(stderr,
               "ra2d: the command '{}' is not available yet; there are 'run', 'plan' and 'chart'\n",
               command);
    return wrong_request;
  }
  const std::string kind = command == "chart" && argc > 2 ? argv[2] : "-";
  if (kind[0] != '-' && kind != stability->get_name() && kind != accuracy->get_name()) {
    fmt::print(stderr, "ra2d: there is no chart '{}'; there are 'stability' and 'accuracy'\n",
               kind);
    return wrong_request;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& request) {
    return app.exit(request) == 0 ? done : wrong_request;
  }
  if (stability->parsed()) return chart_stability_command(common, stability_prefix, !no_plot);
  if (accuracy->parsed())
    return chart_accuracy_command(common, accuracy_prefix, !no_plot, budget, peers);
  if (run->parsed()) return run_command(common, output);
  return asked->count() > 0 ? plan_accuracy_command(common, asked_accuracy, plan_budget, planned)
                            : plan_command(common);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace ra2d;
  catch_interrupts();
  try {
    return dispatch(argc, argv);
  } catch (const RequestError& fault) {
    fmt::print(stderr, "ra2d: {}\n", fault.what());
    return wrong_request;
  } catch (const FileError& fault) {
    fmt::print(stderr, "ra2d: {}\n", fault.what());
    return wrong_file;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "ra2d: out of memory: fewer nodes or modes are needed (see 'ra2d plan')\n");
    return failed;
  } catch (const std::exception& fault) {
    fmt::print(stderr, "ra2d: {}\n", fault.what());
    return failed;
  }
}
