// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host/base/quiet_nan.hpp"

namespace ra2d {

/// A stretch in equal parts: what each has, from its samples and shocks.
struct LevelHistory {
  double from = 0, part_seconds = 0;  // s
  std::vector<double> mean_square;    // (m/s)^2, of the resonator's elastic motion
  std::vector<double> shocks;         // that begin in it, a second
};

/// Adds up a history while samples and shocks come, in any order.
class LevelParts {
 public:
  /// Divides the samples `first` to `first + count` of a run at `rate` [Hz]. `modes`: of the
  /// resonator.
  LevelParts(std::size_t first, std::size_t count, double rate, std::size_t modes);

  /// Velocities of all modes, sample by sample; the first of them is sample `at` of the run.
  void add_rows(std::size_t at, std::span<const double> rows);
  /// Velocities of one mode in the whole stretch.
  void add_column(std::size_t mode, std::span<const double> column);
  void add_shock(double start);  // s

  /// The history of all full parts; `weights`: means of psi_k^2 over the resonator [1/m].
  LevelHistory history(const std::vector<double>& weights) const;

  /// All that it has added up, to be kept and gone on from.
  struct Sums {
    std::size_t filled = 0;       // rows of the stretch that were added
    std::vector<double> squares;  // (part, mode), sums
    std::vector<double> shocks;   // counts
  };
  const Sums& sums() const { return sums_; }
  /// Throws std::invalid_argument where they are of another stretch or other modes.
  void go_on(Sums sums);

 private:
  std::size_t first_, modes_, rows_ = 0, parts_ = 0;  // rows of a part
  double rate_;
  Sums sums_;
};

/// Holds the true value with 95 % confidence; NaN where there is no interval.
struct Interval {
  double low = quiet_nan, high = quiet_nan;
};

/// How far the figures of one run are off by chance: of its stretch of these two faces, as if the
/// slider went on over more of the same plate. Which slider and which plate the seeds drew is not
/// in it.
struct IntervalsOfRun {
  Interval level, shock_rate;  // dB; 1/s
  std::string why_none;        // empty where there is one of the level
};

/// Student's t of the logarithm of the mean of ten parts of the run. Parts follow upon each
/// other, and a mode rings on: the intervals are as much wider as they must be where the motion's
/// power forgets as slowly as its slowest mode does, within `ringing` [s] to 1/e (ringing_of). None
/// for a run shorter than ten times that.
IntervalsOfRun intervals_of_run(const LevelHistory& history, double level, double shock_rate,
                                double ringing);

/// Why a stretch of so many parts and seconds has no interval; empty where it has one.
std::string why_no_interval(double level, std::size_t parts, double seconds, double ringing);

/// 1 / (2 zeta omega) of the slowest elastic mode [s]: infinite without damping; 0 without elastic
/// modes.
double ringing_of(const std::vector<double>& frequencies, double damping);

}  // namespace ra2d
