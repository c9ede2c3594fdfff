// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "host/base/text.hpp"

/// What the commands' options take.
namespace ra2d {

/// The command that a line asks for, ready to be run: returns the exit status.
using Chosen = std::function<int()>;

/// Numbers from `low` to `high`, told as `words`. CLI11's own Range lets nan pass.
CLI::Validator number_from(double low, double high, const std::string& words);

/// Numbers > 0.
CLI::Validator positive_number();

/// The same, told as a length.
CLI::Validator length_in_metres();

/// Texts that `understand` makes something of; `expected` says which.
template <class Understand>
CLI::Validator understood(const std::string& expected, Understand understand) {
  return {[=](std::string& text) {
            return understand(text) ? std::string{}
                                    : fmt::format("'{}': expected {}", shortened(text), expected);
          },
          {}};
}

/// A count, up to 999999999.
CLI::Validator count();

/// How many threads: any number from 1 on. What no machine has is lowered to 999999999 here and to
/// what the machine has later (usable_threads).
CLI::Validator thread_count();

/// A stretch of wall time, "90", "1:30", "0:01:30"; turns it into seconds.
CLI::Validator clock_time();

/// --device, the number of a GPU.
void add_device(CLI::App& command, int& device);

/// A path that is given: an empty one comes from a variable that is not set.
CLI::Validator path();

/// --from and --to: the stretch of a run that is looked at.
void add_stretch(CLI::App& command, std::optional<double>& from, std::optional<double>& to);

/// --checkpoint, in minutes, and --max-wall, in seconds.
void add_checkpoints(CLI::App& command, double& checkpoint, double& most_wall);

/// What a file or a folder is called, without its ending: what is made of it takes that name.
std::string name_of(const std::filesystem::path& file);

// Commands add themselves, each in a file of its own.
void add_check(CLI::App& app, Chosen& chosen);
void add_analyze(CLI::App& app, Chosen& chosen);
void add_plot(CLI::App& app, Chosen& chosen);
void add_report(CLI::App& app, Chosen& chosen);
void add_sound(CLI::App& app, Chosen& chosen);
void add_study(CLI::App& app, Chosen& chosen);
void add_surface_generate(CLI::App& surface, Chosen& chosen);
void add_surface_measure(CLI::App& surface, Chosen& chosen);

}  // namespace ra2d
