// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/check.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"

namespace ra2d {

/// The parts of cells that may be in contact, side by side: one part a lane. A part is the stretch
/// of a cell to one side of the resonator's node within it, where the overlap is one cubic. Where
/// that is concave, as at nearly every contact, all lanes take the same steps; the other parts go
/// one by one through add_contact.
template <class Lanes>
class CellParts {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
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
  KOKKOS_FORCEINLINE_FUNCTION static Real value(const Real* c, const Real& x) {
    return multiply_add(multiply_add(multiply_add(c[3], x, c[2]), x, c[1]), x, c[0]);
  }
  /// A cubic's coefficients with its origin at x.
  KOKKOS_FORCEINLINE_FUNCTION static void shift(const Real* c, const Real& x, Real* about) {
    about[3] = c[3];
    about[2] = multiply_add(Real(3.0) * c[3], x, c[2]);
    about[1] = multiply_add(multiply_add(Real(3.0) * c[3], x, Real(2.0) * c[2]), x, c[1]);
    about[0] = value(c, x);
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
  /// Stores the integrals of the contacts: the overlap is the cubic q about `summit`, the contact's
  /// middle stands at `centre` from there and at c in the cell; h is half of its length.
  KOKKOS_FORCEINLINE_FUNCTION void store_integrals(int first, const Real* q, const Real& centre,
                                                   const Real& c, const Real& h) {
    // about the middle of the contact: even powers alone are left
    const Real h2 = h * h, length = h + h;
    Real o[4], s[4];
    shift(q, centre, s);
    const Real third(1.0 / 3.0), fifth(0.2), seventh(1.0 / 7.0);
    const Real m0 = length * multiply_add(third * h2, s[2], s[0]),
               m1 = length * h2 * multiply_add(fifth * h2, s[3], third * s[1]),
               m2 = length * h2 * multiply_add(fifth * h2, s[2], third * s[0]),
               m3 = length * h2 * h2 * multiply_add(seventh * h2, s[3], fifth * s[1]);
    store(result, first, m0);
    store(result + 1, first, multiply_add(c, m0, m1));
    store(result + 2, first, multiply_add(c, multiply_add(c, m0, m1 + m1), m2));
    store(
        result + 3, first,
        multiply_add(c, multiply_add(c, multiply_add(c, m0, Real(3.0) * m1), Real(3.0) * m2), m3));
    store(result + 4, first,
          multiply_add(s[3], m3, multiply_add(s[2], m2, multiply_add(s[1], m1, s[0] * m0))));
    for (int j = 0; j < 4; ++j) o[j] = row(face + j, first);
    shift(o, c, s);
    store(result + 5, first,
          multiply_add(Real(3.0) * s[3], m2, multiply_add(s[2] + s[2], m1, s[1] * m0)));
  }
  RA2D_FUNCTION void integrate_lanes(int first) {
    Real o[4], p[4];
    for (int j = 0; j < 4; ++j) o[j] = row(overlap + j, first);
    const Real left = row(from, first), right = row(to, first);
    const Real middle = Real(0.5) * (left + right), half = Real(0.5) * (right - left), none(0.0),
               tiny(1e-300);
    shift(o, middle, p);
    const Real half_curvature = p[2] + Kokkos::abs(Real(3.0) * p[3]) * half;  // the largest
    const Real summit = summit_of(p, half);
    // from here on about the summit: so narrow contacts keep their digits
    Real q[4];
    shift(p, summit, q);
    const Real lower = -half - summit, upper = half - summit, top = q[0];
    const Real at_lower = value(q, lower), at_upper = value(q, upper);
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
                                 if_positive(at_upper, Real(-1.0), closed), low, high);
    const Real centre = Real(0.5) * (low + high), h = Real(0.5) * (high - low);
    store_integrals(first, q, centre, (centre + summit) + middle, if_positive(closed, h, none));
    // the others
    const std::uint32_t others = lanes_.at_least(Kokkos::max(-concave, seek), 1.0);
    lanes_.sync();
    if (lanes_.leader())
      for (std::uint32_t bits = others; bits != 0; bits &= bits - 1)
        integrate_alone(first + Kokkos::Experimental::countr_zero_builtin(bits));
  }
  /// Improves the roots `low` and `high` of a cubic between `lower` and 0, and 0 and `upper`, where
  /// `seek_low` and `seek_high` are positive. Positive where one of them is not found.
  RA2D_FUNCTION Real find_roots(const Real* q, const Real& lower, const Real& upper, Real seek_low,
                                Real seek_high, Real& low, Real& high) const {
    const Real none(0.0);
    Real seek(-1.0);
    for (int i = 0; i < 8; ++i) {
      // Halley's steps, by one division
      Real l[4], r[4];
      shift(q, low, l);
      shift(q, high, r);
      const Real of_low = multiply_add(l[1], l[1], -(l[0] * l[2])),
                 of_high = multiply_add(r[1], r[1], -(r[0] * r[2]));
      const Real inverse_both = Real(1.0) / (of_low * of_high);
      const Real by_low = (l[0] * l[1]) * (of_high * inverse_both),
                 by_high = (r[0] * r[1]) * (of_low * inverse_both);
      // an error e of a root changes the integrals by e^2, and the next error is some e^3
      const Real close = Real(1e-3) * (high - low);
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
