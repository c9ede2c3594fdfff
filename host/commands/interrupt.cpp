// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/interrupt.hpp"

#include <csignal>

namespace ra2d {
namespace {

std::atomic<bool> interrupt_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may set it");

void on_signal(int signal) {
  interrupt_asked = true;
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<bool>& catch_interrupts() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  return interrupt_asked;
}

}  // namespace ra2d
