// SPDX-License-Identifier: BSD-3-Clause
#include "tests/separate_device.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <utility>
#include <vector>

namespace ra2d::test {
namespace {

constexpr int anything = 0xFF;  // not a number, not a place

class SeparateQueue : public DeviceQueue {
 public:
  SeparateQueue(SeparateDevice& device, SeparateDevice::Marches marches)
      : device_{device}, marches_{marches} {}

  void zero(char* device, std::size_t bytes) override {
    later([=] { std::memset(device, 0, bytes); });
  }
  void upload(char* device, const void* host, std::size_t bytes) override {
    later([=] { std::memcpy(device, host, bytes); });
  }
  void fetch(void* host, const char* device, std::size_t bytes) override {
    later([=] { std::memcpy(host, device, bytes); });
  }
  void march(const ScenesToMarch& scenes) override {
    later([scenes, marches = marches_] {
      for (int i = 0; i < scenes.count; ++i) {
        const int scene = scenes.scenes[i];
        const auto begin = std::chrono::steady_clock::now();
        marches(scenes.form, scenes.shape)(scenes.tables[scene], scenes.states[scene],
                                           scenes.targets[scene]);
        scenes.seconds[scene] =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      }
    });
  }
  void wait() override {
    const std::lock_guard lock(mutex_);
    if (work_.empty()) return;
    const SeparateDevice::Opened opened(device_);
    for (const auto& work : std::exchange(work_, {})) work();
  }

 private:
  void later(std::function<void()> work) {
    const std::lock_guard lock(mutex_);
    work_.push_back(std::move(work));
  }
  SeparateDevice& device_;
  const SeparateDevice::Marches marches_;
  std::mutex mutex_;
  std::vector<std::function<void()>> work_;
};

std::size_t whole_pages(std::size_t bytes) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return (bytes + page - 1) / page * page;
}

}  // namespace

SeparateDevice::~SeparateDevice() {
  for (const auto& [block, bytes] : blocks_) munmap(block, bytes);
}

char* SeparateDevice::allocate(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  bytes = whole_pages(bytes);
  if (bytes > left_) throw std::bad_alloc();
  void* const block =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (block == MAP_FAILED) throw std::bad_alloc();
  std::memset(block, anything, bytes);
  if (opened_ == 0) mprotect(block, bytes, PROT_NONE);
  left_ -= bytes;
  blocks_[static_cast<char*>(block)] = bytes;
  return static_cast<char*>(block);
}
void SeparateDevice::release(char* block, std::size_t) noexcept {
  const std::lock_guard lock(mutex_);
  const auto found = blocks_.find(block);
  left_ += found->second;
  munmap(block, found->second);
  blocks_.erase(found);
}

char* SeparateDevice::allocate_on_host(std::size_t bytes) {
  void* const block = std::aligned_alloc(64, (bytes + 63) / 64 * 64);
  if (block == nullptr) throw std::bad_alloc();
  std::memset(block, anything, bytes);
  return static_cast<char*>(block);
}
void SeparateDevice::release_on_host(char* block, std::size_t) noexcept { std::free(block); }

std::unique_ptr<DeviceQueue> SeparateDevice::make_queue() {
  return std::make_unique<SeparateQueue>(*this, marches_);
}

std::size_t SeparateDevice::free_memory() const {
  const std::lock_guard lock(mutex_);
  return left_;
}
std::size_t SeparateDevice::blocks() const {
  const std::lock_guard lock(mutex_);
  return blocks_.size();
}

SeparateDevice::Opened::Opened(SeparateDevice& device) : device_{device} {
  const std::lock_guard lock(device_.mutex_);
  if (device_.opened_++ == 0) device_.protect(PROT_READ | PROT_WRITE);
}
SeparateDevice::Opened::~Opened() {
  const std::lock_guard lock(device_.mutex_);
  if (--device_.opened_ == 0) device_.protect(PROT_NONE);
}

void SeparateDevice::protect(int how) {
  for (const auto& [block, bytes] : blocks_) mprotect(block, bytes, how);
}

}  // namespace ra2d::test
