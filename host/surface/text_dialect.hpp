// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/surface/profile.hpp"

/// How texts of numbers from anywhere are written: what parts their numbers, and what their commas
/// are.
namespace ra2d {

using TextFields = std::vector<std::string_view>;

/// An empty field, or one of the words for a missing point.
bool is_missing_word(std::string_view word);

/// A line that has numbers or missing points only, whatever parts them.
bool is_numbers(std::string_view line);

/// The units in brackets of a line.
std::vector<std::string_view> bracketed(std::string_view line);

/// How a file writes its numbers.
struct TextDialect {
  char separator = ' ';  // or ',' with or without blanks, ';', '\t'
  bool decimal_comma = false;
  std::size_t columns = 0;
  bool closed = false;  // a separator at the end of every line

  void split(std::string_view line, TextFields& fields) const;
  /// Finds the columns from the first line of numbers, and whether lines are closed.
  void see_columns(std::string_view line, TextFields& fields);
  std::optional<double> number(std::string_view word, std::string& scratch) const;
};

/// Marks between and in the numbers of the first lines.
struct TextMarks {
  bool semicolon = false, tab = false, blank = false;      // between numbers
  bool comma = false, comma_apart = false, point = false;  // apart: next to a blank or a comma
  std::size_t commas = 0;                                  // most in a line

  void see(std::string_view line);
};

/// How numbers are written, from the marks. `one_comma_parts`: a single comma in every line parts
/// two columns. Throws RequestError, which begins with `where`, where the marks leave it open.
TextDialect understand_marks(const TextMarks& marks, DecimalMark decimal, bool one_comma_parts,
                             const std::string& where);

}  // namespace ra2d
