// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/print.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

#include "host/base/exit_status.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"

namespace ra2d {
namespace {

int fault_of_stdout = 0;  // errno of the first one
std::atomic<bool> progress_is_shown = false;

void note_fault(bool written) {
  if (!written && fault_of_stdout == 0) fault_of_stdout = errno;
}

void to_stderr(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stderr); }

}  // namespace

void hold_standard_files() {
  // stdout for reading: what is written there fails, as it should
  for (const auto& [file, mode] :
       {std::pair{STDIN_FILENO, O_RDONLY}, {STDOUT_FILENO, O_RDONLY}, {STDERR_FILENO, O_WRONLY}})
    if (fcntl(file, F_GETFD) < 0 && open("/dev/null", mode) < 0) return;  // takes the lowest number
}

void print_text(std::string_view text) {
  const std::string safe = printable_lines(text);
  note_fault(std::fwrite(safe.data(), 1, safe.size(), stdout) == safe.size());
}

void print_line(std::string_view name, std::string_view value) {
  print("  {:<17}{}\n", name, value);
}

void say(std::string_view message) {
  const std::string clear = progress_is_shown.exchange(false) ? "\r\033[K" : "";
  to_stderr(clear + "ra2d: " + printable_lines(message) + '\n');
}

std::string fault_text(const std::filesystem::filesystem_error& fault) {
  return fmt::format("cannot read or write '{}': {}", fault.path1().string(),
                     fault.code() == std::errc::too_many_symbolic_link_levels
                         ? std::string("its symbolic links lead in a ring")
                         : fault.code().message());
}

void say_doubts(const std::vector<std::string>& doubts, bool quiet) {
  if (quiet) return;
  for (auto doubt = doubts.begin(); doubt != doubts.end(); ++doubt)
    if (std::find(doubts.begin(), doubt, *doubt) == doubt) say(*doubt);
}

void show(std::string_view progress) {
  to_stderr('\r' + printable(progress) + "\033[K");
  std::fflush(stderr);
  progress_is_shown = !progress.empty();
}

bool shows_progress(bool quiet) { return !quiet && isatty(STDERR_FILENO) != 0; }

std::string clock_text(double seconds) {
  if (std::isnan(seconds)) return "?";
  if (seconds >= 360000) return seconds_text(seconds);
  const int s = static_cast<int>(std::ceil(seconds));
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

int finish_printing(int status) {
  note_fault(std::fflush(stdout) == 0);
  if (fault_of_stdout == 0) return status;
  // The reader has enough, as `head` does: no fault, and the status of a filter that SIGPIPE ends.
  if (fault_of_stdout == EPIPE) return status == exit_status::done ? 128 + SIGPIPE : status;
  say(
      fmt::format("cannot write to the standard output: {}. What was to be printed is cut short, "
                  "files are not",
                  std::strerror(fault_of_stdout)));
  return status == exit_status::done ? exit_status::wrong_file : status;
}

}  // namespace ra2d
