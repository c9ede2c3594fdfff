// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

/// The commands and their options as data. Help, manual pages and completion are written from it.
namespace ra2d {

struct OptionFacts {
  std::vector<std::string> names;    // "-o", "--output"; none for a word without a name, as SCENE
  std::string value;                 // "OUT.h5"; empty for a flag
  std::string range;                 // "from 1e-6 to 1e6", or empty
  std::vector<std::string> choices;  // the words that it takes, if only these
  std::string by_default;
  std::string description;
  std::string group;  // the heading in the help
  std::vector<std::string> needs, excludes;
  bool is_required = false;
  bool repeats = false;  // takes several words

  bool is_flag() const { return value.empty(); }
  /// "-o, --output OUT.h5", or "SCENE".
  std::string left() const;
  /// The description with range, default and the like.
  std::string text() const;
};

struct CommandFacts {
  std::string path;  // "ra2d study merge"
  std::string description;
  std::vector<OptionFacts> arguments, options;
  std::vector<CommandFacts> commands;
  bool needs_command = false;

  std::string name() const { return path.substr(path.rfind(' ') + 1); }
  /// "ra2d study [OPTIONS] [STUDY.toml] [COMMAND]".
  std::string usage() const;
  /// The options under their headings.
  std::vector<std::pair<std::string, std::vector<const OptionFacts*>>> grouped_options() const;
};

/// A command with all that is below it. What is hidden from the help is left out.
CommandFacts facts_of(const CLI::App& command);

/// The exit statuses of the program, each with its meaning.
const std::vector<std::pair<std::string, std::string>>& exit_statuses();

/// Breaks a text into lines of at most `width` characters, between words. Lines after the first
/// begin with `indent` blanks, and the first one has `used` characters before it.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t used,
                    std::size_t width = 80);

/// The help of a command: no line is longer than 80 characters.
std::string help_text(const CommandFacts& command);

/// Gives CLI11 the help above.
class HelpFormatter : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* command, std::string, CLI::AppFormatMode) const override {
    return help_text(facts_of(*command));
  }
};

}  // namespace ra2d
