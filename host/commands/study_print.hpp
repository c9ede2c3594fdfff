// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/study/study_runs.hpp"

/// How the commands of a study write its runs.
namespace ra2d {

inline constexpr std::size_t most_named = 5;  // points in a message

/// "1 run", "2 runs"
std::string runs_text(std::size_t count);

/// Why a run has failed, on one line.
std::string reason_of(const FinishedRun& run);

/// "A; B; and 3 more"
std::string names_of(const StudyPoints& points, const std::vector<std::size_t>& chosen);

/// Says which runs have failed, and why.
void say_failed(const StudyRuns& runs, const std::vector<std::size_t>& failed);

}  // namespace ra2d
