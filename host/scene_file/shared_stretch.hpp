// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "host/scene/scene.hpp"

/// Runs on one part of the same faces deviate alike: they are no independent draws.
namespace ra2d {

/// The scene without its place on the faces (start, side, offsets of maps), its numerics and what
/// is stored of it.
Scene without_place(Scene scene);

/// Length of the resonator that the slider touches during the run [m]: its own, and what it slides.
double touched_length(const Scene& scene);

/// Two of these runs that touch a part of the same faces, by their places in the list: their scenes
/// differ in nothing but the place on the faces, by less than what is touched. None where there are
/// no such two.
std::optional<std::pair<std::size_t, std::size_t>> two_on_one_stretch(
    const std::vector<Scene>& scenes);

}  // namespace ra2d
