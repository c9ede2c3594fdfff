// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/analysis/analysis_text.hpp"
#include "host/analysis/bands.hpp"
#include "host/base/text.hpp"

namespace ra2d {
namespace {

constexpr double audible = 20e3;  // Hz
constexpr std::size_t sound_bands_a_line = 6;
constexpr std::size_t most_times = 10;  // of the level in time

std::string sound_line(const std::string& name, const std::string& value) {
  return fmt::format("  {:<17}{}\n", name, value);
}

std::string warning_line(const std::string& warning) {
  return warning.empty() ? "" : sound_line("warning", warning);
}

std::string band_rows(const Analysis& a, const std::vector<int>& numbers,
                      const std::vector<double>& levels, const char* reference) {
  if (numbers.empty()) return sound_line("third octaves", "none: the stretch is too short");
  std::string text =
      sound_line("third octaves", fmt::format("dB re {}, by midband frequency in Hz", reference));
  const std::vector<bool> above = bands_above_modes(a, numbers);
  for (std::size_t first = 0; first < numbers.size(); first += sound_bands_a_line) {
    std::string row;
    for (std::size_t i = first; i < std::min(first + sound_bands_a_line, numbers.size()); ++i)
      row += fmt::format("{:>7} {:6.1f}{}", third_octave_name(numbers[i]), levels[i],
                         above[i] ? "*" : " ");
    text += "  " + row.substr(0, row.find_last_not_of(' ') + 1) + '\n';
  }
  if (above.back())
    text += sound_line("", fmt::format("* above the last mode that was kept, at {:.4g} kHz: no "
                                       "information",
                                       1e-3 * last_mode(a.natural_frequencies)));
  return text;
}

/// The level in up to ten equal stretches.
std::string history_text(const LevelHistory& history) {
  const std::size_t parts = history.mean_square.size();
  if (parts < 2) return {};
  const std::size_t merged = (parts + most_times - 1) / most_times;
  std::string row;
  for (std::size_t first = 0; first + merged <= parts; first += merged) {
    double sum = 0;
    for (std::size_t i = first; i < first + merged; ++i) sum += history.mean_square[i];
    row += sum > 0 ? fmt::format("{:>7.1f}",
                                 pressure_level(std::sqrt(sum / static_cast<double>(merged))))
                   : fmt::format("{:>7}", "silent");
  }
  return sound_line("in time",
                    fmt::format("dB re 20 uPa, over {:.3g} s each from {:.6g} s on",
                                static_cast<double>(merged) * history.part_seconds, history.from)) +
         "  " + row + '\n';
}

std::string microphone_text(const Analysis& a, std::size_t number) {
  const MicrophoneLevels& m = a.microphones[number];
  std::string text =
      sound_line(fmt::format("microphone {}", number + 1),
                 m.rms > 0 ? level_text(m) + interval_text(m.intervals) : level_text(m));
  text += sound_line(
      "", fmt::format("{}peak {:.4g} Pa; {:.6g} s to {:.6g} s, {:.3g} ms or more after the motion",
                      m.position[2] < 0 ? "below the plate; " : "", m.peak, m.from, m.to,
                      1e3 * m.arrives));
  return text + warning_line(warning_of(m)) + history_text(m.history) +
         band_rows(a, m.number, m.level, "20 uPa");
}

/// One digit, of a bound.
double rounded_up(double bound) {
  if (!(bound > 0)) return bound;
  const double unit = std::pow(10, std::floor(std::log10(bound)));
  return std::ceil(bound / unit) * unit;
}

std::string power_text(const Analysis& a) {
  const RadiatedPower& p = *a.power;
  if (std::isnan(p.watts))
    return sound_line("sound power", "not known: " + too_short_text(p.shortest)) +
           band_rows(a, p.number, p.level, "1 pW");
  if (!(p.watts > 0)) return sound_line("sound power", "none");
  std::string text = sound_line(
      "sound power", fmt::format("{:.2f} dB(A), {:.2f} dB re 1 pW ({:.3e} W) to one side, as much "
                                 "to the other; efficiency {:.3g}",
                                 p.lw_a, p.lw, p.watts, p.efficiency));
  const std::string share =
      p.damping_power > 0
          ? fmt::format("{:.2g} times what the resonator's damping takes", p.share_of_damping)
          : "energy, the resonator's damping none";
  text += sound_line("", fmt::format("both sides take {}; the air would lower its modes by less "
                                     "than {:.1g} %",
                                     share, rounded_up(100 * p.inertia)));
  if (p.air_matters())
    text += sound_line("warning",
                       "the air would damp the motion, and takes nothing of it here: the level is "
                       "too high (raise resonator.damping by what the air adds, "
                       "power.modes.damping_of_air in the JSON)");
  text += warning_line(above_modes_text(p.above, last_mode(a.natural_frequencies)));
  return text + band_rows(a, p.number, p.level, "1 pW");
}

}  // namespace

std::string describe_sound(const Analysis& a) {
  if (!a.no_sound.empty()) return sound_line("sound", "none: " + printable(a.no_sound));
  if (a.microphones.empty() && !a.power) return {};
  std::string text = sound_line(
      "sound", fmt::format("of the resonator in a rigid baffle, in air of {:.1f} m/s and {:.3f} "
                           "kg/m^3",
                           a.air.sound_speed, a.air.density));
  text +=
      sound_line("left out", fmt::format("the slider's own sound; modes above {:.4g} kHz, which "
                                         "were not kept",
                                         1e-3 * last_mode(a.natural_frequencies)));
  if (passed * a.rate / 2 < audible)
    text += sound_line("", fmt::format("nothing above {:.4g} Hz is in it: raise output.rate to "
                                       "{:g} for all that is heard",
                                       passed * a.rate / 2, 44e3));
  for (std::size_t i = 0; i < a.microphones.size(); ++i) text += microphone_text(a, i);
  if (a.power) text += power_text(a);
  return text;
}

std::string sound_csv(const Analysis& a) {
  std::string text =
      "of,x_m,y_m,z_m,nominal_Hz,centre_Hz,level_dB,spread_dB,level_a_dB,efficiency,"
      "above_last_mode\n";
  const auto add = [&](const std::string& of, const std::vector<int>& numbers,
                       const std::vector<double>& levels, const std::vector<double>& spread,
                       const std::vector<double>& weighted, const std::vector<double>& efficiency) {
    const std::vector<bool> above = bands_above_modes(a, numbers);
    for (std::size_t i = 0; i < numbers.size(); ++i)
      text += fmt::format("{},{},{},{},{},{},{},{}\n", of, third_octave_name(numbers[i]),
                          third_octave_centre(numbers[i]), levels[i], spread[i], weighted[i],
                          efficiency.empty() ? std::string() : fmt::format("{}", efficiency[i]),
                          above[i] ? 1 : 0);
  };
  for (std::size_t i = 0; i < a.microphones.size(); ++i) {
    const MicrophoneLevels& m = a.microphones[i];
    add(fmt::format("microphone {},{},{},{}", i + 1, m.position[0], m.position[1], m.position[2]),
        m.number, m.level, m.spread, m.level_a, {});
  }
  if (a.power)
    add("power,,,", a.power->number, a.power->level, a.power->spread, a.power->level_a,
        a.power->band_efficiency);
  return text;
}

std::string sound_history_csv(const Analysis& a) {
  std::string text = "microphone,x_m,y_m,z_m,from_s,to_s,p_rms_Pa,lp_dB\n";
  for (std::size_t i = 0; i < a.microphones.size(); ++i) {
    const MicrophoneLevels& m = a.microphones[i];
    for (std::size_t part = 0; part < m.history.mean_square.size(); ++part) {
      const double from = m.history.from + static_cast<double>(part) * m.history.part_seconds;
      const double rms = std::sqrt(m.history.mean_square[part]);
      text += fmt::format("{},{},{},{},{},{},{},{}\n", i + 1, m.position[0], m.position[1],
                          m.position[2], from, from + m.history.part_seconds, rms,
                          rms > 0 ? fmt::format("{}", pressure_level(rms)) : std::string());
    }
  }
  return text;
}

}  // namespace ra2d
