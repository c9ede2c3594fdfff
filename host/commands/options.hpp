// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/base/text.hpp"

/// The options that several commands have, and what values they take.
namespace ra2d {

struct SoundRequest;

/// Lets an option be given many times, each time with one value: words after it are not its own.
void one_value_each_time(CLI::Option& option);

/// --set, which overrides values of a scene; `of_what` says of which, for the help.
void add_overrides(CLI::App& command, std::vector<std::string>& overrides,
                   const std::string& of_what);

/// The options of a command that reads a scene.
struct SceneOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // --set
  int threads = 1;
  int device = -1;  // less than 0: left to Kokkos
  bool quiet = false;
};
void add_scene_options(CLI::App& command, SceneOptions& options);
/// The words for SCENE where it needs no others.
inline constexpr const char* scene_words =
    "scene file (TOML), or the name of a scene that comes with ra2d";
/// SCENE, the scene's file.
CLI::Option* add_scene(CLI::App& command, SceneOptions& options, const std::string& description);

/// Turns the name of a scene or study that comes with the program into its file.
CLI::Validator scene_or_name();

/// A number in decimals, "12" or "-1.5e-3"; nothing for any other text, hexadecimal ones among
/// them.
std::optional<double> to_decimal(const std::string& text);

/// Numbers from `low` to `high`; `words` say so in a message.
CLI::Validator number_from(double low, double high, const std::string& words);

/// Numbers > 0.
CLI::Validator positive_number();

/// Numbers > 0, which a message calls a length.
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

/// A count, from 1 to 999999999.
CLI::Validator count();

/// A whole number >= 0, such as a seed.
CLI::Validator whole_number();

/// A number of threads, from 1 on. More than any machine has becomes 999999999 here;
/// usable_threads() lowers it to what this machine has.
CLI::Validator thread_count();

/// A stretch of wall time, "90", "1:30", "0:01:30"; turns it into seconds.
CLI::Validator clock_time();

/// --device, the number of a GPU.
void add_device(CLI::App& command, int& device);

/// A path that is not empty. An empty one comes from a shell's variable that is not set.
CLI::Validator path();

/// --from and --to: a stretch of a run.
void add_stretch(CLI::App& command, std::optional<double>& from, std::optional<double>& to);

/// The place that "x,y,z" names; nothing for any other text.
std::optional<std::array<double, 3>> to_position(const std::string& text);

/// --at, --temperature, --pressure: microphones, and the air that they stand in.
CLI::Option* add_microphones(CLI::App& command, SoundRequest& request);
/// Throws RequestError where one of them cannot stand there, or an air is named for none.
void require_microphones(const SoundRequest& request);
/// Puts them into a request to Python.
void add_microphones_to(nlohmann::ordered_json& json, const SoundRequest& request);
/// As a command line has them, with a blank before each.
std::string sound_options(const SoundRequest& request);

/// --checkpoint, in minutes, and --max-wall, in seconds.
void add_checkpoints(CLI::App& command, double& checkpoint, double& most_wall);

/// The name of a file or a folder without its ending. Files that are made of it take that name.
std::string name_of(const std::filesystem::path& file);

}  // namespace ra2d
