// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/tables.hpp"

namespace ra2d {

/// Fills the weights of the Runge-Kutta formula of StageTables, for each pace: the pair of orders
/// 8, 5 and 3 of Dormand and Prince with its continuous output of order 7 (Hairer, Norsett, Wanner:
/// Solving Ordinary Differential Equations I, section II.5 and II.6, DOP853).
void fill_stages(double* table);

}  // namespace ra2d
