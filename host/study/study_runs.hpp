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

/// Whether a finished run lacks what the study keeps beside its figures: its sound, or its own
/// result, which is missing or another run's. `tell` is given a sentence on each that is damaged.
/// Empty where the study keeps neither. `study` must outlive it.
std::function<bool(const FinishedRun&)> lacks_what_is_kept(
    const Study& study, const StudyFolder& folder,
    const std::function<void(const std::string&)>& tell);

/// Writes the table of all that the processes of this folder have finished.
void write_table(StudyRuns& runs, const StudyFolder& folder, const std::filesystem::path& table);

}  // namespace ra2d
