// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <type_traits>
#include <utility>
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#endif

#include "host/device/host_copy.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

using Space = Kokkos::DefaultExecutionSpace;
inline constexpr bool on_host = Kokkos::SpaceAccessibility<Space, Kokkos::HostSpace>::accessible;

/// Every array of a scene, in the order in which they stand in its memory.
template <class Visit>
void visit_arrays(SceneTables& tables, SceneState& state, const Extents& n, Visit&& visit) {
  visit_arrays(tables, n, visit);
  visit_arrays(static_cast<CarriedState&>(state), n, visit);
  visit_arrays(static_cast<Caches&>(state), n, visit);
  visit_arrays(static_cast<WorkSpace&>(state), n, visit);
  visit_arrays(static_cast<HandOut&>(state), n, visit);
}

/// The memory of one scene: a block on the device, zero at first, from which all its arrays come, and
/// the host's copy of it. Each array begins on a cache line, behind a gap that nothing may touch: the
/// address sanitizer watches it.
class Arena {
 public:
  Arena() = default;
  /// `room`: bytes that all scenes of a batch have left, from which this one takes its own; it must
  /// outlive it.
  explicit Arena(std::atomic<std::int64_t>& room) : room_{&room} {}
  ~Arena() { release(); }
  Arena(Arena&& other) noexcept { *this = std::move(other); }
  Arena& operator=(Arena&& other) noexcept {
    release();
    bytes_ = std::exchange(other.bytes_, 0);
    device_ = other.device_;
    host_ = other.host_;
    owned_ = std::move(other.owned_);
    block_ = std::move(other.block_);
    copy_ = std::move(other.copy_);
    room_ = std::exchange(other.room_, nullptr);
    return *this;
  }

  /// Memory for every array of `n`; sets their addresses. Throws std::bad_alloc.
  void provide(SceneTables& tables, SceneState& state, const Extents& n) {
    bytes_ = line;
    visit_arrays(tables, state, n, [&](const char*, const auto* address, std::size_t count) {
      bytes_ += room_for(count * sizeof(*address));
    });
    allocate();
    std::size_t at = line;
    poison(0, line);
    visit_arrays(tables, state, n, [&](const char*, auto*& address, std::size_t count) {
      using T =
          std::remove_const_t<std::remove_pointer_t<std::remove_reference_t<decltype(address)>>>;
      address = reinterpret_cast<T*>(device_ + at);
      const std::size_t used = count * sizeof(T), next = at + room_for(used);
      poison(at + used, next);
      at = next;
    });
  }

  HostCopy on_host_copy() const { return {device_, host_}; }
  std::size_t bytes() const { return bytes_; }

  /// Brings `count` values of an array to the device, or back.
  template <class T>
  void upload(const T* array, std::size_t count) const {
    copy(array, count, true);
  }
  template <class T>
  T* fetch(T* array, std::size_t count) const {
    copy(array, count, false);
    return on_host_copy()(array);
  }

 private:
  static constexpr std::size_t line = 64;
  /// With a gap of a line at the least.
  static std::size_t room_for(std::size_t bytes) { return (bytes + line - 1) / line * line + line; }

  struct Free {
    void operator()(char* block) const { std::free(block); }
  };
  using DeviceBlock = Kokkos::View<char*, Space>;

  void release() {
    if (room_ != nullptr) *room_ += static_cast<std::int64_t>(bytes_);
    bytes_ = 0;
  }

  void allocate() {
    const auto wanted = static_cast<std::int64_t>(bytes_);
    if (room_ != nullptr && room_->fetch_sub(wanted) < wanted) {
      release();
      throw std::bad_alloc();
    }
    if constexpr (on_host) {
      // not through Kokkos: scenes come and go on any thread; and pages that nobody touches cost nothing
      owned_.reset(static_cast<char*>(std::calloc(bytes_ + line, 1)));
      if (!owned_) throw std::bad_alloc();
      host_ = aligned(owned_.get());
      device_ = host_;
    } else {
      try {
        block_ = DeviceBlock("ra2d::scene", bytes_ + line);
        copy_ = Kokkos::create_mirror_view(block_);
      } catch (const std::runtime_error& fault) {
        // Kokkos has one class for all faults; those of the driver are another matter
        if (std::strstr(fault.what(), "failed to allocate") == nullptr) throw;
        throw std::bad_alloc();
      }
      device_ = aligned(block_.data());
      host_ = copy_.data() + (device_ - block_.data());
    }
  }
  static char* aligned(char* block) {
    return block + (line - reinterpret_cast<std::uintptr_t>(block) % line) % line;
  }
  void poison([[maybe_unused]] std::size_t from, [[maybe_unused]] std::size_t to) const {
#if defined(__SANITIZE_ADDRESS__)
    if constexpr (on_host) __asan_poison_memory_region(device_ + from, to - from);
#endif
  }
  template <class T>
  void copy(const T* array, std::size_t count, bool up) const {
    if constexpr (!on_host) {
      using Bytes = Kokkos::View<char*, Space, Kokkos::MemoryUnmanaged>;
      using HostBytes = Kokkos::View<char*, Kokkos::HostSpace, Kokkos::MemoryUnmanaged>;
      const std::size_t at = reinterpret_cast<const char*>(array) - device_;
      const Bytes device(device_ + at, count * sizeof(T));
      const HostBytes host(host_ + at, count * sizeof(T));
      if (up)
        Kokkos::deep_copy(device, host);
      else
        Kokkos::deep_copy(host, device);
    }
  }

  std::atomic<std::int64_t>* room_ = nullptr;
  std::size_t bytes_ = 0;
  char *device_ = nullptr, *host_ = nullptr;
  std::unique_ptr<char, Free> owned_;
  DeviceBlock block_;
  typename DeviceBlock::host_mirror_type copy_;
};

}  // namespace ra2d
