// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>

#include "kernels/lanes.hpp"
#include "tests/numbers.hpp"

/// Arguments for kernel tests with eight modes, or as many more as fill the last pack.
namespace ra2d::test {

inline constexpr int width = HostLanes::width;
inline constexpr int K = (8 + width - 1) / width, modes = K * width;
using Real = HostLanes::Real;
using Amplitudes = std::array<double, modes>;

inline const HostLanes lanes;

}  // namespace ra2d::test
