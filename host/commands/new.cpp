// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/model/model.hpp"
#include "host/model/point_contacts.hpp"
#include "host/scene_file/materials.hpp"
#include "host/scene_file/new_scene.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

constexpr const char* example_line =
    "ra2d new plate.toml --resonator 'aluminium, 500 x 20 x 3 mm' --slider 'steel, 20 x 20 x 20 "
    "mm' "
    "--slider-face '5 um, 0.5 mm' --load '5 N'";

struct NewRequest {
  std::filesystem::path output;
  std::vector<std::string> answers;  // to the questions, in their order
  bool areal = false, lists_materials = false, force = false, quiet = false;
  SceneKind kind() const { return areal ? SceneKind::areal : SceneKind::plane; }
};

int list_materials() {
  print("{:<16} {:>9} {:>8} {:>8} {:<16} source\n", "material", "E [GPa]", "kg/m^3", "Poisson",
        "loss factor");
  for (const Material& one : materials())
    print("{:<16} {:>9g} {:>8g} {:>8g} {:<16} {}\n", one.name, one.young * 1e-9, one.density,
          one.poisson,
          one.most_loss == 0    ? "-"
          : one.least_loss == 0 ? fmt::format("below {:g}", one.most_loss)
          : one.least_loss == one.most_loss
              ? fmt::format("{:g}", one.most_loss)
              : fmt::format("{:g} to {:g}", one.least_loss, one.most_loss),
          one.source);
  print(
      "Typical values; a damping ratio is half a loss factor. Loss factors of the material alone: "
      "{}. Joints and supports add to them, often ten times as much.\n",
      source_of_losses);
  return exit_status::done;
}

/// Asks on the terminal. Throws RequestError at the end of the input.
std::string ask(const NewSceneQuestion& question) {
  std::fputs(fmt::format("{}\n  [{}]: ", question.words, question.usual).c_str(), stderr);
  std::string line;
  if (!std::getline(std::cin, line))
    throw RequestError("the answers ended before the last question: nothing was written");
  return std::string(trimmed(line));
}

NewScene ask_all(SceneKind kind) {
  say("a new scene. Enter takes what stands in brackets; numbers stand with their unit");
  NewScene scene = usual_new_scene(kind);
  for (const NewSceneQuestion& question : new_scene_questions())
    for (bool is_taken = false; !is_taken;) {
      const std::string answer = ask(question);
      try {
        question.take(scene, answer.empty() ? question.usual : answer);
        is_taken = true;
      } catch (const RequestError& fault) {
        say(fault.what());
      } catch (const FileError& fault) {
        say(fault.what());
      }
    }
  return scene;
}

NewScene take_options(const NewRequest& request) {
  NewScene scene = usual_new_scene(request.kind());
  const auto questions = new_scene_questions();
  for (std::size_t i = 0; i < questions.size(); ++i) {
    if (request.answers[i].empty()) continue;
    try {
      questions[i].take(scene, request.answers[i]);
    } catch (const RequestError& fault) {
      throw RequestError(fmt::format("{}: {}", questions[i].option, fault.what()));
    }
  }
  return scene;
}

void require_new(const NewRequest& request) {
  if (request.output.extension() != ".toml")
    throw RequestError(fmt::format("'{}': expected a name that ends in .toml",
                                   shortened(request.output.string())));
  std::error_code none;
  if (!request.force && exists(symlink_status(request.output, none)))
    throw RequestError(
        fmt::format("'{}' is there already: choose another name, or replace it by "
                    "--force",
                    request.output.string()));
  require_output(request.output, {});
}

void write_new(const NewRequest& request, const std::string& text) {
  PartialFile file(request.output);
  file.write(text);
  file.sync();
  require_new(request);  // answers take their time
  file.publish();
}

bool any_answer(const NewRequest& request) {
  for (const std::string& answer : request.answers)
    if (!answer.empty()) return true;
  return false;
}

int make_new(const NewRequest& request) {
  if (request.lists_materials) return list_materials();
  if (request.output.empty())
    throw RequestError(fmt::format("new: which file? For example: {}", example_line));
  require_new(request);
  const bool has_terminal = isatty(STDIN_FILENO) != 0 && isatty(STDERR_FILENO) != 0;
  const bool asks = !any_answer(request) && (has_terminal || !request.areal);
  if (asks && !has_terminal)
    throw RequestError(fmt::format(
        "new: there is no terminal to ask on, and no option says what the scene is: give one or "
        "more, for example: {}",
        example_line));
  NewScene scene = asks ? ask_all(request.kind()) : take_options(request);
  std::string text = new_scene_text(scene, request.output);
  const std::string nothing = "these answers make no scene that runs, nothing was written: ";
  const bool shown = shows_progress(request.quiet);
  if (shown) show("making the faces, and finding how the slider rests on them ");
  const Model model = [&] {
    try {
      Model made = make_model(parse_scene(text, request.output));
      if (!request.areal) return made;
      const PointContacts contacts = point_contacts_of(made, make_start(made));
      if (contacts.radius > 0) {
        constexpr double shock_error = 0.05;  // of rates and durations
        scene.point_kappa = contacts.hertz.kappa;
        scene.row_spacing = width_on_springs(scene.point_kappa, contacts.radius, contacts.load) /
                            nodes_for(shock_error, Faces::smooth);
      }
      text = new_scene_text(scene, request.output);
      return make_model(parse_scene(text, request.output));
    } catch (const RequestError& fault) {
      throw RequestError(nothing + fault.what());
    }
  }();
  if (shown) show({});
  write_new(request, text);
  say_doubts(model.doubts, request.quiet);
  if (request.quiet) return exit_status::done;
  const std::string name = printable(request.output.string());
  print("{}: a slider of {} on a resonator of {}, {:g} s of sliding at {:g} m/s\n", name,
        scene.slider.material->name, scene.resonator.material->name, model.scene.duration,
        model.scene.speed);
  print("next: ra2d plan {0} (modes, cost), then ra2d run {0}. Its comments say what to change\n",
        name);
  return exit_status::done;
}

}  // namespace

void add_new(CLI::App& app, ChosenCommand& chosen) {
  const auto request = std::make_shared<NewRequest>();
  const auto questions = new_scene_questions();
  request->answers.resize(questions.size());
  CLI::App* command = app.add_subcommand(
      "new",
      "writes a commented scene of your case: asks for it on a terminal, or takes it from "
      "options (the others keep their defaults)");
  command->add_option("OUT.toml", request->output, "file to write, which must not be there")
      ->check(path());
  for (std::size_t i = 0; i < questions.size(); ++i)
    command
        ->add_option(questions[i].option, request->answers[i],
                     fmt::format("{} [{}]", questions[i].words, questions[i].usual))
        ->type_name(questions[i].type)
        ->check(understood("an answer",
                           [](const std::string& text) { return !trimmed(text).empty(); }));
  command->add_flag("--areal", request->areal,
                    "a plate and a block with height maps, instead of beams with profiles");
  command->add_flag("--materials", request->lists_materials,
                    "lists the materials: Young's modulus, density, Poisson's ratio, loss factor, "
                    "source");
  command->add_flag("--force", request->force, "replace the file");
  command->add_flag("--quiet", request->quiet, "print nothing but errors");
  command->callback([request, &chosen] { chosen.run = [request] { return make_new(*request); }; });
}

}  // namespace ra2d
