// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/schemes/runge_kutta.hpp"

namespace ra2d {

/// Runge-Kutta of order eight with eleven stages (G. J. Cooper and J. H. Verner, SIAM J. Numer.
/// Anal. 9, 1972, 389-405). The paper names none; no explicit scheme of order eight has fewer
/// stages than eleven (J. C. Butcher, 1985), and this one is known in closed form, so it can be
/// proved: it satisfies all 200 conditions of order eight (tests/kernels/test_schemes.cpp).
///
/// Its weights b are those of Lobatto quadrature of order eight, at 0, (7 -+ sqrt(21))/14, 1/2, 1.
///
/// On a mode R is a polynomial of degree eleven: 1 + z + ... + z^8/8! and three terms of its own.
/// Without damping, x = omega tau,
///
///   |R|^2 = 1 - 4.26e-5 x^10 + ...:   an undamped mode loses that share of its energy a step,
///
/// stable for x <= 3.0018. With damping the limit is 3.09 at zeta = 0.02, 3.19 at 0.2, 3.22 at 0.7,
/// 3.72 on the real axis (zeta = 1), and nowhere below 2.99.
///
/// The penalty spring adds omega_c^2 = k sum phi^2/m to the stiffest modes': omega_c tau <= 3.0018.
/// A shock's onset and release are kinks of the force: across an impact it is of order two like the
/// others.
///
/// Multipliers: as for Heun.
struct Rk8 {
  static constexpr int order = 8, stages = 11;
  static constexpr double root = 4.58257569495584000658804719372800849;  // sqrt(21)
  static constexpr double early = (7 - root) / 14, late = (7 + root) / 14;
  static constexpr double place[] = {0.0, 0.5, 0.5, late, late, 0.5, early, early, 0.5, late, 1.0};
  static constexpr double velocity_lag = 0.0;
  static constexpr double a(int i, int j) { return table[i][j]; }
  static constexpr double b(int i) { return weights[i]; }

  static ModeStep prepare(const Mode& mode, double tau) { return runge_kutta<Rk8>(mode, tau); }

 private:
  static constexpr double weights[] = {1.0 / 20, 0,          0,         0,          0,       0,
                                       0,        49.0 / 180, 16.0 / 45, 49.0 / 180, 1.0 / 20};
  static constexpr double table[11][11] = {
      {},
      {1.0 / 2},
      {1.0 / 4, 1.0 / 4},
      {1.0 / 7, -(7 + 3 * root) / 98, (21 + 5 * root) / 49},
      {(11 + root) / 84, 0, (18 + 4 * root) / 63, (21 - root) / 252},
      {(5 + root) / 48, 0, (9 + root) / 36, (-231 + 14 * root) / 360, (63 - 7 * root) / 80},
      {(10 - root) / 42, 0, (-432 + 92 * root) / 315, (633 - 145 * root) / 90,
       (-504 + 115 * root) / 70, (63 - 13 * root) / 35},
      {1.0 / 14, 0, 0, 0, (14 - 3 * root) / 126, (13 - 3 * root) / 63, 1.0 / 9},
      {1.0 / 32, 0, 0, 0, (91 - 21 * root) / 576, 11.0 / 72, -(385 + 75 * root) / 1152,
       (63 + 13 * root) / 128},
      {1.0 / 14, 0, 0, 0, 1.0 / 9, -(733 + 147 * root) / 2205, (515 + 111 * root) / 504,
       -(51 + 11 * root) / 56, (132 + 28 * root) / 245},
      {0, 0, 0, 0, (-42 + 7 * root) / 18, (-18 + 28 * root) / 45, -(273 + 53 * root) / 72,
       (301 + 53 * root) / 72, (28 - 28 * root) / 45, (49 - 7 * root) / 18}};
};

}  // namespace ra2d
