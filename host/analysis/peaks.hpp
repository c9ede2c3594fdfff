// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>
#include <vector>

/// Peaks of a velocity spectrum near natural frequencies, and how wide they are.
namespace ra2d {

/// A spectrum's lines, evenly spaced from 0 Hz.
struct Lines {
  double resolution = 0;            // Hz
  std::span<const double> density;  // one-sided
  double degrees_of_freedom = 0;    // of each
};

struct SpectralPeak {
  std::size_t mode = 0;  // its number in the file, rigid ones first
  double natural = 0;    // Hz, of the free mode
  /// Hz, of the highest line near it; NaN where none stands out, or neighbours are nearer than
  /// `least_apart` lines: it could be anyone's.
  double frequency = 0;
  double density = 0;  // there; NaN where there is none
  /// Half-power damping, (f2 - f1) / (2 frequency), where f1 and f2 have half the density: under a force
  /// of even density the velocity of a mode alone is exactly 2 zeta f wide. NaN where it cannot be told:
  /// narrower than `least_width` lines, neighbours nearer than `least_distance` widths, or lines that
  /// chance moves too much (`least_degrees`).
  double damping = 0;
  bool of_mesh = false;  // it stands on a tone of the mesh (analysis.hpp), and has no damping
};

inline constexpr double least_apart = 3, least_width = 5, least_distance = 4, least_degrees = 200;

/// For each elastic mode within the spectrum, by frequency. `zeta`: their modal damping ratio, which
/// says how wide peaks should be: over a fifth of that lines are averaged, so that fewer are high by
/// chance. NaN where it is not known, and then no damping is given.
std::vector<SpectralPeak> find_peaks(const Lines& lines, const std::vector<double>& natural,
                                     double zeta);

/// Marks what stands within two lines of a multiple of the mesh's tone [Hz].
void mark_mesh(std::vector<SpectralPeak>& peaks, double tone, double resolution);

/// How far the highest line at a frequency, to two lines on either side, rises above the median of those
/// around [dB]; NaN where the spectrum does not reach so far.
double rise_at(const Lines& lines, double frequency);

}  // namespace ra2d
