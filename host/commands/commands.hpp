// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/CLI.hpp>
#include <functional>

/// The commands of the program. Each is a file of its own: its options, what they are read into,
/// and the run. It adds itself to the command line, and stands in `commands`.
namespace ra2d {

/// The command that a line names, ready to be run. Its callback on the command line fills it in.
struct ChosenCommand {
  std::function<int()> run;        // returns the exit status (host/base/exit_status.hpp)
  bool takes_checkpoints = false;  // SIGUSR1 asks for one, and does not end the command
  bool takes_ranks = false;        // under mpirun all processes take part in it
};

/// Adds a command with its options. Where a line names it, it sets `chosen`.
using AddCommand = void (*)(CLI::App& app, ChosenCommand& chosen);

void add_new(CLI::App& app, ChosenCommand& chosen);
void add_scenes(CLI::App& app, ChosenCommand& chosen);
void add_run(CLI::App& app, ChosenCommand& chosen);
void add_plan(CLI::App& app, ChosenCommand& chosen);
void add_analyze(CLI::App& app, ChosenCommand& chosen);
void add_compare(CLI::App& app, ChosenCommand& chosen);
void add_uncertainty(CLI::App& app, ChosenCommand& chosen);
void add_plot(CLI::App& app, ChosenCommand& chosen);
void add_sound(CLI::App& app, ChosenCommand& chosen);
void add_report(CLI::App& app, ChosenCommand& chosen);
void add_check(CLI::App& app, ChosenCommand& chosen);
void add_study(CLI::App& app, ChosenCommand& chosen);
void add_chart(CLI::App& app, ChosenCommand& chosen);
void add_surface(CLI::App& app, ChosenCommand& chosen);

/// In the order of the help.
inline constexpr AddCommand commands[] = {
    add_new,  add_scenes, add_run,    add_plan,  add_uncertainty, add_analyze, add_compare,
    add_plot, add_sound,  add_report, add_check, add_study,       add_chart,   add_surface};

// Commands of commands.
void add_study_status(CLI::App& study, ChosenCommand& chosen);
void add_study_merge(CLI::App& study, ChosenCommand& chosen);
void add_surface_generate(CLI::App& surface, ChosenCommand& chosen);
void add_surface_map(CLI::App& surface, ChosenCommand& chosen);
void add_surface_measure(CLI::App& surface, ChosenCommand& chosen);

}  // namespace ra2d
