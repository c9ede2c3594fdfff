// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/tables.hpp"

namespace ra2d {

/// The Gauss-Legendre rule of gauss_points points on (0, 1).
inline constexpr double gauss_place[gauss_points] = {
    0.5 - 0.5 * 0.96028985649753623, 0.5 - 0.5 * 0.79666647741362674,
    0.5 - 0.5 * 0.52553240991632899, 0.5 - 0.5 * 0.1834346424956498,
    0.5 + 0.5 * 0.1834346424956498,  0.5 + 0.5 * 0.52553240991632899,
    0.5 + 0.5 * 0.79666647741362674, 0.5 + 0.5 * 0.96028985649753623};
inline constexpr double gauss_weight[gauss_points] = {
    0.5 * 0.10122853629037626, 0.5 * 0.22238103445337447, 0.5 * 0.31370664587788729,
    0.5 * 0.36268378337836198, 0.5 * 0.36268378337836198, 0.5 * 0.31370664587788729,
    0.5 * 0.22238103445337447, 0.5 * 0.10122853629037626};

}  // namespace ra2d
