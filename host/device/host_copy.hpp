// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

namespace ra2d {

/// Finds where the host writes what is to stand on the device: in a copy of a block, or, where both
/// share their memory, at the same address.
class HostCopy {
 public:
  HostCopy() = default;
  HostCopy(const char* device, std::size_t bytes, char* host)
      : device_{device}, bytes_{bytes}, host_{host} {}

  template <class T>
  T* operator()(const T* on_device) const {
    const auto* const address = reinterpret_cast<const char*>(on_device);
    const bool copied = address >= device_ && address < device_ + bytes_;
    return const_cast<T*>(copied ? reinterpret_cast<T*>(host_ + (address - device_)) : on_device);
  }

 private:
  const char* device_ = nullptr;
  std::size_t bytes_ = 0;
  char* host_ = nullptr;
};

}  // namespace ra2d
