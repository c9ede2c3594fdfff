// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/analysis_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/analysis/bands.hpp"
#include "host/analysis/means.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"

namespace ra2d {
namespace {

constexpr std::size_t longest_title = 200;  // bytes
constexpr std::size_t most_peaks = 8, bands_a_line = 6;

std::string line(const char* what, const std::string& value) {
  return fmt::format("  {:<17}{}\n", what, value);
}

std::string frequency_text(double hertz) {
  return hertz < 1000 ? fmt::format("{:g} Hz", hertz) : fmt::format("{:g} kHz", hertz * 1e-3);
}

std::string level_text(const Analysis& a) {
  if (std::isnan(a.v_rms))
    return a.has_modes || a.whole ? "none: nothing was counted"
                                  : "none of a part of the run: " + a.intervals.why_none;
  if (!(a.v_rms > 0)) return "-inf dB: the resonator did not vibrate";
  return fmt::format("{:.2f} dB re 1 nm/s (v_rms {:.3e} m/s){}", a.lv, a.v_rms,
                     a.whole ? "" : ", from the samples") +
         interval_text(a.intervals);
}

/// Of quantities whose figures are given in another unit.
std::string spread_text(const Spread& s, double unit, const char* name) {
  return fmt::format("median {:.3g} {}, 80 % from {:.3g} to {:.3g}, mean {:.3g}", s.median / unit,
                     name, s.p10 / unit, s.p90 / unit, s.mean / unit);
}

std::string shocks_text(const Analysis& a) {
  const ShockStatistics& s = a.shocks;
  std::string text =
      line("shocks",
           s.count == 0
               ? std::string("none")
               : fmt::format("{:.0f} a second, {} in all{}; at once {:.3g} on average, {} at most",
                             s.rate, s.count, rate_interval_text(a.intervals), s.at_once_mean,
                             s.at_once_most));
  if (s.count == 0) return text;
  text += line("  duration", spread_text(s.duration, 1e-6, "us"));
  text += line("  peak force", spread_text(s.peak_force, 1, "N"));
  text += line("  impulse", spread_text(s.impulse, 1e-6, "uN s"));
  if (s.count > 1) text += line("  start to start", spread_text(s.interval, 1e-6, "us"));
  if (!std::isnan(a.energy_per_shock))
    text += line("  energy",
                 fmt::format("mean {:.3g} nJ given to the bodies", a.energy_per_shock / 1e-9));
  return text;
}

std::string energy_text(const Analysis& a) {
  const PowerBalance& e = a.energy;
  if (std::isnan(e.sliding)) return line("power", "not known: fewer than two samples");
  std::string text = line(
      "power", fmt::format("in: sliding {:.3g} W, load {:.3g} W; out: damping {:.3g} W; stored "
                           "{:.3g} W; missing {:.1e} W",
                           e.sliding, e.load, e.damping, e.storing, e.missing));
  return text +
         line("energy", fmt::format("kinetic {:.3g} J, elastic {:.3g} J, contact {:.3g} J, on "
                                    "average",
                                    e.kinetic, e.elastic, e.contact));
}

std::string mesh_text(const MeshTone& mesh) {
  if (mesh.stands_out()) return mesh_tone_text(mesh);
  const std::string text = fmt::format("{:.6g} Hz (speed/spacing)", mesh.frequency);
  if (!mesh.in_spectrum) return text + ", beyond the spectrum";
  return std::isnan(mesh.rise) ? text : text + ": does not stand out";
}

std::string spectrum_text(const Analysis& a) {
  const VelocitySpectrum& s = a.spectrum;
  if (s.frequency.empty()) return line("spectrum", "none: the stretch is too short");
  std::string text = line(
      "spectrum",
      fmt::format("to {} in steps of {:.4g} Hz, {} segment{}; 95 %: density x {:.2f} to {:.2f}",
                  frequency_text(s.frequency.back()), s.resolution, s.segments,
                  s.segments == 1 ? "" : "s", s.confidence.low, s.confidence.high));
  if (a.aliased_modes > 0)
    text +=
        line("warning",
             fmt::format("{} mode{} above half the rate of the samples: spectrum, bands and sound "
                         "have their power in wrong places (raise output.rate)",
                         a.aliased_modes, a.aliased_modes == 1 ? " lies" : "s lie"));
  if (std::isnan(a.mesh.frequency)) return text;
  return text + line("mesh tone", mesh_text(a.mesh));
}

/// The damping of a peak, or why there is none.
std::string damping_text(const SpectralPeak& peak, const Analysis& a) {
  const HalfPower& h = peak.half_power;
  if (peak.of_mesh) return "on a tone of the mesh";
  if (std::isnan(h.damping)) return fmt::format("no damping: {}", reason_of(h.why));
  return fmt::format(
      "damping {:.4f} +- {:.4f}{}", h.damping, h.error,
      std::isnan(a.modal_damping) ? "" : fmt::format(" (modal {:g})", a.modal_damping));
}

/// The highest peaks, by frequency.
std::string peaks_text(const Analysis& a) {
  std::vector<SpectralPeak> peaks = a.peaks;
  std::erase_if(peaks, [](const SpectralPeak& p) { return std::isnan(p.density); });
  std::sort(peaks.begin(), peaks.end(),
            [](const SpectralPeak& x, const SpectralPeak& y) { return x.density > y.density; });
  if (peaks.size() > most_peaks) peaks.resize(most_peaks);
  std::sort(peaks.begin(), peaks.end(),
            [](const SpectralPeak& x, const SpectralPeak& y) { return x.natural < y.natural; });
  if (peaks.empty()) return {};
  std::string text = line("highest peaks", "modes are counted from 0, rigid ones first");
  for (const SpectralPeak& p : peaks)
    text += line("", fmt::format("{:8.1f} Hz  {:.2e} (m/s)^2/Hz  mode {:<3} of {:.1f} Hz, {}",
                                 p.frequency, p.density, p.mode, p.natural, damping_text(p, a)));
  return text;
}

/// Columns of midband frequencies and levels.
std::string bands_text(const Analysis& a) {
  const BandLevels& b = a.bands;
  const bool weighted = !b.level_a.empty();
  if (b.number.empty()) return line("third octaves", "none: the stretch is too short");
  if (!a.has_modes)
    return line("third octaves", "none: the file has no motion of the modes (output.modes)");
  std::string text =
      line("third octaves",
           fmt::format("{}dB re 1 nm/s, by midband frequency; bands from {} to {} Hz",
                       weighted ? "A-weighted, " : "", third_octave_name(b.number.front()),
                       third_octave_name(b.number.back())));
  const std::vector<double>& levels = weighted ? b.level_a : b.level;
  const std::vector<bool> above = bands_above_modes(a, b.number);
  const bool marks = above.back();
  for (std::size_t first = 0; first < b.number.size(); first += bands_a_line) {
    std::string row;
    for (std::size_t i = first; i < std::min(first + bands_a_line, b.number.size()); ++i)
      row += fmt::format("{:>7} {:6.1f}{}", third_octave_name(b.number[i]), levels[i],
                         above[i] ? "*"
                         : marks  ? " "
                                  : "");
    text += "  " + row.substr(0, row.find_last_not_of(' ') + 1) + '\n';
  }
  if (marks)
    text += line("", fmt::format("* above the last mode that was kept, at {:.4g} kHz: no "
                                 "information",
                                 1e-3 * last_mode(a.natural_frequencies)));
  if (weighted)
    text +=
        line("A-weighted", std::isnan(a.lv_a)
                               ? "not known: " + too_short_text(shortest_stretch(
                                                     last_mode(a.natural_frequencies), a.rate))
                               : fmt::format("{:.2f} dB re 1 nm/s; a plate's velocity is no sound "
                                             "pressure: this is no dB(A) of sound",
                                             a.lv_a));
  return text;
}

}  // namespace

std::string interval_text(const IntervalsOfRun& intervals) {
  const auto [low, high] = intervals.level;
  return std::isfinite(low)
             ? fmt::format("; 95 %: {:.1f} to {:.1f} dB, with these surfaces", low, high)
             : fmt::format("; no interval: {}", intervals.why_none);
}

std::string rate_interval_text(const IntervalsOfRun& intervals) {
  const auto [low, high] = intervals.shock_rate;
  return std::isfinite(low) ? fmt::format("; 95 %: {:.0f} to {:.0f}", low, high) : "";
}

std::string mesh_tone_text(const MeshTone& mesh) {
  return fmt::format(
      "{:.6g} Hz (speed/spacing), {:.1f} dB above its surroundings: linear faces make it, "
      "scene.faces = \"smooth\" does not",
      mesh.frequency, mesh.rise);
}

std::string describe(const Analysis& a) {
  std::string text =
      fmt::format("{}: {}, {:g} s to {:g} s, {} sample{}{}\n", printable(a.file.string()),
                  printable(shortened(a.title, longest_title)), a.from, a.to, a.samples,
                  a.samples == 1 ? "" : "s", a.samples > 1 ? " at " + frequency_text(a.rate) : "");
  if (!a.complete)
    text += line("incomplete", "the run was cut short: " + printable(shortened(a.ended, 120)));
  text += line("level Lv", level_text(a));
  if (!std::isnan(a.contact_share))
    text += line("in contact", fmt::format("{:.2f} % of the time", 100 * a.contact_share));
  return text + shocks_text(a) + energy_text(a) + spectrum_text(a) + peaks_text(a) + bands_text(a) +
         describe_sound(a);
}

std::string describe_means(const std::vector<Analysis>& analyses) {
  std::string text = fmt::format(
      "mean of {} files, with its interval of {:.0f} % confidence over runs like these\n",
      analyses.size(), 100 * confidence_of_means);
  for (const FigureOfRuns& f : means_of(analyses)) {
    const MeanOfRuns& v = f.value;
    const std::string of =
        v.count < analyses.size() ? fmt::format(", of {}", v.count) : std::string();
    text += fmt::format("  {:<26}", f.name);
    if (std::isinf(v.mean))
      text += "none: one of the runs did not vibrate\n";
    else if (std::isnan(v.mean))
      text += "none\n";
    else
      text += fmt::format(
          "{:>12.5g} {:<4} {}{}\n", v.mean, f.unit == "1" ? "" : f.unit,
          std::isfinite(v.low) && std::isfinite(v.high)
              ? fmt::format("{:>12.5g} to {:<12.5g} deviation {:.3g}", v.low, v.high, v.deviation)
              : "no interval",
          of);
  }
  return text;
}

}  // namespace ra2d
