// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/analysis/sound_pressure.hpp"
#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/python.hpp"
#include "host/store/result_reader.hpp"
#include "host/study/study_table.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

struct PageRequest {
  std::vector<fs::path> files;
  fs::path output;
  SoundRequest sound;
  bool quiet = false;
};

int make_page(PageRequest& request) {
  if (request.output.empty()) request.output = name_of(request.files.front()) + ".html";
  require_derived_output(request.output, request.files);
  if (const fs::path ending = request.output.extension(); ending != ".html" && ending != ".htm")
    throw RequestError(
        fmt::format("'{}': expected a name of a page that ends in .html", request.output.string()));
  std::string command = "ra2d report";
  // the page is sent to others: no folders of this disk
  const auto named = [](const fs::path& file) {
    return shell_word(
        (file.is_absolute() && file.has_filename() ? file.filename() : file).string());
  };
  for (const fs::path& file : request.files) command += ' ' + named(file);
  command += " -o " + named(request.output) + sound_options(request.sound);
  nlohmann::ordered_json page_request{{"command", "report"},
                                      {"quiet", request.quiet},
                                      {"made", path_text(request.output)},
                                      {"files", path_texts(request.files)},
                                      {"line", path_text(command)}};
  const fs::path table =
      request.files.size() == 1 ? study_table_of(request.files.front()) : fs::path();
  page_request["subject"] = table.empty() ? "results" : "study";
  require_microphones(request.sound);
  if (!table.empty() && request.sound.asks())
    throw RequestError("--at is of results: a study keeps its sound with keep = [\"sound\"]");
  add_microphones_to(page_request, request.sound);
  if (table.empty())
    for (const fs::path& file : request.files) read_stamp(file);
  else
    read_study_table(table);
  PartialFile page(request.output);
  page_request["output"] = path_text(page.path());
  const int status = ask_python(page_request);
  if (status != exit_status::done) return status;
  page.sync();
  page.publish();
  if (!request.quiet)
    print("  {:<17}{}, {}\n", "page", printable(request.output.string()),
          bytes_text(fs::file_size(request.output)));
  return status;
}

}  // namespace

void add_report(CLI::App& app, ChosenCommand& chosen) {
  const auto request = std::make_shared<PageRequest>();
  CLI::App* report = app.add_subcommand(
      "report",
      "one page to keep or to send, complete in itself: figures, pictures, the sound to play, the "
      "scene to copy; needs Python");
  report->add_option("OUT.h5", request->files, "results of 'ra2d run'; or one study's folder")
      ->required()
      ->check(path());
  report
      ->add_option("-o,--output", request->output,
                   "the page [the first result's name with .html, in the current folder]")
      ->type_name("PAGE.html")
      ->check(path());
  add_microphones(*report, request->sound);
  report->add_flag("--quiet", request->quiet, "print nothing but errors");
  report->callback([request, &chosen] { chosen.run = [request] { return make_page(*request); }; });
}

}  // namespace ra2d
