// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/simulate.hpp"

/// Comparison to the last bit: also of zeros' signs, and of what is no number. Where two runs
/// differ it says in which quantity, at which sample, and by how much.
namespace ra2d::test {

inline std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

/// Names of the rows and columns of a quantity.
struct Axes {
  std::string row = "place";
  std::vector<double> times;  // s, of the rows; none where they have no time
  std::size_t columns = 1;
  std::string column = "mode";
};

/// Collects the quantities in which two runs differ.
class Comparison {
 public:
  /// Numbers row by row: where the first pair that differs stands, both numbers, how many doubles
  /// lie between them, and how many pairs differ.
  void add(const std::string& name, const std::vector<double>& a, const std::vector<double>& b,
           const Axes& axes = {});
  void add(const std::string& name, double a, double b);
  void add(const std::string& name, std::int64_t a, std::int64_t b);

  /// Compares the members common to ended and open shocks; `tick` in s, 0 where there is none.
  template <class Shock>
  void add_shocks(const std::string& name, const std::vector<Shock>& a, const std::vector<Shock>& b,
                  double tick) {
    Axes axes{.row = "shock"};
    for (const Shock& shock : a)
      if (tick > 0) axes.times.push_back(static_cast<double>(shock.start) * tick);
    const auto column = [&]<class Number>(const char* what, Number Shock::*member) {
      std::vector<Number> left, right;
      for (const Shock& shock : a) left.push_back(shock.*member);
      for (const Shock& shock : b) right.push_back(shock.*member);
      add(name + " " + what, left, right, axes);
    };
    column("number", &Shock::serial);
    column("start", &Shock::start);
    column("last", &Shock::last);
    column("peak", &Shock::peak);
    column("impulse", &Shock::impulse);
    column("moment", &Shock::moment);
    column("moment across", &Shock::across_moment);
    column("row", &Shock::row);
  }
  void add(const std::string& name, const std::vector<std::int64_t>& a,
           const std::vector<std::int64_t>& b, const Axes& axes);

  /// The state in which two runs ended, and their sums.
  void add(const Snapshot& a, const Snapshot& b, double tick);

  /// Success, or what differs: the earliest first, then what has no time.
  testing::AssertionResult result() const;

 private:
  struct Difference {
    double when;  // s
    std::string text;
  };
  int quantities_ = 0;
  std::vector<Difference> found_;

  template <class Number>
  void compare(const std::string& name, const std::vector<Number>& a, const std::vector<Number>& b,
               const Axes& axes);
};

/// Whether two runs recorded the same: EXPECT_TRUE(same(a, b)).
testing::AssertionResult same(const Recording& a, const Recording& b);

/// Compares two lists of numbers.
testing::AssertionResult same(const std::string& name, const std::vector<double>& a,
                              const std::vector<double>& b);

}  // namespace ra2d::test
