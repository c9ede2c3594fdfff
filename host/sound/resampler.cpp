// SPDX-License-Identifier: BSD-3-Clause
#include "host/sound/resampler.hpp"

#include <fmt/format.h>
#include <soxr.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>

#include "host/base/errors.hpp"

namespace ra2d {
namespace {

constexpr std::size_t out_at_once = 1 << 14;
constexpr double largest_ratio =
    1e6;  // of the rates: beyond, a sound is one sample or an endless line
constexpr double count_slack = 1e-9;  // of a sample, for the roundings of a ratio

void check(soxr_error_t error) {
  if (error) throw std::runtime_error(std::string("cannot resample: ") + error);
}

}  // namespace

struct Resampler::Engine {
  soxr_t handle;
  ~Engine() { soxr_delete(handle); }
};

std::size_t resampled_count(std::size_t count, double from, double to) {
  if (count == 0 || from == to) return count;
  const double last = static_cast<double>(count - 1) * (to / from);
  return static_cast<std::size_t>(std::floor(last * (1 + 1e-15) + count_slack)) + 1;
}

Resampler::Resampler(double from, double to) : from_{from}, to_{to} {
  if (!(from <= largest_ratio * to && to <= largest_ratio * from))
    throw RequestError(
        fmt::format("samples of {:g} Hz cannot become a sound of {:g} Hz: the rates differ by more "
                    "than a factor of {:g} (--slow, --rate, or output.rate of the scene)",
                    from, to, largest_ratio));
  if (from == to) return;
  const soxr_io_spec_t numbers = soxr_io_spec(SOXR_FLOAT64_I, SOXR_FLOAT64_I);
  const soxr_quality_spec_t quality =
      soxr_quality_spec(SOXR_VHQ, SOXR_ROLLOFF_NONE);  // linear phase
  const soxr_runtime_spec_t runtime = soxr_runtime_spec(1);
  soxr_error_t error = nullptr;
  soxr_t handle = soxr_create(from, to, 1, &error, &numbers, &quality, &runtime);
  check(error);
  engine_.reset(new Engine{handle});
  out_.resize(out_at_once);
}

Resampler::~Resampler() = default;

/// Up to a block of output of some input, or, of no input, of what is left.
std::size_t Resampler::step(const double* samples, std::size_t count, std::size_t& used) {
  std::size_t done = 0;
  check(soxr_process(engine_->handle, samples, count, &used, out_.data(), out_.size(), &done));
  return done;
}

/// The library's count may be off by one at the end.
void Resampler::hand_on(std::size_t count, const TakeSamples& take) {
  const std::size_t expected = resampled_count(fed_, from_, to_);
  const std::size_t now = std::min(count, expected - std::min(expected, given_));
  if (now > 0) take({out_.data(), now});
  given_ += now;
}

void Resampler::feed(std::span<const double> samples, const TakeSamples& take) {
  fed_ += samples.size();
  if (!engine_) return take(samples);
  while (!samples.empty()) {
    std::size_t used = 0;
    const std::size_t done = step(samples.data(), samples.size(), used);
    hand_on(done, take);
    samples = samples.subspan(used);
  }
}

void Resampler::finish(const TakeSamples& take) {
  if (!engine_) return;
  // A few zeros more than there were samples: else the last place may be missing.
  const std::vector<double> zeros(static_cast<std::size_t>(std::ceil(from_ / to_)) + 2);
  for (std::size_t fed = 0, used = 0; fed < zeros.size(); fed += used)
    hand_on(step(zeros.data() + fed, zeros.size() - fed, used), take);
  std::size_t used = 0;
  while (const std::size_t done = step(nullptr, 0, used)) hand_on(done, take);
}

}  // namespace ra2d
