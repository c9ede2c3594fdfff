// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/fourier.hpp"

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

struct FourierPlan {
  enum class Direction { forward, backward };

  FourierPlan(std::size_t length, Direction direction)
      : numbers{fftw_alloc_real(length)}, lines{fftw_alloc_complex(length / 2 + 1)} {
    if (numbers == nullptr || lines == nullptr) throw std::bad_alloc{};
    const auto count = static_cast<int>(length);
    const std::lock_guard lock(planner());
    plan = direction == Direction::forward
               ? fftw_plan_dft_r2c_1d(count, numbers, lines, FFTW_ESTIMATE | FFTW_PRESERVE_INPUT)
               : fftw_plan_dft_c2r_1d(count, lines, numbers, FFTW_ESTIMATE);
  }
  ~FourierPlan() {
    const std::lock_guard lock(planner());
    if (plan != nullptr) fftw_destroy_plan(plan);
    fftw_free(numbers);
    fftw_free(lines);
  }
  FourierPlan(const FourierPlan&) = delete;
  FourierPlan& operator=(const FourierPlan&) = delete;

  double* numbers;
  fftw_complex* lines;
  fftw_plan plan = nullptr;
};

Fourier::Fourier(std::size_t length)
    : length_{length},
      plan_{std::make_unique<FourierPlan>(length, FourierPlan::Direction::forward)},
      input_{plan_->numbers} {}

Fourier::~Fourier() = default;

void Fourier::transform() { fftw_execute(plan_->plan); }

std::span<const std::complex<double>> Fourier::spectrum() const {
  return {reinterpret_cast<const std::complex<double>*>(plan_->lines), lines()};
}

BackFourier::BackFourier(std::size_t length)
    : length_{length},
      plan_{std::make_unique<FourierPlan>(length, FourierPlan::Direction::backward)} {}

BackFourier::~BackFourier() = default;

std::span<std::complex<double>> BackFourier::input() {
  return {reinterpret_cast<std::complex<double>*>(plan_->lines), length_ / 2 + 1};
}

void BackFourier::transform() { fftw_execute(plan_->plan); }

std::span<const double> BackFourier::output() const { return {plan_->numbers, length_}; }

std::vector<double> from_lines(const std::vector<std::complex<double>>& lines, std::size_t length) {
  BackFourier back(length);
  std::copy(lines.begin(), lines.end(), back.input().begin());
  back.transform();
  return {back.output().begin(), back.output().end()};
}

double Fourier::power(std::size_t j) const {
  const fftw_complex& x = plan_->lines[j];
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
