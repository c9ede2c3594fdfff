// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "host/device/batch.hpp"
#include "host/result/energy.hpp"
#include "host/result/record.hpp"

/// A whole run in memory, for tests: from a scene to everything that it records.
namespace ra2d::test {

struct Recording {
  Model model;
  ModalStart start;
  SampleBlock samples;
  std::vector<ShockRow> shocks;  // ended ones, in order of their end
  Snapshot end;
  EnergyBalance energy;
};

struct Launches {
  std::int64_t steps = std::numeric_limits<std::int64_t>::max();  // of one launch
  BatchOptions batch;
};

/// Scenes marched side by side from given starts. They must fit into one batch.
std::vector<Recording> simulate(const std::vector<Model>& models,
                                const std::vector<ModalStart>& starts,
                                const Launches& launches = {});

/// Runs scenes in one batch, each from the start that it asks for.
std::vector<Recording> simulate(const std::vector<Scene>& scenes, const Launches& launches = {});

Recording simulate(const Scene& scene, const Launches& launches = {});

}  // namespace ra2d::test
