// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "host/device/marches.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// A device with memory of its own. Nothing else in ra2d knows how bytes come there or back.
namespace ra2d {

/// Scenes of one form and one shape of their teams, to be marched in one launch. All addresses are
/// of the device.
struct ScenesToMarch {
  Form form = Form::semi_implicit;
  TeamShape shape;
  int count = 0;
  const int* scenes = nullptr;  // which of those below
  const SceneTables* tables = nullptr;
  SceneState* states = nullptr;
  const std::int64_t* targets = nullptr;
  double most_seconds = 1e9;  // what each may take, where the lanes have a clock
  double* seconds = nullptr;  // out: what each took
  double tick = 1e-9;         // s, of their clock
  int multiprocessors = 1;    // that the device has
};

/// Work that a device does in the order in which it was given; several queues work side by side.
/// May be called by several threads. Throws std::runtime_error with what the driver says.
class DeviceQueue {
 public:
  virtual ~DeviceQueue() = default;
  virtual void zero(char* device, std::size_t bytes) = 0;
  /// `host` must stay as it is until wait() returns.
  virtual void upload(char* device, const void* host, std::size_t bytes) = 0;
  /// `host` holds it once wait() returns.
  virtual void fetch(void* host, const char* device, std::size_t bytes) = 0;
  virtual void march(const ScenesToMarch& scenes) = 0;
  /// Returns when all of it is done.
  virtual void wait() = 0;
};

class Device {
 public:
  virtual ~Device() = default;
  /// Memory of the device, with anything in it, on a cache line. Throws std::bad_alloc.
  virtual char* allocate(std::size_t bytes) = 0;
  virtual void release(char* block, std::size_t bytes) noexcept = 0;
  /// Memory of the host that the device reaches under the same address.
  virtual char* allocate_on_host(std::size_t bytes) = 0;
  virtual void release_on_host(char* block, std::size_t bytes) noexcept = 0;
  virtual std::unique_ptr<DeviceQueue> make_queue() = 0;
  /// Scenes that it marches at one moment.
  virtual int scenes_at_once() const = 0;
  /// How it is called in reports.
  virtual std::string name() const = 0;
  /// Bytes that are free now; 0 where nobody can say.
  virtual std::size_t free_memory() const = 0;
};

/// Where scenes are marched; none: on the threads of the host, in its memory.
Device* march_device();
/// From here on there (for tests); returns where it was before.
Device* march_on(Device* device);

}  // namespace ra2d
