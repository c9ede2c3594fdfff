// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "tests/ptx/interpreter.hpp"
#include "tests/warp/scene_on_lanes.hpp"

namespace ra2d::test {

/// The marches as PTX, from a folder that make_ptx.py wrote.
class MarchPrograms {
 public:
  static constexpr std::array<Form, 4> forms = {Form::semi_implicit, Form::staged, Form::implicit,
                                                Form::adaptive};

  static const char* name(Form form);

  explicit MarchPrograms(std::string folder) : folder_{std::move(folder)} {}
  /// Read once.
  const Program& of(Form form);

 private:
  std::string folder_;
  std::map<Form, Program> read_;
};

/// A warp that may touch what a scene has. It runs what `program` holds.
PtxWarp warp_for(const Program& program, SceneOnLanes& scene, PtxWarp::Order order);
/// Marches the scene to a target, or until so many meetings of the lanes are over.
void march(PtxWarp& warp, SceneOnLanes& scene, std::int64_t target,
           std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

}  // namespace ra2d::test
