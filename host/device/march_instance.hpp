// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/device/launch.hpp"
#include "kernels/march.hpp"

namespace ra2d {

template <Form form, int K>
void march(const TablesView& tables, const StatesView& states, const ScenesView& scenes,
           std::int64_t target) {
  March<Space, form, K>{tables, states, scenes, target}.launch(Space{});
}

/// Compiles the march of one form for the i-th number of packs.
#define RA2D_MARCH(form, i)                                                                        \
  template void march<form, Packs::at(i)>(const TablesView&, const StatesView&, const ScenesView&, \
                                          std::int64_t)

/// ... for the lower and the upper half of these numbers: half a form a file.
#define RA2D_MARCH_FEW(form) \
  RA2D_MARCH(form, 0);       \
  RA2D_MARCH(form, 1)
#if defined(RA2D_ONE_MARCH)
#define RA2D_MARCH_MANY(form) RA2D_MARCH(form, 0)
#else
#define RA2D_MARCH_MANY(form) \
  RA2D_MARCH(form, 2);        \
  RA2D_MARCH(form, 3)
#endif

}  // namespace ra2d
