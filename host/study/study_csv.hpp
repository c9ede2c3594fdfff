// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/study/law.hpp"

/// Means and law of a study as tables for other programs (docs/analysis.md has the columns).
namespace ra2d {

/// A line for each combination: its values, and the means over its seeds.
std::string means_csv(const StudyAnswers& answers);

/// A line for each number of each law.
std::string law_csv(const std::vector<StudyLaw>& laws);

}  // namespace ra2d
