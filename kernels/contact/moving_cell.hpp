// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/contact/cell_contact.hpp"
#include "kernels/function.hpp"

/// The overlap along a cell of the slider while it moves, as the search for contacts that begin
/// sees it (kernels/adaptive/onsets.hpp).
namespace ra2d {

/// The overlap along a cell, and its rate, on each side of the resonator's node within the cell.
struct MovingCell {
  Cubic overlap[2], rate[2];
  double knot;       // the place of that node
  double curvature;  // m: the largest |h_2''| chi^2 of the two pieces
  double slope;      // m: bound on |h_2'| chi there

  /// The largest overlap, and its rate at that place.
  RA2D_FUNCTION double highest(double& rate_there) const {
    const Highest left = highest_on(overlap[0], -0.5, knot),
                  right = highest_on(overlap[1], knot, 0.5);
    rate_there = left.value > right.value ? rate[0](left.place) : rate[1](right.place);
    return Kokkos::max(left.value, right.value);
  }
  /// The largest overlap if each place went on at its rate for a time s.
  RA2D_FUNCTION double highest_after(double s) const {
    Cubic then[2];
    for (int side = 0; side < 2; ++side)
      for (int j = 0; j < 4; ++j)
        then[side].c[j] = Kokkos::fma(s, rate[side].c[j], overlap[side].c[j]);
    return Kokkos::max(highest_on(then[0], -0.5, knot).value, highest_on(then[1], knot, 0.5).value);
  }
};

/// A moving cell with two derivatives more: its overlap as a cubic of the time.
struct ForeseenCell {
  MovingCell now;
  Cubic second[2], third[2];

  /// No place rises by more until a time s, as two derivatives tell.
  RA2D_FUNCTION double most_rise(double s) const {
    double most = 0.0;
    for (int side = 0; side < 2; ++side) {
      double rise = 0.0, power = 1.0;
      for (int j = 0; j < 4; ++j, power *= 0.5)
        rise = Kokkos::fma(
            power,
            Kokkos::fma(0.5 * s, Kokkos::abs(second[side].c[j]), Kokkos::abs(now.rate[side].c[j])),
            rise);
      most = Kokkos::max(most, rise);
    }
    return s * most;
  }
  /// The largest overlap after a time s.
  RA2D_FUNCTION double highest_after(double s) const {
    Highest highest{-1e300, 0.0};
    for (int side = 0; side < 2; ++side) {
      Cubic then;
      for (int j = 0; j < 4; ++j) {
        const double change = Kokkos::fma(s / 3.0, third[side].c[j], second[side].c[j]);
        then.c[j] = Kokkos::fma(s, Kokkos::fma(0.5 * s, change, now.rate[side].c[j]),
                                now.overlap[side].c[j]);
      }
      const Highest here =
          side == 0 ? highest_on(then, -0.5, now.knot) : highest_on(then, now.knot, 0.5);
      highest.take(here.value, here.place);
    }
    return highest.value;
  }
  /// A time up to `end` at which the largest overlap changes its sign: to 1e-4 of `end`. Given
  /// what it is at 0 and at `end`, of two signs.
  RA2D_FUNCTION double crossing(double end, double at_start, double at_end) const {
    const double close = 1e-4 * end;
    double low = 0.0, high = end;
    int side = 0;  // at which end the chord was kept the last time
    for (int i = 0; i < 30 && high - low > close; ++i) {
      double s = low + (high - low) * (at_start / (at_start - at_end));
      if (!(s > low && s < high)) s = 0.5 * (low + high);
      const double value = highest_after(s);
      if ((value > 0.0) == (at_start > 0.0)) {
        if (s - low < close && low > 0.0) return s;
        low = s;
        at_start = value;
        if (side == 1) at_end *= 0.5;
        side = 1;
      } else {
        if (high - s < close) return s;
        high = s;
        at_end = value;
        if (side == -1) at_start *= 0.5;
        side = -1;
      }
    }
    return 0.5 * (low + high);
  }
};

}  // namespace ra2d
