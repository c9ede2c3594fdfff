// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/errors.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 30;  // bytes
constexpr std::size_t most_faults = 10;
constexpr double evenness = 1e-6;  // of the spacing

struct Fault {
  std::size_t line;
  std::string text;
};

struct Point {
  std::size_t line;
  double x, z;  // m; x is NaN where the line could not be understood
};

/// How finely the x of a file are printed. A program prints either so many significant digits or so
/// many decimals, and may drop trailing zeros: the most seen are the truth. No program prints
/// fewer than five digits or six decimals on its own.
struct Precision {
  int significant = 5, decimals = 6;

  void see(std::string_view word) {
    const std::size_t mantissa_end = std::min(word.find_first_of("eE"), word.size());
    int exponent = 0, digits = 0, after_point = 0;
    if (mantissa_end < word.size()) {
      std::string_view power = word.substr(mantissa_end + 1);
      if (power.starts_with('+')) power.remove_prefix(1);
      std::from_chars(power.data(), power.data() + power.size(), exponent);
    }
    bool pointed = false;
    for (const char c : word.substr(0, mantissa_end)) {
      pointed |= c == '.';
      if (c < '0' || c > '9') continue;
      after_point += pointed;
      digits += digits > 0 || c != '0';
    }
    significant = std::max(significant, digits);
    decimals = std::max(decimals, after_point - std::clamp(exponent, -400, 400));
  }

  /// Largest error [m] that printing has left in x.
  double rounding(double x) const {
    const double leading = x == 0 ? -decimals : std::floor(std::log10(std::abs(x)));
    return 0.5 * std::pow(10.0, std::max<double>(leading + 1 - significant, -decimals));
  }
};

struct Profile {
  std::vector<Point> points;
  std::vector<Fault> faults;
  Precision precision;
};

std::string read_text(const std::filesystem::path& file) {
  const auto unreadable = [&](const std::string& why) {
    return FileError(fmt::format("cannot read the profile {}: {}", file.string(), why));
  };
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (error) throw unreadable(error.message());
  if (!std::filesystem::is_regular_file(status)) throw unreadable("it is not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw unreadable(error.message());
  if (size > largest_file)
    throw RequestError(fmt::format(
        "{}: the profile has {} bytes, at most 1 GiB is read; thin it out", file.string(), size));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw unreadable(std::generic_category().message(errno));
  std::string text(size, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(size));
  if (stream.bad()) throw unreadable("the reading stopped halfway");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

/// The words of a line, without its comment; a comma with or without blanks, or blanks, part them.
std::vector<std::string_view> split(std::string_view line) {
  constexpr std::string_view blanks = " \t\r\v\f";
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> words;
  const auto skip_blanks = [&] {
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
  };
  skip_blanks();
  while (!line.empty()) {
    const std::size_t end = std::min(line.find_first_of(", \t\r\v\f"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
    skip_blanks();
    if (!line.starts_with(',')) continue;
    line.remove_prefix(1);
    skip_blanks();
    if (line.empty()) words.push_back(line);  // a comma at the end parts off an empty word
  }
  return words;
}

/// Nothing for a word that is not a number, infinity for one beyond the range of a double.
std::optional<double> to_number(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::invalid_argument || end != word.data() + word.size()) return {};
  return error == std::errc{} ? value : std::numeric_limits<double>::infinity();
}

/// A word of an unknown file, fit for a message.
std::string quoted(std::string_view word) {
  std::string text(word.substr(0, 40));
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = '?';
  return '"' + text + (word.size() > 40 ? "..." : "") + '"';
}

Profile parse(std::string_view text) {
  Profile profile;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte-order mark
  bool first = true;
  for (std::size_t line = 1; !text.empty() && profile.faults.size() < most_faults; ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const auto words = split(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty()) continue;

    std::vector<std::optional<double>> values;
    values.reserve(words.size());
    for (const auto word : words) values.push_back(to_number(word));
    const auto is_number = [](const auto& value) { return value.has_value(); };
    const bool names = std::none_of(values.begin(), values.end(), is_number);
    if (std::exchange(first, false) && names) continue;

    Point point{line, std::numeric_limits<double>::quiet_NaN(), 0};
    std::string fault;
    if (values.size() != 2) {
      fault = fmt::format("{} columns, expected 2: x and z in metres", values.size());
    } else {
      for (std::size_t i = 2; i-- > 0;)  // the first wrong word is the one that stays
        if (!values[i])
          fault = fmt::format("{} is not a number, expected x and z in metres", quoted(words[i]));
        else if (!std::isfinite(*values[i]))
          fault = fmt::format("{} is not a finite number in double precision", quoted(words[i]));
      if (values[0] && std::isfinite(*values[0])) {
        point.x = *values[0];
        profile.precision.see(words[0]);
      }
      point.z = values[1].value_or(0);
    }
    profile.points.push_back(point);
    if (!fault.empty()) profile.faults.push_back({line, std::move(fault)});
  }
  return profile;
}

/// Adds a fault for every x that does not follow the one before it by the usual (median) step.
void check_steps(Profile& profile) {
  const auto& points = profile.points;
  struct Step {
    double length, printed;  // m, its largest error by printing
  };
  const auto step_to = [&](std::size_t i) {
    return Step{points[i].x - points[i - 1].x, profile.precision.rounding(points[i - 1].x) +
                                                   profile.precision.rounding(points[i].x)};
  };
  std::vector<Step> steps;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i].x > points[i - 1].x) steps.push_back(step_to(i));
  Step usual{0, 0};
  if (!steps.empty()) {
    const auto middle = steps.begin() + (std::ssize(steps) - 1) / 2;
    std::nth_element(steps.begin(), middle, steps.end(),
                     [](const Step& a, const Step& b) { return a.length < b.length; });
    usual = *middle;
  }

  std::size_t found = 0;
  for (std::size_t i = 1; i < points.size() && found < most_faults; ++i) {
    const Step step = step_to(i);
    if (std::isnan(step.length)) continue;
    // However coarse the print, a quarter of a step is no rounding.
    const double tolerance =
        evenness * usual.length + std::min(step.printed + usual.printed, usual.length / 4);
    std::string what;
    if (step.length <= 0)
      what = fmt::format("x = {:.10g} m does not increase, the point before is at {:.10g} m",
                         points[i].x, points[i - 1].x);
    else if (std::abs(step.length - usual.length) > tolerance)
      what = fmt::format("x steps by {:.10g} m, expected an even spacing of {:.10g} m", step.length,
                         usual.length);
    if (what.empty()) continue;
    profile.faults.push_back({points[i].line, std::move(what)});
    ++found;
  }
}

void refuse(const std::filesystem::path& file, std::vector<Fault> faults) {
  std::stable_sort(faults.begin(), faults.end(),
                   [](const Fault& a, const Fault& b) { return a.line < b.line; });
  std::string message;
  for (std::size_t i = 0; i < std::min(faults.size(), most_faults); ++i)
    message += fmt::format("{}{}:{}: {}", i > 0 ? "\n" : "", file.string(), faults[i].line,
                           faults[i].text);
  if (faults.size() >= most_faults) message += "\nthere may be more faults further down";
  throw RequestError(message);
}

}  // namespace

std::vector<double> read_profile(const std::filesystem::path& file, int nodes, double length,
                                 double spacing) {
  Profile profile = parse(read_text(file));
  check_steps(profile);
  if (!profile.faults.empty()) refuse(file, std::move(profile.faults));
  const auto& points = profile.points;
  if (points.size() < 2)
    throw RequestError(fmt::format("{}: {} points, expected at least 2 lines of x and z in metres",
                                   file.string(), points.size()));

  const double first = points.front().x, last = points.back().x, needed = (nodes - 1) * spacing;
  const double step = (last - first) / static_cast<double>(points.size() - 1);
  const double printed = profile.precision.rounding(first) + profile.precision.rounding(last);
  if (last - first < needed - evenness * spacing - std::min(printed, step / 2))
    throw RequestError(
        fmt::format("{}:{}: the profile is {:.10g} m long and the beam {:.10g} m; give a longer "
                    "profile or a shorter beam",
                    file.string(), points.back().line, last - first, length));

  // The same spacing, as far as the digits tell: the nodes are the points.
  const bool same = std::abs(step - spacing) * static_cast<double>(points.size() - 1) <=
                    evenness * spacing + std::min(printed, spacing / 4);
  const double stride = same ? 1 : spacing / step;
  std::vector<double> heights(static_cast<std::size_t>(nodes));
  for (std::size_t n = 0; n < heights.size(); ++n) {
    const double at = static_cast<double>(n) * stride;
    const std::size_t i = std::min(static_cast<std::size_t>(at), points.size() - 2);
    heights[n] = std::lerp(points[i].z, points[i + 1].z, at - static_cast<double>(i));
  }
  subtract_mean(heights);
  return heights;
}

}  // namespace ra2d
