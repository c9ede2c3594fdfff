// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

#include "host/chart/methods.hpp"
#include "host/device/batch.hpp"
#include "host/model/model.hpp"

/// The scenes that are timed, each brought to where its timing starts.
namespace ra2d::bench {

/// Both readings of the paper: scenes/dang2012.toml and scenes/dang2012-pinned.toml.
enum class Paper { free_slider, pinned_slider };

/// A scene and the state that a march of it starts from.
struct Prepared {
  Model model;
  ModalStart start;
};

/// The scene, marched the paper's own way unless another method is asked for. `variant` > 0 stands
/// for the same with other surfaces.
Scene scene_of(Paper paper, int variant = 0, const Method& method = {});

/// A variant of a scene of the paper at t = 0.
Prepared at_start(Paper paper, int variant = 0, const Method& method = {});

/// Variants 0 to count - 1 after about 20 ms, when the start is forgotten. Marched once in a
/// program.
std::vector<Prepared> settled(Paper paper, int count, const Method& method = {});

/// The scene taken over from a march of it: its step 0 is where the march stands.
Prepared taken_over(const Prepared& from, const Snapshot& now);

/// The scene at the start of the first stretch of so many steps in which something touches.
Prepared before_contact(const Prepared& from, std::int64_t stretch);

/// Nothing can touch: a slider a metre away, the resonator ringing in all its modes.
Prepared in_flight(const Method& method = {});

/// Contact at every step: the free slider does not slide, and rocks so little that no node lifts
/// off.
Prepared in_contact(const Method& method = {});

/// The scene with another choice of nodes whose gap is evaluated.
Prepared evaluating(Prepared scene, Nodes nodes);

Batch make_batch(const std::vector<Prepared>& scenes);

/// Marches to a step however many launches that takes, and drops what was recorded.
void march_on(Batch& batch, int scenes, std::int64_t target);

}  // namespace ra2d::bench
