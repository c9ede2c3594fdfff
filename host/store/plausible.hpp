// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/store/result_reader.hpp"

namespace ra2d {

/// The first thing in a result that cannot have come from a run: a time outside it, a place outside
/// the body, a shock longer than the run, a level that its velocity does not have. Empty where
/// nothing is found. All readers ask this before they make anything of the numbers. Times and
/// places are compared with the scene that the result carries; where this program does not
/// understand the scene, they only have to be finite.
std::string implausible(const ResultContents& contents);

/// Whether it is a number, and one of a size that a run can come to, in any unit: squares of larger
/// ones may overflow.
bool is_of_a_run(double value);

}  // namespace ra2d
