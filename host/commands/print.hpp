// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// What the program prints. Control characters in texts from outside never reach a terminal raw.
namespace ra2d {

/// Gives standard files that the caller has closed something harmless to stand for: no result must
/// be opened under their numbers, and printed into.
void hold_standard_files();

/// To stdout. Should it be full or closed, that is told at the end, so that everything else is
/// still written.
void print_text(std::string_view text);

template <class... T>
void print(fmt::format_string<T...> format, T&&... values) {
  print_text(fmt::format(format, std::forward<T>(values)...));
}

/// A message on stderr, behind the name of the program. One that cannot be written is lost.
void say(std::string_view message);

/// What a user should look at, unless `quiet`. What is the same of both faces is said once.
void say_doubts(const std::vector<std::string>& doubts, bool quiet);

/// On stderr, a terminal, over what was shown there before; no text clears it.
void show(std::string_view progress);

/// After the last print: the exit status, 4 for a run that was fine but could not be printed;
/// quietly 141 where the reader of a pipe has closed it.
int finish_printing(int status);

}  // namespace ra2d
