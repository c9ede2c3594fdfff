// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#endif

#include "host/device/device.hpp"
#include "host/device/host_copy.hpp"
#include "host/device/memory.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// Where the arrays of scenes stand, on a device or on the host.
namespace ra2d {

/// The tables that scenes have in common, once for all that have the same values in them.
class SharedTables {
 public:
  struct Entry {
    Block block;
    MemoryShare share;
  };
  using Handle = std::shared_ptr<const Entry>;

  /// The entry of this content (its hash, and its length), which `make` makes where no scene has
  /// it. Threads make theirs side by side; of two that make the same, the one that comes second
  /// throws its own away.
  template <class Make>
  Handle get(const std::string& hash, std::size_t bytes, const Make& make) {
    const std::pair key{hash, bytes};
    if (Handle entry = find(key)) return entry;
    Handle made = std::make_shared<const Entry>(make());
    const std::lock_guard lock(mutex_);
    std::weak_ptr<const Entry>& kept = entries_[key];
    if (Handle entry = kept.lock()) return entry;
    kept = made;
    std::erase_if(entries_, [](const auto& e) { return e.second.expired(); });
    return made;
  }
  /// All that are in use.
  std::size_t bytes() const {
    const std::lock_guard lock(mutex_);
    std::size_t sum = 0;
    for (const auto& [key, entry] : entries_)
      if (const Handle handle = entry.lock()) sum += handle->block.bytes();
    return sum;
  }

 private:
  using Key = std::pair<std::string, std::size_t>;
  Handle find(const Key& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(key);
    return found == entries_.end() ? nullptr : found->second.lock();
  }
  mutable std::mutex mutex_;
  std::map<Key, std::weak_ptr<const Entry>> entries_;
};

/// The memory of the scenes of a batch.
struct BatchMemory {
  /// `most`: bytes for all of them together; 0: as many as there are. `device`: none for the host.
  BatchMemory(Device* device, std::size_t most);

  Device* device;
  MemoryLeft left;
  MemoryLeft* budget;                     // none without a limit
  MemoryLeft left_on_host;                // beside a device: memory that cannot be swapped
  std::unique_ptr<DeviceQueue> queue;     // of the device
  std::unique_ptr<MemorySource> marched;  // where marches read and write
  std::unique_ptr<MemorySource> handed;   // where both do, marches and the host
  HostMemory host;
  SharedTables shared;
};

/// The memory of one scene. Each array begins on a line of the cache, behind a gap that nothing may
/// touch: on the host the address sanitizer watches it.
class SceneMemory {
 public:
  explicit SceneMemory(BatchMemory& batch) : batch_{&batch} {}

  /// Memory for the scene's record, zero at first: the padding of its rows stays so. Sets its
  /// addresses. Throws std::bad_alloc, as do all of these.
  void provide(RecordBuffers& out, const Extents& n) {
    const auto arrays = [&](auto&& visit) { visit_arrays(out, n, visit); };
    const std::size_t bytes = lay_out(nullptr, arrays);
    handed_share_ = MemoryShare(on_host() ? batch_->budget : &batch_->left_on_host, bytes);
    handed_ = batch_->handed->lend(bytes);
    if (!on_host()) std::memset(handed_.data(), 0, bytes);
    lay_out(handed_.data(), arrays);
  }

  /// Memory for all other arrays, zero at first; sets their addresses, and brings there what
  /// `fill(HostCopy)` writes into tables and carried state. `beyond_limit`: whatever is left for
  /// others; its share of the budget stays what it was. Where it throws, the memory that it had is
  /// still its own.
  template <class Fill>
  void provide(SceneTables& tables, SceneState& state, const Extents& n, bool beyond_limit,
               const Fill& fill) {
    const auto shared = [&](auto&& visit) { visit_shared_arrays(tables, n, visit); };
    const auto filled = [&](auto&& visit) {
      visit_own_arrays(tables, n, visit);
      visit_arrays(state.carried, n, visit);
      visit_arrays(state.marks, n, visit);
    };
    const auto own = [&](auto&& visit) {
      filled(visit);
      visit_arrays(state.caches, n, visit);
      visit_arrays(state.work, n, visit);
    };
    Block common = batch_->host.lend(lay_out(nullptr, shared));
    lay_out(common.data(), shared);
    const std::size_t bytes = lay_out(nullptr, own), filled_bytes = lay_out(nullptr, filled);
    MemoryShare taken(beyond_limit ? nullptr : batch_->budget, bytes);
    Block block = batch_->marched->lend(bytes);
    lay_out(block.data(), own);
    if (on_host()) {
      fill(HostCopy());
    } else {
      const Block copy = batch_->host.lend(filled_bytes);
      fill(HostCopy(block.data(), filled_bytes, copy.data()));
      batch_->queue->upload(block.data(), copy.data(), filled_bytes);
      batch_->queue->zero(block.data() + filled_bytes, bytes - filled_bytes);
      batch_->queue->wait();
    }
    shared_ = share(std::move(common), tables, n, beyond_limit);
    lay_out(shared_->block.data(), shared);
    std::swap(own_, block);
    if (!beyond_limit) std::swap(own_share_, taken);
  }

  /// Copies what stands where scenes are marched, or puts it there; `there` is an address of it.
  /// Done, and the other address free again, after wait().
  void read(void* to, const void* there, std::size_t bytes) const {
    if (on_host())
      std::memcpy(to, there, bytes);
    else
      batch_->queue->fetch(to, static_cast<const char*>(there), bytes);
  }
  void write(void* there, const void* from, std::size_t bytes) const {
    if (on_host())
      std::memcpy(there, from, bytes);
    else
      batch_->queue->upload(static_cast<char*>(there), from, bytes);
  }
  bool on_host() const { return batch_->device == nullptr; }
  /// Until all of that is done.
  void wait() const {
    if (!on_host()) batch_->queue->wait();
  }

  /// Where scenes are marched, but for what is shared.
  std::size_t bytes() const { return own_.bytes() + (on_host() ? handed_.bytes() : 0); }

 private:
  /// Sets the addresses of arrays that stand one after the other from `base`, unless that is none;
  /// returns how much they take.
  template <class Arrays>
  std::size_t lay_out(char* base, const Arrays& arrays) const {
    const std::size_t line = on_host() ? host_line : device_line;
    std::size_t at = line;
    poison(base, 0, line);
    arrays([&](const char*, auto*& address, std::size_t count) {
      using T =
          std::remove_const_t<std::remove_pointer_t<std::remove_reference_t<decltype(address)>>>;
      if (base != nullptr) address = reinterpret_cast<T*>(base + at);
      const std::size_t end = at + count * sizeof(T);
      at = (end + line - 1) / line * line + line;
      poison(base, end, at);
    });
    return at;
  }
  void poison([[maybe_unused]] char* base, [[maybe_unused]] std::size_t from,
              [[maybe_unused]] std::size_t to) const {
#if defined(__SANITIZE_ADDRESS__)
    if (base != nullptr && on_host()) __asan_poison_memory_region(base + from, to - from);
#endif
  }

  /// The tables in `common`, or those that another scene has and that are the same.
  SharedTables::Handle share(Block common, SceneTables& tables, const Extents& n,
                             bool beyond_limit) const;

  BatchMemory* batch_;
  // in this order: memory goes back before what it took of the budget
  MemoryShare handed_share_, own_share_;
  Block handed_, own_;
  SharedTables::Handle shared_;
};

}  // namespace ra2d
