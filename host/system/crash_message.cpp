// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/crash_message.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <iterator>

#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

constexpr int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
constexpr int file_error = 4;  // exit status

// what the signal handler reads
std::array<char, 4096> message;
std::atomic<std::size_t> message_size{0};
std::atomic<pid_t> reading_thread{0};
static_assert(std::atomic<pid_t>::is_always_lock_free);

/// The handler's stack: the thread's own may be what overflowed. One thread reads at a time.
alignas(16) std::array<char, 1 << 16> handler_stack;
std::atomic<bool> is_plain{false};

/// The state of the process and of the reading thread before a message: they get it back.
std::array<struct sigaction, std::size(crashes)> actions_before;
stack_t stack_before;

void end_with_message(int signal) {
  if (reading_thread.load() != gettid()) {  // a fault of the program itself
    for (std::size_t i = 0; i < std::size(crashes); ++i)
      if (crashes[i] == signal) sigaction(signal, &actions_before[i], nullptr);
    raise(signal);
    return;
  }
  for (std::size_t done = 0, size = message_size.load(); done < size;) {
    const ssize_t count = write(STDERR_FILENO, message.data() + done, size - done);
    if (count <= 0) break;
    done += static_cast<std::size_t>(count);
  }
  drop_partials();
  _exit(file_error);
}

}  // namespace

CrashMessage::CrashMessage(const std::string& text) {
  if (is_plain.load()) return;
  const std::size_t size = std::min(text.size(), message.size());
  std::memcpy(message.data(), text.data(), size);
  message_size.store(size);
  reading_thread.store(gettid());
  stack_t stack{};
  stack.ss_sp = handler_stack.data();
  stack.ss_size = handler_stack.size();
  sigaltstack(&stack, &stack_before);
  struct sigaction action {};
  action.sa_handler = end_with_message;
  action.sa_flags = SA_ONSTACK;
  sigfillset(&action.sa_mask);
  for (std::size_t i = 0; i < std::size(crashes); ++i)
    sigaction(crashes[i], &action, &actions_before[i]);
}

CrashMessage::~CrashMessage() {
  if (is_plain.load()) return;
  for (std::size_t i = 0; i < std::size(crashes); ++i)
    sigaction(crashes[i], &actions_before[i], nullptr);
  sigaltstack(&stack_before, nullptr);
  reading_thread.store(0);
}

void crash_plainly() {
  is_plain.store(true);
  for (const int signal : crashes) std::signal(signal, SIG_DFL);
}

}  // namespace ra2d
