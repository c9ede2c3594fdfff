// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "host/analysis/analysis_text.hpp"
#include "host/analysis/bands.hpp"
#include "host/analysis/means.hpp"
#include "host/base/csv.hpp"

namespace ra2d {
namespace {

/// A column for each place, named by its number from 1 and where it is. `y`: of an areal scene.
void name_places(const char* quantity, const std::vector<double>& x, const std::vector<double>& y,
                 const char* unit, std::string& text) {
  for (std::size_t p = 0; p < x.size(); ++p)
    text += fmt::format(",{}{}_at_{:g}{}_m{}", quantity, p + 1, x[p],
                        y.empty() ? "" : fmt::format("_{:g}", y[p]), unit);
}

void add(double value, std::string& text) { text += fmt::format(",{}", value); }

}  // namespace

std::string spectrum_csv(const Analysis& a) {
  const VelocitySpectrum& s = a.spectrum;
  std::string text = "frequency_Hz,psd_mean_m2/s2/Hz,psd_force_N2/Hz";
  name_places("psd_probe", a.probe_position, a.probe_y, "_m2/s2/Hz", text);
  name_places("psd_slider_probe", a.slider_probe_position, a.slider_probe_y, "_m2/s2/Hz", text);
  text += '\n';
  for (std::size_t j = 0; j < s.frequency.size(); ++j) {
    text += fmt::format("{},{},{}", s.frequency[j], s.mean[j], s.force[j]);
    for (const auto* probes : {&s.probe, &s.slider_probe})
      for (const std::vector<double>& probe : *probes) add(probe[j], text);
    text += '\n';
  }
  return text;
}

std::string bands_csv(const Analysis& a) {
  const BandLevels& b = a.bands;
  const bool weighted = !b.level_a.empty();
  std::string text = "nominal_Hz,centre_Hz,level_dB,spread_dB";
  if (weighted) text += ",level_a_dB";
  name_places("level_probe", a.probe_position, a.probe_y, "_dB", text);
  text += ",above_last_mode\n";
  const std::vector<bool> above = bands_above_modes(a, b.number);
  for (std::size_t i = 0; i < b.number.size(); ++i) {
    text += fmt::format("{},{},{},{}", third_octave_name(b.number[i]),
                        third_octave_centre(b.number[i]), b.level[i], b.spread[i]);
    if (weighted) add(b.level_a[i], text);
    for (const std::vector<double>& probe : b.level_probe) add(probe[i], text);
    text += above[i] ? ",1\n" : ",0\n";
  }
  return text;
}

std::string shocks_csv(const Analysis& a) {
  const ShockStatistics& s = a.shocks;
  std::string text = "quantity,from,to,count\n";
  for (const auto& [name, bins] : {std::pair{"duration_s", &s.durations},
                                   {"peak_force_N", &s.peak_forces},
                                   {"impulse_Ns", &s.impulses},
                                   {"interval_s", &s.intervals}})
    for (std::size_t i = 0; i < bins->counts.size(); ++i)
      text +=
          fmt::format("{},{},{},{}\n", name, bins->edges[i], bins->edges[i + 1], bins->counts[i]);
  return text;
}

std::string figures_csv(const std::vector<Analysis>& analyses) {
  const auto number = [](double value) {
    return std::isfinite(value) ? fmt::format("{}", value) : std::string();
  };
  std::string text =
      "of,level_dB,level_low_dB,level_high_dB,shocks_1/s,shocks_low_1/s,shocks_high_1/s\n";
  const auto add = [&](const std::string& of, double level, const Interval& levels, double rate,
                       const Interval& rates) {
    text += csv_field(of);
    for (const double value : {level, levels.low, levels.high, rate, rates.low, rates.high})
      text += ',' + number(value);
    text += '\n';
  };
  for (const Analysis& a : analyses)
    add(a.file.string(), a.lv, a.intervals.level, a.shocks.rate, a.intervals.shock_rate);
  if (analyses.size() < 2) return text;
  MeanOfRuns level = mean_of_runs({}), rate = level;
  for (const FigureOfRuns& figure : means_of(analyses))
    if (figure.name == "lv")
      level = figure.value;
    else if (figure.name == "shocks.rate")
      rate = figure.value;
  add("mean", level.mean, {level.low, level.high}, rate.mean, {rate.low, rate.high});
  return text;
}

}  // namespace ra2d
