// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/device/marches.hpp"
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

/// How a GPU marches a form: scenes with up to 24 or 32 modes, and areal ones (RA2D_TEST_PACKS).
constexpr TeamShape shape_of(Form form) {
  if (RA2D_TEST_PACKS > 1) return {warp_width, RA2D_TEST_PACKS};
  return form == Form::semi_implicit ? TeamShape{8, 3} : TeamShape{warp_width, 1};
}

/// Scenes, each of a team of its own.
using TeamScenes = std::vector<SceneOnLanes*>;
/// A warp whose teams may touch what their scenes have. It runs what `program` holds.
PtxWarp warp_for(const Program& program, const TeamScenes& scenes, PtxWarp::Order order);
/// Marches the scenes to a target, or until so many meetings of lanes are over.
void march(PtxWarp& warp, const TeamScenes& scenes, std::int64_t target,
           std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

}  // namespace ra2d::test
