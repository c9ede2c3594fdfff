// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/python.hpp"
#include "host/store/result_reader.hpp"
#include "host/study/study_table.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

struct CompareRequest {
  fs::path a, b;
  bool json = false;
};

/// Reports damage of a result or of a study's table as the other commands do.
void require_readable(const fs::path& side) {
  if (const fs::path table = study_table_of(side); !table.empty())
    read_study_table(table);
  else if (!fs::is_directory(side) && (is_hdf5(side) || side.extension() == ".h5"))
    read_stamp(side);
}

int compare(const CompareRequest& request) {
  for (const fs::path& side : {request.a, request.b}) require_readable(side);
  return ask_python({{"command", "compare"},
                     {"a", path_text(request.a)},
                     {"b", path_text(request.b)},
                     {"json", request.json}});
}

}  // namespace

void add_compare(CLI::App& app, ChosenCommand& chosen) {
  const auto request = std::make_shared<CompareRequest>();
  CLI::App* command =
      app.add_subcommand("compare",
                         "what differs between two results, studies or scenes, and whether the "
                         "answers differ by more than chance; needs Python");
  command->add_option("A", request->a, "result of 'ra2d run', folder of a study, or scene")
      ->required()
      ->check(path())
      ->transform(scene_or_name());
  command->add_option("B", request->b, "what it is compared with")
      ->required()
      ->check(path())
      ->transform(scene_or_name());
  command->add_flag("--json", request->json,
                    "print everything as JSON, in SI units; differences in dB or as 100 ln(b/a)");
  command->callback([request, &chosen] { chosen.run = [request] { return compare(*request); }; });
}

}  // namespace ra2d
