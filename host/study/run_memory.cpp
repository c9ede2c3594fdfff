// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/run_memory.hpp"

#include <algorithm>

#include "host/model/areal_size.hpp"
#include "host/system/machine_memory.hpp"

namespace ra2d {

RunMemory::Part::~Part() {
  if (memory_ == nullptr) return;
  const std::lock_guard lock(memory_->mutex_);
  memory_->given_ -= bytes_;
}

RunMemory::Part RunMemory::part_for(const Scene& scene) {
  if (scene.kind != SceneKind::areal) return {};
  const std::lock_guard lock(mutex_);
  require_areal_memory(scene, room());
  const double bytes = areal_memory(scene) - program_memory;
  given_ += bytes;
  return {this, bytes};
}

bool RunMemory::in_use() const {
  const std::lock_guard lock(mutex_);
  return given_ > 0;
}

bool RunMemory::has_room(double needed) const {
  const std::lock_guard lock(mutex_);
  return needed <= room();
}

bool RunMemory::may_have_room(double needed) const {
  return needed <= static_cast<double>(in_use() ? machine_memory() : attainable_memory());
}

double RunMemory::room() const {
  const auto free = static_cast<double>(available_memory());
  if (!(given_ > 0)) return free;
  const double untouched = given_ + program_memory - static_cast<double>(resident_memory());
  const double room = free - std::max(0.0, untouched);
  if (processes_ == 1) return room;
  return std::min(room, static_cast<double>(machine_memory()) / processes_ - given_);
}

}  // namespace ra2d
