// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

/// Programs that a chart starts.
namespace ra2d {

struct ProgramRun {
  int status = -1;    // exit status; 128 + the signal that ended it; -1: it could not be started
  bool late = false;  // ended here, for its time was over
  std::string out;    // what it printed, where it was asked for
};

/// The destination of a program's standard output.
enum class Output { shown, kept };

/// Runs a program to its end, without a shell; after `limit` seconds it is killed with all that it
/// started (output kept only). It does not outlive this process. `input`: an open file that it
/// finds as its standard input; -1: this process's own.
ProgramRun run_program(std::vector<std::string> words, Output output = Output::shown,
                       double limit = std::numeric_limits<double>::infinity(), int input = -1);

/// Kills the programs that run, with all that they started: signal handlers may call it. Of more
/// than 64 it knows 64.
void kill_programs() noexcept;

/// The folder of the program that runs; empty when the system does not tell.
std::filesystem::path program_folder();

}  // namespace ra2d
