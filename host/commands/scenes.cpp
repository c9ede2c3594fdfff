// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/print.hpp"
#include "host/scene_file/installed_scenes.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t longest_scene = 1 << 20;  // bytes, of a scene that comes with the program

void list_scenes(const std::vector<InstalledScene>& scenes, bool studies) {
  std::size_t width = 0;
  for (const InstalledScene& scene : scenes) width = std::max(width, scene.name.size());
  for (const InstalledScene& scene : scenes)
    if (scene.is_study == studies)
      print("  {:<{}}  {}\n", printable(scene.name), width, printable(scene.about));
}

int show_scenes() {
  const std::vector<InstalledScene> scenes = installed_scenes();
  const std::string folder =
      scenes.empty() ? "" : printable(scenes.front().file.parent_path().string());
  print("scenes in {}\n", folder);
  list_scenes(scenes, false);
  if (std::any_of(scenes.begin(), scenes.end(),
                  [](const InstalledScene& scene) { return scene.is_study; }))
    print("studies there\n");
  list_scenes(scenes, true);
  print(
      "'ra2d scenes NAME' prints one, for a file of your own; 'ra2d run NAME' or 'ra2d study NAME' "
      "runs it\n");
  return exit_status::done;
}

int print_scene(const std::string& name) {
  const std::vector<InstalledScene> scenes = installed_scenes();
  std::vector<std::string> names;
  for (const InstalledScene& scene : scenes) {
    names.push_back(scene.name);
    if (name != scene.name && name != scene.name + ".toml") continue;
    print_text(InputFile(scene.file, "the scene").beginning(longest_scene));
    return exit_status::done;
  }
  const auto near = nearest(name, names);
  throw RequestError(fmt::format("no scene '{}' comes with ra2d{}; there are {}", shortened(name),
                                 near ? fmt::format(" (did you mean '{}'?)", *near) : "",
                                 any_of(names, "'")));
}

}  // namespace

void add_scenes(CLI::App& app, ChosenCommand& chosen) {
  const auto name = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "scenes",
      "lists the scenes that come with ra2d, or prints one: ra2d scenes dang2012 > "
      "my.toml");
  CLI::Option* given = command->add_option("NAME", *name, "the scene to print");
  command->callback([name, given, &chosen] {
    chosen.run = [name, is_given = given->count() > 0] {
      return is_given ? print_scene(*name) : show_scenes();
    };
  });
}

}  // namespace ra2d
