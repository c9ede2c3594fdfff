// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace ra2d {

/// Takes samples of a sound, some at a time.
using TakeSamples = std::function<void(std::span<const double>)>;

/// Another rate for a signal: without delay (sample i stands at i/`to`, the first where the first
/// was), to the last sample that was fed, without aliases (what lies above half of either rate is
/// at least 100 dB down) and even to 0.01 dB up to 0.91 of the lower half. Before and after the
/// signal there is nothing. Equal rates change no bit. The memory it takes does not grow with the
/// signal.
class Resampler {
 public:
  /// Rates in Hz.
  Resampler(double from, double to);
  ~Resampler();
  Resampler(const Resampler&) = delete;
  Resampler& operator=(const Resampler&) = delete;

  void feed(std::span<const double> samples, const TakeSamples& take);
  /// The rest; nothing can be fed afterwards.
  void finish(const TakeSamples& take);

 private:
  struct Engine;
  std::size_t step(const double* samples, std::size_t count, std::size_t& used);
  void hand_on(std::size_t count, const TakeSamples& take);

  double from_, to_;
  std::unique_ptr<Engine> engine_;  // none where the rates are equal
  std::vector<double> out_;
  std::size_t fed_ = 0, given_ = 0;
};

/// How many samples at `to` Hz stand from the first of so many at `from` Hz to the last.
std::size_t resampled_count(std::size_t count, double from, double to);

}  // namespace ra2d
