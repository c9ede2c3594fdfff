// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace ra2d {

/// A series as a picture can hold it: neighbours are put largest_group, and of each group stay the
/// lowest, the highest and the mean value, so that no extreme is lost. Values that are no numbers
/// do not count; a group of them alone is NaN.
struct Envelope {
  std::vector<double> at, low, high, mean;  // at: mean place of the group
  std::size_t largest_group = 0;            // values of the largest group; 1: every value is there
};

/// Where groups begin, and the end: `values` in `most` groups of equal size. Up to twice as many
/// values stay alone.
std::vector<std::size_t> even_groups(std::size_t values, std::size_t most);

Envelope envelope(std::span<const double> at, std::span<const double> values,
                  const std::vector<std::size_t>& groups);

/// As the Python package reads it. For any JSON of nlohmann's, so that this header needs none.
template <class Json>
void to_json(Json& json, const Envelope& e) {
  json = {{"x", e.at}, {"mean", e.mean}, {"together", e.largest_group}};
  if (e.largest_group > 1) {
    json["low"] = e.low;
    json["high"] = e.high;
  }
}

}  // namespace ra2d
