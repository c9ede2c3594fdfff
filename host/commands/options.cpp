// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>

#include "host/analysis/sound_pressure.hpp"
#include "host/scene_file/installed_scenes.hpp"

namespace ra2d {

void one_value_each_time(CLI::Option& option) {
  option.take_all()->expected(1)->allow_extra_args(false);
}

void add_overrides(CLI::App& command, std::vector<std::string>& overrides,
                   const std::string& of_what) {
  CLI::Option* set = command.add_option(
      "--set", overrides,
      fmt::format("overrides one value of {}, e.g. --set contact.stiffness=1e14; repeatable",
                  of_what));
  set->type_name("SECTION.KEY=VALUE");
  one_value_each_time(*set);
}

void add_scene_options(CLI::App& command, SceneOptions& options) {
  add_overrides(command, options.overrides, "the scene");
  command
      .add_option("--threads", options.threads,
                  "how many threads to use, at most one for each processor; a single scene uses "
                  "only one")
      ->transform(thread_count())
      ->capture_default_str();
  add_device(command, options.device);
  command.add_flag("--quiet", options.quiet, "print results and errors only");
}

CLI::Option* add_scene(CLI::App& command, SceneOptions& options, const std::string& description) {
  return command.add_option("SCENE", options.scene, description)
      ->check(path())
      ->transform(scene_or_name());
}

std::optional<double> to_decimal(const std::string& text) {
  if (text.empty() || text.find_first_not_of("0123456789+-.eE") != text.npos) return {};
  const char *begin = text.data() + (text[0] == '+'), *const end = text.data() + text.size();
  double value = 0;
  const auto [rest, fault] = std::from_chars(begin, end, value);
  return fault == std::errc() && rest == end ? std::optional(value) : std::nullopt;
}

CLI::Validator number_from(double low, double high, const std::string& words) {
  return {[=](std::string& text) {
            const std::optional<double> value = to_decimal(text);
            return value && *value >= low && *value <= high
                       ? std::string{}
                       : fmt::format("'{}': expected {}", shortened(text), words);
          },
          words};
}

CLI::Validator positive_number() {
  return number_from(std::numeric_limits<double>::min(), std::numeric_limits<double>::max(),
                     "a number > 0");
}

CLI::Validator length_in_metres() {
  return number_from(std::numeric_limits<double>::min(), std::numeric_limits<double>::max(),
                     "a length in metres, like 2.5e-3")
      .description("");
}

void add_device(CLI::App& command, int& device) {
  command.add_option("--device", device, "the GPU to use, counted from 0, of a build for GPUs [0]")
      ->type_name("N")
      ->transform(whole_number())
      ->check(number_from(0, 1023, "from 0 to 1023"));
}

CLI::Validator scene_or_name() {
  return {[](std::string& text) {
            text = scene_file_of(text).string();  // throws FileError for a name that nothing has
            return std::string{};
          },
          {}};
}

namespace {

constexpr std::size_t most_digits = 9;  // of a count, so that it fits into an int

/// Takes the zeros off the front of a whole number in digits, 1 or more; false for any other text.
bool trim_count(std::string& text) {
  const std::size_t first = text.find_first_not_of('0');
  if (first == text.npos || text.find_first_not_of("0123456789") != text.npos) return false;
  text.erase(0, first);
  return true;
}

/// Of "90", "1:30" or "0:01:30"; none of any other text, and of no time.
std::optional<double> clock_seconds(const std::string& text) {
  double seconds = 0;
  std::size_t begin = 0;
  for (int part = 0; part < 3; ++part) {
    const std::size_t end = std::min(text.find(':', begin), text.size());
    const std::optional<double> value = to_decimal(text.substr(begin, end - begin));
    const bool fits = value && *value <= 1e9 && (part == 0 || *value < 60);
    if (!fits || std::signbit(*value)) return {};
    seconds = 60 * seconds + *value;
    if (end == text.size()) return seconds > 0 ? std::optional(seconds) : std::nullopt;
    begin = end + 1;
  }
  return {};
}

}  // namespace

CLI::Validator count() {
  return {[](std::string& text) {
            const std::string given = text;
            if (trim_count(text) && text.size() <= most_digits) return std::string{};
            return fmt::format("'{}': expected a whole number in digits, from 1 to {}",
                               shortened(given), std::string(most_digits, '9'));
          },
          "1 or more"};
}

CLI::Validator whole_number() {
  return {[](std::string& text) {
            const bool is_whole = !text.empty() && text.size() < 20 &&
                                  text.find_first_not_of("0123456789") == text.npos;
            // CLI11 reads a number that begins with a zero as an octal one
            if (is_whole) text.erase(0, std::min(text.find_first_not_of('0'), text.size() - 1));
            return is_whole ? std::string{}
                            : fmt::format("'{}': expected a whole number in digits, 0 or more",
                                          shortened(text));
          },
          {}};
}

CLI::Validator thread_count() {
  return {[](std::string& text) {
            if (!trim_count(text))
              return fmt::format("'{}': expected a whole number in digits, 1 or more",
                                 shortened(text));
            if (text.size() > most_digits) text = std::string(most_digits, '9');
            return std::string{};
          },
          "1 or more"};
}

CLI::Validator clock_time() {
  return {[](std::string& text) {
            const std::optional<double> seconds = clock_seconds(text);
            if (!seconds)
              return fmt::format(
                  "'{}': expected a time > 0 as seconds, M:S or H:M:S, less than 60 after a colon",
                  shortened(text));
            text = fmt::format("{}", *seconds);
            return std::string{};
          },
          {}};
}

CLI::Validator path() {
  return {[](std::string& text) { return text.empty() ? "'': expected a name" : std::string{}; },
          {}};
}

std::string name_of(const std::filesystem::path& file) {
  return (file.has_filename() ? file : file.parent_path()).stem().string();
}

void add_stretch(CLI::App& command, std::optional<double>& from, std::optional<double>& to) {
  const auto add = [&](const char* name, std::optional<double>& time, const char* what) {
    command.add_option(name, time, what)
        ->type_name("SECONDS")
        ->check(number_from(0, 1e12, "from 0 to 1e12"));
  };
  add("--from", from, "where to begin [output.from of the scene]");
  add("--to", to, "where to end [the end of the run]");
}

std::optional<Position> to_position(const std::string& text) {
  Position found{};
  std::size_t from = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t comma = text.find(',', from);
    if ((comma == text.npos) != (i + 1 == found.size())) return {};
    const std::optional<double> value = to_decimal(text.substr(from, comma - from));
    if (!value) return {};
    found[i] = *value;
    from = comma + 1;
  }
  return found;
}

CLI::Option* add_microphones(CLI::App& command, SoundRequest& request) {
  CLI::Option* at =
      command
          .add_option_function<std::vector<std::string>>(
              "--at",
              [&request](const std::vector<std::string>& places) {
                for (const std::string& place : places)
                  request.microphones.push_back(*to_position(place));
              },
              "a microphone: along the resonator from its left end, across from its edge, and "
              "above it [m]; may be repeated")
          ->type_name("X,Y,Z")
          ->check(understood("three numbers of metres, x,y,z, as 0.15,0.1,0.5",
                             [](const std::string& text) { return to_position(text); }));
  one_value_each_time(*at);
  command.add_option("--temperature", request.celsius, "of the air, degrees Celsius [20]")
      ->type_name("C")
      ->check(number_from(-50, 100, "from -50 to 100"));
  command.add_option("--pressure", request.pascal, "of the still air, Pa [101325]")
      ->type_name("PA")
      ->check(number_from(1e4, 1e6, "from 10000 to 1000000"));
  return at;
}

void require_microphones(const SoundRequest& request) {
  request.require_sense();
  for (const Position& at : request.microphones) require_height(at);
}

void add_microphones_to(nlohmann::ordered_json& json, const SoundRequest& request) {
  if (request.microphones.empty()) return;
  json["at"] = request.microphones;
  if (request.celsius) json["temperature"] = *request.celsius;
  if (request.pascal) json["pressure"] = *request.pascal;
}

std::string sound_options(const SoundRequest& request) {
  std::string words;
  for (const Position& at : request.microphones)
    words += fmt::format(" --at {},{},{}", at[0], at[1], at[2]);
  if (request.celsius) words += fmt::format(" --temperature {}", *request.celsius);
  if (request.pascal) words += fmt::format(" --pressure {}", *request.pascal);
  return words;
}

void add_checkpoints(CLI::App& command, double& checkpoint, double& most_wall) {
  command
      .add_option(
          "--checkpoint", checkpoint,
          "wall time between two checkpoints, from which the same command continues after a crash")
      ->type_name("MINUTES")
      ->check(number_from(1e-6, 1e6, "from 1e-6 to 1e6"))
      ->capture_default_str();
  command
      .add_option("--max-wall", most_wall,
                  "wall time after which to stop, with checkpoints and exit status 5: seconds, or "
                  "H:M:S")
      ->type_name("TIME")
      ->transform(clock_time());
}

}  // namespace ra2d
