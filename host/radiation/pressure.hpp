// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "host/radiation/transfer.hpp"

/// Pressure in time at places above a face, from samples of its modes' velocities.
namespace ra2d {

/// The band that a pressure has: it is kept below `passed`, and nothing is left above `stopped`,
/// times half the rate of the samples.
inline constexpr double passed = 0.91, stopped = 1.0;
/// Samples on either side by which the filter that makes this band reaches: at either end of a
/// record they are missing.
inline constexpr std::size_t filter_half_length = 133;

/// Velocities of all modes, of `count` samples from `first` on, each mode in a vector of its own.
using VelocitySource =
    std::function<std::vector<std::vector<double>>(std::size_t first, std::size_t count)>;

/// A record of the modes' velocities.
struct VelocityRecord {
  std::size_t samples = 0;
  bool rests_before = true;  // nothing moves before its first sample; false: unknown
  VelocitySource read;
};

/// The filters that lead from the modes' velocities to the pressure at each place.
class PressureFilters {
 public:
  PressureFilters(const Radiator& radiator, const Air& air, const std::vector<Position>& places,
                  double rate, const Fineness& fineness = {});

  /// Bytes that the filters of so many places, the pressures of so many samples, and what is read
  /// of the record at once take.
  static double bytes(const Radiator& radiator, const Air& air, std::size_t places, double rate,
                      std::size_t samples);

  /// Samples of the record from `begin` to before `end`, at which the pressure at a place follows
  /// from the record. They are counted as the record's; `end` may be beyond it, by the way of the
  /// sound.
  struct Range {
    std::size_t begin = 0, end = 0;
    std::size_t count() const { return end > begin ? end - begin : 0; }
  };
  Range carried(std::size_t place, const VelocityRecord& record) const;

  /// The pressure [Pa] at each place, in its range, each of which the record carries.
  std::vector<std::vector<double>> pressures(const VelocityRecord& record,
                                             const std::vector<Range>& ranges) const;

 private:
  struct Filter {
    std::size_t lead = 0;        // samples
    std::size_t taps = 0;        // samples that one sample of the pressure is made of
    std::vector<double> re, im;  // (mode, line)
  };

  std::size_t block_ = 0;  // samples, of a transform
  std::size_t modes_ = 0;
  std::vector<Filter> filters_;
};

}  // namespace ra2d
