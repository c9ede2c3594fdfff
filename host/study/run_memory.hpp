// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <mutex>
#include <utility>

#include "host/scene/scene.hpp"

namespace ra2d {

/// The memory that runs of areal scenes share in this process. A run is given its part before it
/// has touched it, so that runs which begin at once do not all count on the same. Any thread may
/// call.
class RunMemory {
 public:
  /// `processes` on this machine have equal shares, this one among them.
  explicit RunMemory(int processes) : processes_{processes} {}

  /// The part of one run; free again when destroyed.
  class Part {
   public:
    Part() = default;
    Part(RunMemory* memory, double bytes) : memory_{memory}, bytes_{bytes} {}
    Part(Part&& other) noexcept
        : memory_{std::exchange(other.memory_, nullptr)}, bytes_{other.bytes_} {}
    Part& operator=(Part&&) = delete;
    ~Part();

   private:
    RunMemory* memory_ = nullptr;
    double bytes_ = 0;
  };
  /// For a run of this scene. Plane scenes are light: nothing is counted. Throws MemoryShortage
  /// where there is too little now.
  Part part_for(const Scene& scene);

  /// Whether a run has a part.
  bool in_use() const;
  /// Whether there is so much [bytes] for another run now.
  bool has_room(double needed) const;
  /// Whether there may be once other runs and programs let go of theirs.
  bool may_have_room(double needed) const;

 private:
  double room() const;
  const int processes_;
  mutable std::mutex mutex_;
  double given_ = 0;  // bytes, to all runs
};

}  // namespace ra2d
