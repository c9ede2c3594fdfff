// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <Kokkos_SIMD.hpp>

namespace ra2d {

/// Penalty contact (paper, section 3): f = kappa chi w max(0, -g), the force [N] that pushes the
/// bodies apart at a node. Conservative: the energy of the spring is kappa chi w g^2 / 2.
struct Penalty {
  double stiffness;  // kappa chi w, N/m

  /// Force at an overlap -g [m].
  template <class Real>
  KOKKOS_FORCEINLINE_FUNCTION Real force(const Real& overlap) const {
    return Real(stiffness) * Kokkos::max(overlap, Real(0.0));
  }
  /// Where the bodies touch: the overlap is not negative.
  KOKKOS_FORCEINLINE_FUNCTION double pressing(double overlap) const { return stiffness * overlap; }
};

}  // namespace ra2d
