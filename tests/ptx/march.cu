// SPDX-License-Identifier: BSD-3-Clause
// The march of one form on the teams of one warp, for the interpreter: tests/ptx/make_ptx.py makes
// PTX of it.
#if defined(RA2D_PTX_PORTABLE_FUNCTIONS)
#include "tests/ptx/portable_functions.hpp"
#endif
// before the kernels
#include "kernels/march.hpp"

using Lanes = ra2d::WarpLanes<RA2D_PTX_WIDTH>;
using Launch = ra2d::March<Kokkos::Cuda, Lanes, ra2d::Form::RA2D_PTX_FORM, RA2D_PTX_PACKS>;

extern "C" __global__ void __launch_bounds__(Launch::most_in_block* Lanes::width,
                                             Launch::least_blocks)
    march(const ra2d::SceneTables* tables, ra2d::SceneState* state, std::int64_t target,
          std::uint64_t end) {
  ra2d::march_scene<Lanes, ra2d::Form::RA2D_PTX_FORM, RA2D_PTX_PACKS>(Lanes(end), *tables, *state,
                                                                      target);
}
