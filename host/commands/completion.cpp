// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "host/scene_file/key_facts.hpp"

namespace ra2d {
namespace {

using Words = std::vector<std::string>;

// ---- what is completed

enum class Kind { nothing, file, folder, file_with_ending, words, scene_key };

/// The values that an option or an argument takes.
struct Completed {
  Kind kind = Kind::nothing;
  std::string ending;  // "toml"
  Words words;
};

/// Whether a word stands for many, as "poly:N" does.
bool is_pattern(const std::string& word) {
  return std::any_of(word.begin(), word.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
}

Completed completed(const OptionFacts& option) {
  const std::string& value = option.value;
  if (value.starts_with("SECTION.KEY")) return {Kind::scene_key, {}, {}};
  if (!option.choices.empty()) {
    Words words = option.choices;
    std::erase_if(words, is_pattern);
    return {Kind::words, {}, words};
  }
  if (value == "SCENE") return {Kind::file_with_ending, "toml", {}};
  if (value == "DIR") return {Kind::folder, {}, {}};
  if (const std::size_t dot = value.rfind('.'); dot != value.npos)
    return {Kind::file_with_ending, value.substr(dot + 1), {}};
  const bool is_file =
      value == "FILE" || value == "PATH" || value == "PREFIX" || value == "PICTURE";
  if (!is_file) return {};
  const std::string& about = option.description;
  if (option.names.empty() && (about.starts_with("result") || about.find(".h5") != about.npos))
    return {Kind::file_with_ending, "h5", {}};
  return {Kind::file, {}, {}};
}

/// A key of a scene that --set takes, and the words that it takes.
struct SceneKey {
  std::string path, meaning;
  Words words;
};

/// The words in the type of a key, which stand between backticks: `"rest"`, `true`.
Words words_in(const std::string& type) {
  Words words;
  for (std::size_t begin, end = 0; (begin = type.find('`', end)) != type.npos; ++end) {
    end = type.find('`', begin + 1);
    if (end == type.npos) break;
    std::string word = type.substr(begin + 1, end - begin - 1);
    std::erase(word, '"');
    if (!word.empty() && !is_pattern(word) && word.find_first_of(" '\\$:") == word.npos)
      words.push_back(word);
  }
  return words;
}

void add_keys(const std::string& path, const std::vector<KeyFacts>& facts,
              std::vector<SceneKey>& keys) {
  for (const KeyFacts& key : facts)
    if (key.type == "table")
      add_keys(path + key.name + '.', key.inner, keys);
    else if (key.inner.empty())  // a list of tables is not written on a command line
      keys.push_back({path + key.name, key.meaning, words_in(key.type)});
}

std::vector<SceneKey> scene_keys() {
  std::vector<SceneKey> keys;
  add_keys("", scene_sections(), keys);
  return keys;
}

template <class Visit>
void visit_commands(const CommandFacts& command, const Visit& visit) {
  visit(command);
  for (const CommandFacts& below : command.commands) visit_commands(below, visit);
}

Words command_names(const CommandFacts& command) {
  Words names;
  for (const CommandFacts& below : command.commands) names.push_back(below.name());
  return names;
}

/// The path below the program: "", "study", "study merge".
std::string path_below(const CommandFacts& command) {
  const std::size_t space = command.path.find(' ');
  return space == command.path.npos ? "" : command.path.substr(space + 1);
}

std::string joined(const Words& words, const char* between = " ") {
  return fmt::format("{}", fmt::join(words, between));
}

std::string with(std::string text, char what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += by.size())
    text.replace(at, 1, by);
  return text;
}

/// Between single quotes of a POSIX shell.
std::string shell_quoted(const std::string& text) {
  return '\'' + with(text, '\'', "'\\''") + '\'';
}

// ---- bash

std::string bash_kind(const Completed& value) {
  switch (value.kind) {
    case Kind::file:
      return "file";
    case Kind::folder:
      return "folder";
    case Kind::file_with_ending:
      return "ending " + value.ending;
    case Kind::words:
      return "words " + joined(value.words);
    case Kind::scene_key:
      return "key";
    default:
      return "nothing";
  }
}

std::string bash_command(const CommandFacts& command) {
  Words options;
  std::string kinds;
  for (const OptionFacts& option : command.options) {
    options.insert(options.end(), option.names.begin(), option.names.end());
    if (!option.is_flag())
      kinds += fmt::format("        {}) kind={} ;;\n", joined(option.names, "|"),
                           shell_quoted(bash_kind(completed(option))));
  }
  return fmt::format(
      "    {})\n      commands={} options={}\n      argument={}\n"
      "      case $2 in\n{}      esac ;;\n",
      shell_quoted(path_below(command)), shell_quoted(joined(command_names(command))),
      shell_quoted(joined(options)),
      shell_quoted(command.arguments.empty() ? "nothing"
                                             : bash_kind(completed(command.arguments[0]))),
      kinds);
}

// ---- zsh

/// A text within a specification of _arguments.
std::string zsh_text(std::string text) {
  for (const char special : {'\\', '[', ']', ':'})
    text = with(text, special, std::string("\\") + special);
  return text;
}

std::string zsh_action(const Completed& value) {
  switch (value.kind) {
    case Kind::file:
      return "_files";
    case Kind::folder:
      return "_files -/";
    case Kind::file_with_ending:
      return fmt::format("_files -g \"*.{}\"", value.ending);
    case Kind::words:
      return '(' + joined(value.words) + ')';
    case Kind::scene_key:
      return "_ra2d_keys";
    default:
      return " ";
  }
}

std::string zsh_option(const OptionFacts& option) {
  const std::string others =
      joined(option.names) + (option.excludes.empty() ? "" : " ") + joined(option.excludes);
  std::string specs;
  for (const std::string& name : option.names) {
    std::string spec = option.value.starts_with("SECTION.KEY") ? "*" : '(' + others + ')';
    spec += name;
    if (!option.is_flag()) spec += name.starts_with("--") ? "=" : "+";
    spec += '[' + zsh_text(option.description) + ']';
    if (!option.is_flag())
      spec += ':' + zsh_text(option.value) + ':' + zsh_action(completed(option));
    specs += " \\\n    " + shell_quoted(spec);
  }
  return specs;
}

std::string zsh_function(const CommandFacts& command) {
  std::string name = "_" + command.path;
  std::replace(name.begin(), name.end(), ' ', '_');
  if (command.path == "ra2d") name += "_program";
  std::string text = name +
                     "() {\n  local curcontext=\"$curcontext\" state line\n"
                     "  typeset -A opt_args\n  _arguments -C";
  for (const OptionFacts& option : command.options) text += zsh_option(option);
  const Completed argument =
      command.arguments.empty() ? Completed{} : completed(command.arguments.front());
  if (command.commands.empty()) {
    if (!command.arguments.empty()) {
      const OptionFacts& first = command.arguments.front();
      text += " \\\n    " + shell_quoted(fmt::format("{}:{}:{}", first.repeats ? "*" : "1",
                                                     zsh_text(first.value), zsh_action(argument)));
    }
    return text + "\n}\n\n";
  }
  text +=
      " \\\n    '1: :->first' '*:: :->rest'\n  case $state in\n  first)\n"
      "    local -a commands=(";
  for (const CommandFacts& below : command.commands)
    text += "\n      " +
            shell_quoted(with(below.name() + ':' + with(below.description, ':', "\\:"), '`', ""));
  text += ")\n    _describe -t commands command commands\n";
  if (!command.arguments.empty()) text += "    " + zsh_action(argument) + '\n';
  text += "    ;;\n  rest)\n    case $words[1] in\n";
  for (const CommandFacts& below : command.commands) {
    std::string function = "_" + below.path;
    std::replace(function.begin(), function.end(), ' ', '_');
    text += fmt::format("    {}) {} ;;\n", below.name(), function);
  }
  return text + "    esac\n    ;;\n  esac\n}\n\n";
}

// ---- fish

/// Between single quotes of fish.
std::string fish_quoted(const std::string& text) {
  return '\'' + with(with(text, '\\', "\\\\"), '\'', "\\'") + '\'';
}

std::string fish_value(const Completed& value) {
  switch (value.kind) {
    case Kind::file:
      return "-r -F";
    case Kind::folder:
      return "-x -a '(__fish_complete_directories)'";
    case Kind::file_with_ending:
      return fmt::format("-x -k -a '(__fish_complete_suffix .{})'", value.ending);
    case Kind::words:
      return "-x -a " + fish_quoted(joined(value.words));
    case Kind::scene_key:
      return "-x -a '(__ra2d_keys)'";
    default:
      return "-x";
  }
}

std::string fish_command(const CommandFacts& command) {
  const std::string begin =
      fmt::format("complete -c ra2d -n {}", fish_quoted("__ra2d_at '" + path_below(command) + "'"));
  std::string text;
  for (const CommandFacts& below : command.commands)
    text += fmt::format("{} -a {} -d {}\n", begin, below.name(), fish_quoted(below.description));
  if (!command.arguments.empty()) {
    const OptionFacts& first = command.arguments.front();
    text += begin + ' ' + fish_value(completed(first)) + '\n';
  }
  for (const OptionFacts& option : command.options) {
    text += begin;
    for (const std::string& name : option.names)
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (!option.is_flag()) text += ' ' + fish_value(completed(option));
    text += " -d " + fish_quoted(option.description) + '\n';
  }
  return text;
}

/// The names of all options that take a value, for the shells that skip these.
std::string valued_options(const CommandFacts& program) {
  Words names;
  visit_commands(program, [&](const CommandFacts& command) {
    for (const OptionFacts& option : command.options)
      if (!option.is_flag())
        for (const std::string& name : option.names)
          if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  });
  return joined(names);
}

/// The completion of bash: what stands between two @ is filled in.
constexpr char bash_text[] = R"(# Completion of ra2d for bash. Made by the build of ra2d.

# Of the command $1: its commands, options, argument; of its option $2: the kind of its value.
_ra2d_facts() {
  commands= options= argument=nothing kind=
  case $1 in
@commands@  esac
}

# Completes $cur as the kind $1 says.
_ra2d_complete() {
  local words= from=$cur
  compopt +o default
  case $1 in
  file) compopt -o default ;;
  folder)
    compopt -o filenames -o default
    mapfile -t COMPREPLY < <(compgen -d -- "$cur") ;;
  ending\ *)
    compopt -o filenames -o default  # where no file has the ending: every file
    mapfile -t COMPREPLY < <(compgen -f -X "!*.${1#* }" -- "$cur"; compgen -d -- "$cur") ;;
  words\ *) words=${1#* } ;;
  key)
    case ${cur%%=*} in
@key_words@    esac
    if [[ $cur == *=* ]]; then
      from=${cur#*=}
      before+=${cur%%=*}=
    else
      words='@keys@'
      compopt -o nospace
    fi ;;
  esac
  [[ -z $words ]] || mapfile -t COMPREPLY < <(compgen -W "$words" -- "$from")
}

_ra2d() {
  local line=() word path= option= before= i cur commands options argument kind
  # readline takes "=" for a word of its own: join what it took apart
  for ((i = 1; i <= COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ ${#line[@]} -gt 0 && ($word == = || ($i -gt 1 && ${COMP_WORDS[i - 1]} == =)) ]]; then
      line[${#line[@]} - 1]+=$word
    else
      line+=("$word")
    fi
  done
  cur=${line[${#line[@]} - 1]}
  COMPREPLY=()
  _ra2d_facts ''
  for word in "${line[@]:0:${#line[@]} - 1}"; do
    if [[ -n $option ]]; then
      option=
    elif [[ $word == -* ]]; then
      _ra2d_facts "$path" "$word"
      [[ -z $kind ]] || option=$word
    elif [[ " $commands " == *" $word "* ]]; then
      path+=${path:+ }$word
      _ra2d_facts "$path"
    fi
  done
  _ra2d_facts "$path" "$option"
  if [[ -n $option ]]; then
    _ra2d_complete "$kind"
  elif [[ $cur == --*=* ]]; then
    _ra2d_facts "$path" "${cur%%=*}"
    before=${cur%%=*}=
    cur=${cur#*=}
    _ra2d_complete "$kind"
  elif [[ $cur == -* ]]; then
    compopt +o default
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$cur")
  else
    _ra2d_complete "$argument"
    local reply=("${COMPREPLY[@]}")
    mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$cur")
    COMPREPLY+=("${reply[@]}")
  fi
  # where "=" does not part words, the whole word is replaced
  [[ $COMP_WORDBREAKS == *=* ]] || COMPREPLY=("${COMPREPLY[@]/#/$before}")
}
complete -o default -F _ra2d ra2d
)";

}  // namespace

std::string bash_completion(const CommandFacts& program) {
  Words keys;
  std::string key_words, commands;
  for (const SceneKey& key : scene_keys()) {
    keys.push_back(key.path + '=');
    if (!key.words.empty())
      key_words += fmt::format("    {}) words={} ;;\n", key.path, shell_quoted(joined(key.words)));
  }
  visit_commands(program, [&](const CommandFacts& command) { commands += bash_command(command); });
  std::string text = bash_text;
  const auto put = [&](const std::string& name, const std::string& by) {
    text.replace(text.find(name), name.size(), by);
  };
  put("@commands@", commands);
  put("@key_words@", key_words);
  put("@keys@", joined(keys));
  return text;
}

std::string zsh_completion(const CommandFacts& program) {
  std::string keys, key_words, functions;
  for (const SceneKey& key : scene_keys()) {
    keys += "    " + shell_quoted(key.path + ':' + with(key.meaning, ':', "\\:")) + '\n';
    if (!key.words.empty())
      key_words += fmt::format("    {}) words=({}) ;;\n", key.path, joined(key.words));
  }
  visit_commands(program, [&](const CommandFacts& command) { functions += zsh_function(command); });
  return "#compdef ra2d\n# Completion of ra2d for zsh. Made by the build of ra2d.\n\n"
         "_ra2d_keys() {\n  local -a keys words\n  if compset -P '*='; then\n"
         "    case ${${IPREFIX%=}##*=} in\n" +
         key_words + "    esac\n    compadd -a words\n  else\n    keys=(\n" + keys +
         "    )\n    _describe -t keys 'key of the scene' keys -S =\n  fi\n}\n\n" + functions +
         "_ra2d_program \"$@\"\n";
}

std::string fish_completion(const CommandFacts& program) {
  std::string keys, commands;
  for (const SceneKey& key : scene_keys()) {
    if (key.words.empty())
      keys += fmt::format("        {} \\\n", fish_quoted(key.path + "=\t" + key.meaning));
    for (const std::string& word : key.words)
      keys +=
          fmt::format("        {} \\\n", fish_quoted(key.path + '=' + word + '\t' + key.meaning));
  }
  visit_commands(program, [&](const CommandFacts& command) { commands += fish_command(command); });
  Words paths;
  visit_commands(program, [&](const CommandFacts& command) {
    if (const std::string path = path_below(command); !path.empty())
      paths.push_back(fish_quoted(path));
  });
  return fmt::format(
      R"(# Completion of ra2d for fish. Made by the build of ra2d.

# Whether the words so far name the command $argv[1].
function __ra2d_at
    set -l path
    set -l skips 0
    for word in (commandline -opc)[2..-1]
        if test $skips = 1
            set skips 0
        else if contains -- $word {}
            set skips 1
        else
            set -l next (string trim -- "$path $word")
            contains -- $next {}
            and set path $next
        end
    end
    test "$path" = "$argv[1]"
end

function __ra2d_keys
    printf '%s\n' \
{}
end

complete -c ra2d -f
{})",
      valued_options(program), joined(paths), keys.substr(0, keys.size() - 3), commands);
}

}  // namespace ra2d
