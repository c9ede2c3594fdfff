// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/displacement.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Modal forces that do not depend on the state: the load, and the forces that travel.
template <class Lanes, int packs>
class OuterForces {
  using Real = typename Lanes::Real;

 public:
  RA2D_FUNCTION OuterForces(const Lanes& lanes, const ModeTables& modes, const SliderMotion& motion,
                            const PatchTables& patches, const MovingForces& forces)
      : lanes_{lanes},
        motion_{motion},
        patches_{patches},
        forces_{forces},
        any_move_{forces.count > 0} {
    for (int p = 0; p < filled<packs>(lanes); ++p) load_[p] = load_pack(lanes, modes.load, p);
  }

  /// Pack p of the constant load.
  KOKKOS_FORCEINLINE_FUNCTION Real load(int p) const { return load_[p]; }
  /// Whether there are moving forces.
  KOKKOS_FORCEINLINE_FUNCTION bool any_move() const { return any_move_; }

  /// The sum of both at a step; the moving forces alone in `moving`, where there are any.
  KOKKOS_FORCEINLINE_FUNCTION void operator()(std::int64_t step, Real* force, Real* moving) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = load(p);
    if (!any_move_) return;
    this->moving(step, 0.0, moving);
    for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = force[p] + moving[p];
  }
  /// The moving forces, a share of a step after `step`.
  RA2D_FUNCTION void moving(std::int64_t step, double share, Real* moving) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) moving[p] = Real(0.0);
    for (int i = 0; i < forces_.count; ++i) {
      const MovingForceTable& f = forces_.list[i];
      const double x = Kokkos::fma(static_cast<double>(step) + share, f.advance, f.position);
      if (x < 0.0 || x > forces_.resonator_length) continue;
      Real psi[packs];
      mode_values<Lanes, packs>(lanes_, patches_, x / motion_.spacing, psi);
      if (forces_.across != nullptr) [[unlikely]] {
        const double* const across = forces_.across + i * packs * Lanes::width;
        for (int p = 0; p < filled<packs>(lanes_); ++p)
          psi[p] = psi[p] * lanes_.load(across + p * Lanes::width);
      }
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        moving[p] = multiply_add(f.force, psi[p], moving[p]);
    }
  }
  /// Their work over a step in which the modes move at v [J].
  KOKKOS_FORCEINLINE_FUNCTION double work(const Real* moving, const Real* v) const {
    Real power(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) power = multiply_add(moving[p], v[p], power);
    return motion_.time_step * lanes_.sum(power);
  }

 private:
  Lanes lanes_;
  const SliderMotion& motion_;
  const PatchTables& patches_;
  const MovingForces& forces_;
  // copies, which stay in registers
  bool any_move_;
  Real load_[packs];
};

}  // namespace ra2d
