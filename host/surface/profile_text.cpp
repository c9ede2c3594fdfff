// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/base/text.hpp"
#include "host/surface/profile_lines.hpp"
#include "host/surface/text_dialect.hpp"
#include "host/surface/usual_faces.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_header_lines = 1000, longest_header = 2000;  // bytes
constexpr std::size_t most_recognized = 200;  // lines of numbers that tell how numbers are written
// Beyond any profile in metres:
constexpr double longest_profile = 10, coarsest = 1e-4, highest = 1e-3;  // m

/// Units of the columns, where the header gives them, and one that belongs to no column.
struct TextHeader {
  struct Unit {
    std::string word;
    std::size_t line = 0;
  };
  std::vector<Unit> units;  // by column; an empty word where the header has none
  Unit loose;
  std::size_t lines = 0;  // before the first line of numbers
};

/// "z [um]", "z_um", "z/um", "z um": the unit; nothing where the field has none.
std::string_view unit_of(std::string_view field) {
  if (const auto units = bracketed(field); units.size() == 1) return units[0];
  const std::size_t mark = field.find_last_of(" \t_/");
  if (mark == field.npos || mark == 0) return {};
  const std::string_view last = field.substr(mark + 1);
  return to_unit(last) ? last : std::string_view{};
}

/// The units that a line of the header gives to the columns; none where it gives no column its own.
std::vector<std::string_view> units_of(std::string_view line, const TextDialect& dialect) {
  std::vector<std::string_view> units = bracketed(line);
  if (units.size() == dialect.columns) return units;
  TextFields fields;
  dialect.split(line, fields);
  if (fields.size() != dialect.columns) return {};
  for (auto& field : fields)
    if (field.size() > 1 && field.starts_with('"') && field.ends_with('"'))
      field = field.substr(1, field.size() - 2);
  if (std::all_of(fields.begin(), fields.end(), [](auto f) { return to_unit(f).has_value(); }))
    return fields;
  units.clear();
  for (const auto field : fields) units.push_back(unit_of(field));
  return units;
}

void read_header_line(std::string_view line, std::size_t number, const TextDialect& dialect,
                      const std::filesystem::path& file, TextHeader& header) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r#%/*"), line.size()));
  line = trimmed(line);
  const std::vector<std::string_view> units = units_of(line, dialect);
  bool any = false;
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (units[i].empty()) continue;
    any = true;
    TextHeader::Unit& unit_here = header.units[i];
    const auto unit = to_unit(units[i]), before = to_unit(unit_here.word);
    if (unit && before && unit->metres != before->metres)
      throw RequestError(fmt::format("{}:{}: column {} is in {} here and in {} in line {}",
                                     file.string(), number, i + 1, unit->name, before->name,
                                     unit_here.line));
    if (unit || unit_here.word.empty()) unit_here = {std::string(units[i]), number};
  }
  if (any) return;
  for (const auto word : bracketed(line))
    if (to_unit(word)) header.loose = {std::string(word), number};
}

std::string place(const std::filesystem::path& file, std::size_t line) {
  return fmt::format("{}:{}", file.string(), line);
}

/// A first pass over the beginning of the file.
std::pair<TextDialect, TextHeader> recognize(const std::filesystem::path& file,
                                             const ProfileQuery& query) {
  ProfileLines lines(file);
  TextMarks marks;
  std::vector<std::pair<std::size_t, std::string>> before;
  std::string first;
  std::size_t first_line = 0, seen = 0;
  while (seen < most_recognized && lines.next()) {
    if (lines.too_long())
      throw RequestError(fmt::format("{}: a line of more than {} bytes (is it another file?)",
                                     place(file, lines.number()), ProfileLines::longest));
    const std::string_view text = lines.text();
    if (is_numbers(text)) {
      if (seen++ == 0) first = text, first_line = lines.number();
      marks.see(text);
    } else if (seen == 0) {
      if (lines.number() > most_header_lines)
        throw RequestError(fmt::format("{}: no line of numbers in the first {}", file.string(),
                                       most_header_lines));
      before.emplace_back(lines.number(), text.substr(0, longest_header));
    }
  }
  if (first_line == 0)
    throw RequestError(
        fmt::format("{}: no line of numbers, expected columns x and z", file.string()));

  TextDialect dialect =
      understand_marks(marks, query.decimal, !query.spacing, place(file, first_line));
  TextFields fields;
  dialect.see_columns(first, fields);
  TextHeader header;
  header.units.resize(dialect.columns);
  header.lines = first_line - 1;
  for (const auto& [number, text] : before) read_header_line(text, number, dialect, file, header);
  return {dialect, header};
}

/// The numbers, in the file's own units.
struct Columns {
  std::optional<std::size_t> x;  // from 0
  std::size_t z;
};

Columns choose_columns(const std::filesystem::path& file, const TextDialect& dialect,
                       const TextHeader& header, const ProfileQuery& query) {
  const std::size_t first = query.spacing ? 1 : 2;  // that heights may have
  const std::string where = place(file, header.lines + 1);
  if (query.column && (*query.column < static_cast<int>(first) ||
                       static_cast<std::size_t>(*query.column) > dialect.columns))
    throw RequestError(fmt::format(
        "{}: --column {}: there {}{}{}", where, *query.column,
        dialect.columns == 1 ? "is 1 column" : fmt::format("are {} columns", dialect.columns),
        query.spacing ? "" : ", and the first is x",
        query.spacing ? "" : " (--spacing says it all)"));
  if (dialect.columns < first)
    throw RequestError(fmt::format(
        "{}: one column, expected x and z; of heights alone give the spacing with --spacing",
        where));
  if (dialect.columns > first && !query.column)
    throw RequestError(
        fmt::format("{}: {} columns, expected {}; say with --column which one has the heights",
                    where, dialect.columns, query.spacing ? "one of heights" : "x and z"));
  Columns columns{{}, query.column ? static_cast<std::size_t>(*query.column) - 1 : first - 1};
  if (!query.spacing) columns.x = 0;
  return columns;
}

/// Unit of a column; nothing where neither the file nor the user gives one.
std::optional<LengthUnit> agreed_unit(const std::filesystem::path& file, const TextHeader& header,
                                      std::size_t column, const std::optional<LengthUnit>& option,
                                      const char* axis) {
  const TextHeader::Unit& own = header.units[column];
  const auto unit = to_unit(own.word);
  if (unit && option && unit->metres != option->metres)
    throw RequestError(
        fmt::format("{}: {} is in {} by the header, and in {} by --{}-unit: mend "
                    "the header, or drop the option",
                    place(file, own.line), axis, unit->name, option->name, axis));
  if (unit || option) return unit ? unit : option;
  if (!own.word.empty())
    throw RequestError(
        fmt::format("{}: {} is in {}, which is none of m, mm, um and nm: bring it to one of these, "
                    "and say with --{}-unit which",
                    place(file, own.line), axis, ra2d::quoted(own.word), axis));
  if (!header.loose.word.empty())
    throw RequestError(
        fmt::format("{}: the header names {}, and not of which column: say with "
                    "--{}-unit what {} is in",
                    place(file, header.loose.line), ra2d::quoted(header.loose.word), axis, axis));
  return {};
}

/// Fault of a field that should be a number; empty where it is one.
std::string fault_of(std::string_view word, const std::optional<double>& value, const char* axis) {
  if (word.empty()) return fmt::format("{} is missing", axis);
  if (!value) return fmt::format("{} is not a number, expected {}", quoted(word), axis);
  if (!std::isfinite(*value))
    return fmt::format("{} is not a finite number in double precision", quoted(word));
  return {};
}

ProfilePoints read_text_points(const std::filesystem::path& file, const TextDialect& dialect,
                               const TextHeader& header, const Columns& columns) {
  ProfileLines lines(file);
  ProfilePoints profile;
  TextFields fields;
  std::string scratch;
  while (profile.faults.size() < most_faults && lines.next()) {
    if (lines.number() <= header.lines) continue;
    if (lines.too_long()) {
      profile.faults.push_back({lines.number(), fmt::format("a line of more than {} bytes (is it "
                                                            "another file?)",
                                                            ProfileLines::longest)});
      break;
    }
    dialect.split(lines.text(), fields);
    if (fields.empty()) continue;
    profile.has_end = lines.has_end();
    ProfilePoint point{quiet_nan, quiet_nan};
    std::string fault;
    if (fields.size() != dialect.columns) {
      fault = fmt::format("{} columns, and {} in the lines before", fields.size(), dialect.columns);
    } else {
      const std::string_view z = fields[columns.z];
      if (columns.z + 1 == fields.size()) profile.at_ends.see(z, profile.has_end);
      if (!is_missing_word(z)) {
        const auto value = dialect.number(z, scratch);
        fault = fault_of(z, value, "z");
        if (fault.empty()) point.z = *value;
      }
      if (columns.x) {
        const std::string_view x = fields[*columns.x];
        const auto value = dialect.number(x, scratch);
        if (fault.empty()) fault = fault_of(x, value, "x");
        if (value && std::isfinite(*value)) {
          point.x = *value;
          profile.digits.see(dialect.decimal_comma ? std::string_view(scratch) : x);
        }
      }
    }
    profile.add(file, lines.number(), point);
    if (fault.empty()) continue;
    if (!profile.has_end) fault += " (the line has no end: was the file cut off here?)";
    profile.faults.push_back({lines.number(), std::move(fault)});
  }
  return profile;
}

/// Throws where numbers that nobody gave a unit cannot be metres.
void require_metres(const std::filesystem::path& file, const Profile& profile, bool x_has_unit,
                    bool z_has_unit) {
  const double length = profile.length();
  if (!x_has_unit && (length > longest_profile || profile.spacing > coarsest))
    throw RequestError(fmt::format(
        "{}: x runs over {:.6g} in steps of {:.6g}, without a unit: too much for metres. Say "
        "with --x-unit what x is in (--x-unit m, if they are)",
        file.string(), length, profile.spacing));
  if (z_has_unit) return;
  double low = quiet_nan, high = quiet_nan, squares = 0, steps = 0, before = quiet_nan;
  for (const double z : profile.heights) {
    low = std::fmin(low, z);
    high = std::fmax(high, z);
    if (!std::isnan(z) && !std::isnan(before)) squares += std::pow(z - before, 2), ++steps;
    before = z;
  }
  const double slope = steps > 0 ? std::sqrt(squares / steps) / profile.spacing : 0;
  if (high - low > highest || slope > usual_faces::steepest)
    throw RequestError(fmt::format(
        "{}: z spans {:.6g} with slopes of {:.3g}, without a unit: too much for metres. Say "
        "with --z-unit what z is in (--z-unit m, if they are)",
        file.string(), high - low, slope));
}

/// Whether a line before the numbers says that these are no metres. Brackets in a comment may hold
/// anything else.
bool names_another_unit(std::string_view line, bool is_comment) {
  TextDialect two;  // columns
  two.columns = 2;
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r#%/*"), line.size()));
  line = trimmed(line);
  std::vector<std::string_view> words = units_of(line, two);
  if (words.empty()) words = bracketed(line);
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
    const auto unit = to_unit(word);
    return unit ? unit->metres != 1 && (!is_comment || words.size() == 2)
                : !word.empty() && !is_comment;
  });
}

}  // namespace

bool is_plain_text(const std::filesystem::path& file) {
  ProfileLines lines(file);
  std::vector<std::string_view> words;
  const auto is_number = [](std::string_view word) { return to_number(word).has_value(); };
  int names = 0;
  while (lines.next()) {
    if (lines.too_long()) return false;  // who reads it says so
    const std::string_view text = lines.text();
    split_words(text, words);
    if (is_numbers(text))
      return words.size() == 2 && std::all_of(words.begin(), words.end(), is_number);
    if (names_another_unit(text, words.empty())) return false;
    if (std::any_of(words.begin(), words.end(), is_number))
      return true;  // a line of faulty numbers
    if (!words.empty() && ++names > 1) return false;
  }
  return false;
}

Profile read_profile_text(const std::filesystem::path& file, const ProfileQuery& query) {
  const auto [dialect, header] = recognize(file, query);
  const Columns columns = choose_columns(file, dialect, header, query);
  if (query.spacing && query.x_unit)
    throw RequestError("--x-unit has no x to act on: --spacing is in metres");
  std::optional<LengthUnit> x_unit;
  if (columns.x) x_unit = agreed_unit(file, header, *columns.x, query.x_unit, "x");
  const auto z_unit = agreed_unit(file, header, columns.z, query.z_unit, "z");

  ProfilePoints read = read_text_points(file, dialect, header, columns);
  if (columns.x) read.check_steps(x_unit ? x_unit->name.data() : "m");
  if (!read.faults.empty()) refuse(file, std::move(read.faults));
  const auto& points = read.points;
  if (points.size() < 2)
    throw RequestError(fmt::format("{}: 1 point, expected at least 2", file.string()));

  Profile profile;
  profile.spacing = query.spacing.value_or(0);
  if (columns.x)
    profile.spacing = (points.back().x - points.front().x) /
                      static_cast<double>(points.size() - 1) * (x_unit ? x_unit->metres : 1);
  if (read.at_ends.may_be_cut()) {
    const std::size_t last = points.size() - 1;
    if (std::string cut = read.far_end(z_unit ? std::string(z_unit->name) : "m", 0); !cut.empty())
      refuse(file, {{read.line_of(last), std::move(cut)}});
    profile.doubt = doubt_of_last_line(file);
  }
  const double metres = z_unit ? z_unit->metres : 1;
  profile.heights.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    profile.heights.push_back(points[i].z * metres);
    if (std::isnan(points[i].z) && profile.first_missing.empty())
      profile.first_missing = place(file, read.line_of(i));
  }
  if (profile.missing() == points.size())
    throw RequestError(fmt::format("{}: every height is missing", file.string()));
  require_metres(file, profile, x_unit || query.spacing, z_unit.has_value());
  return profile;
}

}  // namespace ra2d
