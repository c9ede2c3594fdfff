// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <vector>

#include "kernels/schemes/mode_step.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The effect of 2^level ticks of free flight on one mode under a constant modal force `load` [N
/// m^(-1/2)], and on the integral of its V^2 (kernels/adaptive/flight.hpp): one set of rows for
/// each level from `first_level` on.
std::vector<std::array<double, flight_rows>> flight_tables(const Mode& mode, double load,
                                                           double tick, int first_level,
                                                           int levels);

}  // namespace ra2d
