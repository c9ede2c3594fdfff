// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/chart/survey.hpp"

/// States compared at the instants of a chart.
namespace ra2d {

/// Of every point whose stretch was timed: its states against the reference's, or, of a method that
/// makes another model of an impact, against its own finest ones.
void compare_states(Survey& survey, const std::vector<ChartPoint>& points,
                    const StateReference& reference);

}  // namespace ra2d
