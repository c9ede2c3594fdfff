// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "host/base/quiet_nan.hpp"

namespace ra2d {

/// NaN without values.
inline double median(std::vector<double> values) {
  if (values.empty()) return quiet_nan;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

/// Quantiles of any number of positive values in bounded memory: counts in bins of equal ratio, so
/// a quantile is right to within `resolution`, relative. Values outside 1e-15 ... 1e15 are counted
/// at the nearer end.
class LogHistogram {
 public:
  static constexpr double resolution = 1e-3;

  LogHistogram() : counts_(bins()) {}

  void add(double value) {
    const double place = value > lowest ? std::log(value / lowest) / (2 * resolution) : 0.0;
    ++counts_[std::min(counts_.size() - 1, static_cast<std::size_t>(place))];
    ++total_;
  }
  std::int64_t total() const { return total_; }
  /// Shows all that has to be saved to an archive: bin, count, bin, count, ... of the bins that are
  /// not empty.
  template <class Archive>
  void visit(Archive& archive) {
    std::vector<std::int64_t> filled;
    for (std::size_t bin = 0; bin < counts_.size(); ++bin)
      if (counts_[bin] > 0)
        filled.insert(filled.end(), {static_cast<std::int64_t>(bin), counts_[bin]});
    archive(filled);
    std::fill(counts_.begin(), counts_.end(), 0);
    total_ = 0;
    is_sound_ = filled.size() % 2 == 0;
    for (std::size_t i = 0; i + 1 < filled.size() && is_sound_; i += 2) {
      const std::int64_t bin = filled[i], count = filled[i + 1];
      is_sound_ = bin >= 0 && bin < std::ssize(counts_) && count > 0 && count < most_counted;
      if (!is_sound_) break;
      counts_[static_cast<std::size_t>(bin)] += count;
      total_ += count;
    }
  }
  /// Whether what was shown last could be what a histogram holds.
  bool is_sound() const { return is_sound_; }

  /// The value that a share of all values does not exceed; NaN without values.
  double quantile(double share) const {
    if (total_ == 0) return quiet_nan;
    const auto rank =
        std::max<std::int64_t>(1, std::llround(std::ceil(share * static_cast<double>(total_))));
    std::int64_t seen = 0;
    std::size_t bin = 0;
    while (bin + 1 < counts_.size() && (seen += counts_[bin]) < rank) ++bin;
    return lowest * std::exp((static_cast<double>(bin) + 0.5) * 2 * resolution);
  }

 private:
  static constexpr double lowest = 1e-15, highest = 1e15;
  static std::size_t bins() {
    return 1 + static_cast<std::size_t>(std::log(highest / lowest) / (2 * resolution));
  }
  static constexpr std::int64_t most_counted = std::int64_t{1}
                                               << 46;  // so that all bins' sum is a number
  std::vector<std::int64_t> counts_;
  std::int64_t total_ = 0;
  bool is_sound_ = true;
};

}  // namespace ra2d
