// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host/base/fourier.hpp"
#include "host/base/quiet_nan.hpp"

/// Third-octave bands (IEC 61260-1:2014, base ten, class 1), and the weighting A (IEC 61672-1).
namespace ra2d {

/// The power of signals over a whole stretch, line by line: no window; zeros are added up to a
/// length that is quick to transform, which changes no power.
class WholeSpectrum {
 public:
  WholeSpectrum(std::size_t samples, double rate);

  std::size_t lines() const { return fourier_.lines(); }
  double frequency(std::size_t line) const;  // Hz
  /// Share of the lines that are independent: between them the added zeros make more.
  double independent() const {
    return static_cast<double>(samples_) / static_cast<double>(fourier_.length());
  }
  /// Adds `weight` times the power of a signal of that many samples: over all lines its mean
  /// square.
  void add(std::span<const double> signal, double weight, std::vector<double>& power);

 private:
  std::size_t samples_;
  double rate_;
  Fourier fourier_;
};

/// Number x of a third octave: its midband frequency [Hz] is 1000 G^(x/3), with G = 10^(3/10).
double third_octave_centre(int number);

/// Its lower edge [Hz]: G^(1/6) below the midband frequency.
double third_octave_low(int number);

/// Its name in the standard: "31.5", "1000", "12500".
std::string third_octave_name(int number);

/// Share of a signal's power at this frequency that the band's filter passes:
/// 1 / (1 + u^12), u = Q (f/f_m - f_m/f), a Butterworth filter's, which keeps the limits of
/// class 1. Q is such that noise of a density like 1/f passes as through an ideal filter of a third
/// octave.
double third_octave_share(int number, double frequency);

/// The bands that a stretch carries: below half the rate of its samples, and so wide that there are
/// `least_product` cycles of their width in it.
std::vector<int> carried_bands(double rate, double seconds);
inline constexpr double least_product = 4;

/// The shortest stretch [s] that carries a band which does not lie above the last mode [Hz]: a sum
/// over bands and lines means something from there on.
double shortest_stretch(double last_mode, double rate);

/// Power in each band.
std::vector<double> band_powers(const std::vector<int>& numbers, const WholeSpectrum& spectrum,
                                std::span<const double> power);

/// Power in each band of several spectra at once: without what a band's filter takes down by 160
/// dB, which is most lines.
std::vector<std::vector<double>> band_powers(const std::vector<int>& numbers,
                                             const WholeSpectrum& spectrum,
                                             const std::vector<std::span<const double>>& powers);

/// Shares of a sound's power that lie above the band of the last mode. NaN: not known.
struct SharesAbove {
  double all = quiet_nan, a_weighted = quiet_nan;
};
/// `power` of the lines, `weighted` by A; `last_mode` in Hz.
SharesAbove shares_above(const WholeSpectrum& spectrum, std::span<const double> power,
                         std::span<const double> weighted, double last_mode);

/// Standard deviation of a band's level over runs [dB], were the signal stationary Gaussian noise.
double band_spread(int number, double seconds);

/// The weighting A [dB]: 0 at 1 kHz.
double a_weighting(double frequency);

/// The A-weighted power spectrum.
std::vector<double> a_weighted(const WholeSpectrum& spectrum, std::span<const double> power);

}  // namespace ra2d
