// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <exception>
#include <filesystem>
#include <new>
#include <sstream>
#include <system_error>
#include <tuple>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "host/chart/accuracy_chart.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/interrupt.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/threads.hpp"
#include "host/ranks/ranks.hpp"

namespace {

using Words = std::vector<std::string>;
using ra2d::clock_time, ra2d::number_from, ra2d::path, ra2d::thread_count;

std::string did_you_mean(const std::string& word, const Words& known) {
  const auto near = ra2d::nearest(word, known);
  if (!near) return {};
  return fmt::format(" (did you mean '{}'?)", *near);
}

/// The command that the first words name, and what is wrong with them, if anything.
struct Named {
  const CLI::App* command;
  std::string path, fault;
};

/// Whether a command has words of its own beside its commands.
bool takes_words(const CLI::App& command) {
  const auto options = command.get_options();
  return std::any_of(options.begin(), options.end(),
                     [](const CLI::Option* option) { return option->get_positional(); });
}

Named find_command(const CLI::App& app, const Words& words) {
  Named named{&app, app.get_name(), {}};
  for (const std::string& word : words) {
    const auto commands = named.command->get_subcommands({});
    if (commands.empty() || word.starts_with('-')) break;
    Words names;
    for (const CLI::App* command : commands) names.push_back(command->get_name());
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end()) {
      if (named.command != &app && takes_words(*named.command)) break;  // it is one of these
      if (named.command == &app) names.emplace_back("help");
      named.fault =
          fmt::format("'{}' has no command '{}'{}; there are {}", named.path, ra2d::shortened(word),
                      did_you_mean(word, names), ra2d::any_of(names, "'"));
      break;
    }
    named.command = commands[static_cast<std::size_t>(found - names.begin())];
    named.path += ' ' + word;
  }
  return named;
}

/// Of a line that CLI11 could not read: the first option that its command does not have.
std::string unknown_option(const Named& named, const Words& words) {
  Words names;
  for (const CLI::Option* option : named.command->get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (const std::string& word : words) {
    if (word == "--") break;
    if (!word.starts_with("--")) continue;
    const std::string name = word.substr(0, word.find('='));
    if (std::find(names.begin(), names.end(), name) == names.end())
      return fmt::format("'{}' has no option '{}'{}", named.path, ra2d::shortened(name),
                         did_you_mean(name, names));
  }
  return {};
}

void add_common(CLI::App& command, ra2d::CommonOptions& common) {
  command
      .add_option("--set", common.overrides,
                  "overrides one value of the scene, e.g. --set contact.stiffness=1e14; repeatable")
      ->type_name("SECTION.KEY=VALUE")
      ->take_all()
      ->expected(1);
  command
      .add_option("--threads", common.threads,
                  "how many threads to use, at most one for each processor; a single scene uses "
                  "only one")
      ->transform(thread_count())
      ->capture_default_str();
  ra2d::add_device(command, common.device);
  command.add_flag("--quiet", common.quiet, "print nothing but what was asked for and errors");
}

/// Reads the words of the command line and runs what they ask for.
int dispatch(Words words) {
  using namespace ra2d;
  CLI::App app{
      "ra2d: friction noise of rough surfaces. Two beams slide past each other, their asperities "
      "collide, "
      "each collision rings the beams' modes.",
      "ra2d"};
  app.set_version_flag("--version", program_text());
  app.require_subcommand(1);
  app.footer(
      "Exit status: 0 done; 2 the request is wrong; 3 the simulation failed; 4 a file could not be "
      "read or "
      "written; 5 --max-wall was reached; 128 + n ended by signal n (130: Ctrl-C).");

  CommonOptions common;
  RunChoices run_choices;
  CLI::App* run = app.add_subcommand("run", "simulates a scene and writes one HDF5 file");
  run->add_option("SCENE", common.scene, "scene file (TOML)")->required()->check(path());
  add_common(*run, common);
  run->add_option("-o,--output", run_choices.output,
                  "result file [SCENE's name with .h5, in the current folder]")
      ->type_name("OUT.h5")
      ->check(path());
  run->add_flag(
      "--fresh", run_choices.fresh,
      "start anew: ignore the checkpoint, and run again if the result of this same run is "
      "there");
  run->add_flag(
      "--force", run_choices.force,
      "replace whatever file is there, also the result of another run (of this one: --fresh)");
  add_checkpoints(*run, run_choices.checkpoint, run_choices.most_wall);
  CLI::App* plan =
      app.add_subcommand("plan",
                         "says what would be modelled, and why; runs nothing unless --accuracy "
                         "asks what the scene could do without");
  plan->add_option("SCENE", common.scene, "scene file (TOML)")->required()->check(path());
  double asked_accuracy = 0, plan_budget = 60;
  std::filesystem::path planned;
  CLI::Option* asked =
      plan->add_option("--accuracy", asked_accuracy,
                       "finds by runs the cheapest scheme and step, the fewest modes and the "
                       "coarsest spacing that keep level, rate of shocks and their median duration "
                       "within this relative accuracy, and writes the scene with them")
          ->type_name("A")
          ->check(number_from(std::nextafter(0.0, 1.0), std::nextafter(1.0, 0.0),
                              "between 0 and 1, like 0.01"));
  plan->add_option("--budget", plan_budget, "with --accuracy: wall time it may take, roughly")
      ->type_name("SECONDS")
      ->check(number_from(1e-3, 1e9, "from 1e-3 to 1e9"))
      ->capture_default_str()
      ->needs(asked);
  plan->add_option("-o,--output", planned,
                   "with --accuracy: the scene it writes [SCENE's name with -planned.toml, in the "
                   "current folder]")
      ->type_name("OUT.toml")
      ->check(path())
      ->needs(asked);
  add_common(*plan, common);
  Chosen chosen;
  add_analyze(app, chosen);
  add_plot(app, chosen);
  add_sound(app, chosen);
  add_report(app, chosen);
  add_check(app, chosen);
  add_study(app, chosen);
  CLI::App* chart = app.add_subcommand("chart", "all schemes side by side");
  chart->require_subcommand(1);
  CLI::App* stability = chart->add_subcommand(
      "stability",
      "limits of stability of every scheme, free and in contact, theory beside measurement: prints "
      "the table; writes PREFIX.csv, PREFIX-regions.csv, PREFIX-modes.csv and, drawn with Python's "
      "matplotlib, PREFIX.png");
  stability
      ->add_option("SCENE", common.scene,
                   "scene whose modes are shown in the picture (TOML) [the paper's own]")
      ->check(path());
  CLI::App* accuracy = chart->add_subcommand(
      "accuracy",
      "speed against accuracy of every scheme and contact law, with a ladder of steps or "
      "tolerances: prints what reaches an error at the least cost; writes PREFIX.csv, "
      "PREFIX-long.csv (level and shocks over a long stretch) and PREFIX.png");
  accuracy->add_option("SCENE", common.scene, "scene to be marched (TOML) [the paper's own]")
      ->check(path());
  double budget = AccuracyOptions{}.budget;
  accuracy->add_option("--budget", budget, "wall time that it may take, roughly")
      ->type_name("SECONDS")
      ->check(number_from(0.1, 1e6, "from 0.1 to 1e6"))
      ->capture_default_str();
  std::filesystem::path peers;
  accuracy
      ->add_option("--peers", peers,
                   "program that confirms the reference with other integrators [bench/peers/"
                   "ra2d_peers beside this one, where it was built]")
      ->type_name("PATH")
      ->check(path());
  std::string stability_prefix = "stability", accuracy_prefix = "accuracy";
  bool no_plot = false;
  for (const auto& [kind, prefix] :
       {std::pair{stability, &stability_prefix}, std::pair{accuracy, &accuracy_prefix}}) {
    kind->add_option("-o,--output", *prefix, "how the files' names begin")
        ->type_name("PREFIX")
        ->check(path())
        ->capture_default_str();
    kind->add_flag("--no-plot", no_plot, "leave the picture out");
    add_common(*kind, common);
  }

  CLI::App* surface = app.add_subcommand("surface", "rough profiles");
  surface->require_subcommand(1);
  add_surface_generate(*surface, chosen);
  add_surface_measure(*surface, chosen);

  if (!words.empty() && words[0] == "help") {  // `ra2d help run` as `ra2d run --help`
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  const Named named = find_command(app, words);
  if (!named.fault.empty()) throw RequestError(named.fault);
  try {
    app.parse(Words(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& request) {
    std::ostringstream out, err;
    const bool asked_for = app.exit(request, out, err) == 0;
    print_text(out.str());
    if (asked_for) return done;
    if (const std::string fault = unknown_option(named, words); !fault.empty())
      throw RequestError(fault);
    throw RequestError(err.str().substr(0, err.str().find_last_not_of('\n') + 1));
  }
  const CLI::App* const study = app.get_subcommand("study");
  if (!run->parsed() && !study->parsed()) end_at_checkpoint_signal();
  if (!study->parsed() || !study->get_subcommands().empty()) require_one_process();
  if (chosen) return chosen();
  std::string lowered;
  common.threads = usable_threads(common.threads, lowered);
  if (!lowered.empty() && !common.quiet)
    say(fmt::format("{} thread{}: {}", common.threads, common.threads == 1 ? "" : "s", lowered));
  if (stability->parsed()) return chart_stability_command(common, stability_prefix, !no_plot);
  if (accuracy->parsed())
    return chart_accuracy_command(common, accuracy_prefix, !no_plot, budget, peers);
  if (run->parsed()) return run_command(common, run_choices);
  return asked->count() > 0 ? plan_accuracy_command(common, asked_accuracy, plan_budget, planned)
                            : plan_command(common);
}

/// Tells a fault and gives the exit status on. A rank that fails ends all: they would wait for it.
int give_up(const char* fault, int status) {
  using namespace ra2d;
  Ranks* const ranks = joined_ranks();
  if (ranks == nullptr) {
    // what is asked for is wrong on every rank, and rank 0 says so
    if (status == wrong_request && launch().rank > 0) return done;
    say(fault);
    return status;
  }
  say(ranks->rank() > 0 ? fmt::format("rank {}: {}", ranks->rank(), fault) : fault);
  ranks->report({.ended = RankReport::fault});
  ranks->abort(status);
  return status;
}

/// The exit status; every fault is told.
int answer(const Words& words) {
  using namespace ra2d;
  catch_interrupts();
  try {
    const int status = dispatch(words);
    if (Ranks* const ranks = joined_ranks(); ranks != nullptr) ranks->leave();
    return status;
  } catch (const RequestError& fault) {
    return give_up(fault.what(), wrong_request);
  } catch (const FileError& fault) {
    return give_up(fault.what(), wrong_file);
  } catch (const std::filesystem::filesystem_error& fault) {
    const std::string why = fault.code() == std::errc::too_many_symbolic_link_levels
                                ? "its symbolic links lead in a ring"
                                : fault.code().message();
    return give_up(
        fmt::format("cannot read or write '{}': {}", fault.path1().string(), why).c_str(),
        wrong_file);
  } catch (const std::bad_alloc&) {
    return give_up("out of memory: fewer nodes or modes are needed (see 'ra2d plan')", run_failed);
  } catch (const std::exception& fault) {
    return give_up(fault.what(), run_failed);
  }
}

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Samples come in blocks of a megabyte or two. What is let go of stays with the process for the
  // next: else every block has its pages taken from the system anew.
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
#endif
  ra2d::hold_standard_files();
  std::signal(SIGXFSZ, SIG_IGN);  // ulimit -f: the write says so
  return ra2d::finish_printing(answer(Words(argv + std::min(argc, 1), argv + argc)));
}
