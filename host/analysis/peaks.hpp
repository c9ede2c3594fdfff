// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "host/analysis/half_power.hpp"

/// Peaks of a velocity spectrum near natural frequencies.
namespace ra2d {

/// A spectrum's lines, evenly spaced from 0 Hz.
struct Lines {
  double resolution = 0;            // Hz
  std::span<const double> density;  // one-sided
};

struct SpectralPeak {
  std::size_t mode = 0;  // its number in the file, rigid ones first
  double natural = 0;    // Hz, of the free mode
  /// Hz, of the highest line near it; NaN where none stands out, or neighbours are nearer than
  /// `least_apart` lines: it could be anyone's.
  double frequency = 0;
  double density = 0;    // there; NaN where there is none
  HalfPower half_power;  // of the mode by itself, whatever stands near it
  bool of_mesh = false;  // it stands on a tone of the mesh (analysis.hpp), and has no damping
};

inline constexpr double least_apart = 3;

/// The peak of each elastic mode within the spectrum, by frequency. `zeta`: their modal damping
/// ratio, NaN where it is not known. It gives the expected width of a peak: lines are averaged over
/// a fifth of it, so that fewer are high by chance.
std::vector<SpectralPeak> find_peaks(const Lines& lines, const std::vector<double>& natural,
                                     double zeta);

/// Marks what stands within two lines of a multiple of the mesh's tone [Hz].
void mark_mesh(std::vector<SpectralPeak>& peaks, double tone, double resolution);

/// A tone is sought within lines_of_tone lines of its frequency, and compared with the lines up to
/// lines_around_tone away.
inline constexpr std::size_t lines_of_tone = 2, lines_around_tone = 20;

/// How far the highest line at a frequency rises above the median of those around [dB]; NaN where
/// the spectrum does not reach so far.
double rise_at(const Lines& lines, double frequency);

/// The rise within densities that reach lines_around_tone to either side of the tone.
double rise_of(std::span<const double> densities);

}  // namespace ra2d
