// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

namespace ra2d {

/// The modes at one instant, K packs of them.
template <class Lanes, int K>
struct ModalState {
  using Real = typename Lanes::Real;
  Real u[K], v[K];
  Real square[K];  // integral of V^2 since the sums were last closed, in ticks
};

/// What the modes can do within a step.
struct MotionBounds {
  double travel;           // m: sum max|psi| |U - U_0|
  double fourth;           // m/s^4: fourth derivative of an overlap at a node, whose place moves
  double cubic_remainder;  // m: what the cubics over a patch leave out of a displacement
  double size;             // m: sum max|psi| |U|
  /// Of a displacement [m]. Twice what one sum over most_modes reaches: what it is compared with is
  /// one, too.
  KOKKOS_FORCEINLINE_FUNCTION double rounding() const { return 256 * 0x1p-52 * size; }
};

}  // namespace ra2d
