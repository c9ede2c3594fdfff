// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/interrupt.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/python.hpp"
#include "host/commands/threads.hpp"
#include "host/model/model.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int fewest_seeds = 2, most_seeds = 1000;

struct BudgetRequest {
  fs::path scene;
  std::vector<std::string> overrides;
  int seeds = 5;
  int threads = 0;  // 0: all
  fs::path folder, csv;
  bool json = false, quiet = false;
};

int make_budget(BudgetRequest& request) {
  const Scene scene = read_scene(request.scene, request.overrides);
  if (request.folder.empty()) request.folder = request.scene.stem().string() + "-uncertainty";
  if (!request.csv.empty()) {
    std::vector<fs::path> read = files_of(scene);
    read.push_back(request.scene);
    require_derived_output(request.csv, read, "--csv");
  }
  say_doubts(make_model(scene).doubts, request.quiet);
  Json budget{{"command", "uncertainty"},
              {"quiet", request.quiet},
              {"scene", path_text(request.scene)},
              {"set", path_texts({request.overrides.begin(), request.overrides.end()})},
              {"seeds", request.seeds},
              {"threads", request.threads > 0 ? Json(request.threads) : Json()},
              {"folder", path_text(request.folder)},
              {"json", request.json},
              {"show", shows_progress(request.quiet)}};
  say_when_interrupted("ra2d: interrupted: what is finished is kept; the same command continues\n");
  if (request.csv.empty()) return ask_python(budget);
  PartialFile csv(request.csv, "--csv");
  budget["made"] = path_text(request.csv);
  budget["csv"] = path_text(csv.path());
  const int status = ask_python(budget);
  if (status != exit_status::done) return status;
  csv.sync();
  csv.publish();
  return status;
}

}  // namespace

void add_uncertainty(CLI::App& app, ChosenCommand& chosen) {
  const auto shared = std::make_shared<BudgetRequest>();
  BudgetRequest& request = *shared;
  CLI::App* command = app.add_subcommand(
      "uncertainty",
      "how well level, rate and duration of the shocks are known: chance of the faces, tolerance "
      "or step, spacing, modes, stiffness, and the interval of the whole; needs Python");
  command->add_option("SCENE", request.scene, scene_words)
      ->required()
      ->check(path())
      ->transform(scene_or_name());
  add_overrides(*command, request.overrides, "the scene");
  command
      ->add_option("--seeds", request.seeds,
                   "how many pairs of faces; of measured faces other stretches of the trace, its "
                   "mirror image, and surrogates of equal spectrum")
      ->type_name("N")
      ->check(number_from(fewest_seeds, most_seeds, "from 2 to 1000"))
      ->capture_default_str();
  command
      ->add_option("-o,--output", request.folder,
                   "folder where the runs are kept; the same command continues there "
                   "[SCENE's name with -uncertainty, in the current folder]")
      ->type_name("FOLDER")
      ->check(path());
  command->add_flag("--json", request.json, "print everything as JSON, in SI units");
  command->add_option("--csv", request.csv, "write the table as CSV, too")
      ->type_name("FILE")
      ->check(path());
  command
      ->add_option("--threads", request.threads,
                   "how many threads to use, at most one for each processor [all of them]")
      ->type_name("N")
      ->transform(thread_count());
  command->add_flag("--quiet", request.quiet, "print results and errors only");
  command->callback([shared, &chosen] {
    chosen.run = [shared] {
      if (shared->threads > 0) limit_threads(shared->threads, shared->quiet);
      return make_budget(*shared);
    };
  });
}

}  // namespace ra2d
