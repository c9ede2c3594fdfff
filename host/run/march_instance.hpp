// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/run/launch.hpp"
#include "kernels/march.hpp"
#include "kernels/schemes/backward_euler.hpp"

namespace ra2d {

template <int K>
void march(const TablesView& tables, const StatesView& states, std::int64_t target) {
  March<Space, BackwardEuler, K>{tables, states, target}.launch(Space{});
}

}  // namespace ra2d
