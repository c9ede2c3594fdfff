// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/function.hpp"
#include "kernels/lanes.hpp"

namespace ra2d {

/// The modes at one instant.
template <class Lanes, int packs>
struct ModalState {
  using Real = typename Lanes::Real;
  Real u[packs], v[packs];
  Real square[packs];  // integral of V^2 since it was last added to the sums, in ticks

  RA2D_FUNCTION void take(const Lanes& lanes, const ModalState& from) {
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      u[p] = from.u[p];
      v[p] = from.v[p];
      square[p] = from.square[p];
    }
  }
};

/// Bounds on the motion of the modes within a step.
struct MotionBounds {
  double travel;             // m: sum max|psi| |U - U_0|
  double fourth_derivative;  // m/s^4: of an overlap at a node, whose place moves
  double cubic_remainder;    // m: what the cubics over a patch leave out of a displacement
  double size;               // m: sum max|psi| |U|
  /// Bound on the rounding of a displacement [m]: twice that of one sum over most_modes, because it
  /// is compared with another such sum.
  KOKKOS_FORCEINLINE_FUNCTION double rounding() const { return 256 * 0x1p-52 * size; }
};

}  // namespace ra2d
