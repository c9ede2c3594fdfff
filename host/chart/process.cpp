// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <system_error>

namespace ra2d {
namespace {

using Clock = std::chrono::steady_clock;

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

}  // namespace

ProgramRun run_program(std::vector<std::string> words, Output output, double limit) {
  ProgramRun run;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int ends[2] = {-1, -1};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (output == Output::kept) {
    if (pipe2(ends, O_CLOEXEC) != 0) return run;
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  }
  pid_t child = 0;
  const bool started = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  if (output == Output::kept) {
    close(ends[1]);
    if (started && !read_all(ends[0], limit, run.out)) {
      run.late = true;
      kill(child, SIGKILL);
    }
    close(ends[0]);
  }
  if (!started) return run;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return run;
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return run;
}

std::filesystem::path program_folder() {
  std::error_code none;
  return std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
}

}  // namespace ra2d
