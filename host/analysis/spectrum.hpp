// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "host/base/fourier.hpp"

/// Power spectral densities by Welch's method: segments that overlap, each under a window, their
/// powers averaged.
namespace ra2d {

enum class Window { hann, rectangular };

/// How a signal is cut into segments.
struct Segments {
  double rate = 0;         // Hz, of the samples
  std::size_t length = 0;  // samples of a segment, 2 or more
  std::size_t hop = 0;     // from one segment to the next
  Window window = Window::hann;

  double resolution() const { return rate / static_cast<double>(length); }  // Hz, between lines
  /// How many fit into so many samples.
  std::size_t count(std::size_t samples) const {
    return samples < length ? 0 : (samples - length) / hop + 1;
  }
};

/// Of so many samples under a Hann window, half overlapping.
Segments half_overlapping(double rate, std::size_t length);

/// The longest power of two of which eight would fit end to end: some 15 segments that overlap.
std::size_t usual_segment(std::size_t samples);

/// Estimates densities of several signals in the same way.
class Welch {
 public:
  explicit Welch(const Segments& segments);

  const Segments& segments() const { return segments_; }

  std::size_t lines() const { return fourier_.lines(); }
  std::vector<double> frequencies() const;  // Hz

  /// One-sided density, in the signal's unit squared per Hz, so that sum(density) resolution is the
  /// mean square under the window; empty where no segment fits.
  std::vector<double> density(std::span<const double> signal);

  /// Of an estimate from so many samples of Gaussian noise, were it chi-square: 2 for each segment,
  /// and fewer where segments overlap, by what their windows have in common (Welch 1967). The first
  /// line has half of them, and so has the last of an even length.
  double degrees_of_freedom(std::size_t samples) const;

 private:
  Segments segments_;
  std::vector<double> window_;
  double scale_;  // of |X|^2
  Fourier fourier_;
};

/// An estimate times `low` and times `high` bound the true value with this confidence.
struct Confidence {
  double level = 0, low = 0, high = 0;
};
Confidence confidence_of_density(double degrees_of_freedom, double level = 0.95);

}  // namespace ra2d
