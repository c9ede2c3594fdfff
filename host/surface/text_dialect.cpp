// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/text_dialect.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/surface/profile_lines.hpp"

namespace ra2d {
namespace {

constexpr std::string_view blanks = " \t\r\v\f";

}  // namespace

bool is_missing_word(std::string_view word) {
  if (word.empty() || word.size() > 3) return word.empty();
  std::string lower(word);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower == "nan" || lower == "na" || lower == "n/a";
}

bool is_numbers(std::string_view line) {
  line = line.substr(0, line.find('#'));
  bool any = false;
  while (!(line = trimmed(line)).empty()) {
    const std::size_t end = std::min(line.find_first_of(" \t\r\v\f,;"), line.size());
    const std::string_view word = line.substr(0, end);
    const auto value = to_number(word);
    any |= value && !is_missing_word(word);
    if (!value && !is_missing_word(word)) return false;
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return any;
}

std::vector<std::string_view> bracketed(std::string_view line) {
  std::vector<std::string_view> found;
  while (true) {
    const std::size_t open = line.find_first_of("[(");
    if (open == line.npos) return found;
    const std::size_t close = line.find(line[open] == '[' ? ']' : ')', open);
    if (close == line.npos) return found;
    found.push_back(trimmed(line.substr(open + 1, close - open - 1)));
    line.remove_prefix(close + 1);
  }
}

void TextDialect::split(std::string_view line, TextFields& fields) const {
  line = line.substr(0, line.find('#'));
  fields.clear();
  if (trimmed(line).empty()) return;
  if (separator == ' ' && decimal_comma) {
    while (!(line = trimmed(line)).empty()) {
      const std::size_t end = std::min(line.find_first_of(blanks), line.size());
      fields.push_back(line.substr(0, end));
      line.remove_prefix(end);
    }
  } else if (separator == ' ' || separator == ',') {
    split_words(line, fields);
  } else {
    for (bool more = true; more;) {
      const std::size_t end = std::min(line.find(separator), line.size());
      more = end < line.size();
      fields.push_back(trimmed(line.substr(0, end)));
      line.remove_prefix(more ? end + 1 : end);
    }
  }
  if (closed && fields.size() > 1 && fields.back().empty()) fields.pop_back();
}

void TextDialect::see_columns(std::string_view line, TextFields& fields) {
  split(line, fields);
  if (fields.size() > 2 && fields.back().empty()) {
    closed = true;
    fields.pop_back();
  }
  columns = fields.size();
}

std::optional<double> TextDialect::number(std::string_view word, std::string& scratch) const {
  if (!decimal_comma) return to_number(word);
  if (word.find('.') != word.npos) return {};
  scratch = word;
  std::replace(scratch.begin(), scratch.end(), ',', '.');
  return to_number(scratch);
}

void TextMarks::see(std::string_view line) {
  line = trimmed(line.substr(0, line.find('#')));
  std::size_t in_line = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    semicolon |= c == ';';
    point |= c == '.';
    if (c == ',') {
      ++in_line;
      const auto apart = [&](std::size_t k) {
        return k >= line.size() || line[k] == ',' || blanks.find(line[k]) != blanks.npos;
      };
      comma_apart |= apart(i + 1) || i == 0 || apart(i - 1);
    } else if (blanks.find(c) != blanks.npos) {
      (c == '\t' ? tab : blank) = true;
    }
  }
  commas = std::max(commas, in_line);
  comma |= in_line > 0;
}

TextDialect understand_marks(const TextMarks& marks, DecimalMark decimal, bool one_comma_parts,
                             const std::string& where) {
  const char blank = marks.tab ? '\t' : ' ';
  const auto refuse_mark = [&](const char* why) {
    throw RequestError(
        fmt::format("{}: {}. Say --decimal point, where commas part the columns, or "
                    "--decimal comma",
                    where, why));
  };
  TextDialect dialect;
  if (marks.semicolon || decimal == DecimalMark::comma) {
    dialect.separator = marks.semicolon ? ';' : blank;
    dialect.decimal_comma =
        decimal == DecimalMark::comma || (decimal == DecimalMark::of_the_file && marks.comma);
    if (dialect.decimal_comma && marks.point && marks.comma)
      throw RequestError(
          fmt::format("{}: numbers with points and with commas: write one of them, and "
                      "no groups of thousands",
                      where));
  } else if (!marks.comma) {
    dialect.separator = blank;
  } else if (decimal == DecimalMark::point || marks.comma_apart) {
    dialect.separator = ',';
  } else if (marks.tab || marks.blank) {  // commas inside numbers, blanks between them
    if (marks.point) refuse_mark("points, commas and blanks between digits");
    dialect = {blank, true};
  } else if (marks.point || (marks.commas == 1 && one_comma_parts)) {
    dialect.separator = ',';  // a single column would have no x
  } else {
    refuse_mark("commas between digits may be decimal marks or part the columns");
  }
  return dialect;
}
}  // namespace ra2d
