// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <limits>

namespace ra2d {

/// Stands where there is no number.
inline constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace ra2d
