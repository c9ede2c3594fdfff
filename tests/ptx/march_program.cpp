// SPDX-License-Identifier: BSD-3-Clause
#include "tests/ptx/march_program.hpp"

namespace ra2d::test {

const char* MarchPrograms::name(Form form) {
  switch (form) {
    case Form::semi_implicit:
      return "semi_implicit";
    case Form::staged:
      return "staged";
    case Form::implicit:
      return "implicit";
    case Form::adaptive:
      return "adaptive";
  }
  return "";
}

const Program& MarchPrograms::of(Form form) {
  const auto found = read_.find(form);
  if (found != read_.end()) return found->second;
  return read_.emplace(form, Program::read(folder_ + "/" + name(form) + ".ptx")).first->second;
}

PtxWarp warp_for(const Program& program, const TeamScenes& scenes, PtxWarp::Order order) {
  PtxWarp warp(program, order, scenes.front()->shape().width);
  for (int team = 0; team < static_cast<int>(scenes.size()); ++team)
    for (const SceneOnLanes::Array& array : scenes[static_cast<std::size_t>(team)]->arrays())
      warp.allow(array.name, array.begin, array.bytes, array.writable, team);
  return warp;
}

void march(PtxWarp& warp, const TeamScenes& scenes, std::int64_t target, std::uint64_t most) {
  std::vector<std::vector<std::uint64_t>> parameters;
  for (SceneOnLanes* const scene : scenes)
    parameters.push_back({reinterpret_cast<std::uint64_t>(&scene->tables()),
                          reinterpret_cast<std::uint64_t>(&scene->state()),
                          static_cast<std::uint64_t>(target), most});
  warp.run(parameters);
}

}  // namespace ra2d::test
