// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/tables.hpp"

namespace ra2d {

/// Fills CollocationTables, zero before, for each pace: collocation at the points of Lobatto's rule
/// (Hairer, Wanner: Solving Ordinary Differential Equations II, section IV.5, Lobatto IIIA).
void fill_collocation(double* table);

}  // namespace ra2d
