// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/command_facts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

namespace ra2d {
namespace {

std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back('-' + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> names_of(const std::set<CLI::Option*>& options, const CLI::App& command) {
  std::vector<std::string> names;  // in the order of the help
  for (const CLI::Option* option : command.get_options())
    if (std::any_of(options.begin(), options.end(),
                    [&](const CLI::Option* other) { return other == option; }))
      names.push_back(names_of(*option).back());
  return names;
}

/// Takes CLI11's name of a type apart: "MINUTES:from 1e-6 to 1e6", "TEXT:{rq,none}".
void set_type(OptionFacts& facts, const std::string& type) {
  const std::size_t colon = type.find(':');
  facts.value = type.substr(0, colon);
  if (std::any_of(facts.value.begin(), facts.value.end(),
                  [](unsigned char c) { return std::islower(c) != 0; }) ||
      colon == type.npos) {
    facts.value = type;  // "OUT.h5", "linear:M"
  } else if (const std::string rest = type.substr(colon + 1); rest.starts_with('{')) {
    std::size_t begin = 1;
    for (std::size_t end; (end = rest.find_first_of(",}", begin)) != rest.npos; begin = end + 1)
      facts.choices.push_back(rest.substr(begin, end - begin));
  } else {
    facts.range = rest;
    std::replace(facts.range.begin(), facts.range.end(), ':', ',');
  }
  for (const auto& [of_cli11, word] :
       {std::pair{"TEXT", "WORD"}, {"INT", "N"}, {"UINT", "N"}, {"FLOAT", "X"}})
    if (facts.value == of_cli11) facts.value = word;
}

OptionFacts facts_of(const CLI::Option& option, const CLI::App& command) {
  OptionFacts facts;
  facts.description = option.get_description();
  facts.group = option.get_group();
  facts.is_required = option.get_required();
  facts.repeats = option.get_items_expected_max() > 1;
  if (option.get_positional()) {
    facts.value = option.get_name(true);
    return facts;
  }
  facts.names = names_of(option);
  if (option.get_items_expected_max() > 0) set_type(facts, option.get_type_name());
  if (!facts.is_flag()) facts.by_default = option.get_default_str();
  facts.needs = names_of(option.get_needs(), command);
  facts.excludes = names_of(option.get_excludes(), command);
  return facts;
}

/// An entry of a list in two columns.
std::string entry(const std::string& left, const std::string& right) {
  constexpr std::size_t column = 26;
  std::string text = "  " + left;
  if (right.empty()) return text + '\n';
  if (text.size() + 2 > column) text += '\n' + std::string(column, ' ');
  const std::size_t line = text.rfind('\n') == text.npos ? 0 : text.rfind('\n') + 1;
  text.resize(std::max(text.size(), line + column), ' ');
  return text + wrapped(right, column, column) + '\n';
}

}  // namespace

std::string OptionFacts::left() const {
  if (names.empty()) return value;
  return fmt::format("{}{}{}", fmt::join(names, ", "), is_flag() ? "" : " ", value);
}

std::string OptionFacts::text() const {
  std::string text = description, brackets;
  if (const std::size_t at = text.rfind(" ["); text.ends_with(']') && at != text.npos) {
    brackets = text.substr(at);
    text.resize(at);
  }
  std::vector<std::string> limits;
  if (!choices.empty()) limits.push_back(fmt::format("{}", fmt::join(choices, ", ")));
  if (!range.empty()) limits.push_back(range);
  if (is_required && !names.empty()) limits.emplace_back("required");
  if (!needs.empty()) limits.push_back(fmt::format("only with {}", fmt::join(needs, ", ")));
  if (!excludes.empty()) limits.push_back(fmt::format("not with {}", fmt::join(excludes, ", ")));
  if (!limits.empty()) text += fmt::format(" ({})", fmt::join(limits, "; "));
  text += brackets;
  if (!by_default.empty()) text += fmt::format(" [{}]", by_default);
  return text;
}

std::string CommandFacts::usage() const {
  std::string text = path + " [OPTIONS]";
  for (const OptionFacts& argument : arguments) {
    const std::string word = argument.value + (argument.repeats ? "..." : "");
    text += argument.is_required ? ' ' + word : " [" + word + ']';
  }
  if (!commands.empty()) text += needs_command ? " COMMAND" : " [COMMAND]";
  return text;
}

std::vector<std::pair<std::string, std::vector<const OptionFacts*>>> CommandFacts::grouped_options()
    const {
  std::vector<std::pair<std::string, std::vector<const OptionFacts*>>> groups;
  for (const OptionFacts& option : options) {
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&](const auto& one) { return one.first == option.group; });
    if (group == groups.end()) group = groups.insert(groups.end(), {option.group, {}});
    group->second.push_back(&option);
  }
  return groups;
}

CommandFacts facts_of(const CLI::App& command) {
  CommandFacts facts;
  facts.path = command.get_name();
  for (const CLI::App* above = command.get_parent(); above != nullptr; above = above->get_parent())
    facts.path = above->get_name() + ' ' + facts.path;
  facts.description = command.get_description();
  facts.needs_command = command.get_require_subcommand_min() > 0;
  for (const CLI::Option* option : command.get_options())
    if (!option->get_group().empty())
      (option->get_positional() ? facts.arguments : facts.options)
          .push_back(facts_of(*option, command));
  for (const CLI::App* below : command.get_subcommands({}))
    if (!below->get_group().empty()) facts.commands.push_back(facts_of(*below));
  return facts;
}

const std::vector<std::pair<std::string, std::string>>& exit_statuses() {
  static const std::vector<std::pair<std::string, std::string>> statuses{
      {"0", "done"},
      {"2", "the request is wrong"},
      {"3", "the simulation failed"},
      {"4", "a file could not be read or written"},
      {"5", "--max-wall was reached"},
      {"128 + n", "ended by signal n (130: Ctrl-C)"}};
  return statuses;
}

std::string wrapped(const std::string& text, std::size_t indent, std::size_t used,
                    std::size_t width) {
  std::string lines;
  std::size_t column = used;
  bool begins = true;  // a line
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    begin = end + 1;
    if (word.empty()) continue;
    if (!begins && column + 1 + word.size() > width) {
      lines += '\n' + std::string(indent, ' ');
      column = indent;
      begins = true;
    }
    lines += (begins ? "" : " ") + word;
    column += word.size() + (begins ? 0 : 1);
    begins = false;
  }
  return lines;
}

std::string help_text(const CommandFacts& command) {
  std::string text = wrapped(command.description, 0, 0) + "\n";
  const std::string usage = "Usage: ";
  text += usage + wrapped(command.usage(), usage.size() + 2, usage.size()) + '\n';
  if (!command.arguments.empty()) text += "\nArguments:\n";
  for (const OptionFacts& argument : command.arguments)
    text += entry(argument.left() + (argument.repeats ? "..." : ""), argument.text());
  for (const auto& [group, options] : command.grouped_options()) {
    text += fmt::format("\n{}:\n", group);
    for (const OptionFacts* option : options) text += entry(option->left(), option->text());
  }
  if (!command.commands.empty()) text += "\nCommands:\n";
  for (const CommandFacts& below : command.commands) text += entry(below.name(), below.description);
  std::vector<std::string> statuses;
  for (const auto& [number, meaning] : exit_statuses()) statuses.push_back(number + ' ' + meaning);
  return text + '\n' + wrapped(fmt::format("Exit status: {}.", fmt::join(statuses, "; ")), 0, 0) +
         '\n';
}

}  // namespace ra2d
