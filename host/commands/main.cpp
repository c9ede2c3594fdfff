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
#include <memory>
#include <new>
#include <sstream>
#include <system_error>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "host/commands/command_facts.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/interrupt.hpp"
#include "host/commands/manual.hpp"
#include "host/commands/print.hpp"
#include "host/ranks/ranks.hpp"

namespace {

using Words = std::vector<std::string>;

std::string did_you_mean(const std::string& word, const Words& candidates) {
  const auto near = ra2d::nearest(word, candidates);
  if (!near) return {};
  return fmt::format(" (did you mean '{}'?)", *near);
}

/// The command that the first words name, and what is wrong with them, if anything.
struct NamedCommand {
  const CLI::App* command;
  std::string path, fault;
};

/// Whether a command takes words that are not commands, such as names of files.
bool takes_words(const CLI::App& command) {
  const auto options = command.get_options();
  return std::any_of(options.begin(), options.end(),
                     [](const CLI::Option* option) { return option->get_positional(); });
}

NamedCommand find_command(const CLI::App& app, const Words& words) {
  NamedCommand named{&app, app.get_name(), {}};
  for (const std::string& word : words) {
    const auto commands = named.command->get_subcommands({});
    if (commands.empty() || word.starts_with('-')) break;
    Words names;
    for (const CLI::App* command : commands) names.push_back(command->get_name());
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end()) {
      if (named.command != &app && takes_words(*named.command)) break;
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

/// The first option of a line that its command does not have.
std::string unknown_option(const NamedCommand& named, const Words& words) {
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

/// Reads the words of the command line and runs the command that they name.
int dispatch(Words words) {
  using namespace ra2d;
  CLI::App app{
      "ra2d: friction noise of rough surfaces. Two beams, or a block and a plate, slide past each "
      "other, their asperities collide, each collision rings the bodies' modes.",
      "ra2d"};
  app.set_version_flag("--version", program_text());
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpFormatter>());
  ChosenCommand chosen;
  for (const AddCommand add : commands) add(app, chosen);

  if (words.size() == 3 && words[0] == "--write-manuals") {  // the build asks for it
    write_manuals(facts_of(app), words[1], words[2]);
    return exit_status::done;
  }
  if (!words.empty() && words[0] == "help") {  // `ra2d help run` as `ra2d run --help`
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  const NamedCommand named = find_command(app, words);
  if (!named.fault.empty()) throw RequestError(named.fault);
  try {
    app.parse(Words(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& ending) {
    std::ostringstream out, err;
    const bool is_help = app.exit(ending, out, err) == 0;
    print_text(out.str());
    if (is_help) return exit_status::done;
    if (const std::string fault = unknown_option(named, words); !fault.empty())
      throw RequestError(fault);
    throw RequestError(err.str().substr(0, err.str().find_last_not_of('\n') + 1));
  } catch (const FileError&) {  // the value of a mistyped option is no scene's name
    if (const std::string fault = unknown_option(named, words); !fault.empty())
      throw RequestError(fault);
    throw;
  }
  if (!chosen.takes_checkpoints) end_at_checkpoint_signal();
  if (!chosen.takes_ranks) require_one_process();
  return chosen.run();
}

/// Says a fault; returns the exit status. A rank that fails ends all others, which would wait for
/// it.
int give_up(const char* fault, int status) {
  using namespace ra2d;
  Ranks* const ranks = joined_ranks();
  const int rank = launch().rank;
  say(rank > 0 ? fmt::format("rank {}: {}", rank, fault) : fault);
  if (ranks == nullptr) return status;
  ranks->report({.ended = RankReport::fault});
  ranks->abort(status);
  return status;
}

/// Runs the line; says every fault. Returns the exit status.
int answer(const Words& words) {
  using namespace ra2d;
  catch_interrupts();
  try {
    const int status = dispatch(words);
    if (Ranks* const ranks = joined_ranks(); ranks != nullptr) ranks->leave();
    return status;
  } catch (const RequestError& fault) {
    return give_up(fault.what(), exit_status::wrong_request);
  } catch (const FileError& fault) {
    return give_up(fault.what(), exit_status::wrong_file);
  } catch (const std::filesystem::filesystem_error& fault) {
    return give_up(fault_text(fault).c_str(), exit_status::wrong_file);
  } catch (const std::bad_alloc&) {
    return give_up("out of memory: fewer nodes or modes are needed (see 'ra2d plan')",
                   exit_status::failed);
  } catch (const std::exception& fault) {
    return give_up(fault.what(), exit_status::failed);
  }
}

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Samples come in blocks of a megabyte or two. The process keeps the memory of one for the next.
  // Else every block has its pages taken from the system anew.
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
#endif
  ra2d::hold_standard_files();
  std::signal(SIGXFSZ, SIG_IGN);  // ulimit -f: the write says so
  return ra2d::finish_printing(answer(Words(argv + std::min(argc, 1), argv + argc)));
}
