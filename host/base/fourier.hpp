// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace ra2d {

struct FourierPlan;  // FFTW's, with its numbers

/// The discrete Fourier transform of real numbers, X_j = sum_n x_n exp(-2 pi i j n / N), by FFTW in
/// double precision.
class Fourier {
 public:
  explicit Fourier(std::size_t length);
  ~Fourier();
  Fourier(const Fourier&) = delete;
  Fourier& operator=(const Fourier&) = delete;

  std::size_t length() const { return length_; }           // N
  std::size_t lines() const { return length_ / 2 + 1; }    // j = 0 ... N/2
  std::span<double> input() { return {input_, length_}; }  // x, which a transform leaves as it is
  void transform();
  std::span<const std::complex<double>> spectrum() const;  // X_j
  std::complex<double> line(std::size_t j) const { return spectrum()[j]; }
  /// |X_j|^2, counted for +j and -j together: twice, but for j = 0 and j = N/2.
  double power(std::size_t j) const;

 private:
  std::size_t length_;
  std::unique_ptr<FourierPlan> plan_;
  double* input_;
};

/// The way back: the real numbers x_n = sum_j X_j exp(2 pi i j n / N) with X_-j = conj X_j, from
/// X_0 ... X_{N/2}.
class BackFourier {
 public:
  explicit BackFourier(std::size_t length);
  ~BackFourier();
  BackFourier(const BackFourier&) = delete;
  BackFourier& operator=(const BackFourier&) = delete;

  std::span<std::complex<double>> input();  // X, which a transform destroys
  void transform();
  std::span<const double> output() const;

 private:
  std::size_t length_;
  std::unique_ptr<FourierPlan> plan_;
};

/// The way back for lines that are needed once.
std::vector<double> from_lines(const std::vector<std::complex<double>>& lines, std::size_t length);

/// The smallest length of at least `least` with no prime factor above 7, which are quick to
/// transform.
std::size_t quick_length(std::size_t least);

}  // namespace ra2d
