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

std::string sound_line(const std::string& name, const std::string& value) {
  return fmt::format("  {:<17}{}\n", name, value);
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
                                       1e-3 * last_mode(a)));
  return text;
}

std::string microphone_text(const Analysis& a, std::size_t number) {
  const MicrophoneLevels& m = a.microphones[number];
  std::string text =
      sound_line(fmt::format("microphone {}", number + 1),
                 m.rms > 0 ? level_text(m) + interval_text(m.intervals) : level_text(m));
  text += sound_line(
      "", fmt::format("{}peak {:.4g} Pa; {:.6g} s to {:.6g} s, the sound takes {:.3g} ms or more",
                      m.position[2] < 0 ? "below the plate; " : "", m.peak, m.from, m.to,
                      1e3 * m.arrives));
  return text + band_rows(a, m.number, m.level, "20 uPa");
}

std::string power_text(const Analysis& a) {
  const RadiatedPower& p = *a.power;
  if (!(p.watts > 0)) return sound_line("sound power", "none");
  std::string text = sound_line(
      "sound power", fmt::format("{:.2f} dB(A), {:.2f} dB re 1 pW ({:.3e} W) to one side, as much "
                                 "to the other; efficiency {:.3g}",
                                 p.lw_a, p.lw, p.watts, p.efficiency));
  text += sound_line(
      "", fmt::format("both sides take {:.2g} of what the resonator's damping takes; the air "
                      "would lower its modes by less than {:.1g} %",
                      p.share_of_damping, 100 * p.inertia));
  if (p.air_matters())
    text += sound_line("warning",
                       "the air would damp the motion, and takes nothing of it here: the level is "
                       "too high (raise resonator.damping by what the air adds, mode_damping in "
                       "the JSON)");
  return text + band_rows(a, p.number, p.level, "1 pW");
}

}  // namespace

std::string describe_sound(const Analysis& a) {
  if (!a.no_sound.empty()) return sound_line("sound", "none: " + printable(a.no_sound));
  if (a.microphones.empty() && !a.power) return {};
  std::string text = sound_line(
      "sound", fmt::format("of the resonator in a rigid baffle, in air of {:.1f} m/s and {:.3f} "
                           "kg/m^3; without that of the slider",
                           a.air.sound_speed, a.air.density));
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

}  // namespace ra2d
