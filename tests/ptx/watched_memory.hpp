// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ra2d::test {

/// Arrays that the lanes of a warp may touch, and who touched which place since the last sync.
class WatchedMemory {
 public:
  /// Two lanes touched one place without a sync between, and one of them wrote.
  struct Conflict {
    int earlier, later;  // instructions
  };

  void allow(std::string name, const void* begin, std::size_t bytes, bool writable);
  /// Two accesses on different sides of a sync are in order.
  void sync() { ++epoch_; }

  /// An access by a lane: returns whether it is within an array. A conflict is added to the list.
  /// `hint`: of an earlier access of the same instruction, to look there first.
  bool touch(std::uint64_t address, int bytes, bool writes, int lane, int instruction,
             std::uint32_t& hint, std::vector<Conflict>& conflicts);
  bool holds(std::uint64_t address, int bytes, bool writes, std::uint32_t& hint) const;

 private:
  static constexpr std::uint64_t piece = 4;  // bytes that are watched as one

  /// The last accesses to a piece.
  struct Touched {
    std::uint32_t written = 0, read = 0;  // epochs
    std::uint32_t readers = 0;            // bits
    int writer = 0;
    int writing = 0, reading = 0;  // instructions
  };
  struct Range {
    std::uint64_t begin, end;
    bool writable;
    std::string name;
    std::vector<Touched> pieces;
  };

  std::vector<Range> ranges_;
  std::uint32_t epoch_ = 1;
};

}  // namespace ra2d::test
