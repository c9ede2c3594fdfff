// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "kernels/state.hpp"

namespace ra2d {

/// All that a scene's march goes on from, on the host: with it another batch gives the same bits.
struct SavedState {
  CarriedState values;                         // its addresses mean nothing
  std::vector<std::vector<std::byte>> arrays;  // in the order in which visit_arrays names them
  int room = 0;                                // Room::nodes, which may have grown
};

/// What a march could not go on from in a saved state, which may come from a file: empty where
/// every length is that of the scene's arrays, and all that the kernels index with stays within
/// them. `n`: lengths of the scene's arrays with the state's room; `steps`, `samples`: of the whole
/// run.
std::string fault_of(const SavedState& saved, const Extents& n, std::int64_t steps,
                     std::int64_t samples);

}  // namespace ra2d
