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

PtxWarp warp_for(const Program& program, SceneOnLanes& scene, PtxWarp::Order order) {
  PtxWarp warp(program, order);
  for (const SceneOnLanes::Array& array : scene.arrays())
    warp.allow(array.name, array.begin, array.bytes, array.writable);
  return warp;
}

void march(PtxWarp& warp, SceneOnLanes& scene, std::int64_t target, std::uint64_t most) {
  warp.run({reinterpret_cast<std::uint64_t>(&scene.tables()),
            reinterpret_cast<std::uint64_t>(&scene.state()), static_cast<std::uint64_t>(target),
            most});
}

}  // namespace ra2d::test
