// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/study/study_table.hpp"

namespace ra2d {

/// Whether the values of an axis choose among faces, or stretches of them, and measure nothing.
bool chooses_faces(const StudyAxis& axis);

/// Whether any two runs that differ along this axis alone have other answers. Those of a key
/// without effect are one run.
bool changes_along(const StudyAnswers& answers, const std::vector<double>& amplitude,
                   std::size_t axis);

/// Which runs share faces, and so deviate alike. Runs of different draws are independent. Draws are
/// the seeds; of a study with one seed the values of the axes that choose faces.
struct Draws {
  std::vector<std::string> axes;    // whose values make them; none: nothing is drawn
  std::vector<std::size_t> of_run;  // from 0 to before `count`
  std::size_t count = 1;
  /// Why no group of runs is independent of all others; empty where each draw is.
  std::string dependent;
};
Draws draws_of(const StudyAnswers& answers, const std::vector<double>& amplitude);

}  // namespace ra2d
