// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/check.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"

namespace ra2d {

/// The value of a cubic at x.
template <class Real>
KOKKOS_FORCEINLINE_FUNCTION Real cubic_at(const Real* c, const Real& x) {
  return multiply_add(multiply_add(multiply_add(c[3], x, c[2]), x, c[1]), x, c[0]);
}
/// A cubic's coefficients with its origin at x.
template <class Real>
KOKKOS_FORCEINLINE_FUNCTION void shift_cubic(const Real* c, const Real& x, Real* about) {
  about[3] = c[3];
  about[2] = multiply_add(Real(3.0) * c[3], x, c[2]);
  about[1] = multiply_add(multiply_add(Real(3.0) * c[3], x, Real(2.0) * c[2]), x, c[1]);
  about[0] = cubic_at(c, x);
}

/// The largest value of a cubic between two places.
template <class Real>
KOKKOS_FORCEINLINE_FUNCTION Real highest_between(const Real* c, const Real& from, const Real& to) {
  // where it is flat and concave: the root of c_1 + 2 c_2 x + 3 c_3 x^2 at which that falls. Where
  // there is none, any place does no harm.
  const Real root =
      Kokkos::sqrt(Kokkos::max(Real(0.0), multiply_add(c[2], c[2], Real(-3.0) * c[3] * c[1])));
  const Real both = Kokkos::max(root + Kokkos::abs(c[2]), Real(1e-300));
  const Real flat = if_positive(c[2], -both, c[1]) / if_positive(c[2], Real(3.0) * c[3], both);
  const Real inside = Kokkos::min(Kokkos::max(flat, from), to);
  return Kokkos::max(cubic_at(c, inside), Kokkos::max(cubic_at(c, from), cubic_at(c, to)));
}

/// The parts of cells that may be in contact, side by side: one part a lane. A part is the stretch
/// of a cell to one side of the resonator's node within it, where the overlap is one cubic. Where
/// that is concave, as at nearly every contact, all lanes take the same steps; the other parts go
/// one by one through add_contact.
template <class Lanes>
class CellParts {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  /// The last step to a root of the overlap, over the length of contact, after which it is right:
  /// it leaves some cube of itself, and the integrals are off by the square of that.
  static constexpr double roots_close = 1e-3;
  /// At once; two for each cell at the least.
  static constexpr int capacity = width < 2 ? 2 : width;
  /// Rows of the memory that it works in, each of `capacity` numbers.
  enum Row : int { overlap = 0, face = 4, from = 8, to, cell_number, result, rows = result + 6 };
  static_assert(rows == cell_part_rows);

  RA2D_FUNCTION CellParts(const Lanes& lanes, double* memory) : lanes_{lanes}, memory_{memory} {}

  KOKKOS_FORCEINLINE_FUNCTION int count() const { return count_; }
  KOKKOS_FORCEINLINE_FUNCTION bool has_room() const { return count_ + 2 <= capacity; }
  KOKKOS_FORCEINLINE_FUNCTION void clear() { count_ = 0; }

  /// Adds the parts of a cell that its coefficients do not tell to be open. Its left node stands
  /// theta chi behind a node of the resonator. `displacement`: u_1 + u_2, about its middle.
  KOKKOS_FORCEINLINE_FUNCTION void add_cell(int cell, const CellFaces& faces, double theta,
                                            const Cubic& displacement) {
    const Cubic moving = faces.own + displacement;
    for (int side = 0; side < 2; ++side) {
      const Cubic passing = faces.passing[side].about(theta + 0.5 - side);
      const Cubic sum = moving + passing;
      if (is_open(sum)) continue;
      RA2D_CHECK(count_ < capacity);
      if (lanes_.leader()) {
        const double knot = 0.5 - theta;
        for (int j = 0; j < 4; ++j) {
          at(overlap + j, count_) = sum.c[j];
          at(face + j, count_) = passing.c[j];
        }
        at(from, count_) = side == 0 ? -0.5 : knot;
        at(to, count_) = side == 0 ? knot : 0.5;
        at(cell_number, count_) = cell;
      }
      ++count_;
    }
  }

  /// The integrals over all parts.
  RA2D_FUNCTION void integrate() {
    lanes_.sync();
    if (lanes_.leader())  // beyond the last part: none
      for (int i = count_; i < (count_ + width - 1) / width * width; ++i) {
        for (int row = 0; row < result; ++row) at(row, i) = 0.0;
        at(overlap, i) = -1.0;
      }
    lanes_.sync();
    for (int first = 0; first < count_; first += width) integrate_lanes(first);
    lanes_.sync();
  }
  /// The integrals of CellContact, over one part a lane, and where the contact begins and ends in
  /// the cell: low >= high where there is none, or where add_contact found it.
  struct Integrals {
    Real moment[4], square, face_work;
    Real low, high;
  };
  /// Those over parts that are given in lanes: from `left` to `right`, with these cubics of overlap
  /// and resonator's face. Parts that were added are lost where it goes through add_contact.
  RA2D_FUNCTION void integrate(const Real* o, const Real* f, const Real& left, const Real& right,
                               double close, Integrals& sum) {
    const std::uint32_t others = integrate_concave(o, f, left, right, close, sum);
    if (others == 0) [[likely]]
      return;
    lanes_.sync();
    for (int j = 0; j < 4; ++j) {
      store(overlap + j, 0, o[j]);
      store(face + j, 0, f[j]);
    }
    store(from, 0, left);
    store(to, 0, right);
    store_integrals(0, sum);
    lanes_.sync();
    integrate_others(others, 0);
    lanes_.sync();
    for (int j = 0; j < 4; ++j) sum.moment[j] = row(result + j, 0);
    sum.square = row(result + 4, 0);
    sum.face_work = row(result + 5, 0);
    sum.low = sum.high = Real(0.0);
    lanes_.sync();
  }
  /// As above, from `low` and `high` as they were a little before. `at_left`, `at_right`: the cubic
  /// about the part's ends. Where `near` is negative there is plainly no contact. False where
  /// integrate() must find it: contact vanishes in a lane or reaches another end of the part, the
  /// overlap is not concave, or two steps of the search are not enough.
  RA2D_FUNCTION bool integrate_from(const Real* o, const Real* f, const Real& left,
                                    const Real& right, const Real* at_left, const Real* at_right,
                                    const Real& near, const Real& low, const Real& high,
                                    Integrals& sum) const {
    const Real none(0.0), yes(1.0), no(-1.0), open = -near;
    const Real convex = Kokkos::max(at_left[2], at_right[2]);
    Real begin = low, end = high;
    for (int i = 0; i < 2; ++i) {
      Real by_begin, by_end;
      halley_steps(o, begin, end, by_begin, by_end);
      const Real length = end - begin;
      by_begin = if_positive(at_left[0], begin - left, by_begin);
      by_end = if_positive(at_right[0], end - right, by_end);
      begin = if_positive(open, none, begin - by_begin);
      end = if_positive(open, none, end - by_end);
      const Real by = Kokkos::max(Kokkos::abs(by_begin), Kokkos::abs(by_end)),
                 outside = Kokkos::max(Kokkos::max(left - begin, end - right), convex);
      // each step leaves some cube of the error before it, and the integrals are off by its square
      const auto any_beyond = [&](double share) {
        const Real found = if_positive(outside, no, if_positive(share * length - by, yes, no));
        return lanes_.at_least(if_positive(open, no, -found), 0.0) != 0;
      };
      if (!any_beyond(5e-3)) {
        const Real middle = Real(0.5) * (begin + end), half = Real(0.5) * (end - begin);
        find_integrals(o, f, middle, middle, half, sum);
        sum.low = begin;
        sum.high = end;
        return true;
      }
      if (any_beyond(0.1)) return false;
    }
    return false;
  }
  KOKKOS_FORCEINLINE_FUNCTION int cell(int part) const {
    return static_cast<int>(at(cell_number, part));
  }
  KOKKOS_FORCEINLINE_FUNCTION CellContact integrals(int part) const {
    CellContact sum;
    for (int j = 0; j < 4; ++j) sum.moment[j] = at(result + j, part);
    sum.square = at(result + 4, part);
    sum.face_work = at(result + 5, part);
    return sum;
  }

 private:
  Lanes lanes_;
  double* memory_;
  int count_ = 0;

  KOKKOS_FORCEINLINE_FUNCTION double& at(int row, int part) const {
    return memory_[row * capacity + part];
  }
  KOKKOS_FORCEINLINE_FUNCTION Real row(int number, int first) const {
    return lanes_.load(memory_ + number * capacity + first);
  }
  /// Where the overlap p of a part, about its middle, is largest: where its slope falls through
  /// zero, at an end where it does not. Half of the part is `half` long.
  KOKKOS_FORCEINLINE_FUNCTION static Real summit_of(const Real* p, const Real& half) {
    const Real none(0.0), slant = Real(3.0) * p[3];
    const Real inside = multiply_add(p[2], p[2], -(slant * p[1])),
               root = Kokkos::sqrt(Kokkos::max(inside, none));
    const Real vertex = p[1] / Kokkos::max(root - p[2], Real(1e-300)),
               end = if_positive(p[1], half, -half);
    return Kokkos::max(-half, Kokkos::min(half, if_positive(-inside, end, vertex)));
  }
  /// The integrals of the contacts: the overlap is the cubic q about `summit`, the contact's middle
  /// stands at `centre` from there and at c in the cell; h is half of its length.
  KOKKOS_FORCEINLINE_FUNCTION static void find_integrals(const Real* q, const Real* passing,
                                                         const Real& centre, const Real& c,
                                                         const Real& h, Integrals& sum) {
    // about the middle of the contact: even powers alone are left
    const Real h2 = h * h, length = h + h;
    Real s[4];
    shift_cubic(q, centre, s);
    const Real third(1.0 / 3.0), fifth(0.2), seventh(1.0 / 7.0);
    const Real m0 = length * multiply_add(third * h2, s[2], s[0]),
               m1 = length * h2 * multiply_add(fifth * h2, s[3], third * s[1]),
               m2 = length * h2 * multiply_add(fifth * h2, s[2], third * s[0]),
               m3 = length * h2 * h2 * multiply_add(seventh * h2, s[3], fifth * s[1]);
    sum.moment[0] = m0;
    sum.moment[1] = multiply_add(c, m0, m1);
    sum.moment[2] = multiply_add(c, multiply_add(c, m0, m1 + m1), m2);
    sum.moment[3] =
        multiply_add(c, multiply_add(c, multiply_add(c, m0, Real(3.0) * m1), Real(3.0) * m2), m3);
    sum.square = multiply_add(s[3], m3, multiply_add(s[2], m2, multiply_add(s[1], m1, s[0] * m0)));
    shift_cubic(passing, c, s);
    sum.face_work = multiply_add(Real(3.0) * s[3], m2, multiply_add(s[2] + s[2], m1, s[1] * m0));
  }
  KOKKOS_FORCEINLINE_FUNCTION void store_integrals(int first, const Integrals& sum) const {
    for (int j = 0; j < 4; ++j) store(result + j, first, sum.moment[j]);
    store(result + 4, first, sum.square);
    store(result + 5, first, sum.face_work);
  }
  RA2D_FUNCTION void integrate_lanes(int first) {
    Real o[4], f[4];
    for (int j = 0; j < 4; ++j) {
      o[j] = row(overlap + j, first);
      f[j] = row(face + j, first);
    }
    Integrals sum;
    const std::uint32_t others =
        integrate_concave(o, f, row(from, first), row(to, first), roots_close, sum);
    store_integrals(first, sum);
    lanes_.sync();
    integrate_others(others, first);
  }
  RA2D_FUNCTION void integrate_others(std::uint32_t others, int first) const {
    if (lanes_.leader())
      for (std::uint32_t bits = others; bits != 0; bits &= bits - 1)
        integrate_alone(first + Kokkos::Experimental::countr_zero_builtin(bits));
  }
  /// One bit for each part that is left to add_contact: its overlap is not concave, or a root was
  /// not found.
  RA2D_FUNCTION std::uint32_t integrate_concave(const Real* o, const Real* f, const Real& left,
                                                const Real& right, double close,
                                                Integrals& sum) const {
    Real p[4];
    const Real middle = Real(0.5) * (left + right), half = Real(0.5) * (right - left), none(0.0),
               tiny(1e-300);
    shift_cubic(o, middle, p);
    const Real half_curvature = p[2] + Kokkos::abs(Real(3.0) * p[3]) * half;  // the largest
    const Real summit = summit_of(p, half);
    // from here on about the summit: so narrow contacts keep their digits
    Real q[4];
    shift_cubic(p, summit, q);
    const Real lower = -half - summit, upper = half - summit, top = q[0];
    const Real at_lower = cubic_at(q, lower), at_upper = cubic_at(q, upper);
    // both roots of the parabola there, and what the cubic's last term moves them by
    const Real size =
        Kokkos::sqrt(Kokkos::max(multiply_add(q[1], q[1], Real(-4.0) * top * q[2]), none));
    const Real twice = q[2] + q[2],
               inverse = Real(1.0) / Kokkos::min(size * twice, -tiny),  // neither may vanish
        per_slope = twice * inverse, per_curvature = size * inverse;
    Real low = (size - q[1]) * per_curvature, high = -((size + q[1]) * per_curvature);
    const auto moved = [&](const Real& x, const Real& by) {  // by no more than half of it
      return multiply_add(x, Kokkos::max(Real(-0.5), Kokkos::min(Real(0.5), by)), x);
    };
    low = moved(low, -(q[3] * per_slope) * (low * low));
    high = moved(high, q[3] * per_slope * (high * high));
    low = Kokkos::min(none, Kokkos::max(low, lower));
    high = Kokkos::max(none, Kokkos::min(high, upper));
    low = if_positive(at_lower, lower, low);
    high = if_positive(at_upper, upper, high);
    // positive where there is contact
    const Real concave = if_positive(half_curvature, Real(-1.0), Real(1.0)),
               closed = Kokkos::min(concave, if_positive(top, Real(1.0), Real(-1.0)));
    const Real seek = find_roots(q, lower, upper, if_positive(at_lower, Real(-1.0), closed),
                                 if_positive(at_upper, Real(-1.0), closed), close, low, high);
    const Real centre = Real(0.5) * (low + high), h = Real(0.5) * (high - low);
    find_integrals(q, f, centre, (centre + summit) + middle, if_positive(closed, h, none), sum);
    const Real about_middle = summit + middle;
    sum.low = if_positive(closed, low + about_middle, none);
    sum.high = if_positive(closed, high + about_middle, none);
    return lanes_.at_least(Kokkos::max(-concave, seek), 1.0);
  }
  /// Halley's steps for both roots, by one division: to be taken off them.
  KOKKOS_FORCEINLINE_FUNCTION static void halley_steps(const Real* q, const Real& low,
                                                       const Real& high, Real& by_low,
                                                       Real& by_high) {
    Real l[4], r[4];
    shift_cubic(q, low, l);
    shift_cubic(q, high, r);
    const Real of_low = multiply_add(l[1], l[1], -(l[0] * l[2])),
               of_high = multiply_add(r[1], r[1], -(r[0] * r[2]));
    const Real inverse_both = Real(1.0) / (of_low * of_high);
    by_low = (l[0] * l[1]) * (of_high * inverse_both);
    by_high = (r[0] * r[1]) * (of_low * inverse_both);
  }
  /// Improves the roots `low` and `high` of a cubic between `lower` and 0, and 0 and `upper`, where
  /// `seek_low` and `seek_high` are positive. Positive where one of them is not found.
  RA2D_FUNCTION Real find_roots(const Real* q, const Real& lower, const Real& upper, Real seek_low,
                                Real seek_high, double share, Real& low, Real& high) const {
    const Real none(0.0);
    Real seek(-1.0);
    for (int i = 0; i < 8; ++i) {
      Real by_low, by_high;
      halley_steps(q, low, high, by_low, by_high);
      const Real close = Real(share) * (high - low);
      low = if_positive(seek_low, Kokkos::max(lower, Kokkos::min(none, low - by_low)), low);
      high = if_positive(seek_high, Kokkos::min(upper, Kokkos::max(none, high - by_high)), high);
      seek_low = if_positive(Kokkos::abs(by_low) - close, seek_low, Real(-1.0));
      seek_high = if_positive(Kokkos::abs(by_high) - close, seek_high, Real(-1.0));
      seek = Kokkos::max(seek_low, seek_high);
      if (lanes_.at_least(seek, 1.0) == 0) break;
    }
    return seek;
  }
  RA2D_FUNCTION void integrate_alone(int part) const {
    Cubic o, f;
    for (int j = 0; j < 4; ++j) {
      o.c[j] = at(overlap + j, part);
      f.c[j] = at(face + j, part);
    }
    CellContact sum;
    add_contact(o, f, at(from, part), at(to, part), sum);
    for (int j = 0; j < 4; ++j) at(result + j, part) = sum.moment[j];
    at(result + 4, part) = sum.square;
    at(result + 5, part) = sum.face_work;
  }
  KOKKOS_FORCEINLINE_FUNCTION void store(int number, int first, const Real& x) const {
    lanes_.store(memory_ + number * capacity + first, x);
  }
};

}  // namespace ra2d
