// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/spectrum.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "host/analysis/distributions.hpp"

namespace ra2d {
namespace {

/// The periodic one, whose segments at half their length add up to a constant.
std::vector<double> make_window(Window kind, std::size_t length) {
  std::vector<double> window(length, 1.0);
  if (kind == Window::hann)
    for (std::size_t n = 0; n < length; ++n)
      window[n] =
          0.5 - 0.5 * std::cos(2 * M_PI * static_cast<double>(n) / static_cast<double>(length));
  return window;
}

/// sum_n w_n w_{n + shift}
double product_at(const std::vector<double>& window, std::size_t shift) {
  double sum = 0;
  for (std::size_t n = 0; n + shift < window.size(); ++n) sum += window[n] * window[n + shift];
  return sum;
}

}  // namespace

Segments half_overlapping(double rate, std::size_t length) {
  return {rate, length, std::max<std::size_t>(1, length / 2), Window::hann};
}

std::size_t usual_segment(std::size_t samples) {
  return samples < 16 ? 0 : std::bit_floor(samples / 8);
}

Welch::Welch(const Segments& segments)
    : segments_{segments},
      window_{make_window(segments.window, segments.length)},
      scale_{1.0 / (segments.rate * product_at(window_, 0))},
      fourier_{segments.length} {}

std::vector<double> Welch::frequencies() const {
  std::vector<double> frequency(lines());
  for (std::size_t j = 0; j < frequency.size(); ++j)
    frequency[j] = static_cast<double>(j) * segments_.rate / static_cast<double>(segments_.length);
  return frequency;
}

std::vector<double> Welch::density(std::span<const double> signal) {
  const std::size_t count = segments_.count(signal.size());
  if (count == 0) return {};
  std::vector<double> density(lines());
  const std::span<double> input = fourier_.input();
  for (std::size_t segment = 0; segment < count; ++segment) {
    const double* samples = signal.data() + segment * segments_.hop;
    for (std::size_t n = 0; n < input.size(); ++n) input[n] = window_[n] * samples[n];
    fourier_.transform();
    for (std::size_t j = 0; j < density.size(); ++j) density[j] += fourier_.power(j);
  }
  for (double& value : density) value *= scale_ / static_cast<double>(count);
  return density;
}

double Welch::degrees_of_freedom(std::size_t samples) const {
  const std::size_t count = segments_.count(samples);
  const auto segments = static_cast<double>(count);
  double shared = 0;  // variance that segments have in common, of that of one
  for (std::size_t m = 1; m < count && m * segments_.hop < segments_.length; ++m) {
    const double overlap = product_at(window_, m * segments_.hop) / product_at(window_, 0);
    shared += (1 - static_cast<double>(m) / segments) * overlap * overlap;
  }
  return 2 * segments / (1 + 2 * shared);
}

Confidence confidence_of_density(double degrees_of_freedom, double level) {
  const double tail = (1 - level) / 2;
  return {level, degrees_of_freedom / chi_square_quantile(1 - tail, degrees_of_freedom),
          degrees_of_freedom / chi_square_quantile(tail, degrees_of_freedom)};
}

}  // namespace ra2d
