// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/interrupt.hpp"

#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <string_view>

#include "host/ranks/ranks.hpp"
#include "host/system/interruption.hpp"
#include "host/system/partial_file.hpp"
#include "host/system/process.hpp"

namespace ra2d {
namespace {

constexpr int interrupts[] = {SIGINT,    SIGQUIT, SIGTERM, SIGHUP,  SIGALRM,
                              SIGVTALRM, SIGPROF, SIGXCPU, SIGUSR2, SIGUSR1};
bool on_terminal = false;
bool is_silent = false;                     // of several ranks the first says it for all
volatile std::sig_atomic_t keeps_none = 0;  // the command is one that keeps no checkpoints
volatile std::sig_atomic_t came_early = 0;  // SIGUSR1, before it was known which command this is

#ifdef __linux__
/// SIGUSR1 requests a checkpoint. It must not end a run that does not catch it yet, so it is
/// blocked first of all, also before the constructors of the libraries that this program loads.
/// While these are being loaded SIGUSR1 still ends the process, unless the shell has it ignored
/// (trap '' USR1), which changes nothing later.
void hold_checkpoint_signal(int, char**, char**) {
  static const std::uint64_t mask = std::uint64_t{1} << (SIGUSR1 - 1);
  // by itself: sanitizers have their own sigprocmask, and are not ready
  syscall(SYS_rt_sigprocmask, SIG_BLOCK, &mask, nullptr, sizeof mask);
}
[[gnu::section(".preinit_array"), gnu::used]] void (*before_all)(int, char**,
                                                                 char**) = hold_checkpoint_signal;
#endif

std::atomic<const char*> at_once = "ra2d: interrupted\n";

void write_to_terminal(std::string_view text) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
}

void on_signal(int signal) {
  const int before = interruption();
  if (signal == SIGUSR1 && keeps_checkpoints()) return request_checkpoint();
  if (signal == SIGUSR1 && keeps_none == 0) {
    came_early = 1;
    return;
  }
  if (before == 0 && ends_orderly()) return interrupt(signal);
  // a terminal that closes says so twice, by the system and by the shell
  if (before == SIGHUP && signal == SIGHUP) return;
  drop_partials();
  kill_programs();
  if (on_terminal) write_to_terminal("\r\033[K");  // the line of progress
  if (!is_silent)
    write_to_terminal(before == 0
                          ? at_once.load()
                          : "ra2d: interrupted again: only what a checkpoint holds is kept\n");
  _exit(128 + signal);
}

}  // namespace

void catch_interrupts() {
  on_terminal = isatty(STDERR_FILENO) != 0;
  is_silent = launch().rank > 0;
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  for (const int signal : interrupts) sigaddset(&action.sa_mask, signal);
  for (const int signal : interrupts) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) continue;
    // a profiler that was loaded with the program has its own use for it
    if (signal == SIGPROF && before.sa_handler != SIG_DFL) continue;
    sigaction(signal, &action, nullptr);
  }
  ::signal(SIGPIPE, SIG_IGN);
  sigset_t held;
  sigemptyset(&held);
  sigaddset(&held, SIGUSR1);
  sigprocmask(SIG_UNBLOCK, &held, nullptr);
}

void say_when_interrupted(const char* words) { at_once = words; }

void end_at_checkpoint_signal() {
  keeps_none = 1;
  if (came_early != 0) std::raise(SIGUSR1);
}

}  // namespace ra2d
