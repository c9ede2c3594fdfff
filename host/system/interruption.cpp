// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/interruption.hpp"

#include <atomic>

namespace ra2d {
namespace {

constinit int interrupted_by = 0;
constinit std::atomic<int> orderly{0}, keepers{0}, checkpoint_requested{0};
static_assert(std::atomic_ref<int>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "signal handlers write and read them");

}  // namespace

void interrupt(int signal) noexcept { std::atomic_ref<int>(interrupted_by).store(signal); }
int interruption() noexcept { return std::atomic_ref<int>(interrupted_by).load(); }
const int* interruption_flag() noexcept { return &interrupted_by; }

void request_checkpoint() noexcept { checkpoint_requested = 1; }
CheckpointKeeper::CheckpointKeeper() noexcept { ++keepers; }
CheckpointKeeper::~CheckpointKeeper() { --keepers; }
bool keeps_checkpoints() noexcept { return keepers > 0; }
bool take_checkpoint_request() noexcept { return checkpoint_requested.exchange(0) != 0; }

OrderlyEnd::OrderlyEnd() noexcept { ++orderly; }
OrderlyEnd::~OrderlyEnd() { --orderly; }
bool ends_orderly() noexcept { return orderly > 0; }

}  // namespace ra2d
