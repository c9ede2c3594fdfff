// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/modal_state.hpp"
#include "kernels/check.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Free flight in closed form, of any length: the modes oscillate about where the load holds them,
///
///   U'' + 2 zeta omega U' + omega^2 (U - U_s) = 0,   U_s = load/(m omega^2),
///
/// and a rigid mode falls, U'' = load/m. What 2^l ticks do to (U - U_s, V, 1) is tabled for every
/// l, together with the integral of V^2, a quadratic form of it; a flight is one product for each
/// bit of its length. Lengths below the first table are one Taylor step: they are so short that
/// what it leaves out is below the roundings.
template <class Lanes, int packs>
class Flight {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  RA2D_FUNCTION Flight(const Lanes& lanes, const ModeTables& modes, const SliderMotion& motion,
                       const MotionLimits& bounds, const SeriesTables& adaptive,
                       const FlightTables& flight)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        bounds_{bounds},
        adaptive_{adaptive},
        flight_{flight} {}

  /// On by `ticks`; adds the integral of V^2 over them, in ticks, to `square`.
  RA2D_FUNCTION void operator()(Real* u, Real* v, Real* square, std::int64_t ticks) const {
    const auto bits = static_cast<std::uint64_t>(ticks);
    const std::uint64_t low = bits & ((std::uint64_t{1} << flight_.first_level) - 1);
    if (low != 0) taylor_step(u, v, square, static_cast<double>(low));
    for (std::uint64_t rest = bits >> flight_.first_level; rest != 0; rest &= rest - 1)
      advance_by_table(u, v, square, Kokkos::Experimental::countr_zero_builtin(rest));
  }

  /// Bounds on the motion within `time` [s]. The energy norm E^2 = V^2 + omega^2 (U - U_s)^2 does
  /// not grow in free flight, and (omega U, V)' is at most omega (zeta + sqrt(1 + zeta^2)) E.
  RA2D_FUNCTION MotionBounds bounds(const Real* u, const Real* v, double time) const {
    Real travel(0.0), fourth_derivative(0.0), tail(0.0), size(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real stretch =
          load_pack(lanes_, modes_.omega, p) * (u[p] - load_pack(lanes_, flight_.rest, p));
      const Real e = Kokkos::sqrt(multiply_add(v[p], v[p], stretch * stretch));
      // of a rigid mode, which may fall from rest, the first is the smaller
      const Real mean =
          multiply_add(0.5 * time, Kokkos::abs(load_pack(lanes_, flight_.free_acceleration, p)), e);
      const Real displacement = Kokkos::min(
          Real(time) * mean, mean * load_pack(lanes_, flight_.displacement_per_energy_norm, p));
      const Real amplitude = Kokkos::abs(u[p]) + displacement;
      const Real largest = load_pack(lanes_, bounds_.largest_shape, p);
      travel = multiply_add(largest, displacement, travel);
      fourth_derivative = multiply_add(
          load_pack(lanes_, flight_.fourth_derivative_per_energy_norm, p), e, fourth_derivative);
      tail = multiply_add(load_pack(lanes_, bounds_.cubic_remainder, p), amplitude, tail);
      size = multiply_add(largest, amplitude, size);
    }
    double sums[4];
    four_sums(lanes_, {travel, fourth_derivative, tail, size}, sums);
    return {sums[0], sums[1] + flight_.fourth_derivative_at_rest, sums[2], sums[3]};
  }

 private:
  Lanes lanes_;
  const ModeTables& modes_;
  const SliderMotion& motion_;
  const MotionLimits& bounds_;
  const SeriesTables& adaptive_;
  const FlightTables& flight_;

  KOKKOS_FORCEINLINE_FUNCTION void advance_by_table(Real* u, Real* v, Real* square,
                                                    int level) const {
    RA2D_CHECK(level >= 0 && level < flight_.levels);
    const double* rows =
        flight_.rows + static_cast<std::int64_t>(level) * (flight_rows * packs * width);
    const int elastic = has_many_packs<Lanes, packs>
                            ? Kokkos::min(flight_.elastic_packs, filled<packs>(lanes_))
                            : 0;
    for (int p = 0; p < elastic; ++p) advance_pack<false>(rows, p, u[p], v[p], square[p]);
    for (int p = elastic; p < filled<packs>(lanes_); ++p)
      advance_pack<true>(rows, p, u[p], v[p], square[p]);
  }
  /// `falls`: whether there are rigid modes. Of elastic ones the rows that go with the 1 are zero:
  /// to read the table is most of the work.
  template <bool falls>
  KOKKOS_FORCEINLINE_FUNCTION void advance_pack(const double* rows, int p, Real& u, Real& v,
                                                Real& square) const {
    const auto row = [&](FlightRow r) { return lanes_.load(rows + (r * packs + p) * width); };
    const auto of_rest = [&](FlightRow r) { return falls ? row(r) : Real(0.0); };
    const Real d = u - load_pack(lanes_, flight_.rest, p), w = v;
    u = u + multiply_add(row(flight_u_u), d, multiply_add(row(flight_u_v), w, of_rest(flight_u)));
    v = multiply_add(row(flight_v_u), d, multiply_add(row(flight_v_v), w, of_rest(flight_v)));
    const Real of_d = multiply_add(row(flight_s_uu), d, row(flight_s_uv) * w);
    const Real of_w = multiply_add(row(flight_s_vv), w, of_rest(flight_s_v));
    square = square + multiply_add(of_d, d, multiply_add(of_w, w, of_rest(flight_s)));
  }

  RA2D_FUNCTION void taylor_step(Real* u, Real* v, Real* square, double ticks) const {
    const double time = ticks * motion_.time_step;
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real decay = load_pack(lanes_, adaptive_.decay, p),
                 omega = load_pack(lanes_, modes_.omega, p), stiff = omega * omega;
      const Real d = u[p] - load_pack(lanes_, flight_.rest, p);
      const Real a =
          load_pack(lanes_, flight_.free_acceleration, p) - multiply_add(stiff, d, decay * v[p]);
      const Real jerk = Real(-1.0) * multiply_add(stiff, v[p], decay * a);
      const Real snap = Real(-1.0) * multiply_add(stiff, a, decay * jerk);
      const Real dv =
          Real(time) * multiply_add(0.5 * time, multiply_add(time / 3.0, snap, jerk), a);
      const Real du =
          Real(time) * (v[p] + Real(time) * multiply_add(time / 6.0, jerk, Real(0.5) * a));
      // the integral of (v + a t + jerk t^2/2)^2
      const Real third = multiply_add(a, a, v[p] * jerk);
      square[p] = square[p] + Real(ticks) * multiply_add(v[p], v[p] + Real(time) * a,
                                                         Real(time * time / 3.0) * third);
      u[p] = u[p] + du;
      v[p] = v[p] + dv;
    }
  }
};

}  // namespace ra2d
