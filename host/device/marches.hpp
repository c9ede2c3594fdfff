// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// The marches, compiled for a few shapes of a team in files of their own (host/CMakeLists.txt
/// makes them).
namespace ra2d {

/// A team has `width` lanes, and each of them one mode of every pack.
struct TeamShape {
  int width = 0, packs = 0;

  constexpr int modes() const { return width * packs; }
  // written out: nvcc leaves defaulted ones without a body
  friend constexpr bool operator==(const TeamShape& a, const TeamShape& b) {
    return a.width == b.width && a.packs == b.packs;
  }
  friend constexpr bool operator<(const TeamShape& a, const TeamShape& b) {
    return a.width != b.width ? a.width < b.width : a.packs < b.packs;
  }
};

/// The smallest shape for so many modes that is compiled.
TeamShape compiled_shape(Form form, int modes);

/// Marches one scene to `target`, on the thread that calls.
using MarchScene = void (*)(const SceneTables&, SceneState&, std::int64_t target);
/// Throws std::logic_error in a build for a GPU, which has none for the host.
MarchScene march_of(Form form, const TeamShape& shape);

}  // namespace ra2d
