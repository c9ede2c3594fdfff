// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/device/marches.hpp"
#include "host/model/model.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"
#include "tests/reductions.hpp"

namespace ra2d::test {

/// A scene at its start, laid out for 32 lanes or fewer, in memory of its own.
class SceneOnLanes {
 public:
  /// Its modes are padded to `least_packs` packs of `width` at the least.
  SceneOnLanes(const Model& model, const ModalStart& start, int least_packs,
               int width = warp_width);
  SceneOnLanes(const Model& model, const ModalStart& start, const TeamShape& least)
      : SceneOnLanes(model, start, least.packs, least.width) {}
  SceneOnLanes(const SceneOnLanes&) = delete;

  /// Rounds the numbers of the tables and of the start to fewer digits. A sum or a sine has another
  /// last bit on another make of processor; rounded, all have the same, and so the same motion.
  void round_numbers();

  int packs() const { return packs_; }
  TeamShape shape() const { return {n_.width, packs_}; }
  const SceneTables& tables() const { return tables_; }
  SceneState& state() { return state_; }

  /// An array, or a struct, that the march may touch.
  struct Array {
    const char* name;
    const void* begin;
    std::size_t bytes;
    bool writable;
  };
  const std::vector<Array>& arrays() const { return named_; }

  /// The differences in bits between two marches of one scene: of their states, samples and shocks;
  /// empty: none.
  std::string differs_from(const SceneOnLanes& other) const;

 private:
  int packs_;
  Extents n_;
  SceneTables tables_;
  SceneState state_;
  std::vector<std::vector<double>> arrays_;
  std::vector<Array> named_;
};

}  // namespace ra2d::test
