// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/child_answer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>

#include "host/system/crash_message.hpp"

namespace ra2d {
namespace {

enum Ending { answered = 0, no_memory = 3, failed_to_answer = 4 };

/// Bytes of address space that this process has now; 0 where the system does not say.
double own_memory() {
  double pages = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "re"); file != nullptr) {
    if (std::fscanf(file, "%lf", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void set_limit(int resource, double most) {
  rlimit now{};
  if (getrlimit(static_cast<__rlimit_resource_t>(resource), &now) != 0) return;
  if (most < static_cast<double>(now.rlim_max)) now.rlim_max = static_cast<rlim_t>(most);
  now.rlim_cur = now.rlim_max;
  setrlimit(static_cast<__rlimit_resource_t>(resource), &now);
}

[[noreturn]] void answer(const std::function<std::string()>& ask, int to, pid_t parent,
                         double memory, double seconds) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(failed_to_answer);  // it ended before it could be watched
  crash_plainly();
  std::signal(SIGXCPU, SIG_DFL);
  std::signal(SIGPIPE, SIG_IGN);
  // what the C library says of a heap that is spoilt is no message of ours
  if (const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC); nowhere >= 0)
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, stream);
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_CPU, std::max(1.0, seconds));
  if (const double own = own_memory(); own > 0) set_limit(RLIMIT_AS, own + memory);
  std::string text;
  try {
    text = ask();
  } catch (const std::bad_alloc&) {
    _exit(no_memory);
  } catch (...) {
    _exit(failed_to_answer);
  }
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(to, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR) _exit(failed_to_answer);
    done += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  _exit(answered);
}

std::string ending_of(int status, double memory, double seconds) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return signal == SIGXCPU || signal == SIGKILL
               ? fmt::format("did not end within {:.0f} s", seconds)
               : fmt::format("ended by signal {} ({})", signal, strsignal(signal));
  }
  if (WEXITSTATUS(status) == no_memory)
    return fmt::format("asked for more than {:.0f} MB of memory", memory * 1e-6);
  return "gave no answer";
}

}  // namespace

ChildAnswer ask_in_child(const std::function<std::string()>& ask, double memory, double seconds) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {false, {}, std::strerror(errno)};
  const pid_t parent = getpid(), child = fork();
  if (child == 0) {
    close(ends[0]);
    answer(ask, ends[1], parent, memory, seconds);
  }
  const int error = errno;
  close(ends[1]);
  ChildAnswer found;
  std::array<char, 4096> part;
  ssize_t count = 0;
  while (child > 0 && (count = read(ends[0], part.data(), part.size())) != 0) {
    if (count > 0)
      found.text.append(part.data(), static_cast<std::size_t>(count));
    else if (errno != EINTR)
      break;
  }
  close(ends[0]);
  if (child < 0) return {false, {}, std::strerror(error)};
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return {true, {}, std::strerror(errno)};
  if (WIFEXITED(status) && WEXITSTATUS(status) == answered) return found;
  return {true, {}, ending_of(status, memory, seconds)};
}

}  // namespace ra2d
