// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace ra2d {

struct ChartAxis {
  double low = 0, high = 1;
  bool logarithmic = false;
  std::string label;
  /// Places and names of the ticks; without any they are found.
  std::vector<std::pair<double, std::string>> ticks;
};

/// A chart as inline SVG: small enough for a telephone, of the page's own colours (classes of
/// host/report/page_style.hpp). What is beyond an axis is drawn at its end.
class SvgChart {
 public:
  /// `summary`: what is to be seen, for who cannot see it. No markup in any text.
  SvgChart(ChartAxis x, ChartAxis y, std::string summary);

  /// All drawn from here on belongs to this series, from 0, and has its colour. Dots and
  /// whiskers stand `aside` dots of the picture to the right of their place, so that those of
  /// several series do not hide each other.
  void begin_series(std::size_t number, double aside);

  /// A line through points of ascending x. Of many within one dot of the screen the extent is
  /// drawn.
  void line(const std::vector<double>& x, const std::vector<double>& y, bool dashed = false);
  void dot(double x, double y);
  /// A column from the bottom to `y`; `faint`, where it means little.
  void column(double x_low, double x_high, double y, bool faint = false);
  /// A vertical bar with ends.
  void whisker(double x, double low, double high);
  /// A short tick from the top.
  void mark_top(double x);
  /// A dashed line across; the name stands below the marks at the top.
  void vertical(double x, const std::string& name);
  void horizontal(double y);
  void note(double x, double y, const std::string& text);

  std::string svg() const;

 private:
  double px(double x) const;
  double py(double y) const;
  void draw_axes();

  ChartAxis x_, y_;
  std::string summary_, axes_, body_;
  std::string series_;  // its class in the page's style
  double aside_ = 0;
};

/// Limits that hold all values, rounded to a multiple of `step`.
std::pair<double, double> rounded_limits(const std::vector<double>& values, double step);

}  // namespace ra2d
