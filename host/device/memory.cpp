// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/memory.hpp"

#include <cstdint>
#include <cstdlib>
#include <new>

namespace ra2d {
namespace {

constexpr std::size_t line = 64;

}  // namespace

Block::~Block() {
  if (source_ != nullptr) source_->take_back(data_, bytes_);
}

Block HostMemory::lend(std::size_t bytes) {
  // calloc: the system's fresh pages are zero. What it gave stands before the line that is handed
  // on.
  auto* const given = static_cast<char*>(std::calloc(bytes + line + sizeof(char*), 1));
  if (given == nullptr) throw std::bad_alloc();
  char* const from = given + sizeof(char*);
  char* const data = from + (line - reinterpret_cast<std::uintptr_t>(from) % line) % line;
  reinterpret_cast<char**>(data)[-1] = given;
  return {this, data, bytes};
}

void HostMemory::take_back(char* data, std::size_t) noexcept {
  std::free(reinterpret_cast<char**>(data)[-1]);
}

Block DevicePool::lend(std::size_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = free_.lower_bound(bytes);
    if (found != free_.end() && found->first <= bytes + bytes / 10) {
      Block block(this, found->second, found->first);
      free_.erase(found);
      return block;
    }
  }
  if (most_ > 0 && held_ + bytes > most_) give_back();
  try {
    return {this, allocate(bytes), bytes};
  } catch (const std::bad_alloc&) {
    give_back();
    return {this, allocate(bytes), bytes};
  }
}

void DevicePool::take_back(char* data, std::size_t bytes) noexcept {
  try {
    const std::lock_guard lock(mutex_);
    free_.emplace(bytes, data);
  } catch (...) {
    release(data, bytes);
  }
}

char* DevicePool::allocate(std::size_t bytes) {
  char* const block =
      kind_ == Kind::on_device ? device_.allocate(bytes) : device_.allocate_on_host(bytes);
  held_ += bytes;
  return block;
}
void DevicePool::release(char* data, std::size_t bytes) noexcept {
  held_ -= bytes;
  kind_ == Kind::on_device ? device_.release(data, bytes) : device_.release_on_host(data, bytes);
}

void DevicePool::give_back() noexcept {
  const std::lock_guard lock(mutex_);
  for (const auto& [bytes, data] : free_) release(data, bytes);
  free_.clear();
}

MemoryShare::MemoryShare(MemoryLeft* budget, std::size_t bytes) {
  const auto wanted = static_cast<std::int64_t>(bytes);
  if (budget != nullptr && budget->fetch_sub(wanted) < wanted) {
    *budget += wanted;
    throw std::bad_alloc();
  }
  budget_ = budget;
  bytes_ = wanted;
}

}  // namespace ra2d
