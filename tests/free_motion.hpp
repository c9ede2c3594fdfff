// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/mode_step.hpp"

/// The free motion of one mode in closed form, in long double.
namespace ra2d::test {

struct State {
  long double u, v, square;  // square: the integral of v^2
};

/// U'' + 2 zeta omega U' + omega^2 U = load/mass over a time [s].
State fly(const Mode& mode, long double load, State y, long double t, bool sum = false);

}  // namespace ra2d::test
