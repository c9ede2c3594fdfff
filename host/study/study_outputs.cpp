// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/errors.hpp"
#include "host/study/ledger.hpp"
#include "host/study/study_table.hpp"
#include "host/system/input_file.hpp"
#include "host/system/output_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

// how nlohmann's dump() begins what snapshot_text() and status_json() give it
constexpr std::string_view snapshot_begins = "{\n \"format\":", status_begins = "{\n \"shard\":";

bool begins_with(const fs::path& file, std::string_view text) {
  return InputFile(file).beginning(text.size()) == text;
}

/// Whether there is a file with something in it.
bool is_filled(const fs::path& file) {
  std::error_code none;
  return fs::exists(file, none) &&
         (!fs::is_regular_file(file, none) || fs::file_size(file, none) > 0);
}

/// The files in a folder, but folders.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (fs::directory_iterator entry(folder, none), end; !none && entry != end;
       entry.increment(none))
    if (!entry->is_directory(none)) files.push_back(entry->path());
  return files;
}

bool has_ledger(const StudyFolder& folder) {
  const std::string head = ledger_head();
  const std::vector<fs::path> files = files_in(folder.ledgers());
  return std::any_of(files.begin(), files.end(), [&](const fs::path& file) {
    return file.extension() == ".log" && fs::is_regular_file(file) && begins_with(file, head);
  });
}

RequestError not_ours(const fs::path& file, const char* expected) {
  return RequestError(fmt::format(
      "'{}' is there already, and is no {}: it is left as it is. Choose another place with "
      "-o, or move it away",
      file.string(), expected));
}

/// Whether what stands where a study's own table goes may be replaced by it.
bool is_table(const fs::path& file) { return is_study_table(file) || is_damaged_table(file); }

}  // namespace

std::vector<fs::path> inputs_of(const Study& study, std::vector<fs::path> profiles) {
  profiles.push_back(study.file);
  profiles.push_back(study.base);
  return profiles;
}

void require_study_folder(const StudyFolder& folder, const Shard& shard,
                          const std::vector<fs::path>& inputs) {
  const fs::path table = folder.table(), snapshot = folder.snapshot(),
                 status = folder.status(shard);
  for (const fs::path& file : {table, snapshot, status, folder.ledger(shard)})
    if (file != folder.ledger(shard) && is_filled(file)) require_output(file, inputs);
  if (is_filled(snapshot) && !begins_with(snapshot, snapshot_begins))
    throw not_ours(snapshot, "snapshot of a study");
  const bool is_ours = is_filled(snapshot) || has_ledger(folder);
  if (is_filled(table) && !(is_ours && is_table(table)))
    throw not_ours(table, "table of the study in this folder");
  if (is_filled(status) && !(is_ours && begins_with(status, status_begins)))
    throw not_ours(status, "status of a study in this folder");
}

void require_merged_table(const fs::path& output, const Study& study,
                          const std::vector<fs::path>& folders, std::vector<fs::path> inputs) {
  std::error_code none;
  for (const fs::path& path : folders) {
    const StudyFolder folder{path};
    const fs::path parent = folder_of(output);
    const std::string name = output.filename().string();
    if (fs::equivalent(parent, folder.results(), none) ||
        (fs::equivalent(parent, folder.path, none) &&
         (name == folder.snapshot().filename() || name.starts_with("status"))))
      throw RequestError(
          fmt::format("'{}' lies among the files of the study '{}': name a file elsewhere with -o",
                      output.string(), path.string()));
  }
  if (!fs::exists(output, none)) return require_output(output, {});
  bool is_own = false;  // of one of the folders
  for (const fs::path& path : folders) {
    const StudyFolder folder{path};
    is_own = is_own || is_same_file(output, folder.table());
    for (const fs::path& of_folder : {folder.path, folder.ledgers(), folder.results()})
      for (fs::path& file : files_in(of_folder))
        if (file != folder.table()) inputs.push_back(std::move(file));
  }
  require_output(output, inputs);
  if (!is_filled(output) || (is_own && is_table(output))) return;
  constexpr const char* expected = "table of this study";
  if (!is_study_table(output)) throw not_ours(output, expected);
  const StudyAnswers there = read_study_table(output);
  if (there.study != study.text || there.base != study.base_text) throw not_ours(output, expected);
}

}  // namespace ra2d
