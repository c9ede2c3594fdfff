// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/chart/survey.hpp"

/// Long runs and their statistics.
namespace ra2d {

/// Level, rate of shocks and their duration of a few settings over a long stretch, on the same
/// surfaces each.
void run_long(Survey& survey);

}  // namespace ra2d
