// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <unordered_set>
#include <utility>

#include "host/base/errors.hpp"
#include "host/store/result_reader.hpp"
#include "host/study/study_table.hpp"

namespace ra2d {

StudyRuns::StudyRuns(Study study, const std::function<void(std::size_t)>& progress)
    : points{std::move(study)}, census{points, progress} {}

std::vector<std::size_t> StudyRuns::failed_points() const {
  std::vector<std::size_t> failed;
  for (const std::size_t point : census.different())
    if (const FinishedRun* run = find(point); run != nullptr && run->status != RunStatus::done)
      failed.push_back(point);
  return failed;
}

std::vector<std::string> StudyRuns::foreign_runs() const {
  const std::unordered_set<Key128> own(census.keys.begin(), census.keys.end());
  std::vector<std::string> names;
  for (const auto& [key, run] : finished.runs)
    if (!own.contains(key)) names.push_back(run.point);
  std::sort(names.begin(), names.end());
  return names;
}

std::function<bool(const FinishedRun&)> lacks_what_is_kept(
    const Study& study, const StudyFolder& folder,
    const std::function<void(const std::string&)>& tell) {
  if (!study.keep_files && !study.keep_sound) return {};
  return [&study, folder, tell](const FinishedRun& run) {
    if (study.keep_sound && run.status == RunStatus::done && !run.sound) return true;
    if (!study.keep_files || run.status == RunStatus::refused) return false;
    const std::string key = key_text(run.run);
    const std::filesystem::path file = folder.path / StudyFolder::result(key);
    try {
      const std::optional<ResultStamp> stamp = stamp_of(file);
      return !stamp || stamp->key != key;
    } catch (const FileError&) {
      if (tell)
        tell(
            fmt::format("'{}' is damaged, or another program has changed it: its run is made again",
                        file.string()));
      return true;
    }
  };
}

void write_table(StudyRuns& runs, const StudyFolder& folder, const std::filesystem::path& table) {
  const TableLock alone(folder);
  runs.finished.add(folder);
  write_study_table(table, runs.points, runs.census, runs.finished);
}

}  // namespace ra2d
