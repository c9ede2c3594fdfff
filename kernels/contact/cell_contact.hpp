// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

/// Contact of smooth faces, integrated over a cell of the slider: the stretch between two of its
/// nodes. With eta the place in the cell, from its middle, in units of chi, the overlap
///
///   o(eta) = h_1(eta) - delta + h_2(eta) + u_1(eta) + u_2(eta)
///
/// is one cubic on each side of the resonator's node that stands within the cell. The penalty force
/// on mode k is -kappa w times the integral of o psi_k over the places where o > 0. With psi_k a
/// cubic of eta, too, all that contact needs are the moments
///
///   M_j = integral of o eta^j over o > 0,   j = 0 ... 3,
///
/// in closed form between the roots of o. So no force depends on where nodes stand.
namespace ra2d {

/// c_0 + c_1 eta + c_2 eta^2 + c_3 eta^3.
struct Cubic {
  double c[4];

  KOKKOS_FORCEINLINE_FUNCTION double operator()(double eta) const {
    return Kokkos::fma(eta, Kokkos::fma(eta, Kokkos::fma(eta, c[3], c[2]), c[1]), c[0]);
  }
  KOKKOS_FORCEINLINE_FUNCTION double slope(double eta) const {
    return Kokkos::fma(eta, Kokkos::fma(3.0 * eta, c[3], 2.0 * c[2]), c[1]);
  }
  /// This polynomial with its origin at `eta`.
  KOKKOS_FORCEINLINE_FUNCTION Cubic about(double eta) const {
    return {{(*this)(eta), slope(eta), Kokkos::fma(3.0 * eta, c[3], c[2]), c[3]}};
  }
  KOKKOS_FORCEINLINE_FUNCTION friend Cubic operator+(const Cubic& a, const Cubic& b) {
    return {{a.c[0] + b.c[0], a.c[1] + b.c[1], a.c[2] + b.c[2], a.c[3] + b.c[3]}};
  }
};

/// A place along a cell, and the value there.
struct Highest {
  double value, place;

  KOKKOS_FORCEINLINE_FUNCTION void take(double v, double x) {
    if (!(v > value)) return;
    value = v;
    place = x;
  }
};

/// Where a cubic is largest on [from, to].
KOKKOS_INLINE_FUNCTION Highest highest_on(const Cubic& p, double from, double to) {
  Highest highest{p(from), from};
  highest.take(p(to), to);
  const double a = 3.0 * p.c[3], b = p.c[2], c = p.c[1];  // of the slope, a x^2 + 2 b x + c
  const double discriminant = Kokkos::fma(b, b, -a * c);
  if (discriminant > 0.0) {
    const double root = Kokkos::sqrt(discriminant);  // where the slope falls: a x + b = -root
    const double x = b < 0.0 ? c / (root - b) : (-b - root) / a;
    if (x > from && x < to) highest.take(p(x), x);
  }
  return highest;
}

/// A spline between two nodes: heights there, and second derivatives times chi^2 [m]; about the
/// left node.
KOKKOS_FORCEINLINE_FUNCTION Cubic spline_piece(double left, double right, double curvature_left,
                                               double curvature_right) {
  return {{left,
           Kokkos::fma(-1.0 / 6.0, curvature_left + curvature_left + curvature_right, right - left),
           0.5 * curvature_left, (1.0 / 6.0) * (curvature_right - curvature_left)}};
}

/// Integrals over the places of a cell where the overlap o is positive.
struct CellContact {
  double moment[4] = {};  // m, of o eta^j
  double square = 0;      // m^2, of o^2
  double face_work = 0;   // m^2, of o dh_2/deta

  KOKKOS_FORCEINLINE_FUNCTION friend CellContact operator+(CellContact a, const CellContact& b) {
    for (int j = 0; j < 4; ++j) a.moment[j] += b.moment[j];
    a.square += b.square;
    a.face_work += b.face_work;
    return a;
  }
};

/// Adds the integrals over [from, to], where `overlap` is not negative. `face`: h_2.
KOKKOS_INLINE_FUNCTION void add_closed(const Cubic& overlap, const Cubic& face, double from,
                                       double to, CellContact& sum) {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  if (!(half > 0.0)) return;
  // about the middle: even powers alone are left, and narrow contacts keep their digits
  const Cubic o = overlap.about(middle);
  const double h2 = half * half, size = 2.0 * half;
  const double third = 1.0 / 3.0, fifth = 0.2, seventh = 1.0 / 7.0;
  const double m0 = size * Kokkos::fma(third * h2, o.c[2], o.c[0]);
  const double m1 = size * h2 * Kokkos::fma(fifth * h2, o.c[3], third * o.c[1]);
  const double m2 = size * h2 * Kokkos::fma(fifth * h2, o.c[2], third * o.c[0]);
  const double m3 = size * h2 * h2 * Kokkos::fma(seventh * h2, o.c[3], fifth * o.c[1]);
  const double c = middle;
  sum.moment[0] += m0;
  sum.moment[1] += Kokkos::fma(c, m0, m1);
  sum.moment[2] += Kokkos::fma(c, Kokkos::fma(c, m0, 2.0 * m1), m2);
  sum.moment[3] += Kokkos::fma(c, Kokkos::fma(c, Kokkos::fma(c, m0, 3.0 * m1), 3.0 * m2), m3);
  sum.square +=
      Kokkos::fma(o.c[3], m3, Kokkos::fma(o.c[2], m2, Kokkos::fma(o.c[1], m1, o.c[0] * m0)));
  const Cubic f = face.about(middle);
  sum.face_work += Kokkos::fma(3.0 * f.c[3], m2, Kokkos::fma(2.0 * f.c[2], m1, f.c[1] * m0));
}

/// The root of a cubic that changes its sign on [low, high] and is monotonic or concave there:
/// Newton's method from the root of the parabola in the middle, halving where it leaves the
/// interval. An error d of a root changes the integrals below by d^2 alone: they have all their
/// digits once it is below 1e-10 of a cell.
KOKKOS_INLINE_FUNCTION double root_between(const Cubic& p, double low, double high, double at_low,
                                           double at_high) {
  const bool rises = at_low < at_high;
  const double middle = 0.5 * (low + high);
  const Cubic about = p.about(middle);
  const double inside = Kokkos::fma(about.c[1], about.c[1], -4.0 * about.c[2] * about.c[0]);
  double x = middle - 2.0 * about.c[0] /
                          (about.c[1] +
                           Kokkos::copysign(Kokkos::sqrt(Kokkos::max(inside, 0.0)), about.c[1]));
  if (!(x > low && x < high)) x = middle;
  for (int i = 0; i < 80; ++i) {
    const double value = p(x), inverse = 1.0 / p.slope(x);
    if ((value < 0.0) == rises)
      low = x;
    else
      high = x;
    const double step = value * inverse, next = x - step;
    if (!(next > low && next < high)) {
      if (value == 0.0 || high - low <= 0x1p-52) return x;
      x = 0.5 * (low + high);
      continue;
    }
    // the next one is off by some p''/(2 p') times the square of this step
    const double curvature = Kokkos::fma(3.0 * x, p.c[3], p.c[2]);
    if (Kokkos::abs(step * step * curvature * inverse) <= 1e-11) return next;
    x = next;
  }
  return x;
}

/// Whether a cubic is negative everywhere within half a unit of its origin, told by its
/// coefficients alone.
KOKKOS_FORCEINLINE_FUNCTION bool is_open(const Cubic& o) {
  return Kokkos::fma(0.125, Kokkos::abs(o.c[3]),
                     Kokkos::fma(0.25, Kokkos::abs(o.c[2]),
                                 Kokkos::fma(0.5, Kokkos::abs(o.c[1]), o.c[0]))) < 0.0;
}

/// Calls visit(left, right) for each stretch of [from, to] where `overlap` is positive.
template <class Visit>
KOKKOS_INLINE_FUNCTION void visit_contact(const Cubic& overlap, double from, double to,
                                          const Visit& visit) {
  const double a = 3.0 * overlap.c[3], b = overlap.c[2], c = overlap.c[1];  // a x^2 + 2 b x + c
  const double last = overlap(to);
  double left = overlap(from);
  const auto visit_one_side = [&](double low, double high, double at_low, double at_high) {
    const double root = root_between(overlap, low, high, at_low, at_high);
    if (at_low > 0.0)
      visit(low, root);
    else
      visit(root, high);
  };
  // the usual case, concave: closed at both ends it is so in between, and between two signs there
  // is one root
  if (Kokkos::fma(a, from, b) <= 0.0 && Kokkos::fma(a, to, b) <= 0.0) {
    if (left > 0.0 && last > 0.0) return visit(from, to);
    if (left > 0.0 || last > 0.0) return visit_one_side(from, to, left, last);
    if (overlap.slope(from) <= 0.0 || overlap.slope(to) >= 0.0) return;  // highest at an end
  }
  // between the roots of its slope a cubic is monotonic
  double edge[4];
  int edges = 0;
  edge[edges++] = from;
  const double discriminant = Kokkos::fma(b, b, -a * c);
  if (discriminant > 0.0) {
    const double q = -(b + Kokkos::copysign(Kokkos::sqrt(discriminant), b));
    double first = c / q, second = q / a;  // infinite or not a number: in no interval
    if (second < first) {
      const double swap = first;
      first = second;
      second = swap;
    }
    if (first > from && first < to) edge[edges++] = first;
    if (second > from && second < to) edge[edges++] = second;
  }
  edge[edges++] = to;
  for (int i = 0; i + 1 < edges; ++i) {
    const double right = i + 2 < edges ? overlap(edge[i + 1]) : last;
    if (left > 0.0 && right > 0.0)
      visit(edge[i], edge[i + 1]);
    else if (left > 0.0 || right > 0.0)
      visit_one_side(edge[i], edge[i + 1], left, right);
    left = right;
  }
}

/// Adds the integrals over the places in [from, to] where `overlap` is positive.
KOKKOS_INLINE_FUNCTION void add_contact(const Cubic& overlap, const Cubic& face, double from,
                                        double to, CellContact& sum) {
  visit_contact(overlap, from, to,
                [&](double left, double right) { add_closed(overlap, face, left, right, sum); });
}

/// The faces of a cell: the slider's, less delta, about the middle of the cell, and the two pieces
/// of the resonator's that pass it, each about its left node.
struct CellFaces {
  Cubic own, passing[2];

  /// Bounds on the resonator's slope and its second derivative along these pieces [m].
  struct Steepness {
    double slope, curvature;
  };
  KOKKOS_FORCEINLINE_FUNCTION Steepness steepness() const {
    Steepness most{0.0, 0.0};
    for (int side = 0; side < 2; ++side) {
      const double* const c = passing[side].c;
      most.slope = Kokkos::max(
          most.slope, Kokkos::abs(c[1]) + 2.0 * Kokkos::abs(c[2]) + 3.0 * Kokkos::abs(c[3]));
      // a cubic's second derivative is largest at an end
      const double left = 2.0 * c[2], right = Kokkos::fma(6.0, c[3], left);
      most.curvature =
          Kokkos::max(most.curvature, Kokkos::max(Kokkos::abs(left), Kokkos::abs(right)));
    }
    return most;
  }
};

}  // namespace ra2d
