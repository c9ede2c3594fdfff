// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/study/study_table.hpp"

namespace ra2d {

/// A warning that several runs of a study have.
struct SharedWarning {
  std::string text;      // of the first of them: others have other numbers in it
  std::string first;     // its name
  std::size_t runs = 0;  // that have it
};

/// The warnings of finished runs, those of most runs first. Two that differ in their numbers alone
/// are one.
std::vector<SharedWarning> shared_warnings(const StudyAnswers& answers);

/// A line for each of the first few: how many runs have it, and the first of them.
std::string warnings_text(const StudyAnswers& answers);

}  // namespace ra2d
