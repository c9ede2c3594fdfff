// SPDX-License-Identifier: BSD-3-Clause
#include "tests/studies.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/study/ledger.hpp"
#include "host/study/study_points.hpp"
#include "host/study/study_table.hpp"
#include "tests/child.hpp"

namespace ra2d::test {

std::string timeless_table(const std::filesystem::path& folder) {
  const StudyPoints points(study_of(StudyFolder{folder}));
  FinishedRuns finished;
  finished.add(StudyFolder{folder});
  for (auto& [key, run] : finished.runs) run.figures.wall_seconds = 0;
  const Folder aside;
  finished.folders = {aside.path()};  // as from the folder's own table
  const std::filesystem::path file = aside.path() / "timeless.h5";
  write_study_table(file, points, PointCensus(points), finished);
  const StudyAnswers here = read_study_table(file), there = read_study_table(folder / "results.h5");
  EXPECT_EQ(here.status, there.status);
  EXPECT_TRUE(std::equal(here.v_rms.begin(), here.v_rms.end(), there.v_rms.begin(),
                         there.v_rms.end(),
                         [](double a, double b) { return a == b || (a != a && b != b); }));
  return read_file(file);
}

}  // namespace ra2d::test
