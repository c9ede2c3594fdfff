// SPDX-License-Identifier: BSD-3-Clause
#include "tests/ptx/watched_memory.hpp"

#include <utility>

namespace ra2d::test {

void WatchedMemory::allow(std::string name, const void* begin, std::size_t bytes, bool writable) {
  const auto first = reinterpret_cast<std::uint64_t>(begin);
  ranges_.push_back({first, first + bytes, writable, std::move(name),
                     std::vector<Touched>(writable ? (bytes + 2 * piece - 1) / piece : 0)});
}

bool WatchedMemory::holds(std::uint64_t address, int bytes, bool writes,
                          std::uint32_t& hint) const {
  const auto in = [&](const Range& range) {
    return address >= range.begin && address + static_cast<std::uint64_t>(bytes) <= range.end &&
           (range.writable || !writes);
  };
  if (hint < ranges_.size() && in(ranges_[hint])) return true;
  for (std::uint32_t k = 0; k < ranges_.size(); ++k)
    if (in(ranges_[k])) {
      hint = k;
      return true;
    }
  return false;
}

bool WatchedMemory::touch(std::uint64_t address, int bytes, bool writes, int lane, int instruction,
                          std::uint32_t& hint, std::vector<Conflict>& conflicts) {
  if (!holds(address, bytes, writes, hint)) return false;
  Range& range = ranges_[hint];
  if (!range.writable) return true;
  const std::uint64_t from = address - range.begin;
  const std::uint32_t bit = 1u << lane;
  for (std::uint64_t k = from / piece; k * piece < from + static_cast<std::uint64_t>(bytes); ++k) {
    Touched& place = range.pieces[k];
    if (place.written == epoch_ && place.writer != lane)
      conflicts.push_back({place.writing, instruction});
    if (place.read != epoch_) place.readers = 0;
    if (writes) {
      if ((place.readers & ~bit) != 0) conflicts.push_back({place.reading, instruction});
      place.written = epoch_;
      place.writer = lane;
      place.writing = instruction;
    } else {
      place.read = epoch_;
      place.readers |= bit;
      place.reading = instruction;
    }
  }
  return true;
}

}  // namespace ra2d::test
