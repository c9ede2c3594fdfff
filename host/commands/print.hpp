// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// The program's output. Control characters in texts from outside never reach a terminal raw.
namespace ra2d {

/// Opens /dev/null for standard files that the caller has closed. Else a result would be opened
/// under their numbers, and be printed into.
void hold_standard_files();

/// To stdout. Where it is full or closed, finish_printing() says so, so that all files are written
/// first.
void print_text(std::string_view text);

template <class... T>
void print(fmt::format_string<T...> format, T&&... values) {
  print_text(fmt::format(format, std::forward<T>(values)...));
}

/// A line of a report: what it is of, and its value.
void print_line(std::string_view name, std::string_view value);

/// A message on stderr, behind the name of the program. One that cannot be written is lost.
void say(std::string_view message);

/// The system could not do something with a file: says so as a FileError does.
std::string fault_text(const std::filesystem::filesystem_error& fault);

/// Says each doubt once, unless `quiet`: those of two faces may be the same.
void say_doubts(const std::vector<std::string>& doubts, bool quiet);

/// On stderr, a terminal, in the place of the text that was shown before; an empty text clears it.
void show(std::string_view progress);
/// Whether progress is to be shown: on a terminal, unless `quiet`.
bool shows_progress(bool quiet);

/// A time [s] that is left: "4:05", "1:00:00", "4.17 days", or "?" for NaN.
std::string clock_text(double seconds);

/// After the last print: the exit status, 4 for a run that was fine but could not be printed;
/// quietly 141 where the reader of a pipe has closed it.
int finish_printing(int status);

}  // namespace ra2d
