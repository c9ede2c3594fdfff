// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/base/text.hpp"
#include "host/base/units.hpp"
#include "host/surface/profile_lines.hpp"
#include "host/surface/text_dialect.hpp"

namespace ra2d {
namespace {

constexpr std::size_t longest_row = std::size_t{16} << 20;                   // bytes
constexpr std::size_t most_lines_before = 1000, most_of_header_line = 2000;  // lines, bytes
constexpr std::size_t rows_that_tell = 20;  // how numbers are written

std::string line_place(const std::filesystem::path& file, std::size_t line) {
  return fmt::format("{}:{}", file.string(), line);
}

/// Entries of the lines before the first row.
struct MatrixHeader {
  std::size_t lines = 0;
  std::string unit;  // as the header has it
  std::size_t unit_line = 0;
  std::optional<double> spacing, spacing_y;  // m
};

/// Reads "spacing = 8 um" (or "spacing_x") or "spacing_y = 8 um": an entry of the header, between
/// commas or semicolons, or behind the unit of the heights.
void read_spacing(const std::filesystem::path& file, std::string_view entry, std::size_t number,
                  MatrixHeader& header) {
  const std::size_t sign = entry.find_first_of("=:");
  if (sign == entry.npos) return;
  std::string_view before = entry.substr(0, sign);
  if (const std::size_t unit = before.find_last_of("])"); unit != before.npos)
    before.remove_prefix(unit + 1);
  std::string name(trimmed(before, " \t#%;*/\""));
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const bool along_x = name == "spacing" || name == "spacing_x";
  if (!along_x && name != "spacing_y") return;
  const std::string text(trimmed(entry.substr(sign + 1), " \t\r\n\""));
  const NumberWithUnit length = read_quantity(text, "m");
  const double metres = length.value.value_or(0);
  if (!(metres > 0) || !std::isfinite(metres))
    throw RequestError(fmt::format("{}: {} = {}{}: expected a length, {}", line_place(file, number),
                                   name, quoted(std::string_view(text)),
                                   length.fault.empty() ? "" : ", which " + length.fault,
                                   quantity_examples("m")));
  std::optional<double>& of_header = along_x ? header.spacing : header.spacing_y;
  if (of_header && *of_header != metres)
    throw RequestError(fmt::format("{}: {} = {} m here and {} m before: expected one",
                                   line_place(file, number), name, metres, *of_header));
  of_header = metres;
}

void read_matrix_header(const std::filesystem::path& file, std::string_view line,
                        std::size_t number, MatrixHeader& header) {
  for (std::string_view rest = line; !rest.empty();) {
    const std::size_t end = std::min(rest.find_first_of(",;"), rest.size());
    read_spacing(file, rest.substr(0, end), number, header);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  for (const auto word : bracketed(line)) {
    const auto unit = to_unit(word), before = to_unit(header.unit);
    if (!unit) continue;
    if (before && before->metres != unit->metres)
      throw RequestError(fmt::format(
          "{}: the header names {} here and {} in line {}: expected one unit, that of the heights, "
          "and a row of them in each line (a profile, or a list of points, is no map)",
          line_place(file, number), unit->name, before->name, header.unit_line));
    header.unit = word;
    header.unit_line = number;
  }
}

[[noreturn]] void refuse_long_row(const std::filesystem::path& file, std::size_t line) {
  throw RequestError(fmt::format("{}: a line of more than {} bytes (is it another file?)",
                                 line_place(file, line), longest_row));
}

/// A first pass over the beginning of the file.
std::pair<TextDialect, MatrixHeader> recognize_matrix(const std::filesystem::path& file,
                                                      DecimalMark decimal) {
  ProfileLines lines(file, longest_row);
  TextMarks marks;
  MatrixHeader header;
  std::string first;
  std::size_t seen = 0;
  while (seen < rows_that_tell && lines.next()) {
    if (lines.too_long()) refuse_long_row(file, lines.number());
    if (is_numbers(lines.text())) {
      if (seen++ == 0) first = lines.text(), header.lines = lines.number() - 1;
      marks.see(lines.text());
    } else if (seen == 0) {
      if (lines.number() > most_lines_before)
        throw RequestError(fmt::format("{}: no line of numbers in the first {}", file.string(),
                                       most_lines_before));
      read_matrix_header(file, lines.text().substr(0, most_of_header_line), lines.number(), header);
    }
  }
  if (seen == 0)
    throw RequestError(fmt::format("{}: no line of numbers, expected a row of heights in each line",
                                   file.string()));
  TextDialect dialect = understand_marks(marks, decimal, false, line_place(file, header.lines + 1));
  TextFields fields;
  dialect.see_columns(first, fields);
  return {dialect, std::move(header)};
}

/// Adds the heights of a row; its fault, empty where there is none.
std::string add_row(const TextDialect& dialect, const TextFields& fields, std::string& scratch,
                    std::vector<double>& numbers) {
  if (fields.size() != dialect.columns)
    return fmt::format("{} heights, and {} in the rows before", fields.size(), dialect.columns);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (is_missing_word(fields[i])) {
      numbers.push_back(quiet_nan);
      continue;
    }
    const auto value = dialect.number(fields[i], scratch);
    if (!value) return fmt::format("height {}: {} is not a number", i + 1, quoted(fields[i]));
    if (!std::isfinite(*value))
      return fmt::format("height {}: {} is not a finite number in double precision", i + 1,
                         quoted(fields[i]));
    numbers.push_back(*value);
  }
  return {};
}

/// How far the numbers of a row or column are from even steps, in steps: number k is
/// numbers[first + k stride]. Number 0 is left out: beside places along x and y it is a corner's.
/// NaN where the ends are missing or alike.
double unevenness(const std::vector<double>& numbers, std::size_t first, std::size_t stride,
                  std::size_t count) {
  const auto at = [&](std::size_t k) { return numbers[first + k * stride]; };
  const double step = (at(count - 1) - at(1)) / static_cast<double>(count - 2);
  double most = 0;
  for (std::size_t k = 1; k < count; ++k)
    most = std::max(most, std::abs(at(k) - at(1) - static_cast<double>(k - 1) * step));
  return most / std::abs(step);
}

/// Doubt of a first row or column that some programs write around the heights: the places of the
/// points. Empty where there is none.
std::string doubt_of_places(const std::filesystem::path& file, const BareMap& map) {
  constexpr double of_places = 0.25, of_heights = 2;  // steps: a print's rounding; a rough face
  constexpr std::size_t fewest = 10;                  // numbers that are not even by chance
  for (const bool along_y : {false, true}) {
    const std::size_t count = along_y ? map.ny : map.nx, stride = along_y ? map.nx : 1;
    if (count < fewest || !(unevenness(map.numbers, 0, stride, count) <= of_places) ||
        unevenness(map.numbers, along_y ? 1 : map.nx, stride, count) <= of_heights)
      continue;
    const char* const line = along_y ? "column" : "row";
    return fmt::format(
        "{}: the numbers of its first {} go in even steps, as places along {} do. They are read as "
        "heights: if they are none, take that {} off the file",
        file.string(), line, along_y ? 'y' : 'x', line);
  }
  return {};
}

}  // namespace

BareMap read_map_text(const std::filesystem::path& file, DecimalMark decimal) {
  const auto [dialect, header] = recognize_matrix(file, decimal);
  BareMap map;
  map.nx = dialect.columns;
  map.spacing = header.spacing;
  map.spacing_y = header.spacing_y;
  map.unit = to_unit(header.unit);
  if (map.nx < 2)
    throw RequestError(
        fmt::format("{}: one number, expected a row of heights in each line (a profile is no map)",
                    line_place(file, header.lines + 1)));
  ProfileLines lines(file, longest_row);
  TextFields fields;
  std::string scratch;
  NumbersAtEnds at_ends;
  std::vector<LineFault> faults;
  while (faults.size() < most_faults && lines.next()) {
    if (lines.number() <= header.lines) continue;
    if (lines.too_long()) refuse_long_row(file, lines.number());
    dialect.split(lines.text(), fields);
    if (fields.empty()) continue;
    at_ends.see(fields.back(), lines.has_end());
    std::string fault = add_row(dialect, fields, scratch, map.numbers);
    ++map.ny;
    if (map.ny > 1)
      require_map_size(file.string(), static_cast<double>(map.nx), static_cast<double>(map.ny));
    if (fault.empty()) continue;
    if (!lines.has_end()) fault += " (the line has no end: was the file cut off here?)";
    faults.push_back({lines.number(), std::move(fault)});
  }
  if (!faults.empty()) refuse(file, std::move(faults));
  require_map_size(file.string(), static_cast<double>(map.nx), static_cast<double>(map.ny));
  map.doubt = at_ends.may_be_cut() ? doubt_of_last_line(file) : doubt_of_places(file, map);
  return map;
}

}  // namespace ra2d
