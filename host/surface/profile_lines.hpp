// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/system/input_file.hpp"

/// Common to the readers of profiles in text: lines of bounded length, numbers, points that know
/// their lines, even steps.
namespace ra2d {

constexpr double evenness = 1e-6;  // of the spacing
constexpr std::size_t most_faults = 10;

/// Fault of a line, for a message.
struct LineFault {
  std::size_t line;
  std::string text;
};

/// Throws RequestError that names up to ten faults in the order of their lines.
[[noreturn]] void refuse(const std::filesystem::path& file, std::vector<LineFault> faults);

/// A profile of any format, of at most 1 GiB. Throws FileError where it cannot be read,
/// RequestError where it is too large.
class ProfileStream : public InputStream {
 public:
  explicit ProfileStream(const std::filesystem::path& file);
};

/// The lines of a ProfileStream, one at a time.
class ProfileLines {
 public:
  static constexpr std::size_t longest = 1u << 16;  // bytes of a line of a profile

  explicit ProfileLines(const std::filesystem::path& file, std::size_t longest_line = longest);
  /// Goes on to the next line. No line comes after one that is too long.
  bool next();
  /// Without its end and without a byte-order mark. Carriage returns stay: they are blanks.
  std::string_view text() const { return text_; }
  std::size_t number() const { return number_; }  // from 1
  bool has_end() const { return has_end_; }       // a line feed
  bool too_long() const { return too_long_; }

 private:
  ProfileStream stream_;
  std::string buffer_;
  std::string_view text_;
  std::size_t number_ = 0;
  bool has_end_ = true, too_long_ = false;
};

/// The words of a line, without its comment; a comma with or without blanks, or blanks, part them.
void split_words(std::string_view line, std::vector<std::string_view>& words);

/// Nothing for a word that is not a number, infinity for one beyond the range of a double.
std::optional<double> to_number(std::string_view word);

/// A word of an unknown file, fit for a message.
std::string quoted(std::string_view word);

/// How finely the x of a file are printed. A program prints either so many significant digits or so
/// many decimals, and may drop trailing zeros: the most seen are the truth. No program prints
/// fewer than five digits or six decimals on its own.
struct PrintedDigits {
  int significant = 5, decimals = 6;

  void see(std::string_view word);
  /// Largest error that printing has left in x.
  double rounding(double x) const;
};

/// The numbers at the ends of lines. Where the last line has no end, the file may be cut off inside
/// its number: then this has fewer digits behind its mark, or in its exponent, than any before it.
/// Of whole numbers, or where digits vary, a cut leaves no trace.
class NumbersAtEnds {
 public:
  NumbersAtEnds() { fewest_decimals_.fill(std::numeric_limits<std::size_t>::max()); }
  void see(std::string_view word, bool line_has_end);
  bool may_be_cut() const { return may_be_cut_; }

 private:
  std::array<std::size_t, 5> fewest_decimals_;  // by the digits of the exponent
  bool may_be_cut_ = false;
};

struct ProfilePoint {
  double x, z;  // x is NaN where the line could not be understood
};

/// Lowest and highest of heights.
struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  double size() const { return high - low; }
  /// Distance of a height from the span.
  double away(double z) const { return std::max({low - z, z - high, 0.0}); }
  /// Whether a height is so far away as no height of a face: a number that is cut off inside its
  /// exponent is off by powers of ten.
  bool is_far(double z) const { return away(z) > 10 * size(); }
};

struct ProfilePoints {
  std::deque<ProfilePoint> points;  // which holds no more than they need while it grows
  std::vector<LineFault> faults;
  PrintedDigits digits;
  NumbersAtEnds at_ends;
  bool has_end = true;  // the last line

  /// Throws RequestError where there are too many.
  void add(const std::filesystem::path& file, std::size_t line, ProfilePoint point);
  std::size_t line_of(std::size_t point) const;
  /// Adds a fault for every x [unit] that does not follow the one before it by the usual (median)
  /// step.
  void check_steps(const char* unit);
  Span all_but(std::size_t point) const;
  /// Fault of the last height [unit] of a file whose last line has no end, where it is far from all
  /// others, by more than `least`; empty where it is not, and of few points.
  std::string far_end(const std::string& unit, double least) const;

 private:
  struct Run {
    std::size_t point, line;  // from this point on one stands in each line
  };
  std::vector<Run> runs_;
};

}  // namespace ra2d
