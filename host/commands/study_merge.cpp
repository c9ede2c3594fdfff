// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/study_print.hpp"
#include "host/study/study_outputs.hpp"
#include "host/system/output_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

struct MergeRequest {
  std::vector<fs::path> folders;
  fs::path output;
  bool quiet = false;
};

/// Adds the finished runs of a folder, which must be of the same study.
void add_folder(StudyRuns& runs, const fs::path& folder, const fs::path& first) {
  const Study& study = runs.points.study();
  const Study other = study_of(StudyFolder{folder});
  const char* const difference = other.text != study.text             ? "study"
                                 : other.base_text != study.base_text ? "base scene"
                                 : other.given != study.given         ? "--set"
                                                                      : nullptr;
  if (difference != nullptr)
    throw RequestError(
        fmt::format("'{}' and '{}' are of two studies, their {} differs: expected parts of one. "
                    "Run one of them again with the other's",
                    first.string(), folder.string(), difference));
  runs.finished.add(StudyFolder{folder});
}

void require_all(const StudyRuns& runs, const fs::path& first) {
  std::vector<std::size_t> missing;
  for (const std::size_t point : runs.census.different())
    if (runs.find(point) == nullptr) missing.push_back(point);
  if (missing.empty()) return;
  const Study& study = runs.points.study();
  std::string given;
  for (const std::string& text : study.given) given += " --set " + shell_word(text);
  throw RequestError(fmt::format(
      "cannot merge: {} of {} {} missing: {}. Run them (ra2d study {} -o {}{}), or name the folder "
      "that has them",
      missing.size(), runs_text(runs.census.different().size()), missing.size() == 1 ? "is" : "are",
      names_of(runs.points, missing), shell_word(study.file.string()), shell_word(first.string()),
      given));
}

/// A table of several folders is none of one of them: that folder's own command would replace it by
/// its part.
void require_place_of_all(const MergeRequest& request) {
  if (request.folders.size() == 1) return;
  std::error_code none;
  for (const fs::path& folder : request.folders)
    if (request.output.empty() ||
        (fs::equivalent(folder_of(request.output), folder, none) &&
         request.output.filename() == StudyFolder{folder}.table().filename()))
      throw RequestError(fmt::format(
          "'{}' is the table of the runs in its folder alone: name one for the runs of all {} "
          "folders with -o, like -o all.h5",
          StudyFolder{folder}.table().string(), request.folders.size()));
}

int merge(const MergeRequest& request) {
  const std::vector<fs::path>& folders = request.folders;
  const StudyFolder home{folders.front()};
  StudyRuns runs(study_of(home));
  const Study& study = runs.points.study();
  for (const fs::path& folder : folders) add_folder(runs, folder, folders.front());
  require_all(runs, folders.front());
  require_place_of_all(request);
  const fs::path output = request.output.empty() ? home.table() : request.output;
  require_merged_table(output, study, folders, inputs_of(study, runs.census.profiles));
  write_table(runs, home, output);
  const std::vector<std::size_t> failed = runs.failed_points();
  if (!request.quiet) {
    print("{} of {} folder{}\n", runs_text(runs.census.different().size()), folders.size(),
          folders.size() == 1 ? "" : "s");
    print_line("table", printable(output.string()));
  }
  say_failed(runs, failed);
  return failed.empty() ? exit_status::done : exit_status::failed;
}

}  // namespace

void add_study_merge(CLI::App& study, ChosenCommand& chosen) {
  const auto request = std::make_shared<MergeRequest>();
  CLI::App* command = study.add_subcommand(
      "merge",
      "makes one table of all that folders of one study hold; refuses missing runs, and "
      "different results of one run");
  command->add_option("DIR", request->folders, "folders of one study")->required()->check(path());
  command->add_option("-o,--output", request->output, "the table [of one folder its results.h5]")
      ->type_name("OUT.h5")
      ->check(path());
  command->add_flag("--quiet", request->quiet, "print nothing but errors");
  command->callback([request, &chosen] {
    chosen.takes_checkpoints = true;
    chosen.run = [request] { return merge(*request); };
  });
}

}  // namespace ra2d
