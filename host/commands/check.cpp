// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/run/checked_checkpoint.hpp"
#include "host/store/checked_file.hpp"
#include "host/store/output_names.hpp"
#include "host/study/study_check.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

struct CheckRequest {
  std::vector<std::filesystem::path> files;
  bool quiet = false;
};

/// The result for one file: its faults, or a line that says that it is whole.
struct Found {
  std::vector<std::string> faults;
  std::string whole;
};

/// Of a result, with the checkpoints beside it from which its run would go on.
Found find_fault(const std::filesystem::path& file) {
  const CheckedFile result = check_result(file);
  Found found{result.faults, fmt::format("{}; {} datasets, {:.1f} MB, all with their hashes",
                                         result.what, result.datasets, result.bytes * 1e-6)};
  const OutputNames names = output_names(file);
  for (const std::filesystem::path& saved : {names.checkpoint, names.previous}) {
    if (!std::filesystem::is_regular_file(saved)) continue;
    const CheckedCheckpoint checkpoint = check_checkpoint(saved);
    for (const std::string& fault : checkpoint.faults)
      found.faults.push_back(fmt::format("'{}': {}", saved.string(), fault));
    found.whole += fmt::format("\n  beside it {}", checkpoint.what);
  }
  return found;
}

Found find_any_fault(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) {
    const CheckedStudy found = check_study(StudyFolder{file});
    return {found.faults, found.what};
  }
  if (InputFile(file).beginning(15) != "ra2d checkpoint") return find_fault(file);
  const CheckedCheckpoint found = check_checkpoint(file);
  return {found.faults, found.what};
}

int check_files(const CheckRequest& request) {
  bool damaged = false;
  for (const std::filesystem::path& file : request.files) {
    const Found found = find_any_fault(file);
    for (const std::string& fault : found.faults)
      say(fmt::format("{}: {}", printable(file.string()), fault));
    if (found.faults.empty() && !request.quiet)
      print("{}: {}\n", printable(file.string()), found.whole);
    damaged = damaged || !found.faults.empty();
  }
  return damaged ? exit_status::wrong_file : exit_status::done;
}

}  // namespace

void add_check(CLI::App& app, ChosenCommand& chosen) {
  const auto request = std::make_shared<CheckRequest>();
  CLI::App* command = app.add_subcommand("check",
                                         "looks at every byte of results, segments, checkpoints "
                                         "and studies: hashes, counts, what is missing");
  command
      ->add_option("FILE", request->files,
                   "OUT.h5, OUT.h5.parts/000001.h5, OUT.h5.checkpoint, or a study's folder")
      ->required()
      ->check(path());
  command->add_flag("--quiet", request->quiet, "print nothing but faults");
  command->callback(
      [request, &chosen] { chosen.run = [request] { return check_files(*request); }; });
}

}  // namespace ra2d
