// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_check.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/run/checked_checkpoint.hpp"
#include "host/store/checked_file.hpp"
#include "host/store/result_reader.hpp"
#include "host/study/ledger.hpp"
#include "host/study/study_checkpoints.hpp"
#include "host/study/study_points.hpp"
#include "host/study/study_table.hpp"

namespace ra2d {
namespace {

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Compares the table with the ledgers; returns how many finished runs it does not have yet.
std::size_t check_table(const StudyFolder& folder, const StudyPoints& points,
                        const PointCensus& census, const FinishedRuns& finished,
                        std::vector<std::string>& faults) {
  const std::string file = folder.table().string();
  const CheckedFile hashes = check_hashes(folder.table());
  for (const std::string& fault : hashes.faults)
    faults.push_back(fmt::format("'{}': {}", file, fault));
  if (!hashes.faults.empty()) return 0;
  const StudyAnswers table = read_study_table(folder.table());
  if (table.status.size() != points.size()) {
    faults.push_back(
        fmt::format("'{}' has {} runs, and the study {}: 'ra2d study merge' makes it anew", file,
                    table.status.size(), points.size()));
    return 0;
  }
  std::size_t behind = 0, finished_here = 0;
  for (const Key128& key : census.keys) finished_here += finished.find(key) != nullptr;
  if (finished_here == 0 && !finished.runs.empty())
    return 0;  // all of another version: check_study says so
  for (std::size_t point = 0; point < points.size(); ++point) {
    const FinishedRun* run = finished.find(census.keys[point]);
    const bool is_missing = table.status[point] == static_cast<double>(RunStatus::missing);
    if (is_missing && run != nullptr) ++behind;
    if (is_missing) continue;
    const bool has_sound = !table.lw.empty() && !table.lp.empty() && run != nullptr && run->sound;
    if (has_sound && std::isnan(table.lw[point]) && !std::isnan(run->sound->lw)) {
      ++behind;
      continue;
    }
    if (run == nullptr || table.status[point] != static_cast<double>(run->status) ||
        (!table.v_rms.empty() && !same(run->figures.v_rms, table.v_rms[point])) ||
        (has_sound &&
         !(same(run->sound->lw, table.lw[point]) && same(run->sound->lp, table.lp[point]))))
      faults.push_back(
          fmt::format("'{}' and the ledgers differ in the run {}", file, points.name(point)));
  }
  return behind;
}

/// A run's own result.
void check_kept(const StudyFolder& folder, const FinishedRun& run,
                std::vector<std::string>& faults) {
  const std::string key = key_text(run.run);
  const std::filesystem::path file = folder.path / StudyFolder::result(key);
  if (!std::filesystem::exists(file)) {
    faults.push_back(
        fmt::format("'{}' is missing, the result of the run {}: the study's line makes it again",
                    file.string(), run.point));
    return;
  }
  const CheckedFile found = check_result(file);
  for (const std::string& fault : found.faults)
    faults.push_back(fmt::format("'{}': {}", file.string(), fault));
  if (!found.faults.empty()) return;
  const ResultReader reader(file);
  if (reader.contents().key != key)
    faults.push_back(fmt::format("'{}' is of another run", file.string()));
  else if (run.status == RunStatus::done &&
           !same(reader.contents().summary.v_rms, run.figures.v_rms))
    faults.push_back(fmt::format("'{}' and the ledgers differ in v_rms: {} and {} m/s",
                                 file.string(), reader.contents().summary.v_rms,
                                 run.figures.v_rms));
}

/// Results that no ledger has: of earlier versions of the study, or of runs that were cut off
/// before their entry; how many there are.
std::size_t check_earlier(const StudyFolder& folder, const std::set<std::filesystem::path>& kept,
                          std::vector<std::string>& faults) {
  std::set<std::filesystem::path> files;
  std::error_code none;  // no such folder: no such files
  for (std::filesystem::directory_iterator entry(folder.results(), none), end;
       !none && entry != end; entry.increment(none))
    if (entry->path().extension() == ".h5" && !kept.contains(entry->path()))
      files.insert(entry->path());
  for (const std::filesystem::path& file : files)
    for (const std::string& fault : check_result(file).faults)
      faults.push_back(fmt::format("'{}': {}", file.string(), fault));
  return files.size();
}

/// Checkpoints of runs on their way; how many there are.
std::size_t check_checkpoints(const StudyFolder& folder, std::vector<std::string>& faults) {
  const std::vector<std::filesystem::path> files = study_checkpoints(folder);
  for (const std::filesystem::path& file : files)
    for (const std::string& fault : check_checkpoint(file).faults)
      faults.push_back(fmt::format("'{}': {}", file.string(), fault));
  return files.size();
}

}  // namespace

CheckedStudy check_study(const StudyFolder& folder) {
  CheckedStudy found;
  try {
    const StudyPoints points(study_of(folder));
    const PointCensus census(points);
    FinishedRuns finished;
    finished.add(folder);
    const std::vector<std::size_t> points_to_run = census.different();
    std::size_t done = 0, failed = 0, missing = 0;
    std::set<std::filesystem::path> kept;
    for (const std::size_t point : points_to_run) {
      const FinishedRun* run = finished.find(census.keys[point]);
      ++(run == nullptr ? missing : run->status == RunStatus::done ? done : failed);
      if (!points.study().keep_files || run == nullptr || run->status == RunStatus::refused)
        continue;
      check_kept(folder, *run, found.faults);
      kept.insert(folder.path / StudyFolder::result(key_text(run->run)));
    }
    found.what =
        fmt::format("a study of {} runs: {} done, {} failed, {} not run yet; all hashes agree",
                    points_to_run.size(), done, failed, missing);
    if (!kept.empty()) found.what += fmt::format(", also of {} results", kept.size());
    if (const std::size_t count = check_earlier(folder, kept, found.faults); count > 0)
      found.what += fmt::format(
          ", and of {} result{} that no ledger has, as of earlier versions of "
          "the study",
          count, count == 1 ? "" : "s");
    if (missing == points_to_run.size() && !finished.runs.empty())
      found.what +=
          fmt::format("; the ledgers hold {} finished runs of another version or build of ra2d",
                      finished.runs.size());
    if (const std::size_t count = check_checkpoints(folder, found.faults); count > 0)
      found.what += fmt::format(", and of {} checkpoint{}", count, count == 1 ? "" : "s");
    if (std::filesystem::exists(folder.table())) {
      const std::size_t behind = check_table(folder, points, census, finished, found.faults);
      if (behind > 0)
        found.what += fmt::format(
            "; the table lacks {} of them until the study goes on or is merged", behind);
    } else if (missing == 0) {
      found.faults.push_back(fmt::format("'{}' is missing: 'ra2d study merge' makes it anew",
                                         folder.table().string()));
    }
  } catch (const FileError& fault) {
    found.faults.emplace_back(fault.what());
  } catch (const RequestError& fault) {
    found.faults.emplace_back(fault.what());
  }
  return found;
}

}  // namespace ra2d
