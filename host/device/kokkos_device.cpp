// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/kokkos_device.hpp"

#include <Kokkos_Core.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/device/card.hpp"
#include "host/device/launch.hpp"

namespace ra2d {
namespace {

using DeviceMemory = Space::memory_space;
using PinnedMemory = Kokkos::SharedHostPinnedSpace;
template <class Byte, class Memory>
using Bytes = Kokkos::View<Byte*, Memory, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;

/// Before work is given to Kokkos, which would end the program over the fault of an earlier launch.
void require_no_fault(const Space& instance = Space()) {
  if (const std::string fault = card::fault(instance); !fault.empty())
    throw std::runtime_error("the GPU's driver reports a failure: " + fault);
}

/// Instances of the execution space that no queue has. They are kept to the end of the program: to
/// destroy one may fail where Kokkos lets no exception out.
class SpareInstances {
 public:
  std::unique_ptr<Space> take() {
    {
      const std::lock_guard lock(mutex_);
      if (!spare_.empty()) {
        std::unique_ptr<Space> last = std::move(spare_.back());
        spare_.pop_back();
        return last;
      }
    }
    // where an instance finds no memory for itself, Kokkos ends the program
    constexpr std::size_t needed = 4 << 20;  // bytes
    if (const std::size_t left = card::free_memory(); left > 0 && left < needed)
      throw std::runtime_error("the GPU has " + std::to_string(left >> 20) +
                               " MB of memory left: others have the rest ('" + card::monitor() +
                               "')");
    auto [own] = Kokkos::Experimental::partition_space(Space(), 1);
    return std::make_unique<Space>(std::move(own));
  }
  void take_back(std::unique_ptr<Space> instance) {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(instance));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Space>> spare_;
};
SpareInstances& spare_instances() {
  static auto* const never_destroyed = new SpareInstances;
  return *never_destroyed;
}

class KokkosQueue : public DeviceQueue {
 public:
  KokkosQueue() {
    require_no_fault();
    instance_ = spare_instances().take();
  }
  ~KokkosQueue() override {
    try {
      card::wait(*instance_);
      spare_instances().take_back(std::move(instance_));
    } catch (const std::exception&) {  // told to those who waited for it
      static_cast<void>(instance_.release());
    }
  }
  KokkosQueue(const KokkosQueue&) = delete;
  KokkosQueue& operator=(const KokkosQueue&) = delete;

  void zero(char* device, std::size_t bytes) override {
    give([&] { Kokkos::deep_copy(*instance_, Bytes<char, DeviceMemory>(device, bytes), char{0}); });
  }
  void upload(char* device, const void* host, std::size_t bytes) override {
    give([&] {
      Kokkos::deep_copy(
          *instance_, Bytes<char, DeviceMemory>(device, bytes),
          Bytes<const char, Kokkos::HostSpace>(static_cast<const char*>(host), bytes));
    });
  }
  void fetch(void* host, const char* device, std::size_t bytes) override {
    give([&] {
      Kokkos::deep_copy(*instance_, Bytes<char, Kokkos::HostSpace>(static_cast<char*>(host), bytes),
                        Bytes<const char, DeviceMemory>(device, bytes));
    });
  }
  void march(const ScenesToMarch& scenes) override {
    static std::mutex one_at_a_time;  // what Kokkos knows of a kernel it writes down without a lock
    const std::lock_guard lock(one_at_a_time);
    give([&] {
      ScenesToMarch here = scenes;
      here.multiprocessors = card::multiprocessors();
      here.tick = card::tick();
      launch_march(*instance_, here);
      // Kokkos does not ask. Memory that a launch lacks is none that fewer scenes would leave.
      require_no_fault(*instance_);
    });
  }
  void wait() override { card::wait(*instance_); }

 private:
  /// Where it fails, nothing is being done any more: who gave the work may give back its memory.
  template <class Work>
  void give(const Work& work) try {
    require_no_fault(*instance_);
    work();
  } catch (...) {
    card::settle(*instance_);
    throw;
  }

  std::unique_ptr<Space> instance_;
};

/// Memory of a space that throws std::bad_alloc where there is none.
template <class Memory>
char* allocate_in(std::size_t bytes) {
  require_no_fault();
  try {
    return static_cast<char*>(Memory().allocate("ra2d", bytes));
  } catch (const std::runtime_error&) {
    require_no_fault();
    throw std::bad_alloc();
  }
}
/// After a fault the driver takes nothing back. Who waits for work hears of a failure.
template <class Memory>
void release_in(char* block, std::size_t bytes) noexcept try {
  if (card::fault().empty()) Memory().deallocate("ra2d", block, bytes);
} catch (const std::exception&) {
}

class KokkosDevice : public Device {
 public:
  KokkosDevice() { card::begin(); }
  char* allocate(std::size_t bytes) override { return allocate_in<DeviceMemory>(bytes); }
  void release(char* block, std::size_t bytes) noexcept override {
    release_in<DeviceMemory>(block, bytes);
  }
  char* allocate_on_host(std::size_t bytes) override { return allocate_in<PinnedMemory>(bytes); }
  void release_on_host(char* block, std::size_t bytes) noexcept override {
    release_in<PinnedMemory>(block, bytes);
  }
  std::unique_ptr<DeviceQueue> make_queue() override { return std::make_unique<KokkosQueue>(); }
  int scenes_at_once() const override { return card::scenes_at_once(); }
  std::string name() const override { return card::name(); }
  std::size_t free_memory() const override { return card::free_memory(); }
};

}  // namespace

std::unique_ptr<Device> make_kokkos_device() { return std::make_unique<KokkosDevice>(); }

}  // namespace ra2d
