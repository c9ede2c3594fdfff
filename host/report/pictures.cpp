// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/analysis/bands.hpp"
#include "host/report/html.hpp"
#include "host/report/svg_chart.hpp"
#include "host/result/level.hpp"

namespace ra2d {
namespace {

constexpr double lowest_frequency = 10;          // Hz, that is drawn
constexpr double most_decibels = 80;             // that an axis spans
constexpr double normal_95 = 1.959963984540054;  // standard deviations

double decibels(double density) { return 10 * std::log10(density / 1e-18); }

/// "500", "16k".
std::string short_name(int number) {
  const std::string name = third_octave_name(number);
  return number < 0 ? name : fmt::format("{:g}k", std::stod(name) * 1e-3);
}

/// The axis for levels, from which the lowest ones may hang.
ChartAxis level_axis(const std::vector<double>& levels, const char* label) {
  const auto [low, high] = rounded_limits(levels, 10);
  return {std::max(low, high - most_decibels), high, false, label, {}};
}

Picture spectrum_picture(const Analysis& a) {
  const VelocitySpectrum& s = a.spectrum;
  std::vector<double> frequency, density;
  for (std::size_t j = 1; j < s.frequency.size(); ++j)
    if (s.frequency[j] >= lowest_frequency) {
      frequency.push_back(s.frequency[j]);
      density.push_back(decibels(s.mean[j]));
    }
  if (frequency.size() < 2) return {};
  ChartAxis y = level_axis(density, "velocity, dB re 1 (nm/s)²/Hz");
  y.high += 10;
  SvgChart chart({frequency.front(), frequency.back(), true, "frequency, Hz", {}}, y,
                 "Velocity spectrum of the resonator");
  chart.line(frequency, density);
  for (const double natural : a.natural_frequencies)
    if (natural > frequency.front() && natural < frequency.back()) chart.mark_top(natural);
  std::string caption =
      "<b>Velocity spectrum</b>, mean over the resonator. Ticks at the top: natural frequencies "
      "of the free plate.";
  if (a.mesh.stands_out()) {
    chart.vertical(a.mesh.frequency, "mesh");
    caption += " A line at the dashed place is the mesh's own tone, not the surface's.";
  }
  const double place = frequency.front() * 1.35, middle = y.low + 0.12 * (y.high - y.low);
  chart.whisker(place, middle + decibels(1e-18 * s.confidence.low),
                middle + decibels(1e-18 * s.confidence.high));
  chart.note(place * 1.25, middle - 0.015 * (y.high - y.low), "95 %");
  caption += fmt::format(
      " The bar marked 95 %: where the true density lies around each line, {} to {} dB, were the "
      "noise stationary and Gaussian. Lines every {} Hz.",
      html_number(10 * std::log10(s.confidence.low), 2),
      html_number(10 * std::log10(s.confidence.high), 2), html_number(s.resolution));
  return {chart.svg(), caption};
}

Picture bands_picture(const Analysis& a) {
  const BandLevels& b = a.bands;
  if (b.number.empty()) return {};
  ChartAxis y = level_axis(b.level, "level, dB re 1 nm/s");
  y.high += 10;
  ChartAxis x{
      b.number.front() - 0.5, b.number.back() + 0.5, false, "third octave, Hz (k: 1000)", {}};
  for (const int number : b.number)
    if (number % 3 == 0) x.ticks.emplace_back(number, short_name(number));
  SvgChart chart(x, y, "Levels in third octaves");
  const std::vector<bool> above = bands_above_modes(a);
  for (std::size_t i = 0; i < b.number.size(); ++i) {
    if (!std::isfinite(b.level[i])) continue;
    chart.column(b.number[i] - 0.5, b.number[i] + 0.5, b.level[i], above[i]);
    chart.whisker(b.number[i], b.level[i] - normal_95 * b.spread[i],
                  b.level[i] + normal_95 * b.spread[i]);
  }
  std::string caption =
      "<b>Third octaves</b> (IEC 61260-1), mean over the resonator. Bars with ends: 95 %, were "
      "the noise stationary and Gaussian.";
  if (above.back())
    caption += fmt::format(" Pale: above the last mode that was kept, at {} kHz: no information.",
                           html_number(1e-3 * last_mode(a), 4));
  return {chart.svg(), caption};
}

Picture history_picture(const Analysis& a, const LevelHistory& h) {
  std::vector<double> time, levels;
  for (std::size_t i = 0; i < h.mean_square.size(); ++i) {
    const double value = level(std::sqrt(h.mean_square[i]));
    if (!std::isfinite(value)) continue;
    time.push_back(h.from + (static_cast<double>(i) + 0.5) * h.part_seconds);
    levels.push_back(value);
  }
  if (time.size() < 2) return {};
  SvgChart chart({a.from, a.to, false, "time, s", {}}, level_axis(levels, "level, dB re 1 nm/s"),
                 "Level over the time of the run");
  chart.line(time, levels);
  if (std::isfinite(a.lv)) chart.horizontal(a.lv);
  return {chart.svg(),
          fmt::format(
              "<b>Level in time</b>, in steps of {} ms; dashed: over the whole stretch, {:.1f} dB.",
              html_number(h.part_seconds * 1e3), a.lv)};
}

/// Bins from one to the other without the rare ones at the ends: less than a thousandth on either
/// side.
std::pair<std::size_t, std::size_t> usual_bins(const std::vector<std::size_t>& counts) {
  const double rare = 1e-3 * std::accumulate(counts.begin(), counts.end(), 0.0);
  std::size_t first = 0, beyond = counts.size();
  for (double sum = static_cast<double>(counts[first]); sum < rare;
       sum += static_cast<double>(counts[first]))
    ++first;
  for (double sum = static_cast<double>(counts[beyond - 1]); sum < rare;
       sum += static_cast<double>(counts[beyond - 1]))
    --beyond;
  return {first, beyond};
}

/// `unit`: what the values are divided by.
Picture histogram_picture(const LogBins& bins, const Spread& spread, double unit,
                          const std::string& what, const std::string& label) {
  if (bins.counts.empty()) return {};
  const auto [first, beyond] = usual_bins(bins.counts);
  std::size_t most = 1, shown = 0, all = 0;
  for (std::size_t i = 0; i < bins.counts.size(); ++i) {
    most = std::max(most, bins.counts[i]);
    all += bins.counts[i];
    if (i >= first && i < beyond) shown += bins.counts[i];
  }
  const double step = std::pow(10, std::floor(std::log10(static_cast<double>(most))));
  SvgChart chart(
      {bins.edges[first] / unit, bins.edges[beyond] / unit, true, label, {}},
      {0, std::ceil(1.15 * static_cast<double>(most) / step) * step, false, "shocks", {}},
      "Histogram of shocks: " + what);
  for (std::size_t i = first; i < beyond; ++i)
    if (bins.counts[i] > 0)
      chart.column(bins.edges[i] / unit, bins.edges[i + 1] / unit,
                   static_cast<double>(bins.counts[i]));
  chart.vertical(spread.median / unit, "median");
  const std::string rest =
      shown < all ? fmt::format(" {} of {} are beyond the picture.", all - shown, all) : "";
  return {chart.svg(), fmt::format("<b>Shocks: {}.</b> Median {}, eight of ten from {} to {} {}.{}",
                                   html(what), html_number(spread.median / unit),
                                   html_number(spread.p10 / unit), html_number(spread.p90 / unit),
                                   html(label.substr(label.find(", ") + 2)), rest)};
}

}  // namespace

std::vector<Picture> pictures_of(const Analysis& a, const LevelHistory& history) {
  std::vector<Picture> pictures;
  if (!a.spectrum.frequency.empty() && a.v_rms > 0) pictures.push_back(spectrum_picture(a));
  if (a.v_rms > 0) pictures.push_back(bands_picture(a));
  pictures.push_back(history_picture(a, history));
  pictures.push_back(histogram_picture(a.shocks.durations, a.shocks.duration, 1e-6,
                                       "how long they last", "duration, µs"));
  pictures.push_back(histogram_picture(a.shocks.peak_forces, a.shocks.peak_force, 1,
                                       "their peak force", "peak force, N"));
  std::erase_if(pictures, [](const Picture& picture) { return picture.svg.empty(); });
  return pictures;
}

}  // namespace ra2d
