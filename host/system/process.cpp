// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

namespace ra2d {
namespace {

using Clock = std::chrono::steady_clock;

/// The programs that run, for signal handlers: each the leader of a process group; 0 where there is
/// none.
constinit std::array<std::atomic<pid_t>, 64> running{};
/// Programs that are being started: between the fork and its entry above.
constinit std::atomic<int> starting{0};
static_assert(std::atomic<pid_t>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler reads them");

void put(pid_t from, pid_t to) {
  for (std::atomic<pid_t>& place : running)
    if (pid_t expected = from; place.compare_exchange_strong(expected, to)) return;
}

/// Reads to the end of a pipe; false when `limit` seconds were over before.
bool read_all(int pipe, double limit, std::string& text) {
  const Clock::time_point begun = Clock::now();
  for (char part[4096];;) {
    const double left = limit - std::chrono::duration<double>(Clock::now() - begun).count();
    if (left <= 0) return false;
    pollfd waiting{pipe, POLLIN, 0};
    if (poll(&waiting, 1, static_cast<int>(1000 * std::min(left, 3600.0)) + 1) <= 0) continue;
    const ssize_t count = read(pipe, part, sizeof part);
    if (count > 0)
      text.append(part, static_cast<std::size_t>(count));
    else if (count == 0 || errno != EINTR)
      return true;
  }
}

/// The child's side of a fork, where only the simplest calls are allowed: becomes the program, with
/// a group of its own, that ends with its parent. Does not return.
void become(char** argv, int input, int output, int failure, pid_t parent,
            const sigset_t& unblocked) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);  // it has ended before that
  setpgid(0, 0);
  signal(SIGPIPE, SIG_DFL);  // handlers fall back by themselves
  if (input >= 0) dup2(input, STDIN_FILENO);
  if (output >= 0) dup2(output, STDOUT_FILENO);
  sigprocmask(SIG_SETMASK, &unblocked, nullptr);
  execvp(argv[0], argv);
  const int error = errno;
  [[maybe_unused]] const ssize_t written = write(failure, &error, sizeof error);
  _exit(127);
}

}  // namespace

ProgramRun run_program(std::vector<std::string> words, Output output, double limit, int input) {
  ProgramRun run;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int ends[2] = {-1, -1}, failure[2] = {-1, -1};
  const auto close_all = [&] {
    for (const int end : {ends[0], ends[1], failure[0], failure[1]})
      if (end >= 0) close(end);
  };
  if ((output == Output::kept && pipe2(ends, O_CLOEXEC) != 0) || pipe2(failure, O_CLOEXEC) != 0) {
    close_all();
    return run;
  }
  // from the fork until it is known here, no interrupt of this thread may end the parent alone; one
  // of another thread waits (kill_programs)
  sigset_t all, unblocked;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &unblocked);
  ++starting;
  const pid_t parent = getpid(), child = fork();
  if (child == 0) become(argv.data(), input, ends[1], failure[1], parent, unblocked);
  if (child > 0) {
    setpgid(child, child);  // both do, so that it is done for either
    put(0, child);
  }
  --starting;
  pthread_sigmask(SIG_SETMASK, &unblocked, nullptr);
  close(std::exchange(ends[1], -1));
  close(std::exchange(failure[1], -1));
  int error = 0;
  const bool started = child > 0 && read(failure[0], &error, sizeof error) == 0;
  if (started && output == Output::kept && !read_all(ends[0], limit, run.out)) {
    run.late = true;
    kill(-child, SIGKILL);
  }
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  put(child, 0);
  close_all();
  if (started) run.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return run;
}

void kill_programs() noexcept {
  // a second at most: the thread that starts one goes on meanwhile
  for (int i = 0; starting > 0 && i < 1000; ++i) usleep(1000);
  for (const std::atomic<pid_t>& child : running)
    if (const pid_t group = child.load(); group > 0) kill(-group, SIGKILL);
}

std::filesystem::path program_folder() {
  std::error_code none;
  return std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
}

}  // namespace ra2d
