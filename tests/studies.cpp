// SPDX-License-Identifier: BSD-3-Clause
#include "tests/studies.hpp"

#include "host/study/ledger.hpp"
#include "host/study/study_points.hpp"
#include "host/study/study_table.hpp"
#include "tests/child.hpp"

namespace ra2d::test {

std::string timeless_table(const std::filesystem::path& folder) {
  const StudyPoints points(parse_snapshot(read_file(folder / "study.json"), "study.json"));
  FinishedRuns finished;
  finished.add(StudyFolder{folder});
  for (auto& [key, run] : finished.runs) run.figures.wall_seconds = 0;
  const Folder temporary;
  const std::filesystem::path file = temporary.path() / "timeless.h5";
  write_study_table(file, points, PointCensus(points), finished);
  return read_file(file);
}

}  // namespace ra2d::test
