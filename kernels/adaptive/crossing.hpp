// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

/// Where a polynomial first comes to a level: contacts that begin and end.
namespace ra2d {

struct ValueAndSlope {
  double value, slope;
};

/// c_0 + c_1 x + ... + c_n x^n. Even and odd powers apart: half as long a chain of operations.
KOKKOS_INLINE_FUNCTION double polynomial(const double* c, int n, double x) {
  const double y = x * x;
  int j = n & ~1;
  double even = c[j], odd = n > j ? c[n] : 0.0;
  RA2D_KEEP_LOOP
  for (j -= 2; j >= 0; j -= 2) {
    odd = Kokkos::fma(odd, y, c[j + 1]);
    even = Kokkos::fma(even, y, c[j]);
  }
  return Kokkos::fma(odd, x, even);
}
KOKKOS_INLINE_FUNCTION ValueAndSlope polynomial_and_slope(const double* c, int n, double x) {
  const double y = x * x;
  int j = n & ~1;
  double even = c[j], odd = n > j ? c[n] : 0.0, of_even = 0.0, of_odd = 0.0;  // over y
  for (j -= 2; j >= 0; j -= 2) {
    of_odd = Kokkos::fma(of_odd, y, odd);
    of_even = Kokkos::fma(of_even, y, even);
    odd = Kokkos::fma(odd, y, c[j + 1]);
    even = Kokkos::fma(even, y, c[j]);
  }
  return {Kokkos::fma(odd, x, even), Kokkos::fma(2.0 * x, Kokkos::fma(of_odd, x, of_even), odd)};
}

/// The largest value on [0, end], right to within roundings if the slope changes its sign no more
/// than once in each third.
KOKKOS_INLINE_FUNCTION double highest_value(const double* c, int n, double end) {
  double highest = c[0], slope = n > 0 ? c[1] : 0.0;  // at the beginning of the third
  RA2D_KEEP_LOOP
  for (int third = 0; third < 3; ++third) {
    double low = third * (end / 3.0), high = (third + 1) * (end / 3.0);
    double x = third < 2 ? high : end, rising = 0.0, falling = 0.0, next = 0.0;
    // at its end; if a top lies within, towards it: the false position, the other end's slope
    // halved
    for (int i = 0; i <= 60; ++i) {
      const ValueAndSlope p = polynomial_and_slope(c, n, x);
      if (p.value > highest) highest = p.value;
      if (i == 0) {
        next = p.slope;
        if (!(slope > 0.0 && next <= 0.0)) break;
        rising = slope;
        falling = next;
      } else if (p.slope * p.slope * (high - low) <=
                 1e-16 * Kokkos::abs(p.value) * (rising - falling)) {
        break;  // the value is off by no more than slope^2/(2 |curvature|)
      } else if (p.slope > 0.0) {
        low = x;
        rising = p.slope;
        falling *= 0.5;
      } else {
        high = x;
        falling = p.slope;
        rising *= 0.5;
      }
      x = low + (high - low) * (rising / (rising - falling));
      if (!(x > low && x < high)) break;
    }
    slope = next;
  }
  return highest;
}

/// The first x in [0, end] at which sign p(x) comes to within `noise` of `level` or above it; a
/// value beyond `end` where there is none. Nothing is stepped over: with |p''| <= curvature on [0,
/// end], the parabola through the present value and slope whose second derivative is `curvature`
/// meets the level no later than p does. Near a simple crossing the steps shrink quadratically, as
/// Newton's.
KOKKOS_INLINE_FUNCTION double first_crossing(const double* c, int n, double sign, double level,
                                             double noise, double end, double curvature) {
  double x = 0.0;
  while (true) {
    const ValueAndSlope p = polynomial_and_slope(c, n, x);
    const double miss = level - sign * p.value, rate = sign * p.slope;
    if (!(miss > noise)) return x;
    // the positive root of rate d + curvature d^2/2 = miss, in the form that keeps its digits
    const double root = Kokkos::sqrt(Kokkos::fma(rate, rate, 2.0 * curvature * miss));
    const double d = rate > 0.0 ? 2.0 * miss / (root + rate) : (root - rate) / (curvature + 1e-300);
    const double next = x + d;
    // without slope and curvature it never comes to the level
    if (!(next <= end) || root == 0.0) return 2.0 * end + 1.0;
    if (next == x) return x;  // as near as roundings let it come
    x = next;
  }
}

/// A polynomial over [0, x] lies between the smallest and the largest of its Bernstein
/// coefficients, b_i = sum_j C(i, j)/C(n, j) c_j x^j, and its derivatives between their
/// differences. `table`: of polynomials of degree n (SeriesTables::hull).
template <class Lanes>
KOKKOS_INLINE_FUNCTION Hull hull_of(const Lanes& lanes, const double* table, const double* c, int n,
                                    double x, double* bernstein) {
  using Real = typename Lanes::Real;
  constexpr int width = Lanes::width, packs = (overlap_terms + width - 1) / width;
  Real b[packs];
  for (int g = 0; g < packs; ++g) b[g] = Real(c[0]);
  double power = 1.0;
  const int used = n / width + 1;
  for (int j = 1; j <= n; ++j) {
    power *= x;
    const Real term(c[j] * power);
    for (int g = 0; g < packs; ++g)
      if (g < used)
        b[g] = multiply_add(lanes.load(table + j * overlap_terms + g * width), term, b[g]);
  }
  for (int g = 0; g < packs; ++g)
    if (g < used) lanes.store(bernstein + g * width, b[g]);
  lanes.sync();
  const double* mask = table + overlap_terms * overlap_terms;
  const double first = bernstein[1] - bernstein[0];
  Real least = b[0], most = b[0], falling(1e300), rising(-1e300), curvature(0.0);
  for (int g = 0; g < packs; ++g) {
    if (g >= used) continue;
    least = Kokkos::min(least, b[g]);
    most = Kokkos::max(most, b[g]);
    const Real b1 = lanes.load(bernstein + g * width + 1),
               b2 = lanes.load(bernstein + g * width + 2);
    const Real d1 = b1 - b[g], d2 = (b2 - b1) - d1;
    // what is masked out repeats a difference
    const Real in = lanes.load(mask + g * width), d = in * d1 + (Real(1.0) - in) * Real(first);
    falling = Kokkos::min(falling, d);
    rising = Kokkos::max(rising, d);
    curvature =
        Kokkos::max(curvature, Kokkos::abs(d2) * lanes.load(mask + overlap_terms + g * width));
  }
  lanes.sync();
  const double per = n / x;
  double extremes[4];
  four_minima(lanes, {least, -most, falling, -rising}, extremes);
  return {extremes[0], -extremes[1], per * extremes[2], per * -extremes[3],
          per * ((n - 1.0) / x) * lanes.max(curvature)};
}

}  // namespace ra2d
