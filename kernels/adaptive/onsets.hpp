// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/adaptive/pace.hpp"
#include "kernels/candidate_groups.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// A motion of the modes that is a polynomial in x, and the slider's way meanwhile: a flight by its
/// series, or a step between smooth faces.
template <class Lanes, int packs>
struct PolynomialMotion {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

  const double* rows;  // (power of x, lane)
  int order;
  Pace pace;
  double advance;  // chi, over x from 0 to 1
  double most;     // the x that it is used to

  /// Displacements, and what they change by per x.
  RA2D_FUNCTION void at(const Lanes& lanes, double x, Real* u, Real* rate) const {
    const Real here(x);
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      u[p] = load_row(lanes, order, p);
      rate[p] = Real(static_cast<double>(order)) * u[p];
    }
    for (int j = order - 1; j >= 1; --j)
      for (int p = 0; p < filled<packs>(lanes); ++p) {
        const Real c = load_row(lanes, j, p);
        u[p] = multiply_add(u[p], here, c);
        rate[p] = multiply_add(rate[p], here, Real(static_cast<double>(j)) * c);
      }
    for (int p = 0; p < filled<packs>(lanes); ++p)
      u[p] = multiply_add(u[p], here, load_row(lanes, 0, p));
  }
  KOKKOS_FORCEINLINE_FUNCTION Real load_row(const Lanes& lanes, int j, int p) const {
    return lanes.load(rows + (j * packs + p) * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION Place place_at(const Place& start, double x) const {
    Place place = start;
    const double travelled = advance * pace_share(pace, x);
    place.position += travelled;
    place.theta += travelled;
    place.offset += travelled;
    return place;
  }
  /// chi per x: the rate at which the slider moves, and the most that it and its change are.
  KOKKOS_FORCEINLINE_FUNCTION double slide_rate(double x) const {
    return advance * pace_rate(pace, x);
  }
  KOKKOS_FORCEINLINE_FUNCTION double most_slide_rate() const {
    return pace == Pace::even ? advance : 2.0 * advance;
  }
  KOKKOS_FORCEINLINE_FUNCTION double change_of_slide_rate() const {
    return advance * Kokkos::abs(pace_change(pace));
  }

  /// Bounds on what the modes do up to `most`, at a place that moves with the slider.
  struct Bounds {
    double travel;     // m: sum max|psi| |U - U_0|
    double curvature;  // m per x^2: on the second derivative of their displacement
    // m: of the cubic through their displacement and its rate at both ends, from the fourth
    // derivative and from the second
    double of_fourth, of_second;
    RA2D_FUNCTION double remainder() const { return of_fourth + of_second; }
  };
  /// The remainder of the modes at a fixed place is 1/384 of their fourth derivative. What the
  /// place moves by is little; of a function with a bounded second derivative alone, the cubic is
  /// off by less than a third of that bound: its own second derivative is 5/3 of it at the most.
  RA2D_FUNCTION Bounds bounds(const Lanes& lanes, const MotionLimits& limits,
                              double spacing) const {
    const Real at(most);
    const double first = most_slide_rate() * spacing, second = change_of_slide_rate() * spacing;
    Real travel(0.0), still(0.0), moving(0.0), fourth_derivative(0.0);
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      Real d0(0.0), d1(0.0), d2(0.0), d4(0.0);  // of |c_j| x^j
      for (int j = order; j >= 1; --j) {
        const Real c = Kokkos::abs(load_row(lanes, j, p));
        if (j >= 4) d4 = multiply_add(d4, at, Real(j * (j - 1.0) * (j - 2.0) * (j - 3.0)) * c);
        if (j >= 2) d2 = multiply_add(d2, at, Real(j * (j - 1.0)) * c);
        d1 = multiply_add(d1, at, Real(static_cast<double>(j)) * c);
        d0 = multiply_add(d0, at, c);
      }
      d0 = d0 * at;
      const Real shape = load_pack(lanes, limits.largest_shape, p),
                 rise = load_pack(lanes, limits.largest_slope, p),
                 curve = load_pack(lanes, limits.largest_curvature, p);
      const Real size = d0 + Kokkos::abs(load_row(lanes, 0, p));
      travel = multiply_add(shape, d0, travel);
      still = multiply_add(shape, d2, still);
      fourth_derivative = multiply_add(shape, d4, fourth_derivative);
      moving = multiply_add(Real(first) * rise, multiply_add(Real(2.0), d1, d2 * at), moving);
      moving = multiply_add(Real(first * first) * curve, size, moving);
      moving = multiply_add(Real(second) * rise, size, moving);
    }
    double of_travel, of_still, of_moving, of_fourth_derivative;
    lanes.sum(travel, still, of_travel, of_still);
    lanes.sum(moving, fourth_derivative, of_moving, of_fourth_derivative);
    const double square = most * most;
    return {of_travel, of_still + of_moving, square * square * of_fourth_derivative / 384.0,
            square * of_moving / 3.0};
  }
};

/// A part of a motion, in its x.
struct OnsetInterval {
  double from, to;
};

/// Where the overlap anywhere in a cell first comes to within `noise` of `level` in a part of
/// `motion`, which the modes follow from `start` on: the x; beyond motion.most where it never does.
/// `curvature`: of PolynomialMotion::bounds.
///
/// Nothing is stepped over. At each place the overlap is at most the parabola through its value and
/// rate whose second derivative is the bound K. The largest of these parabolas over the cell is a
/// convex function of time, so a chord between a time at which it is below the level and one at
/// which it is not meets the level before it does.
template <class Lanes, int packs>
RA2D_FUNCTION double first_contact(const Lanes& lanes,
                                   const NodeContact<Lanes, packs>& node_contact,
                                   const PolynomialMotion<Lanes, packs>& motion, const Place& start,
                                   int cell, const OnsetInterval& interval, double curvature,
                                   double level, double noise) {
  using Real = typename Lanes::Real;
  const double beyond = 2.0 * motion.most + 1.0, slide_rate = motion.most_slide_rate();
  double x = interval.from;
  for (int i = 0; i < 200; ++i) {
    Real u[packs], rate[packs];
    motion.at(lanes, x, u, rate);
    const Place here = motion.place_at(start, x);
    const MovingCell moving = node_contact.moving_cell(cell, here, u, rate, motion.slide_rate(x));
    double rate_there;
    const double miss = level - moving.highest(rate_there);
    if (!(miss > noise)) return x;
    if (i % 16 == 15) {
      // a summit that passes a flat slider keeps its height: by the parabolas below, which do not
      // know that, the search would stand still
      const double travelled = motion.place_at(start, interval.to).theta - here.theta;
      if (node_contact.most_overlap(cell, here, moving, motion.slide_rate(x), travelled,
                                    interval.to - x, curvature) < level - noise)
        return beyond;
    }
    const double bound =
        Kokkos::fma(slide_rate * slide_rate, moving.steepness.curvature,
                    Kokkos::fma(motion.change_of_slide_rate(), moving.steepness.slope, curvature));
    const auto excess = [&](double s) {
      return Kokkos::fma(0.5 * bound * s, s, moving.highest_after(s) - level);
    };
    // the parabola at the highest place comes to the level no sooner than the largest of all
    const double root = Kokkos::sqrt(Kokkos::fma(rate_there, rate_there, 2.0 * bound * miss));
    const double sooner = rate_there > 0.0    ? 2.0 * miss / (root + rate_there)
                          : root > rate_there ? (root - rate_there) / (bound + 1e-300)
                                              : 1e300;  // nothing moves
    const double high = Kokkos::min(sooner, interval.to - x), of_high = excess(high);
    if (of_high < 0.0 && !(sooner < interval.to - x)) return beyond;
    const double next = x + (of_high > 0.0 ? high * (miss / (of_high + miss)) : high);
    if (!(next > x)) return x;  // as near as roundings let it come
    x = next;
  }
  return x;
}

}  // namespace ra2d
