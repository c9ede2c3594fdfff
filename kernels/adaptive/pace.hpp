// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/tables.hpp"

/// The time of a step at a pace (Pace, kernels/tables.hpp), as a share of its length.
namespace ra2d {

KOKKOS_INLINE_FUNCTION double pace_share(Pace pace, double x) {
  return pace == Pace::even ? x : pace == Pace::from_onset ? x * x : x * (2.0 - x);
}
KOKKOS_INLINE_FUNCTION double pace_rate(Pace pace, double x) {
  return pace == Pace::even ? 1.0 : pace == Pace::from_onset ? 2.0 * x : 2.0 - 2.0 * x;
}
/// The change of that rate per x.
KOKKOS_INLINE_FUNCTION double pace_change(Pace pace) {
  return pace == Pace::even ? 0.0 : pace == Pace::from_onset ? 2.0 : -2.0;
}
/// The x at which a share of the time has passed.
template <class Real>
KOKKOS_INLINE_FUNCTION Real pace_x(Pace pace, const Real& share) {
  if (pace == Pace::even) return share;
  if (pace == Pace::from_onset) return Kokkos::sqrt(share);
  return share / (Real(1.0) + Kokkos::sqrt(Real(1.0) - share));
}

}  // namespace ra2d
