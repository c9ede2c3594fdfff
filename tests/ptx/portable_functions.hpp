// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <Kokkos_SIMD.hpp>
#include <cstdint>

/// exp2, log2 and hypot of the adaptive march by operations that every machine rounds alike, so
/// that a GPU and a CPU come to the same bits. To be included before any kernel: the kernels then
/// call these.
namespace Kokkos {

/// 2^x, off by some roundings.
KOKKOS_INLINE_FUNCTION double portable_exp2(double x) {
  if (!(x > -1022)) return x != x ? x : 0.0;  // no subnormal results
  if (x >= 1024) return Experimental::infinity_v<double>;
  const auto whole = static_cast<std::int64_t>(x + (x < 0 ? -0.5 : 0.5));
  const double y = (x - static_cast<double>(whole)) * 0.69314718055994531;  // |y| <= ln(2)/2
  double sum = 1;  // Taylor's series of e^y, whose next term is y^15/15! < 1e-19
  for (int n = 14; n > 0; --n) sum = 1 + sum * y * (1.0 / n);
  // in two factors, as 2^1024 is none
  const auto power = [](std::int64_t n) {
    return bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
  };
  return sum * power(whole / 2) * power(whole - whole / 2);
}

/// log2 x, off by some roundings.
KOKKOS_INLINE_FUNCTION double portable_log2(double x) {
  constexpr double infinity = Experimental::infinity_v<double>;
  if (!(x > 0)) return x == 0 ? -infinity : Experimental::quiet_NaN_v<double>;
  if (x == infinity) return x;
  int exponent = 0;
  if (x < Experimental::norm_min_v<double>) {
    x *= 0x1p54;
    exponent = -54;
  }
  const auto bits = bit_cast<std::uint64_t>(x);
  exponent += static_cast<int>(bits >> 52) - 1023;
  double part = bit_cast<double>((bits & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000);
  if (part > 1.4142135623730951) {
    part /= 2;
    ++exponent;
  }
  const double s = (part - 1) / (part + 1), square = s * s;  // ln part = 2 artanh s, |s| < 0.172
  double sum = 0;  // artanh's series, whose next term is s^23/23 < 1e-18
  for (int n = 21; n > 0; n -= 2) sum = sum * square + 1.0 / n;
  return exponent + s * sum * 2.8853900817779268;  // 2/ln 2
}

/// sqrt(x^2 + y^2), off by some roundings.
KOKKOS_INLINE_FUNCTION double portable_hypot(double x, double y) {
  const double a = x < 0 ? -x : x, b = y < 0 ? -y : y;
  const double large = a < b ? b : a, small = a < b ? a : b;
  if (!(large > 0) || large == Experimental::infinity_v<double>) return large + small;
  const double ratio = small / large;
  return large * sqrt(1 + ratio * ratio);
}

}  // namespace Kokkos

#define exp2 portable_exp2
#define log2 portable_log2
#define hypot portable_hypot
