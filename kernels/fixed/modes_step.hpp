// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/fixed/advance.hpp"
#include "kernels/fixed/outer_forces.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The motion during a stretch of fixed steps, in registers.
template <class Lanes, int packs>
struct Motion {
  using Real = typename Lanes::Real;
  Real u[packs], v[packs];  // modal displacements and velocities
  Real square[packs];       // sum of V^2 since the last sample
  Real deflection_work;     // RunningSums::deflection_work_part
  std::int64_t step;        // at which it stands

  Motion() = default;
  KOKKOS_FORCEINLINE_FUNCTION Motion(const Motion& other) { *this = other; }
  /// Value by value: as one block of memory it would not come into registers.
  KOKKOS_FORCEINLINE_FUNCTION Motion& operator=(const Motion& other) {
    for (int p = 0; p < packs; ++p) {
      u[p] = other.u[p];
      v[p] = other.v[p];
      square[p] = other.square[p];
    }
    deflection_work = other.deflection_work;
    step = other.step;
    return *this;
  }

  KOKKOS_FORCEINLINE_FUNCTION void add_squares(const Lanes& lanes) {
    for (int p = 0; p < filled<packs>(lanes); ++p) square[p] = multiply_add(v[p], v[p], square[p]);
  }
};

/// Time integration: a step of all modes under given forces (kernels/schemes/mode_step.hpp).
template <class Lanes, Form form, int packs>
class ModesStep {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  RA2D_FUNCTION ModesStep(const Lanes& lanes, const SliderMotion& motion,
                          const SchemeWeights& scheme, const OuterForces<Lanes, packs>& outer)
      : lanes_{lanes}, scheme_{scheme}, outer_{outer}, time_step_{motion.time_step} {}

  /// The weights of a free step; the others are read where they are needed.
  struct Weights {
    Real v_u[packs], v_v[packs], v_f[packs];                    // Form::semi_implicit
    Real u_u[packs], u_v[packs], u_load[packs], v_load[packs];  // the others, and the first two
  };
  KOKKOS_FORCEINLINE_FUNCTION Weights weights() const {
    Weights w;
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
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
    const Real tau(time_step_);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      advance_semi_implicit(u[p], v[p], w.v_v[p], w.v_u[p], w.v_f[p] * force[p], tau);
      square[p] = multiply_add(v[p], v[p], square[p]);
    }
  }

  /// The other forms: one step under the load and the stages' modal forces; bit j of `acting` tells
  /// whether there is one at stage j.
  KOKKOS_FORCEINLINE_FUNCTION void advance(Real* u, Real* v, const Weights& w, unsigned acting,
                                           const Real (*force)[packs]) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real du = multiply_add(w.u_u[p], u[p], multiply_add(w.u_v[p], v[p], w.u_load[p]));
      Real v1 = multiply_add(w.v_u[p], u[p], multiply_add(w.v_v[p], v[p], w.v_load[p]));
      for (unsigned rest = acting; rest != 0; rest &= rest - 1) {
        const int j = Kokkos::Experimental::countr_zero_builtin(rest);
        du = multiply_add(end(end_forces + 2 * j, p), force[j][p], du);
        v1 = multiply_add(end(end_forces + 2 * j + 1, p), force[j][p], v1);
      }
      u[p] = u[p] + du;
      v[p] = v1;
    }
  }

  /// The displacement that stage i >= 1 sees.
  KOKKOS_FORCEINLINE_FUNCTION void stage_displacement(int i, const Real* u, const Real* v,
                                                      unsigned acting, const Real (*force)[packs],
                                                      Real* at) const {
    const double* rows = scheme_.stage + scheme_.stage_row[i] * (packs * width);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real du = multiply_add(load_pack(lanes_, rows, p), u[p],
                             multiply_add(load_pack(lanes_, rows, packs + p), v[p],
                                          load_pack(lanes_, rows, 2 * packs + p)));
      for (unsigned rest = acting; rest != 0; rest &= rest - 1)
        du = multiply_add(
            load_pack(lanes_, rows,
                      (3 + Kokkos::Experimental::countr_zero_builtin(rest)) * packs + p),
            force[Kokkos::Experimental::countr_zero_builtin(rest)][p], du);
      at[p] = u[p] + du;
    }
  }

  /// The moving forces at each stage of a step; returns which stages have any.
  KOKKOS_FORCEINLINE_FUNCTION unsigned stage_forces(std::int64_t step, Real (*force)[packs]) const {
    if (!outer_.any_move()) return 0;
    for (int i = 0; i < scheme_.stages; ++i) outer_.moving(step, scheme_.place[i], force[i]);
    return (1u << scheme_.stages) - 1;
  }

  /// Takes v from where it lags to the present, over a share of the step under `force`.
  KOKKOS_FORCEINLINE_FUNCTION void lead(const Real* u, Real* v, const Real* force) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real pushed = multiply_add(end(end_v_u, p), u[p], end(end_forces + 1, p) * force[p]);
      const Real next = multiply_add(end(end_v_v, p), v[p], pushed);
      const Real mean = multiply_add(scheme_.velocity_lag, next - v[p], v[p]);
      v[p] = multiply_add(end(end_now_pushed, p), pushed, end(end_now_mean, p) * mean);
    }
  }
  /// The inverse: from the present to the time at which the scheme has v.
  KOKKOS_FORCEINLINE_FUNCTION void lag(const Real* u, Real* v, const Real* force) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real pushed = multiply_add(end(end_v_u, p), u[p], end(end_forces + 1, p) * force[p]);
      const Real of_pushed =
          multiply_add(scheme_.velocity_lag, end(end_now_mean, p), end(end_now_pushed, p));
      v[p] = (v[p] - of_pushed * pushed) /
             (end(end_now_mean, p) *
              multiply_add(scheme_.velocity_lag, end(end_v_v, p) - Real(1.0), Real(1.0)));
    }
  }

 private:
  Lanes lanes_;
  const SchemeWeights& scheme_;
  OuterForces<Lanes, packs> outer_;
  double time_step_;  // s

  KOKKOS_FORCEINLINE_FUNCTION Real end(int row, int p) const {
    return lanes_.load(scheme_.end + (row * packs + p) * width);
  }
};

}  // namespace ra2d
