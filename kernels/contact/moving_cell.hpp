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
  double knot;  // the place of that node
  CellFaces::Steepness steepness;

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

}  // namespace ra2d
