// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/commands/command_facts.hpp"

/// Completion for shells: commands, options, the keys of a scene after --set with the words that
/// they take, files by their kind. The scripts know all this by themselves: none runs the program.
namespace ra2d {

std::string bash_completion(const CommandFacts& program);
std::string zsh_completion(const CommandFacts& program);
std::string fish_completion(const CommandFacts& program);

}  // namespace ra2d
