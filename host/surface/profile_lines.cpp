// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

#include "host/base/errors.hpp"

namespace ra2d {
namespace {

constexpr std::uint64_t largest_file = std::uint64_t{1} << 30;  // bytes
constexpr std::size_t most_points = 50'000'000;

}  // namespace

ProfileStream::ProfileStream(const std::filesystem::path& file) : InputStream(file, "the profile") {
  if (size() > largest_file)
    throw RequestError(fmt::format(
        "{}: the profile has {} bytes, at most 1 GiB is read; thin it out", file.string(), size()));
}

void refuse(const std::filesystem::path& file, std::vector<LineFault> faults) {
  std::stable_sort(faults.begin(), faults.end(),
                   [](const LineFault& a, const LineFault& b) { return a.line < b.line; });
  std::string message;
  for (std::size_t i = 0; i < std::min(faults.size(), most_faults); ++i)
    message += fmt::format("{}{}:{}: {}", i > 0 ? "\n" : "", file.string(), faults[i].line,
                           faults[i].text);
  if (faults.size() >= most_faults) message += "\nthere may be more faults further down";
  throw RequestError(message);
}

ProfileLines::ProfileLines(const std::filesystem::path& file, std::size_t longest_line)
    : stream_(file), buffer_(std::min<std::size_t>(longest_line, stream_.size() + 1) + 1, '\0') {}

bool ProfileLines::next() {
  if (stream_.eof() || too_long_) return false;
  ++number_;
  stream_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  const auto got = static_cast<std::size_t>(stream_.gcount());
  if (stream_.bad()) throw stream_.file().unreadable("the reading stopped halfway");
  has_end_ = !stream_.eof();
  too_long_ = stream_.fail() && has_end_;
  text_ = {buffer_.data(), has_end_ && !too_long_ ? got - 1 : got};
  if (number_ == 1 && text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
  return true;
}

void split_words(std::string_view line, std::vector<std::string_view>& words) {
  // character by character: find_first_of() would look each up in a list by a call
  const auto is_blank = [](char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
  };
  line = line.substr(0, line.find('#'));
  words.clear();
  const auto skip_blanks = [&] {
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  };
  skip_blanks();
  while (!line.empty()) {
    std::size_t end = 0;
    while (end < line.size() && line[end] != ',' && !is_blank(line[end])) ++end;
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
    skip_blanks();
    if (!line.starts_with(',')) continue;
    line.remove_prefix(1);
    skip_blanks();
    if (line.empty()) words.push_back(line);  // a comma at the end parts off an empty word
  }
}

std::optional<double> to_number(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::invalid_argument || end != word.data() + word.size()) return {};
  return error == std::errc{} ? value : std::numeric_limits<double>::infinity();
}

std::string quoted(std::string_view word) {
  std::string text(word.substr(0, 40));
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = '?';
  return '"' + text + (word.size() > 40 ? "..." : "") + '"';
}

void PrintedDigits::see(std::string_view word) {
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

double PrintedDigits::rounding(double x) const {
  const double leading = x == 0 ? -decimals : std::floor(std::log10(std::abs(x)));
  return 0.5 * std::pow(10.0, std::max<double>(leading + 1 - significant, -decimals));
}

void NumbersAtEnds::see(std::string_view word, bool line_has_end) {
  constexpr std::string_view all_digits = "0123456789";
  if (word.find_first_of(all_digits) == word.npos) return;  // a missing point
  const auto digits_of = [&](std::string_view part) {
    return static_cast<std::size_t>(std::count_if(
        part.begin(), part.end(), [&](char c) { return all_digits.find(c) != part.npos; }));
  };
  const std::size_t mantissa_end = std::min(word.find_first_of("eE"), word.size());
  const std::string_view mantissa = word.substr(0, mantissa_end);
  const std::size_t mark = std::min(mantissa.find_first_of(".,"), mantissa.size());
  const std::size_t decimals = digits_of(mantissa.substr(mark)),
                    of_exponent =
                        std::min(digits_of(word.substr(mantissa_end)), fewest_decimals_.size() - 1);
  const auto end = fewest_decimals_.begin() + static_cast<std::ptrdiff_t>(of_exponent) + 1;
  may_be_cut_ = !line_has_end && std::none_of(fewest_decimals_.begin(), end,
                                              [&](std::size_t few) { return few <= decimals; });
  fewest_decimals_[of_exponent] = std::min(fewest_decimals_[of_exponent], decimals);
}

void ProfilePoints::add(const std::filesystem::path& file, std::size_t line, ProfilePoint point) {
  if (runs_.empty() || line != line_of(points.size() - 1) + 1)
    runs_.push_back({points.size(), line});
  points.push_back(point);
  if (points.size() > most_points)
    throw RequestError(fmt::format("{}:{}: more than {} points; thin the profile out",
                                   file.string(), line, most_points));
}

std::size_t ProfilePoints::line_of(std::size_t point) const {
  const auto after =
      std::upper_bound(runs_.begin(), runs_.end(), point,
                       [](std::size_t value, const Run& run) { return value < run.point; });
  const Run& run = *std::prev(after);
  return run.line + point - run.point;
}

Span ProfilePoints::all_but(std::size_t point) const {
  Span span;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == point) continue;
    span.low = std::min(span.low, points[i].z);  // NaN, a missing height, is passed over
    span.high = std::max(span.high, points[i].z);
  }
  return span;
}

std::string ProfilePoints::far_end(const std::string& unit, double least) const {
  if (points.size() < 4) return {};
  const Span others = all_but(points.size() - 1);
  const double z = points.back().z;
  if (!others.is_far(z) || !(others.away(z) > least)) return {};
  return fmt::format(
      "the line has no end, and its height of {:.6g} {} is far from all others ({:.6g} to {:.6g} "
      "{}): the file was cut off inside this number. Complete the line, or drop it",
      z, unit, others.low, others.high, unit);
}

void ProfilePoints::check_steps(const char* unit) {
  struct Step {
    double length, printed;  // its largest error by printing
  };
  const auto step_to = [&](std::size_t i) {
    return Step{points[i].x - points[i - 1].x,
                digits.rounding(points[i - 1].x) + digits.rounding(points[i].x)};
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
    const double length = points[i].x - points[i - 1].x;
    if (std::isnan(length)) continue;
    // an even spacing passes without a look at the digits, which cost a power
    if (length > 0 && std::abs(length - usual.length) <= evenness * usual.length) continue;
    const Step step = step_to(i);
    // However coarse the print, a quarter of a step is no rounding.
    const double tolerance =
        evenness * usual.length + std::min(step.printed + usual.printed, usual.length / 4);
    std::string what;
    if (step.length <= 0)
      what = fmt::format("x = {:.10g} {} does not increase, the point before is at {:.10g} {}",
                         points[i].x, unit, points[i - 1].x, unit);
    else if (std::abs(step.length - usual.length) > tolerance)
      what = fmt::format("x steps by {:.10g} {}, expected an even spacing of {:.10g} {}",
                         step.length, unit, usual.length, unit);
    if (what.empty()) continue;
    faults.push_back({line_of(i), std::move(what)});
    ++found;
  }
}

}  // namespace ra2d
