// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

namespace ra2d {

/// Finds the host's copy of what stands on the device: the same place, where both share their memory.
class HostCopy {
 public:
  HostCopy(const void* device, void* host)
      : device_{static_cast<const char*>(device)}, host_{static_cast<char*>(host)} {}

  /// What a device address of the block holds, on the host, to be written.
  template <class T>
  T* operator()(const T* on_device) const {
    return reinterpret_cast<T*>(host_ + (reinterpret_cast<const char*>(on_device) - device_));
  }

 private:
  const char* device_;
  char* host_;
};

}  // namespace ra2d
