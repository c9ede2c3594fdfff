// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/svg_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "host/report/html.hpp"

namespace ra2d {
namespace {

// In dots of the picture, which the page stretches to its width.
constexpr double width = 440, height = 290, left = 56, right = 20, top = 12, bottom = 46;
constexpr double plot_width = width - left - right, plot_height = height - top - bottom;
constexpr double base = top + plot_height, end = left + plot_width;
constexpr int most_ticks = 6;

struct Tick {
  double at;
  std::string name;  // empty: a small one
};

std::string tick_name(double value) {
  return std::abs(value) < 1e-12 ? "0"
                                 : fmt::format("{}{:g}", value < 0 ? "−" : "", std::abs(value));
}

std::vector<Tick> even_ticks(double low, double high) {
  const double rough = (high - low) / most_ticks;
  const double decade = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * decade;
  for (const double digit : {5, 2, 1})
    if (digit * decade >= rough) step = digit * decade;
  std::vector<Tick> ticks;
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i)
    ticks.push_back({i * step, tick_name(i * step)});
  return ticks;
}

/// Names at every decade, and at 2 and 5 where there are few of them.
std::vector<Tick> log_ticks(double low, double high) {
  const bool few = std::log10(high / low) < 2;
  std::vector<Tick> ticks;
  for (int power = static_cast<int>(std::floor(std::log10(low))); std::pow(10, power) <= high;
       ++power)
    for (int digit = 1; digit < 10; ++digit) {
      const double at = digit * std::pow(10, power);
      const bool named = digit == 1 || (few && (digit == 2 || digit == 5));
      if (at >= low * (1 - 1e-9) && at <= high * (1 + 1e-9))
        ticks.push_back({at, named ? tick_name(at) : ""});
    }
  return ticks;
}

std::vector<Tick> ticks_of(const ChartAxis& axis) {
  if (axis.ticks.empty())
    return axis.logarithmic ? log_ticks(axis.low, axis.high) : even_ticks(axis.low, axis.high);
  std::vector<Tick> ticks;
  for (const auto& [at, name] : axis.ticks) ticks.push_back({at, name});
  return ticks;
}

double share(const ChartAxis& axis, double value) {
  if (axis.logarithmic && !(value > 0)) return 0;
  const double part = axis.logarithmic ? std::log(value / axis.low) / std::log(axis.high / axis.low)
                                       : (value - axis.low) / (axis.high - axis.low);
  return std::isnan(part) ? 0 : std::clamp(part, 0.0, 1.0);
}

std::string text(double x, double y, const char* anchor, const std::string& words,
                 const char* kind = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>", x, y, anchor,
                     kind, html(words));
}

std::string stroke(const char* kind, double x1, double y1, double x2, double y2) {
  return fmt::format("<path class=\"{}\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>", kind, x1, y1, x2,
                     y2);
}

}  // namespace

SvgChart::SvgChart(ChartAxis x, ChartAxis y, std::string summary)
    : x_{std::move(x)}, y_{std::move(y)}, summary_{std::move(summary)} {
  draw_axes();
}

double SvgChart::px(double x) const { return left + plot_width * share(x_, x); }
double SvgChart::py(double y) const { return base - plot_height * share(y_, y); }

void SvgChart::draw_axes() {
  for (const Tick& tick : ticks_of(y_)) {
    const double y = py(tick.at);
    axes_ +=
        stroke(tick.name.empty() ? "tick" : "grid", left, y, tick.name.empty() ? left + 3 : end, y);
    axes_ += text(left - 6, y + 4, "end", tick.name);
  }
  for (const Tick& tick : ticks_of(x_)) {
    const double x = px(tick.at);
    axes_ += stroke("tick", x, base, x, base + (tick.name.empty() ? 3 : 6));
    if (!tick.name.empty()) axes_ += text(x, base + 19, "middle", tick.name);
  }
  axes_ += stroke("axis", left, base, end, base) + stroke("axis", left, top, left, base);
  axes_ += text(left + plot_width / 2, height - 8, "middle", x_.label);
  axes_ +=
      text(0, 0, "middle", y_.label,
           fmt::format(" transform=\"translate(13 {:.1f}) rotate(-90)\"", top + plot_height / 2)
               .c_str());
}

void SvgChart::begin_series(std::size_t number, double aside) {
  series_ = fmt::format(" series{}", number % 5);
  aside_ = aside;
}

void SvgChart::dot(double x, double y) {
  body_ += fmt::format("<circle class=\"dot{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"/>", series_,
                       px(x) + aside_, py(y));
}

void SvgChart::line(const std::vector<double>& x, const std::vector<double>& y, bool dashed) {
  std::string path;
  for (std::size_t i = 0; i < x.size();) {
    const double at = px(x[i]);
    double low = y[i], high = y[i];
    std::size_t next = i + 1;
    for (; next < x.size() && px(x[next]) < at + 0.7; ++next) {
      low = std::min(low, y[next]);
      high = std::max(high, y[next]);
    }
    fmt::format_to(std::back_inserter(path), "{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', at,
                   py(high));
    if (next > i + 1) fmt::format_to(std::back_inserter(path), "V{:.1f}", py(low));
    i = next;
  }
  body_ +=
      fmt::format("<path class=\"line{}{}\" d=\"{}\"/>", dashed ? " dashed" : "", series_, path);
}

void SvgChart::column(double x_low, double x_high, double y, bool faint) {
  const double x1 = px(x_low), x2 = px(x_high), at = py(y);
  body_ += fmt::format(
      "<rect class=\"bar\"{} x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>",
      faint ? " opacity=\"0.3\"" : "", x1 + 0.5, at, std::max(0.5, x2 - x1 - 1), base - at);
}

void SvgChart::whisker(double x, double low, double high) {
  const double at = px(x) + aside_, y1 = py(low), y2 = py(high);
  body_ += fmt::format(
      "<path class=\"whisker{5}\" d=\"M{0:.1f} {2:.1f}H{1:.1f}M{0:.1f} {3:.1f}H{1:.1f}M{4:.1f} "
      "{2:.1f}V{3:.1f}\"/>",
      at - 3, at + 3, y1, y2, at, series_);
}

void SvgChart::mark_top(double x) { body_ += stroke("mark", px(x), top, px(x), top + 9); }

void SvgChart::vertical(double x, const std::string& name) {
  const double at = px(x), y = top + 22;
  const bool near_end = at > left + 0.7 * plot_width;
  body_ += stroke("dashed", at, top, at, base);
  body_ += text(near_end ? at - 5 : at + 5, y, near_end ? "end" : "start", name, " class=\"name\"");
}

void SvgChart::horizontal(double y) { body_ += stroke("dashed", left, py(y), end, py(y)); }

void SvgChart::note(double x, double y, const std::string& words) {
  body_ += text(px(x), py(y), "start", words, " class=\"name\"");
}

std::string SvgChart::svg() const {
  return fmt::format("<svg viewBox=\"0 0 {:g} {:g}\" role=\"img\" aria-label=\"{}\">{}{}</svg>\n",
                     width, height, html(summary_), axes_, body_);
}

std::pair<double, double> rounded_limits(const std::vector<double>& values, double step) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const double value : values)
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  if (!(low <= high)) return {0, step};
  low = std::floor(low / step) * step;
  high = std::ceil(high / step) * step;
  return {low, std::max(high, low + step)};
}

}  // namespace ra2d
