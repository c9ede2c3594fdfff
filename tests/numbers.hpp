// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <numbers>

namespace ra2d::test {

inline constexpr double pi = std::numbers::pi;
/// Distance from 1 to the next double, 2^-52: twice the largest relative error of one rounding.
inline constexpr double eps = std::numeric_limits<double>::epsilon();
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace ra2d::test
