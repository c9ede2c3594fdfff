// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

namespace ra2d {

/// Standard normal number `index` of the stream `seed`; any of them, in any order, negative ones
/// too.
double white_noise(std::uint64_t seed, std::int64_t index);

/// Heights [m] of a Gaussian process with correlation exp(-(x/correlation_length)^2) at n spacing,
/// n = 0 ... nodes - 1; their mean is 0 and their root mean square rq [m]. The same bits on every
/// platform and compiler.
std::vector<double> gaussian_heights(double rq, double correlation_length, std::uint64_t seed,
                                     int nodes, double spacing);

/// Heights [m] of that same profile, of `drawn` nodes drawn at `drawn_spacing` [m], at other places
/// n spacing: the sum of the filter's bells, which is a smooth function of x. Nodes that fall on
/// drawn ones have their heights to the last bit.
std::vector<double> gaussian_heights_at(double rq, double correlation_length, std::uint64_t seed,
                                        int drawn, double drawn_spacing, int nodes, double spacing);

}  // namespace ra2d
