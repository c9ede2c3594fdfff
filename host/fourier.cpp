// SPDX-License-Identifier: BSD-3-Clause
#include "host/fourier.hpp"

#include <fftw3.h>

#include <algorithm>
#include <mutex>
#include <new>

namespace ra2d {
namespace {

/// FFTW plans and forgets one at a time; transforms need no lock.
std::mutex& planner() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

struct Fourier::Plan {
  explicit Plan(std::size_t length)
      : input{fftw_alloc_real(length)}, output{fftw_alloc_complex(length / 2 + 1)} {
    if (input == nullptr || output == nullptr) throw std::bad_alloc{};
    const std::lock_guard lock(planner());
    plan = fftw_plan_dft_r2c_1d(static_cast<int>(length), input, output,
                                FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
  }
  ~Plan() {
    const std::lock_guard lock(planner());
    if (plan != nullptr) fftw_destroy_plan(plan);
    fftw_free(input);
    fftw_free(output);
  }
  Plan(const Plan&) = delete;
  Plan& operator=(const Plan&) = delete;

  double* input;
  fftw_complex* output;
  fftw_plan plan = nullptr;
};

Fourier::Fourier(std::size_t length)
    : length_{length}, plan_{std::make_unique<Plan>(length)}, input_{plan_->input} {}

Fourier::~Fourier() = default;

void Fourier::transform() { fftw_execute(plan_->plan); }

std::span<const std::complex<double>> Fourier::spectrum() const {
  return {reinterpret_cast<const std::complex<double>*>(plan_->output), lines()};
}

struct BackFourier::Plan {
  explicit Plan(std::size_t length)
      : input{fftw_alloc_complex(length / 2 + 1)}, output{fftw_alloc_real(length)} {
    if (input == nullptr || output == nullptr) throw std::bad_alloc{};
    const std::lock_guard lock(planner());
    plan = fftw_plan_dft_c2r_1d(static_cast<int>(length), input, output, FFTW_ESTIMATE);
  }
  ~Plan() {
    const std::lock_guard lock(planner());
    if (plan != nullptr) fftw_destroy_plan(plan);
    fftw_free(input);
    fftw_free(output);
  }
  Plan(const Plan&) = delete;
  Plan& operator=(const Plan&) = delete;

  fftw_complex* input;
  double* output;
  fftw_plan plan = nullptr;
};

BackFourier::BackFourier(std::size_t length)
    : length_{length}, plan_{std::make_unique<Plan>(length)} {}

BackFourier::~BackFourier() = default;

std::span<std::complex<double>> BackFourier::input() {
  return {reinterpret_cast<std::complex<double>*>(plan_->input), length_ / 2 + 1};
}

void BackFourier::transform() { fftw_execute(plan_->plan); }

std::span<const double> BackFourier::output() const { return {plan_->output, length_}; }

std::vector<double> from_lines(const std::vector<std::complex<double>>& lines, std::size_t length) {
  BackFourier back(length);
  std::copy(lines.begin(), lines.end(), back.input().begin());
  back.transform();
  return {back.output().begin(), back.output().end()};
}

double Fourier::power(std::size_t j) const {
  const fftw_complex& x = plan_->output[j];
  const bool alone = j == 0 || 2 * j == length_;
  return (alone ? 1.0 : 2.0) * (x[0] * x[0] + x[1] * x[1]);
}

std::size_t quick_length(std::size_t least) {
  for (std::size_t length = least;; ++length) {
    std::size_t rest = length;
    for (const std::size_t prime : {2, 3, 5, 7})
      while (rest > 0 && rest % prime == 0) rest /= prime;
    if (rest <= 1) return length;
  }
}

}  // namespace ra2d
