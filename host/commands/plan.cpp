// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/plan.hpp"

#include <cmath>
#include <memory>

#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/threads.hpp"
#include "host/device/backend.hpp"
#include "host/device/batch.hpp"
#include "host/savings/savings.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

struct PlanRequest {
  SceneOptions common;
  double accuracy = 0, budget = 60;  // s of wall time
  std::filesystem::path output;      // the cheaper scene
  bool json = false;
};

int plan_scene(const PlanRequest& request) {
  const SceneOptions& common = request.common;
  const Scene scene = read_scene(common.scene, common.overrides);
  const Backend backend(common.threads, common.device);
  const Model model = make_model(scene);
  const ModalStart start = make_start(model);
  const Batch batch({model}, {start});
  const Plan plan = make_plan(model, batch.bytes(), start);
  say_doubts(model.doubts, common.quiet);
  if (request.json) {
    print_text(plan_json(model, plan));
    return exit_status::done;
  }
  if (!common.quiet) print("# {}, complete:\n{}\n", printable(common.scene.string()), echo(scene));
  print_text(describe(model, plan));
  return exit_status::done;
}

/// Finds what the scene can do without, and writes the scene that does.
int plan_accuracy(PlanRequest& request) {
  const SceneOptions& common = request.common;
  const Scene scene = read_scene(common.scene, common.overrides);
  if (request.output.empty()) request.output = common.scene.stem().string() + "-planned.toml";
  require_derived_output(request.output, files_of(scene));

  SavingsOptions options;
  options.accuracy = request.accuracy;
  options.budget = request.budget;
  const bool shown = shows_progress(common.quiet);
  if (shown) options.progress = [](const std::string& text) { show(text); };
  say_doubts(make_model(scene).doubts, common.quiet);
  const Backend backend(common.threads, common.device);
  const Savings savings = find_savings(scene, options);
  if (shown) show({});
  if (!request.json) print_text(describe(savings));
  write_text(request.output, planned_scene(savings));
  if (request.json)
    print_text(savings_json(savings, request.output));
  else if (!common.quiet)
    print("written    {}\n", printable(request.output.string()));
  return exit_status::done;
}

}  // namespace

void add_plan(CLI::App& app, ChosenCommand& chosen) {
  const auto request = std::make_shared<PlanRequest>();
  CLI::App* plan =
      app.add_subcommand("plan",
                         "says what would be modelled, and why; runs nothing unless --accuracy "
                         "asks what the scene could do without");
  add_scene(*plan, request->common, scene_words)->required();
  CLI::Option* accuracy =
      plan->add_option(
              "--accuracy", request->accuracy,
              "finds by runs the cheapest scheme and step, the fewest modes and the "
              "cheapest faces and spacing that keep level, rate of shocks and their median "
              "duration within this relative accuracy, and writes the scene with them; "
              "a scene.faces that the scene has is kept")
          ->type_name("A")
          ->check(number_from(std::nextafter(0.0, 1.0), std::nextafter(1.0, 0.0),
                              "between 0 and 1, like 0.01"));
  plan->add_option("--budget", request->budget, "wall time it may take, roughly")
      ->type_name("SECONDS")
      ->check(number_from(1e-3, 1e9, "from 1e-3 to 1e9"))
      ->capture_default_str()
      ->needs(accuracy);
  plan->add_option("-o,--output", request->output,
                   "the scene it writes [SCENE's name with -planned.toml, in the "
                   "current folder]")
      ->type_name("OUT.toml")
      ->check(path())
      ->needs(accuracy);
  plan->add_flag("--json", request->json, "prints everything as one JSON object, in SI units");
  add_scene_options(*plan, request->common);
  plan->callback([request, accuracy, &chosen] {
    const bool has_accuracy = accuracy->count() > 0;
    chosen.run = [request, has_accuracy] {
      limit_threads(request->common.threads, request->common.quiet);
      return has_accuracy ? plan_accuracy(*request) : plan_scene(*request);
    };
  });
}

}  // namespace ra2d
