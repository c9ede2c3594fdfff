// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/memory.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace ra2d {
namespace {

constexpr std::size_t most_of_slab = 32 << 20;  // bytes

constexpr std::size_t whole_lines(std::size_t bytes, std::size_t line) {
  return (bytes + line - 1) / line * line;
}

}  // namespace

Block::~Block() {
  if (source_ != nullptr) source_->take_back(data_, bytes_);
}

Block HostMemory::lend(std::size_t bytes) {
  // calloc: the system's fresh pages are zero. What it gave stands before the line that is handed
  // on.
  auto* const given = static_cast<char*>(std::calloc(bytes + host_line + sizeof(char*), 1));
  if (given == nullptr) throw std::bad_alloc();
  char* const from = given + sizeof(char*);
  const auto address = reinterpret_cast<std::uintptr_t>(from);
  char* const data = from + whole_lines(address, host_line) - address;
  reinterpret_cast<char**>(data)[-1] = given;
  return {this, data, bytes};
}

void HostMemory::take_back(char* data, std::size_t) noexcept {
  std::free(reinterpret_cast<char**>(data)[-1]);
}

Block DevicePool::lend(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  auto found = free_.lower_bound(bytes);
  if (found == free_.end() || found->first > bytes + bytes / 10) {
    add_slab(whole_lines(bytes, device_line));
    found = free_.lower_bound(bytes);
  }
  Block block(this, found->second, found->first);
  ++slab_of(block.data())->second.lent;
  free_.erase(found);
  return block;
}

void DevicePool::take_back(char* data, std::size_t bytes) noexcept {
  const std::lock_guard lock(mutex_);
  --slab_of(data)->second.lent;
  try {
    free_.emplace(bytes, data);
  } catch (...) {  // it is not lent again, but goes back with its slab
  }
}

/// Throws std::bad_alloc.
void DevicePool::add_slab(std::size_t block) {
  if (most_ > 0 && held_ + block > most_) give_back_unused();
  Slab slab{block, blocks_of_next(block)};
  char* begin = nullptr;
  try {
    begin = allocate(slab.bytes());
  } catch (const std::bad_alloc&) {
    give_back_unused();
    slab.blocks = 1;
    begin = allocate(block);
  }
  held_ += slab.bytes();
  slabs_[begin] = slab;
  for (std::size_t i = 0; i < slab.blocks; ++i) free_.emplace(block, begin + i * block);
}

/// As many as there are of this size. Where memory may get short each has a slab of its own, which
/// goes back without others: scenes that grow have other blocks then.
std::size_t DevicePool::blocks_of_next(std::size_t block) const {
  const std::size_t plenty = most_ / 2;
  std::size_t most = most_of_slab / block, there = 0;
  if (most_ > 0) most = std::min(most, (plenty - std::min(plenty, held_)) / block);
  for (const auto& [begin, slab] : slabs_)
    if (slab.block == block) there += slab.blocks;
  return std::max<std::size_t>(std::min(there, most), 1);
}

char* DevicePool::allocate(std::size_t bytes) {
  return kind_ == Kind::on_device ? device_.allocate(bytes) : device_.allocate_on_host(bytes);
}

void DevicePool::give_back_unused() noexcept {
  for (auto at = slabs_.begin(); at != slabs_.end();) {
    const auto& [begin, slab] = *at;
    if (slab.lent > 0) {
      ++at;
      continue;
    }
    std::erase_if(free_, [&, first = begin, end = begin + slab.bytes()](const auto& block) {
      return block.second >= first && block.second < end;
    });
    held_ -= slab.bytes();
    kind_ == Kind::on_device ? device_.release(begin, slab.bytes())
                             : device_.release_on_host(begin, slab.bytes());
    at = slabs_.erase(at);
  }
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
