// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/study/study_table.hpp"

namespace ra2d {

/// The page of a study, complete in itself (docs/report.md): the law, the levels, the study and its
/// base to copy. `name`: what it is called; `command`: what made the page.
std::string study_page(const StudyAnswers& answers, const std::string& name,
                       const std::string& command);

}  // namespace ra2d
