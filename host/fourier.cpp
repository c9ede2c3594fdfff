// SPDX-License-Identifier: BSD-3-Clause
#include "host/fourier.hpp"

#include <fftw3.h>

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

std::complex<double> Fourier::line(std::size_t j) const {
  return {plan_->output[j][0], plan_->output[j][1]};
}

std::vector<double> from_lines(std::vector<std::complex<double>> lines, std::size_t length) {
  std::vector<double> out(length);
  std::unique_lock lock(planner());
  fftw_plan plan =
      fftw_plan_dft_c2r_1d(static_cast<int>(length), reinterpret_cast<fftw_complex*>(lines.data()),
                           out.data(), FFTW_ESTIMATE);
  lock.unlock();
  fftw_execute(plan);
  lock.lock();
  fftw_destroy_plan(plan);
  return out;
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
