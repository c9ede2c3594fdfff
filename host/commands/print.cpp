// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/print.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

#include "host/base/text.hpp"
#include "host/commands/commands.hpp"

namespace ra2d {
namespace {

int fault_of_stdout = 0;  // errno of the first that was heard

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

void say(std::string_view message) { to_stderr("ra2d: " + printable_lines(message) + '\n'); }

void say_doubts(const std::vector<std::string>& doubts, bool quiet) {
  if (quiet) return;
  for (auto doubt = doubts.begin(); doubt != doubts.end(); ++doubt)
    if (std::find(doubts.begin(), doubt, *doubt) == doubt) say(*doubt);
}

void show(std::string_view progress) {
  to_stderr('\r' + printable(progress) + "\033[K");
  std::fflush(stderr);
}

int finish_printing(int status) {
  note_fault(std::fflush(stdout) == 0);
  if (fault_of_stdout == 0) return status;
  // Whoever reads has enough, as `head` does: no fault, and the status of a filter that SIGPIPE
  // ends.
  if (fault_of_stdout == EPIPE) return status == done ? 128 + SIGPIPE : status;
  say(
      fmt::format("cannot write to the standard output: {}. What was to be printed is cut short, "
                  "files are not",
                  std::strerror(fault_of_stdout)));
  return status == done ? wrong_file : status;
}

}  // namespace ra2d
