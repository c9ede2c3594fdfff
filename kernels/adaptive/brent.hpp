// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/contact/cell_contact.hpp"

namespace ra2d {

/// The largest f(x) between two places, where f has one maximum, and its place; by parabolas
/// through three values, and golden sections where these do not close in (Brent 1973, chapter 5).
/// The place is right to some 1e-4 of the interval, the value so to 1e-8 of its change. Given f at
/// both places, and at one between them.
template <class Function>
KOKKOS_INLINE_FUNCTION Highest highest_between(const Highest& left, const Highest& inside,
                                               const Highest& right, const Function& f) {
  constexpr double golden = 0.3819660112501051;
  double from = left.place, to = right.place;
  const double close = 1e-4 * (to - from);
  const Highest& high = left.value > right.value ? left : right;
  const Highest& low = left.value > right.value ? right : left;
  double x = inside.place, w = high.place, v = low.place;
  double fx = inside.value, fw = high.value, fv = low.value, d = to - from, before = d;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (from + to);
    if (Kokkos::abs(x - middle) <= 2.0 * close - 0.5 * (to - from)) break;
    bool parabola = false;
    if (Kokkos::abs(before) > close) {
      const double r = (x - w) * (fx - fv), q = (x - v) * (fx - fw);
      double top = (x - v) * q - (x - w) * r, bottom = 2.0 * (q - r);
      if (bottom > 0.0) top = -top;
      bottom = Kokkos::abs(bottom);
      if (Kokkos::abs(top) < Kokkos::abs(0.5 * bottom * before) && top > bottom * (from - x) &&
          top < bottom * (to - x)) {
        before = d;
        d = top / bottom;
        parabola = true;
      }
    }
    // where the latest step was short, too, the parabola tells the place
    if (parabola && Kokkos::abs(d) <= close && Kokkos::abs(before) <= 1e2 * close) break;
    if (!parabola) {
      before = x >= middle ? from - x : to - x;
      d = golden * before;
    }
    const double next = x + (Kokkos::abs(d) >= close ? d : Kokkos::copysign(close, d));
    const double value = f(next);
    if (value >= fx) {
      (next >= x ? from : to) = x;
      v = w;
      fv = fw;
      w = x;
      fw = fx;
      x = next;
      fx = value;
    } else {
      (next < x ? from : to) = next;
      if (value >= fw || w == x) {
        v = w;
        fv = fw;
        w = next;
        fw = value;
      } else if (value >= fv || v == x || v == w) {
        v = next;
        fv = value;
      }
    }
  }
  return {fx, x};
}

}  // namespace ra2d
