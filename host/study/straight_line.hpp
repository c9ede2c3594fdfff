// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <vector>

#include "host/study/draws.hpp"
#include "host/study/law.hpp"

namespace ra2d {

/// Whether the logarithm of each run's amplitude is a straight line in the logarithms of the
/// `fitted` dimensions. Values of the others are averaged first. Only draws that have all points
/// count: those of two thirds of the draws or more (a point may fail at all of them).
StraightLine test_straight_line(const StudyAnswers& answers, const std::vector<double>& amplitude,
                                const std::vector<std::size_t>& fitted, const Draws& draws);

}  // namespace ra2d
