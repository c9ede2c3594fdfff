// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/displacement.hpp"
#include "kernels/lanes.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Modal forces that do not depend on the state: the load, and the forces that travel.
template <class Lanes, int K>
class OuterForces {
  using Real = typename Lanes::Real;

 public:
  KOKKOS_FUNCTION OuterForces(const Lanes& lanes, const SceneTables& tables)
      : lanes_{lanes}, t_{tables} {
    for (int p = 0; p < K; ++p) load_[p] = lanes.load(t_.load + p * Lanes::width);
  }

  KOKKOS_FORCEINLINE_FUNCTION const Real* load() const { return load_; }

  /// Both at a step; the second by themselves in `moving`, where there are any.
  KOKKOS_FORCEINLINE_FUNCTION void operator()(std::int64_t step, Real* force, Real* moving) const {
    for (int p = 0; p < K; ++p) force[p] = load_[p];
    if (t_.moving_forces == 0) return;
    this->moving(step, 0.0, moving);
    for (int p = 0; p < K; ++p) force[p] = force[p] + moving[p];
  }
  /// The forces that travel, at a share `behind` of the step after `step`.
  KOKKOS_FUNCTION void moving(std::int64_t step, double behind, Real* moving) const {
    for (int p = 0; p < K; ++p) moving[p] = Real(0.0);
    for (int i = 0; i < t_.moving_forces; ++i) {
      const MovingForceTable& f = t_.moving_force[i];
      const double x = Kokkos::fma(static_cast<double>(step) + behind, f.advance, f.position);
      if (x < 0.0 || x > t_.resonator_length) continue;
      Real psi[K];
      mode_values<Lanes, K>(lanes_, t_, x / t_.spacing, psi);
      for (int p = 0; p < K; ++p) moving[p] = multiply_add(f.force, psi[p], moving[p]);
    }
  }
  /// Their work over a step in which the modes move at v [J].
  KOKKOS_FORCEINLINE_FUNCTION double work(const Real* moving, const Real* v) const {
    Real power(0.0);
    for (int p = 0; p < K; ++p) power = multiply_add(moving[p], v[p], power);
    return t_.step * lanes_.sum(power);
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  Real load_[K];
};

}  // namespace ra2d
