// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/bands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ra2d {
namespace {

constexpr int order = 6;  // of the Butterworth filter that the bandpass is made from
constexpr int lowest_band = -30, highest_band = 90;  // 1 Hz, 1 THz

/// G^(x/3)
double third_octaves(double x) { return std::pow(10.0, x / 10); }

/// Of the ideal band, from G^(-1/6) to G^(1/6), over pi/(2n) / sin(pi/(2n)), by which more passes
/// through a Butterworth filter of order n with its half power at these edges.
double quality() {
  static const double value = (M_PI / (2 * order)) / std::sin(M_PI / (2 * order)) /
                              (third_octaves(0.5) - third_octaves(-0.5));
  return value;
}

double relative_width() { return third_octaves(0.5) - third_octaves(-0.5); }

double share_at(double centre, double frequency) {
  if (!(frequency > 0)) return 0;
  const double u = quality() * (frequency / centre - centre / frequency);
  const double cube = u * u * u;
  return 1 / (1 + cube * cube * cube * cube);
}

/// R_A(f)^2, not yet scaled to 1 at 1 kHz.
double a_power(double frequency) {
  constexpr double f1 = 20.598997, f2 = 107.65265, f3 = 737.86223, f4 = 12194.217;  // Hz
  const double s = frequency * frequency;
  const double top = f4 * f4 * s * s;
  const double below = (s + f1 * f1) * (s + f4 * f4);
  return top * top / (below * below * (s + f2 * f2) * (s + f3 * f3));
}

}  // namespace

WholeSpectrum::WholeSpectrum(std::size_t samples, double rate)
    : samples_{samples}, rate_{rate}, fourier_{quick_length(std::max<std::size_t>(2, samples))} {}

double WholeSpectrum::frequency(std::size_t line) const {
  return static_cast<double>(line) * rate_ / static_cast<double>(fourier_.length());
}

void WholeSpectrum::add(std::span<const double> signal, double weight, std::vector<double>& power) {
  const std::span<double> input = fourier_.input();
  std::fill(std::copy(signal.begin(), signal.end(), input.begin()), input.end(), 0.0);
  fourier_.transform();
  const double scale =
      weight / (static_cast<double>(samples_) * static_cast<double>(fourier_.length()));
  power.resize(lines());
  for (std::size_t j = 0; j < power.size(); ++j) power[j] += scale * fourier_.power(j);
}

double third_octave_low(int number) { return 1000 * third_octaves(number - 0.5); }

double third_octave_centre(int number) { return 1000 * third_octaves(number); }

std::string third_octave_name(int number) {
  constexpr double names[] = {1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3, 8};  // of the numbers 0 to 9
  const int decade = static_cast<int>(std::floor(number / 10.0));
  return fmt::format("{:g}", names[number - 10 * decade] * std::pow(10.0, 3 + decade));
}

double third_octave_share(int number, double frequency) {
  return share_at(third_octave_centre(number), frequency);
}

std::vector<int> carried_bands(double rate, double seconds) {
  std::vector<int> numbers;
  for (int number = lowest_band; number <= highest_band; ++number) {
    const double centre = third_octave_centre(number);
    if (centre * third_octaves(0.5) > rate / 2) break;
    if (centre * relative_width() * seconds >= least_product) numbers.push_back(number);
  }
  return numbers;
}

double shortest_stretch(double last_mode, double rate) {
  int highest = lowest_band;
  for (const int number : carried_bands(rate, std::numeric_limits<double>::infinity()))
    if (!(third_octave_low(number) > last_mode)) highest = number;
  return least_product / (third_octave_centre(highest) * relative_width());
}

std::vector<double> band_powers(const std::vector<int>& numbers, const WholeSpectrum& spectrum,
                                std::span<const double> power) {
  std::vector<double> found;
  for (const int number : numbers) {
    const double centre = third_octave_centre(number);
    double sum = 0;
    for (std::size_t j = 1; j < power.size(); ++j)
      sum += power[j] * share_at(centre, spectrum.frequency(j));
    found.push_back(sum);
  }
  return found;
}

std::vector<std::vector<double>> band_powers(const std::vector<int>& numbers,
                                             const WholeSpectrum& spectrum,
                                             const std::vector<std::span<const double>>& powers) {
  // u = 10^(16/12) and more
  const double u = std::pow(10.0, 16.0 / 12) / quality(), ratio = u / 2 + std::hypot(1, u / 2);
  std::vector<std::vector<double>> found(powers.size());
  for (const int number : numbers) {
    const double centre = third_octave_centre(number), line = spectrum.frequency(1);
    const auto first = static_cast<std::size_t>(std::max(1.0, std::floor(centre / ratio / line)));
    const auto beyond =
        std::min(spectrum.lines(), static_cast<std::size_t>(std::ceil(centre * ratio / line)) + 1);
    std::vector<double> sums(powers.size());
    for (std::size_t j = first; j < beyond; ++j) {
      const double share = share_at(centre, spectrum.frequency(j));
      for (std::size_t i = 0; i < powers.size(); ++i) sums[i] += powers[i][j] * share;
    }
    for (std::size_t i = 0; i < powers.size(); ++i) found[i].push_back(sums[i]);
  }
  return found;
}

SharesAbove shares_above(const WholeSpectrum& spectrum, std::span<const double> power,
                         std::span<const double> weighted, double last_mode) {
  int first = lowest_band;
  while (first < highest_band && !(third_octave_low(first) > last_mode)) ++first;
  const double edge = third_octave_low(first);
  const auto share = [&](std::span<const double> of_lines) {
    double above = 0, all = 0;
    for (std::size_t j = 0; j < of_lines.size(); ++j) {
      all += of_lines[j];
      if (spectrum.frequency(j) > edge) above += of_lines[j];
    }
    return above / all;
  };
  return {share(power), share(weighted)};
}

double band_spread(int number, double seconds) {
  return 10 / std::log(10.0) / std::sqrt(third_octave_centre(number) * relative_width() * seconds);
}

double a_weighting(double frequency) { return 10 * std::log10(a_power(frequency) / a_power(1000)); }

std::vector<double> a_weighted(const WholeSpectrum& spectrum, std::span<const double> power) {
  std::vector<double> weighted(power.begin(), power.end());
  for (std::size_t j = 0; j < weighted.size(); ++j)
    weighted[j] *= a_power(spectrum.frequency(j)) / a_power(1000);
  return weighted;
}

}  // namespace ra2d
