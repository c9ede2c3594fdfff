// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/lanes.hpp"

namespace ra2d {

/// One step of a mode with U1 = U0 + tau V1, V1 = v_v V0 + v_u U0 + dv (ModeStep::semi_implicit),
/// dv the velocity that the force adds: three dependent operations.
template <class Real>
KOKKOS_FORCEINLINE_FUNCTION void advance_semi_implicit(Real& u, Real& v, const Real& v_v,
                                                       const Real& v_u, const Real& dv,
                                                       const Real& tau) {
  v = multiply_add(v_v, v, multiply_add(v_u, u, dv));
  u = multiply_add(tau, v, u);
}

}  // namespace ra2d
