// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cfloat>
#include <cmath>

/// exp and log from the operations that IEEE 754 defines to the last bit (+ - * /, comparisons,
/// floor, frexp, ldexp), so that they give the same bits on every platform and compiler. libm's do
/// not. Holds only without contraction to fused multiply-adds: compile with -ffp-contract=off.
namespace ra2d::portable {

#ifdef __FAST_MATH__
#error "the random surfaces need IEEE arithmetic: compile without -ffast-math"
#endif
static_assert(FLT_EVAL_METHOD == 0 && DBL_MANT_DIG == 53, "needs IEEE double arithmetic");

// ln 2 in two parts; the first has 32 bits, so that its product with an exponent is exact.
inline constexpr double ln2_high = 0x1.62e42feep-1, ln2_low = 0x1.a39ef35793c76p-33;

inline constexpr int most_divisor = 16;
inline constexpr auto inverses = [] {
  std::array<double, most_divisor + 1> of{};
  for (int n = 1; n <= most_divisor; ++n) of[n] = 1.0 / n;
  return of;
}();

/// x/n as IEEE 754 rounds it, for n from 1 to most_divisor and x = 0 or 1e-280 < |x| < 1e300, in
/// three operations that take a fraction of a division's time (Markstein 1990). x times the rounded
/// 1/n is off by two ulp at the most; what x then lacks is a double; and the last operation is off
/// by 2^-50 ulp before it rounds, while no x/n is nearer than 1/(2n) of an ulp to the middle
/// between two doubles.
inline double divide_by(int n, double x) {
#if defined(__FP_FAST_FMA)
  const double divisor = n, quotient = x * inverses[n];
  return std::fma(std::fma(-divisor, quotient, x), inverses[n], quotient);
#else
  return x / n;
#endif
}

/// Of Taylor's series of exp; the next, r^15/15!, is below 1e-19.
inline constexpr int exp_terms = 14;

/// e^x for |x| < 700, within 1 ulp of the correctly rounded value.
inline double exp(double x) {
  const double k = std::floor(x / ln2_high + 0.5);
  const double r = (x - k * ln2_high) - k * ln2_low;  // |r| <= ln 2 / 2
  double sum = 1;
  for (int n = exp_terms; n > 0; --n) sum = 1 + r * sum / n;
  return std::ldexp(sum, static_cast<int>(k));
}

/// Natural logarithm of a finite x > 0, within 1 ulp of the correctly rounded value.
inline double log(double x) {
  int k = 0;
  double m = std::frexp(x, &k);
  if (m < 0x1.6a09e667f3bcdp-1) m *= 2, --k;  // m from 1/sqrt(2) to sqrt(2)
  // ln(1 + f) = 2 artanh s = f - f^2/2 + s (f^2/2 + R), R = 2 s^2/3 + 2 s^4/5 + ...; s^2 < 0.0295
  const double f = m - 1, s = f / (2 + f), z = s * s, half_square = f * f / 2;
  double rest = 0;
  for (int n = 21; n >= 3; n -= 2) rest = z * (2.0 / n + rest);
  return k * ln2_high - ((half_square - (s * (half_square + rest) + k * ln2_low)) - f);
}

}  // namespace ra2d::portable
