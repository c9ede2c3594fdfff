// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/chart/survey.hpp"

/// The choice of points: which settings of which methods are measured at all.
namespace ra2d {

/// Writes a row for every setting and returns those that can be measured; the others say why not.
std::vector<ChartPoint> list_points(Survey& survey);

}  // namespace ra2d
