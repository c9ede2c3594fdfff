// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace ra2d {

/// Standard normal number `index` of the stream `seed`; any of them, in any order, negative ones
/// too.
double white_noise(std::uint64_t seed, std::int64_t index);

/// Standard normal numbers at the places (first, j), (first + 1, j), ... of the plane `seed`,
/// places of 32 bits. A place has the same number in every row that reaches it. None of the
/// stream's numbers is among them.
void white_noise_row(std::uint64_t seed, std::int64_t first, std::int64_t j, std::span<double> row);

/// The noise at the places -half_width ... places + half_width of Bells (host/surface/bells.hpp).
std::vector<double> noise_about(std::uint64_t seed, int places);

/// Bells at distances of a quarter of the correlation length, each of one white noise number, make
/// the process.
inline constexpr double places_per_length = 4;

/// Heights [m] at n spacing, n = 0 ... nodes - 1, of a Gaussian process with correlation
/// exp(-(x/correlation_length)^2) along a beam of `length` [m]; its mean over the length is 0 and
/// its root mean square rq [m]. The profile is a smooth function of x that the seed and the two
/// lengths fix: other nodes see other points of the same one. The same bits on every platform and
/// compiler.
std::vector<double> gaussian_heights(double rq, double correlation_length, std::uint64_t seed,
                                     double length, int nodes, double spacing);

}  // namespace ra2d
