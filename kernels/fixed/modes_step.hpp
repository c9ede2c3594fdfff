// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/fixed/advance.hpp"
#include "kernels/fixed/outer_forces.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// What a stretch of fixed steps works on, in registers.
template <class Lanes, int K>
struct Motion {
  using Real = typename Lanes::Real;
  Real u[K], v[K];    // modal displacements and velocities
  Real square[K];     // sum of V^2 since the last sample
  Real bend;          // see CarriedState::bend_part
  std::int64_t step;  // that it stands at

  Motion() = default;
  KOKKOS_FORCEINLINE_FUNCTION Motion(const Motion& other) { *this = other; }
  /// Value by value: as one block of memory it would not come into registers.
  KOKKOS_FORCEINLINE_FUNCTION Motion& operator=(const Motion& other) {
    for (int p = 0; p < K; ++p) {
      u[p] = other.u[p];
      v[p] = other.v[p];
      square[p] = other.square[p];
    }
    bend = other.bend;
    step = other.step;
    return *this;
  }

  KOKKOS_FORCEINLINE_FUNCTION void add_squares() {
    for (int p = 0; p < K; ++p) square[p] = multiply_add(v[p], v[p], square[p]);
  }
};

/// Time integration: a step of all modes under given forces (kernels/schemes/mode_step.hpp).
template <class Lanes, Form form, int K>
class ModesStep {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION ModesStep(const Lanes& lanes, const SceneTables& tables,
                            const OuterForces<Lanes, K>& outer)
      : lanes_{lanes}, t_{tables}, outer_{outer} {}

  /// What the free step needs of every mode; the rest is read where it is needed.
  struct Weights {
    Real v_u[K], v_v[K], v_f[K];                // Form::semi_implicit
    Real u_u[K], u_v[K], u_load[K], v_load[K];  // the others, and the first two
  };
  KOKKOS_FORCEINLINE_FUNCTION Weights weights() const {
    Weights w;
    for (int p = 0; p < K; ++p) {
      w.v_u[p] = end(end_v_u, p);
      w.v_v[p] = end(end_v_v, p);
      if constexpr (form == Form::semi_implicit) {
        w.v_f[p] = end(end_forces + 1, p);
      } else {
        w.u_u[p] = end(end_u_u, p);
        w.u_v[p] = end(end_u_v, p);
        w.u_load[p] = end(end_u_load, p);
        w.v_load[p] = end(end_v_load, p);
      }
    }
    return w;
  }

  /// Form::semi_implicit: one step under the modal forces `force`.
  KOKKOS_FORCEINLINE_FUNCTION void advance(Real* u, Real* v, Real* square, const Real* force,
                                           const Weights& w) const {
    const Real tau(t_.step);
    for (int p = 0; p < K; ++p) {
      advance_semi_implicit(u[p], v[p], w.v_v[p], w.v_u[p], w.v_f[p] * force[p], tau);
      square[p] = multiply_add(v[p], v[p], square[p]);
    }
  }

  /// The other forms: one step under the load and the stages' modal forces; bit j of `acting` tells
  /// whether there is one at stage j.
  KOKKOS_FORCEINLINE_FUNCTION void advance(Real* u, Real* v, const Weights& w, unsigned acting,
                                           const Real (*force)[K]) const {
    for (int p = 0; p < K; ++p) {
      Real du = multiply_add(w.u_u[p], u[p], multiply_add(w.u_v[p], v[p], w.u_load[p]));
      Real v1 = multiply_add(w.v_u[p], u[p], multiply_add(w.v_v[p], v[p], w.v_load[p]));
      for (unsigned rest = acting; rest != 0; rest &= rest - 1) {
        const int j = Kokkos::countr_zero(rest);
        du = multiply_add(end(end_forces + 2 * j, p), force[j][p], du);
        v1 = multiply_add(end(end_forces + 2 * j + 1, p), force[j][p], v1);
      }
      u[p] = u[p] + du;
      v[p] = v1;
    }
  }

  /// The displacement that stage i >= 1 sees.
  KOKKOS_FORCEINLINE_FUNCTION void stage_displacement(int i, const Real* u, const Real* v,
                                                      unsigned acting, const Real (*force)[K],
                                                      Real* at) const {
    const double* rows = t_.stage + t_.stage_row[i] * (K * width);
    for (int p = 0; p < K; ++p) {
      Real du = multiply_add(load(rows, p), u[p],
                             multiply_add(load(rows, K + p), v[p], load(rows, 2 * K + p)));
      for (unsigned rest = acting; rest != 0; rest &= rest - 1)
        du = multiply_add(load(rows, (3 + Kokkos::countr_zero(rest)) * K + p),
                          force[Kokkos::countr_zero(rest)][p], du);
      at[p] = u[p] + du;
    }
  }

  /// The moving forces at each stage of a step; returns which stages have any.
  KOKKOS_FORCEINLINE_FUNCTION unsigned stage_forces(std::int64_t step, Real (*force)[K]) const {
    if (t_.moving_forces == 0) return 0;
    for (int i = 0; i < t_.stages; ++i) outer_.moving(step, t_.place[i], force[i]);
    return (1u << t_.stages) - 1;
  }

  /// Takes v from where it lags to the present, over a share of the step under `force`.
  KOKKOS_FORCEINLINE_FUNCTION void lead(const Real* u, Real* v, const Real* force) const {
    for (int p = 0; p < K; ++p) {
      const Real pushed = multiply_add(end(end_v_u, p), u[p], end(end_forces + 1, p) * force[p]);
      const Real next = multiply_add(end(end_v_v, p), v[p], pushed);
      v[p] = multiply_add(t_.velocity_lag, next - v[p], v[p]);
    }
  }
  /// The other way round: from the present to where the scheme has it.
  KOKKOS_FORCEINLINE_FUNCTION void lag(const Real* u, Real* v, const Real* force) const {
    for (int p = 0; p < K; ++p) {
      const Real pushed = multiply_add(end(end_v_u, p), u[p], end(end_forces + 1, p) * force[p]);
      v[p] = (v[p] - Real(t_.velocity_lag) * pushed) /
             multiply_add(t_.velocity_lag, end(end_v_v, p) - Real(1.0), Real(1.0));
    }
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  const OuterForces<Lanes, K>& outer_;

  KOKKOS_FORCEINLINE_FUNCTION Real load(const double* lanes, int pack) const {
    return lanes_.load(lanes + pack * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION Real end(int row, int p) const {
    return lanes_.load(t_.end + (row * K + p) * width);
  }
};

}  // namespace ra2d
