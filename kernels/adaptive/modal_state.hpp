// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

namespace ra2d {

/// The modes at one instant.
template <class Lanes, int packs>
struct ModalState {
  using Real = typename Lanes::Real;
  Real u[packs], v[packs];
  Real square[packs];  // integral of V^2 since it was last added to the sums, in ticks
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
