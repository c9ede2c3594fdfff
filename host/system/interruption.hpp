// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How a process is asked to end. Programs ask from their signal handlers
/// (host/commands/interrupt.hpp does for ra2d); users of the library may call it from anywhere.
namespace ra2d {

/// Asks all marches of this process to end soon: run() then writes what it has, what keeps nothing
/// throws Interrupted. `signal` is what asked; 0 takes it back. Signal handlers may call it.
void interrupt(int signal) noexcept;

/// The signal that asked; 0 while none did.
int interruption() noexcept;

/// Where interruption() stands, for the kernels of a host backend: they read it atomically.
const int* interruption_flag() noexcept;

/// Asks those that keep checkpoints to write one and go on. Signal handlers may call it.
void request_checkpoint() noexcept;

/// While one is there, something is going on that heeds request_checkpoint().
class CheckpointKeeper {
 public:
  CheckpointKeeper() noexcept;
  ~CheckpointKeeper();
  CheckpointKeeper(const CheckpointKeeper&) = delete;
  CheckpointKeeper& operator=(const CheckpointKeeper&) = delete;
};

/// Whether there is one. Signal handlers may call it.
bool keeps_checkpoints() noexcept;

/// Whether one was asked for since this was last called.
bool take_checkpoint_request() noexcept;

/// Thrown where runs were asked to end and nothing of them is kept.
struct Interrupted {};

/// While one is there, something is going on that has results to write when it is interrupted. What
/// does not may be ended at once, wherever it is.
class OrderlyEnd {
 public:
  OrderlyEnd() noexcept;
  ~OrderlyEnd();
  OrderlyEnd(const OrderlyEnd&) = delete;
  OrderlyEnd& operator=(const OrderlyEnd&) = delete;
};

/// Whether there is one. Signal handlers may call it.
bool ends_orderly() noexcept;

}  // namespace ra2d
