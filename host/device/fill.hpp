// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/device/host_copy.hpp"
#include "host/device/layout.hpp"
#include "host/model/model.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// From a model to what a march reads.
namespace ra2d {

/// Fills the tables, whose arrays have their addresses; `host` finds the host's copy of them.
void fill(SceneTables& tables, const Model& model, const PatchSeries& series, const Extents& n,
          const HostCopy& host);

/// Puts a scene where it starts.
void fill(SceneState& state, const Model& model, const ModalStart& start, const Extents& n,
          const HostCopy& host);

}  // namespace ra2d
