// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/study/study_points.hpp"

/// Warnings about a study before its runs are made.
namespace ra2d {

/// Throws RequestError where a combination is asked for with several seeds and no seed changes its
/// scene (its faces are measured, flat or of peaks): its runs would be one run, and their spread
/// and intervals nothing.
void require_other_seeds(const StudyPoints& points, const PointCensus& census);

/// Dimensions that change no scene, as a step that the scheme does not take; and doubts of the
/// study's scenes (scene_doubts), each once: of the first combination, and of those that differ
/// from it in one dimension. At most `most_doubts`, and how many more there are.
std::vector<std::string> study_doubts(const StudyPoints& points, const PointCensus& census);
inline constexpr std::size_t most_doubts = 6;

}  // namespace ra2d
