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
  int node_capacity = 0;                       // Capacity::nodes, which may have grown
};

/// The fault for which a march cannot go on from a saved state, which may come from a file. Empty
/// where every length is that of the scene's arrays, and all indices of the kernels stay within
/// them. `n`: lengths of the scene's arrays with the state's capacity; `steps`, `samples`: of the
/// whole run.
std::string fault_of(const SavedState& saved, const Extents& n, std::int64_t steps,
                     std::int64_t samples);

}  // namespace ra2d
