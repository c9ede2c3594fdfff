// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "host/device/device.hpp"
#include "host/device/marches.hpp"

/// A device on the host, with memory of its own: tests see a batch work as for a GPU
/// without one.
namespace ra2d::test {

/// Only its own work may touch its memory: any other access ends the program. It does nothing
/// until it is waited for, and begins with any numbers but zeros in its memory. Scenes are marched
/// one after the other by the marches of the host, so the bits are theirs, or by those of a test.
class SeparateDevice : public Device {
 public:
  /// Which march a form has for a shape of its teams.
  using Marches = MarchScene (*)(Form, const TeamShape&);
  /// `memory`: bytes that it has.
  explicit SeparateDevice(std::size_t memory = std::size_t{1} << 40, Marches marches = march_of)
      : left_{memory}, marches_{marches} {}
  ~SeparateDevice() override;

  char* allocate(std::size_t bytes) override;
  void release(char* block, std::size_t bytes) noexcept override;
  char* allocate_on_host(std::size_t bytes) override;
  void release_on_host(char* block, std::size_t bytes) noexcept override;
  std::unique_ptr<DeviceQueue> make_queue() override;
  int scenes_at_once() const override { return 8; }
  std::string name() const override { return "a device of the tests"; }
  std::size_t free_memory() const override;

  /// Blocks on the device that somebody has.
  std::size_t blocks() const;

  /// As long as one lives, the memory can be touched.
  class Opened {
   public:
    explicit Opened(SeparateDevice& device);
    ~Opened();
    Opened(const Opened&) = delete;
    Opened& operator=(const Opened&) = delete;

   private:
    SeparateDevice& device_;
  };

 private:
  void protect(int how);

  mutable std::mutex mutex_;
  std::map<char*, std::size_t> blocks_;  // with their lengths
  std::size_t left_;
  Marches marches_;
  int opened_ = 0;
};

/// As long as it lives, scenes are marched there.
class MarchedThere {
 public:
  explicit MarchedThere(SeparateDevice& device) : before_{march_on(&device)} {}
  ~MarchedThere() { march_on(before_); }
  MarchedThere(const MarchedThere&) = delete;

 private:
  Device* before_;
};

}  // namespace ra2d::test
