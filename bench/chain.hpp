// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

/// The loop-carried dependency chain of a step and nothing else: no march is faster than these on
/// one core. Written with the kernels' own functions for the host's lanes, for as many packs as the
/// paper's scene has modes (19 and 2 rigid ones).
namespace ra2d::bench {

/// Operations that wait for one another in one step, a shuffle of the sum over lanes counted as
/// one.
int flight_chain_operations();
int contact_chain_operations();

/// So many steps; returns something that depends on all of them.
double flight_chain(std::int64_t steps);
double contact_chain(std::int64_t steps);

}  // namespace ra2d::bench
