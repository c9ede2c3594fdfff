// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/chart/survey.hpp"

/// Timed stretches: what every point costs, and how well its energy closes.
namespace ra2d {

/// The first timing of every point, over as long a stretch as the time given allows; returns the
/// points that came through, the coarse ones first.
std::vector<ChartPoint> first_stretches(Survey& survey, std::vector<ChartPoint> points);

/// Another timing of each that is expected to end by `end`, over the same stretch.
void repeat_stretches(Survey& survey, const std::vector<ChartPoint>& points, double end);

}  // namespace ra2d
