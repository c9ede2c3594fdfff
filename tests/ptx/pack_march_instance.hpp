// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// in this order: what kernels call must be known before them
#include "tests/ptx/portable_functions.hpp"
//
#include "tests/pack.hpp"
//
#include "kernels/march.hpp"
#include "tests/ptx/march_program.hpp"
#include "tests/ptx/pack_march.hpp"

namespace ra2d::test {

template <Form form>
void march_form(SceneOnLanes& scene, std::int64_t target) {
  constexpr TeamShape shape = shape_of(form);
  using Lanes = PackLanesOf<shape.width>;
  march_scene<Lanes, form, shape.packs>(Lanes(), scene.tables(), scene.state(), target);
}

}  // namespace ra2d::test
