// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/contact/cell_contact.hpp"

/// The overlap along a cell of the slider while it moves, as the search for contacts that begin
/// sees it (kernels/adaptive/onsets.hpp).
namespace ra2d {

/// A place along a cell, and the value there.
struct Highest {
  double value, place;

  KOKKOS_FORCEINLINE_FUNCTION void take(double v, double x) {
    if (!(v > value)) return;
    value = v;
    place = x;
  }
};

/// Where a cubic is largest on [from, to].
KOKKOS_INLINE_FUNCTION Highest highest_on(const Cubic& p, double from, double to) {
  Highest highest{p(from), from};
  highest.take(p(to), to);
  const double a = 3.0 * p.c[3], b = p.c[2], c = p.c[1];  // of the slope, a x^2 + 2 b x + c
  const double discriminant = Kokkos::fma(b, b, -a * c);
  if (discriminant > 0.0) {
    const double root = Kokkos::sqrt(discriminant);  // where the slope falls: a x + b = -root
    const double x = b < 0.0 ? c / (root - b) : (-b - root) / a;
    if (x > from && x < to) highest.take(p(x), x);
  }
  return highest;
}

/// The overlap along a cell, and its rate, on each side of the resonator's node within the cell.
struct MovingCell {
  Cubic overlap[2], rate[2];
  double knot;       // the place of that node
  double curvature;  // m: the largest |h_2''| chi^2 of the two pieces
  double slope;      // m: bound on |h_2'| chi there

  /// The largest overlap, and its rate at that place.
  KOKKOS_FUNCTION double highest(double& rate_there) const {
    const Highest left = highest_on(overlap[0], -0.5, knot),
                  right = highest_on(overlap[1], knot, 0.5);
    rate_there = left.value > right.value ? rate[0](left.place) : rate[1](right.place);
    return Kokkos::max(left.value, right.value);
  }
  /// The largest overlap if each place went on at its rate for a time s.
  KOKKOS_FUNCTION double highest_after(double s) const {
    Cubic then[2];
    for (int side = 0; side < 2; ++side)
      for (int j = 0; j < 4; ++j)
        then[side].c[j] = Kokkos::fma(s, rate[side].c[j], overlap[side].c[j]);
    return Kokkos::max(highest_on(then[0], -0.5, knot).value, highest_on(then[1], knot, 0.5).value);
  }
};

}  // namespace ra2d
