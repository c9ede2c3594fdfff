// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <deque>
#include <fstream>
#include <iterator>
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
constexpr std::size_t longest_line = 1u << 16;                    // bytes
constexpr std::size_t most_points = 50'000'000;
constexpr std::size_t most_faults = 10;
constexpr double evenness = 1e-6;  // of the spacing
// What no face is, whatever made or measured it:
constexpr double longest_share = 900;  // a profile so many times as long as the beam
constexpr double largest_share = 0.5;  // of the beam's thickness, from the lowest to the highest
constexpr double steepest = 1;         // root mean square slope: 45 degrees
// What few faces are:
constexpr double large_share = 0.05, steep = 0.2;
constexpr double inches = 1 / 0.0254, like_inches = 0.05;
// A number that is cut off inside its exponent is off by powers of ten. No last height of a face is
// so many times its peak to valley away from all others.
constexpr double far_off = 10;
constexpr double usual_height = 2e-5;  // m, peak to valley of a ground face
constexpr double coarse_nodes = 20;    // of the scene, to a step of the profile
constexpr std::size_t few_points = 100;

struct Fault {
  std::size_t line;
  std::string text;
};

struct Point {
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
  std::deque<Point> points;  // which holds no more than they need while it grows
  std::vector<Fault> faults;
  Precision precision;
  bool has_end = true;  // the last line

  void add(std::size_t line, Point point) {
    if (runs_.empty() || line != line_of(points.size() - 1) + 1)
      runs_.push_back({points.size(), line});
    points.push_back(point);
  }
  std::size_t line_of(std::size_t point) const {
    const auto after =
        std::upper_bound(runs_.begin(), runs_.end(), point,
                         [](std::size_t value, const Run& run) { return value < run.point; });
    const Run& run = *std::prev(after);
    return run.line + point - run.point;
  }

 private:
  struct Run {
    std::size_t point, line;  // from this point on one stands in each line
  };
  std::vector<Run> runs_;
};

FileError unreadable(const std::filesystem::path& file, const std::string& why) {
  return FileError(fmt::format("cannot read the profile {}: {}", file.string(), why));
}

std::ifstream open_profile(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (error) throw unreadable(file, error.message());
  if (!std::filesystem::is_regular_file(status)) throw unreadable(file, "it is not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw unreadable(file, error.message());
  if (size > largest_file)
    throw RequestError(fmt::format(
        "{}: the profile has {} bytes, at most 1 GiB is read; thin it out", file.string(), size));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw unreadable(file, std::generic_category().message(errno));
  return stream;
}

/// The words of a line, without its comment; a comma with or without blanks, or blanks, part them.
void split(std::string_view line, std::vector<std::string_view>& words) {
  constexpr std::string_view blanks = " \t\r\v\f";
  line = line.substr(0, line.find('#'));
  words.clear();
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

/// What is wrong with the words of a line, and its point.
std::string understand(const std::vector<std::string_view>& words,
                       const std::vector<std::optional<double>>& values, Point& point) {
  if (values.size() != 2)
    return fmt::format("{} columns, expected 2: x and z in metres", values.size());
  if (values[0] && std::isfinite(*values[0])) point.x = *values[0];
  point.z = values[1].value_or(0);
  for (std::size_t i = 0; i < 2; ++i) {
    if (!values[i])
      return fmt::format("{} is not a number, expected x and z in metres", quoted(words[i]));
    if (!std::isfinite(*values[i]))
      return fmt::format("{} is not a finite number in double precision", quoted(words[i]));
  }
  return {};
}

/// Reads line by line: beside the points no more than one line is held.
Profile read_points(const std::filesystem::path& file) {
  std::ifstream stream = open_profile(file);
  Profile profile;
  std::string buffer(longest_line + 1, '\0');
  std::vector<std::string_view> words;
  std::vector<std::optional<double>> values;
  bool first = true;
  for (std::size_t line = 1; !stream.eof() && profile.faults.size() < most_faults; ++line) {
    stream.getline(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto got = static_cast<std::size_t>(stream.gcount());
    if (stream.bad()) throw unreadable(file, "the reading stopped halfway");
    if (stream.fail() && !stream.eof()) {
      profile.faults.push_back({line, fmt::format("a line of more than {} bytes, expected x and z "
                                                  "in metres (is it another file?)",
                                                  longest_line)});
      break;
    }
    std::string_view text(buffer.data(), stream.eof() ? got : got - 1);
    if (line == 1 && text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte-order mark
    split(text, words);
    if (words.empty()) continue;

    values.clear();
    for (const auto word : words) values.push_back(to_number(word));
    const auto is_number = [](const auto& value) { return value.has_value(); };
    const bool names = std::none_of(values.begin(), values.end(), is_number);
    if (std::exchange(first, false) && names) continue;

    profile.has_end = !stream.eof();
    Point point{std::numeric_limits<double>::quiet_NaN(), 0};
    std::string fault = understand(words, values, point);
    if (!std::isnan(point.x)) profile.precision.see(words[0]);
    profile.add(line, point);
    if (profile.points.size() > most_points)
      throw RequestError(fmt::format("{}:{}: more than {} points; thin the profile out",
                                     file.string(), line, most_points));
    if (fault.empty()) continue;
    if (!profile.has_end) fault += " (the line has no end: was the file cut off here?)";
    profile.faults.push_back({line, std::move(fault)});
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
  std::vector<std::uint32_t> steps;  // by the point where each ends
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i].x > points[i - 1].x) steps.push_back(static_cast<std::uint32_t>(i));
  Step usual{0, 0};
  if (!steps.empty()) {
    const auto middle = steps.begin() + (std::ssize(steps) - 1) / 2;
    const auto length = [&](std::uint32_t i) { return points[i].x - points[i - 1].x; };
    std::nth_element(steps.begin(), middle, steps.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return length(a) < length(b); });
    usual = step_to(*middle);
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
    profile.faults.push_back({profile.line_of(i), std::move(what)});
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

/// Lowest and highest of the first `count` heights [m], but for one.
struct Span {
  double low = infinity, high = -infinity;

  double size() const { return high - low; }
  /// How far a height lies outside.
  double away(double z) const { return std::max({low - z, z - high, 0.0}); }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
};

Span span_of(const std::deque<Point>& points, std::size_t count, std::size_t but) {
  Span span;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == but) continue;
    span.low = std::min(span.low, points[i].z);
    span.high = std::max(span.high, points[i].z);
  }
  return span;
}

struct Unit {
  const char *name, *factor;
  double metres;
};
constexpr Unit units[] = {{"mm", "1e-3", 1e-3}, {"um", "1e-6", 1e-6}, {"nm", "1e-9", 1e-9}};
constexpr Unit mils{"mils", "2.54e-5", 2.54e-5};

/// In which unit such heights would be those of a face.
const Unit& likely_unit(double height) {
  const auto off = [&](const Unit& unit) {
    return std::abs(std::log(height * unit.metres / usual_height));
  };
  return *std::min_element(std::begin(units), std::end(units),
                           [&](const Unit& a, const Unit& b) { return off(a) < off(b); });
}

/// The smallest unit in which the profile would still reach along the beam.
const Unit& likely_unit(double length, double beam) {
  for (const Unit* unit = std::end(units); --unit != units;)
    if (length * unit->metres >= 0.9 * beam) return *unit;
  return length * mils.metres >= 0.9 * beam ? mils : units[0];
}

/// The face in numbers.
struct Relief {
  std::size_t lowest = 0, highest = 0;
  std::optional<std::size_t> slip;  // the height along the beam that is far from all others
  double height = 0;                // m, from the lowest to the highest
  double slope = 0;                 // root mean square, along the beam
  double depth = 0;  // m, of the body: its thickness, or its length where it has none
  bool has_thickness = false;

  bool odd() const { return height > large_share * depth || slope > steep; }
};

Relief measure(const std::deque<Point>& points, std::size_t used, double length, double thickness) {
  Relief relief;
  relief.has_thickness = thickness > 0;
  relief.depth = relief.has_thickness ? thickness : length;
  double squares = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].z < points[relief.lowest].z) relief.lowest = i;
    if (points[i].z > points[relief.highest].z) relief.highest = i;
    if (i < used) squares += std::pow(points[i].z - points[i - 1].z, 2);
  }
  const auto steps = static_cast<double>(used - 1);
  relief.height = points[relief.highest].z - points[relief.lowest].z;
  relief.slope = std::sqrt(squares * steps) / (points[used - 1].x - points[0].x);
  if (!relief.odd() || points.size() < 4) return relief;
  for (const std::size_t i : {relief.lowest, relief.highest}) {
    const Span others = span_of(points, points.size(), i);
    if (others.away(points[i].z) <= far_off * others.size()) continue;
    if (i < used)
      relief.slip = i;
    else
      relief.height = others.size();
  }
  return relief;
}

/// What is out of all proportion to the beam, with the line where it is seen; no text where nothing
/// is.
Fault find_disproportion(const Profile& profile, double length, const Relief& relief) {
  const auto& points = profile.points;
  const std::size_t last = points.size() - 1;
  if (!profile.has_end && last >= 3) {
    const Span others = span_of(points, last, last);
    if (others.away(points[last].z) > std::max(far_off * others.size(), large_share * relief.depth))
      return {profile.line_of(last),
              fmt::format("the line has no end, and its height of {:.6g} m is far from all others "
                          "({:.6g} to {:.6g} m): the file was cut off inside this number. Complete "
                          "the line, or drop it",
                          points[last].z, others.low, others.high)};
  }
  const double range = points[last].x - points[0].x;
  if (range >= longest_share * length) {
    const Unit& unit = likely_unit(range, length);
    return {profile.line_of(last),
            fmt::format("x runs over {:.6g} for a beam of {:.6g} m: is it in {}? Lengths are read "
                        "in metres: multiply x by {}, and z by what its own unit asks for",
                        range, length, unit.name, unit.factor)};
  }
  // a rigid body's length says less about its faces than a thickness
  const bool tall = relief.height > relief.depth * (relief.has_thickness ? largest_share : 1);
  if (!tall && relief.slope <= steepest) return {0, {}};
  if (relief.slip) {
    const Span others = span_of(points, points.size(), *relief.slip);
    return {profile.line_of(*relief.slip),
            fmt::format("a height of {:.6g} m, and all others lie from {:.6g} to {:.6g} m: is "
                        "there a digit missing? Mend the number",
                        points[*relief.slip].z, others.low, others.high)};
  }
  const Unit& unit = likely_unit(relief.height);
  const std::string cure = fmt::format("is z in {}? Heights are read in metres: multiply z by {}",
                                       unit.name, unit.factor);
  const std::size_t line = profile.line_of(relief.highest);
  if (tall)
    return {line, fmt::format("the heights span {:.6g} m on a beam {:.6g} m {}: {}", relief.height,
                              relief.depth, relief.has_thickness ? "thick" : "long", cure)};
  return {line, fmt::format("the slopes have a root mean square of {:.3g}, steeper than any face: "
                            "{}",
                            relief.slope, cure)};
}

/// The same of what is rare, but may be meant.
Fault find_oddity(const Profile& profile, double length, const Relief& relief) {
  const auto& points = profile.points;
  const double range = points.back().x - points.front().x;
  if (std::abs(range / length / inches - 1) < like_inches)
    return {profile.line_of(points.size() - 1),
            fmt::format("x runs over {:.6g} m for a beam of {:.6g} m, {:.3g} times as long: is it "
                        "in inches?",
                        range, length, range / length)};
  if (relief.height > large_share * relief.depth)
    return {profile.line_of(relief.highest),
            fmt::format("the heights span {:.3g} m, {:.0f} % of the beam's {}: are they in metres?",
                        relief.height, 100 * relief.height / relief.depth,
                        relief.has_thickness ? "thickness" : "length")};
  if (relief.slope > steep)
    return {profile.line_of(relief.highest),
            fmt::format("the slopes have a root mean square of {:.2g}, and few faces are so steep: "
                        "are x and z in metres?",
                        relief.slope)};
  return {0, {}};
}

}  // namespace

std::vector<double> read_profile(const std::filesystem::path& file, int nodes, double length,
                                 double spacing, double thickness,
                                 std::vector<std::string>* doubts) {
  Profile profile = read_points(file);
  check_steps(profile);
  if (!profile.faults.empty()) refuse(file, std::move(profile.faults));
  const auto& points = profile.points;
  if (points.size() < 2)
    throw RequestError(fmt::format("{}: {} points, expected at least 2 lines of x and z in metres",
                                   file.string(), points.size()));

  const std::size_t last_line = profile.line_of(points.size() - 1);
  const double first = points.front().x, last = points.back().x, needed = (nodes - 1) * spacing;
  const double step = (last - first) / static_cast<double>(points.size() - 1);
  const double printed = profile.precision.rounding(first) + profile.precision.rounding(last);
  if (last - first < needed - evenness * spacing - std::min(printed, step / 2))
    throw RequestError(
        fmt::format("{}:{}: the profile is {:.10g} m long and the beam {:.10g} m; give a longer "
                    "profile or a shorter beam",
                    file.string(), last_line, last - first, length));

  const double reach = std::ceil(needed / step * (1 - evenness)) + 1;  // points along the beam
  const auto used =
      static_cast<std::size_t>(std::clamp(reach, 2.0, static_cast<double>(points.size())));
  const Relief relief = measure(points, used, length, thickness);
  if (Fault fault = find_disproportion(profile, length, relief); !fault.text.empty())
    refuse(file, {std::move(fault)});
  if (const Fault odd = find_oddity(profile, length, relief);
      doubts != nullptr && !odd.text.empty())
    doubts->push_back(fmt::format("{}:{}: {}", file.string(), odd.line, odd.text));
  if (doubts != nullptr && !profile.has_end)
    doubts->push_back(
        fmt::format("{}:{}: the last line has no end: if the file was cut off there, "
                    "its height of {:.6g} m is wrong",
                    file.string(), last_line, points.back().z));
  if (doubts != nullptr && step > coarse_nodes * spacing && points.size() > few_points)
    doubts->push_back(
        fmt::format("{}: x steps by {:.6g} m, {:.0f} nodes of the scene, between "
                    "which the face is straight: is x in metres?",
                    file.string(), step, step / spacing));

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
