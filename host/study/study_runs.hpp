// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/study/ledger.hpp"
#include "host/study/study_points.hpp"

namespace ra2d {

/// A study, its points, and those of its runs that are finished.
struct StudyRuns {
  StudyPoints points;
  PointCensus census;
  FinishedRuns finished;

  /// Reads the scene of every point; `progress` as for PointCensus.
  explicit StudyRuns(Study study, const std::function<void(std::size_t)>& progress = {});

  const FinishedRun* find(std::size_t point) const { return finished.find(census.keys[point]); }
  /// Points whose run has failed or was refused; of equal runs the first.
  std::vector<std::size_t> failed_points() const;
  /// Finished runs, by name, that no point of the study has: the study was another one then, or
  /// another build of ra2d ran it.
  std::vector<std::string> foreign_runs() const;
};

/// Whether a run's own result, which the study keeps, is missing or is another run's. `tell` is
/// given a sentence on each that is damaged. Empty where the study keeps no results.
std::function<bool(const FinishedRun&)> lacks_its_result(
    const Study& study, const StudyFolder& folder,
    const std::function<void(const std::string&)>& tell);

/// Writes the table of all that the processes of this folder have finished.
void write_table(StudyRuns& runs, const StudyFolder& folder, const std::filesystem::path& table);

}  // namespace ra2d
