// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/scene_memory.hpp"

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "host/base/hash.hpp"
#include "host/system/machine_memory.hpp"

namespace ra2d {

BatchMemory::BatchMemory(Device* device_, std::size_t most)
    : device{device_},
      left{static_cast<std::int64_t>(most)},
      budget{most > 0 ? &left : nullptr},
      left_on_host{machine_memory() / 8} {
  if (device == nullptr) {
    marched = std::make_unique<HostMemory>();
    handed = std::make_unique<HostMemory>();
  } else {
    queue = device->make_queue();
    marched = std::make_unique<DevicePool>(*device, DevicePool::Kind::on_device, most);
    handed = std::make_unique<DevicePool>(*device, DevicePool::Kind::on_host,
                                          static_cast<std::size_t>(left_on_host.load()));
  }
}

SharedTables::Handle SceneMemory::share(Block common, SceneTables& tables, const Extents& n,
                                        bool beyond_limit) const {
  Hash hash;
  visit_shared_arrays(tables, n, [&](const char*, const auto* array, std::size_t count) {
    hash.add(std::string_view(reinterpret_cast<const char*>(&count), sizeof count));
    hash.add(std::string_view(reinterpret_cast<const char*>(array), count * sizeof(*array)));
  });
  const std::size_t bytes = common.bytes();
  return batch_->shared.get(hash.text(), bytes, [&] {
    SharedTables::Entry entry;
    entry.share = MemoryShare(beyond_limit ? nullptr : batch_->budget, bytes);
    if (batch_->device == nullptr) {
      entry.block = std::move(common);
    } else {
      entry.block = batch_->marched->lend(bytes);
      batch_->queue->upload(entry.block.data(), common.data(), bytes);
      batch_->queue->wait();  // whoever shares it next may be on another thread
    }
    return entry;
  });
}

}  // namespace ra2d
