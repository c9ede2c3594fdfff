// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "host/device/device.hpp"

/// Memory of the scenes of a batch.
namespace ra2d {

/// Bytes of what a processor, or a GPU, fetches at once. Blocks begin on such a line.
inline constexpr std::size_t host_line = 64, device_line = 128;

class MemorySource;

/// A piece of memory that begins on a cache line; goes back to where it came from.
class Block {
 public:
  Block() = default;
  Block(MemorySource* source, char* data, std::size_t bytes)
      : source_{source}, data_{data}, bytes_{bytes} {}
  ~Block();
  Block(Block&& other) noexcept { *this = std::move(other); }
  Block& operator=(Block&& other) noexcept {
    std::swap(source_, other.source_);
    std::swap(data_, other.data_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  char* data() const { return data_; }
  std::size_t bytes() const { return bytes_; }

 private:
  MemorySource* source_ = nullptr;
  char* data_ = nullptr;
  std::size_t bytes_ = 0;
};

/// Lends blocks, which must not outlive it. May be called by several threads.
class MemorySource {
 public:
  virtual ~MemorySource() = default;
  /// Throws std::bad_alloc.
  virtual Block lend(std::size_t bytes) = 0;
  virtual void take_back(char* data, std::size_t bytes) noexcept = 0;
};

/// Zeros of the host's memory; pages that nobody touches cost nothing.
class HostMemory : public MemorySource {
 public:
  Block lend(std::size_t bytes) override;
  void take_back(char* data, std::size_t bytes) noexcept override;
};

/// Blocks of a device that are used again: to get and to give back memory takes the driver as long
/// as a launch, and stops all others meanwhile. So it is asked for many blocks of a size at once, a
/// slab: for as many as there are already, up to 32 MB, and to half of the limit. What is in them
/// is what the last user left.
class DevicePool : public MemorySource {
 public:
  enum class Kind { on_device, on_host };
  /// `most`: bytes that it holds at the most where it can, what is free among them; 0: no limit.
  DevicePool(Device& device, Kind kind, std::size_t most)
      : device_{device}, kind_{kind}, most_{most} {}
  ~DevicePool() override { give_back_unused(); }
  DevicePool(const DevicePool&) = delete;
  DevicePool& operator=(const DevicePool&) = delete;
  /// A free block that is at most a tenth too large (as much as backend_memory leaves), else a new
  /// one. Gives back all unused slabs first where the limit, or the memory, is reached.
  Block lend(std::size_t bytes) override;
  void take_back(char* data, std::size_t bytes) noexcept override;

 private:
  struct Slab {
    std::size_t block = 0, blocks = 0;  // bytes of each, and how many there are
    std::size_t lent = 0;               // of these
    std::size_t bytes() const { return block * blocks; }
  };
  using Slabs = std::map<char*, Slab>;  // by where they begin

  void add_slab(std::size_t block);
  std::size_t blocks_of_next(std::size_t block) const;
  char* allocate(std::size_t bytes);
  void give_back_unused() noexcept;
  Slabs::iterator slab_of(char* data) { return std::prev(slabs_.upper_bound(data)); }

  Device& device_;
  Kind kind_;
  std::size_t most_;
  std::mutex mutex_;
  Slabs slabs_;
  std::size_t held_ = 0;                    // bytes of all slabs
  std::multimap<std::size_t, char*> free_;  // by size
};

/// Bytes that all scenes of a batch have left.
using MemoryLeft = std::atomic<std::int64_t>;

/// A part of that, until it is destroyed.
class MemoryShare {
 public:
  MemoryShare() = default;
  /// Throws std::bad_alloc where so much is not left. `budget` may be none: then there is no limit.
  MemoryShare(MemoryLeft* budget, std::size_t bytes);
  ~MemoryShare() {
    if (budget_ != nullptr) *budget_ += bytes_;
  }
  MemoryShare(MemoryShare&& other) noexcept { *this = std::move(other); }
  MemoryShare& operator=(MemoryShare&& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }

 private:
  MemoryLeft* budget_ = nullptr;
  std::int64_t bytes_ = 0;
};

}  // namespace ra2d
