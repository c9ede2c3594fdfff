// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "tests/pack.hpp"
// before the kernels
#include <array>

#include "host/device/launch.hpp"
#include "host/device/marches.hpp"
#include "kernels/march.hpp"

namespace ra2d::test {

static_assert(pack_width == LanesOf<Space>::width);

/// Numbers of packs that are compared: a few, so that sums go over several; and of a warp one,
/// which is enough for the paper's scenes.
#if defined(RA2D_WARPS)
inline constexpr std::array plain_packs{1, 2};
#else
inline constexpr std::array plain_packs{Shapes<Form::staged>::at(1).packs};
#endif

/// The march of production on lanes that are nothing but doubles, with the i-th of these numbers.
template <Form form, int i>
void plain_march(const SceneTables& tables, SceneState& state, std::int64_t target) {
  march_scene<PackLanes, form, plain_packs[i]>(PackLanes(), tables, state, target);
}
/// The march with `packs` packs, one of plain_packs.
template <Form form>
MarchScene plain_march_of(int packs);

#define RA2D_PLAIN_MARCH(form)                                                  \
  template <>                                                                   \
  MarchScene plain_march_of<form>(int packs) {                                  \
    return packs == plain_packs[0] ? plain_march<form, 0>                       \
                                   : plain_march<form, plain_packs.size() - 1>; \
  }

// one form each, in files of their own
template <>
MarchScene plain_march_of<Form::semi_implicit>(int packs);
template <>
MarchScene plain_march_of<Form::staged>(int packs);
template <>
MarchScene plain_march_of<Form::implicit>(int packs);
template <>
MarchScene plain_march_of<Form::adaptive>(int packs);

}  // namespace ra2d::test
