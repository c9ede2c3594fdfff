// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_filter.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <span>

#include "host/base/fourier.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

using std::numbers::pi;
const double alpha = std::sqrt(std::numbers::ln2 / pi);
/// In cutoffs. Beyond it there is erfc(bell_half_width sqrt(pi)/alpha) = 1e-17 of a bell.
constexpr double bell_half_width = 1.6;
constexpr double strides = 256;    // of a wide bell's cutoff
constexpr double narrowest = 7.5;  // strides: 2^-7.5^2 is what a stride mistakes for something slow
constexpr double least_weight = 1e-17;   // of a point, against 1
constexpr std::size_t few_weights = 32;  // which are summed plainly

/// The bell's weights by the distance in points, and its moments up to there.
struct Bell {
  std::vector<double> weight, moment;  // moment: weight times distance, in units of the half width
  std::vector<double> sum0, sum1, sum2;

  Bell(std::size_t points, double spacing, double cutoff) {
    const double far = std::ceil(bell_half_width * cutoff / spacing);
    const std::size_t half =
        far < static_cast<double>(points) ? static_cast<std::size_t>(far) : points - 1;
    const double unit = static_cast<double>(std::max<std::size_t>(half, 1));
    double total0 = 0, total1 = 0, total2 = 0;
    for (std::size_t i = 0; i <= half; ++i) {
      const double x = static_cast<double>(i) * (spacing / cutoff);
      // pi/alpha^2 = pi^2/ln 2
      const double here = std::exp(-pi * pi / std::numbers::ln2 * x * x);
      if (here < least_weight) break;
      weight.push_back(here);
      const double distance = static_cast<double>(i) / unit;
      moment.push_back(weight[i] * distance);
      sum0.push_back(total0 += weight[i]);
      sum1.push_back(total1 += moment[i]);
      sum2.push_back(total2 += moment[i] * distance);
    }
  }
  std::size_t half() const { return weight.size() - 1; }
  double unit() const { return static_cast<double>(std::max<std::size_t>(half(), 1)); }  // points
};

/// The heights' weighted sum (real part) and their first moment (imaginary part) about every point.
using BellMoments = std::vector<std::complex<double>>;
using Transformed = std::vector<std::complex<double>>;

BellMoments sum_plainly(const std::vector<double>& heights, const Bell& bell) {
  BellMoments moments(heights.size());
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const std::size_t left = std::min(i, bell.half());
    const std::size_t right = std::min(heights.size() - 1 - i, bell.half());
    double sum = bell.weight[0] * heights[i], first = 0;
    for (std::size_t j = 1; j <= left; ++j) {
      sum += bell.weight[j] * heights[i - j];
      first -= bell.moment[j] * heights[i - j];
    }
    for (std::size_t j = 1; j <= right; ++j) {
      sum += bell.weight[j] * heights[i + j];
      first += bell.moment[j] * heights[i + j];
    }
    moments[i] = {sum, first};
  }
  return moments;
}

/// The transform of a kernel: at[0] about its middle, at[j] j points before and side * at[j]
/// behind.
Transformed transfer(Fourier& fourier, const std::vector<double>& at, double side) {
  const std::span<double> kernel = fourier.input();
  std::fill(kernel.begin(), kernel.end(), 0.0);
  kernel[0] = at[0];
  for (std::size_t j = 1; j < at.size(); ++j) {
    kernel[j] = side * at[j];
    kernel[kernel.size() - j] = at[j];
  }
  fourier.transform();
  return {fourier.spectrum().begin(), fourier.spectrum().end()};
}

/// Each line times another, and back; written out: operator* looks for NaN.
void convolve(std::span<const std::complex<double>> lines, const Transformed& other,
              BackFourier& back) {
  const auto product = back.input();
  for (std::size_t k = 0; k < product.size(); ++k) {
    const auto a = lines[k], b = other[k];
    product[k] = {a.real() * b.real() - a.imag() * b.imag(),
                  a.real() * b.imag() + a.imag() * b.real()};
  }
  back.transform();
}

/// Sums of any bell: convolutions with the weights and with the moments, block by block.
BellMoments sum_by_fft(const std::vector<double>& heights, const Bell& bell) {
  const std::size_t half = bell.half(), count = heights.size();
  const std::size_t block = std::min(std::bit_ceil(8 * half), std::bit_ceil(count + 2 * half));
  const std::size_t fresh = block - 2 * half;  // points of a block that see no wrapping
  Fourier fourier(block);
  BackFourier sums(block), firsts(block);
  const Transformed weights = transfer(fourier, bell.weight, 1),
                    moment = transfer(fourier, bell.moment, -1);
  const double scale = 1 / static_cast<double>(block);
  BellMoments moments(count);
  const std::span<double> values = fourier.input();
  for (std::size_t begin = 0; begin < count; begin += fresh) {
    for (std::size_t k = 0; k < block; ++k) {
      const std::size_t at = begin + k;  // of a profile that begins half points later
      values[k] = at >= half && at - half < count ? heights[at - half] : 0.0;
    }
    fourier.transform();
    convolve(fourier.spectrum(), weights, sums);
    convolve(fourier.spectrum(), moment, firsts);
    for (std::size_t k = 0; k < fresh && begin + k < count; ++k)
      moments[begin + k] = {scale * sums.output()[k + half], scale * firsts.output()[k + half]};
  }
  return moments;
}

/// Sums of a wide bell, all lengths in points. A bell of `cutoff` is one of `narrow` convolved with
/// one of `wide`. The first is computed at every `stride`th point only. Its convolution with the
/// second is so smooth that eight points interpolate all between them, to 1e-14 of the heights.
BellMoments sum_in_strides(const std::vector<double>& heights, double cutoff, double unit) {
  const auto stride =
      static_cast<std::size_t>(std::min(cutoff / strides, static_cast<double>(heights.size())));
  const auto step = static_cast<double>(stride);
  const double narrow = narrowest * step;
  const double wide = cutoff * std::sqrt(1 - std::pow(narrow / cutoff, 2));
  const auto far = static_cast<std::ptrdiff_t>(bell_half_width * narrow) + 1;
  const std::size_t margin = static_cast<std::size_t>(far) / stride + 5;
  const auto count = static_cast<std::ptrdiff_t>(heights.size());
  const std::size_t coarse = heights.size() / stride + 2 * margin;

  const Bell near(static_cast<std::size_t>(far) + 1, 1, narrow);
  const auto half = static_cast<std::ptrdiff_t>(near.half());
  std::vector<double> kernel(near.weight.rbegin(), near.weight.rend());
  kernel.insert(kernel.end(), near.weight.begin() + 1, near.weight.end());
  std::vector<double> smooth(coarse, 0.0);
  for (std::size_t k = 0; k < coarse; ++k) {
    const std::ptrdiff_t at =
        (static_cast<std::ptrdiff_t>(k) - static_cast<std::ptrdiff_t>(margin)) *
        static_cast<std::ptrdiff_t>(stride);
    const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(at - half, 0);
    const std::ptrdiff_t end = std::min(at + half + 1, count);
    for (std::ptrdiff_t i = begin; i < end; ++i)
      smooth[k] +=
          kernel[static_cast<std::size_t>(i - at + half)] * heights[static_cast<std::size_t>(i)];
  }
  const Bell bell(coarse, step, wide);
  const BellMoments sums = sum_by_fft(smooth, bell);

  const double scale = step * cutoff / (alpha * narrow * wide);
  const double first_scale = scale * std::pow(cutoff / wide, 2) * bell.unit() * step / unit;
  std::vector<std::array<double, 8>> lagrange(stride);  // by the place between two points
  for (std::size_t k = 0; k < stride; ++k)
    for (std::size_t j = 0; j < 8; ++j) {
      const double x = 3 + static_cast<double>(k) / step;
      lagrange[k][j] = 1;
      for (std::size_t m = 0; m < 8; ++m)
        if (m != j)
          lagrange[k][j] *=
              (x - static_cast<double>(m)) / (static_cast<double>(j) - static_cast<double>(m));
    }
  BellMoments moments(heights.size());
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const std::size_t first = i / stride + margin - 3;
    double sum = 0, moment = 0;
    for (std::size_t j = 0; j < 8; ++j) {
      sum += lagrange[i % stride][j] * sums[first + j].real();
      moment += lagrange[i % stride][j] * sums[first + j].imag();
    }
    moments[i] = {scale * sum, first_scale * moment};
  }
  return moments;
}

}  // namespace

std::vector<double> gaussian_mean_line(const std::vector<double>& heights, double spacing,
                                       double cutoff) {
  if (heights.empty()) return {};
  const Bell bell(heights.size(), spacing, cutoff);
  std::vector<double> line = heights;
  const double mean = subtract_mean(line);  // or the roundings would be those of a far offset
  const BellMoments moments = bell.half() <= few_weights ? sum_plainly(line, bell)
                              : cutoff >= 4 * strides * spacing
                                  ? sum_in_strides(line, cutoff / spacing, bell.unit())
                                  : sum_by_fft(line, bell);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const std::size_t left = std::min(i, bell.half());
    const std::size_t right = std::min(line.size() - 1 - i, bell.half());
    const double s0 = bell.sum0[left] + bell.sum0[right] - bell.weight[0];
    const double s1 = bell.sum1[right] - bell.sum1[left];
    const double s2 = bell.sum2[right] + bell.sum2[left];
    const double fitted =
        left == right ? moments[i].real() / s0
                      : (s2 * moments[i].real() - s1 * moments[i].imag()) / (s0 * s2 - s1 * s1);
    line[i] = mean + fitted;
  }
  return line;
}

std::vector<double> mean_line_above_valleys(const std::vector<double>& heights, double spacing,
                                            double cutoff) {
  std::vector<double> lifted = gaussian_mean_line(heights, spacing, cutoff);
  for (std::size_t i = 0; i < lifted.size(); ++i) lifted[i] = std::max(lifted[i], heights[i]);
  return gaussian_mean_line(lifted, spacing, cutoff);
}

}  // namespace ra2d
