// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

namespace ra2d {

/// A point of a line of `points` that is repeated for ever: a point of the line, or, in the seam
/// between two copies, two of them with their shares.
struct RepeatedPlace {
  std::size_t point, other = 0;
  double share = 1, other_share = 0;

  RepeatedPlace(std::size_t points, std::size_t place);
  /// Steps from one copy to the next: a tenth of the line, at least one.
  static std::size_t seam(std::size_t points);
};

}  // namespace ra2d
