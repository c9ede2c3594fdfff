// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <limits>
#include <numbers>

/// Numbers by their short names, for all tests.
namespace ra2d {

using std::numbers::pi;
inline constexpr double eps = std::numeric_limits<double>::epsilon();
inline constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace ra2d
