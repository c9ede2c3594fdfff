// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/collocation.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/onsets.hpp"
#include "kernels/adaptive/pace.hpp"
#include "kernels/check.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// A step of the modes in contact between smooth faces. The force of a contact is no polynomial of
/// the time, so its motion has no power series as that of nodes (kernels/adaptive/series.hpp). It
/// is smooth all the same, but for the onset and the release: the equations of motion hold at the
/// nine points of Lobatto's rule over the step (CollocationSweeps), a formula of order 16. The
/// points stand at shares of the time or, next to an onset or a release, closer there (Pace,
/// kernels/tables.hpp). The polynomial through them is the motion over the whole step; whatever is
/// integrated over the step has the same weights.
template <class Lanes, int packs>
class SmoothStep {
  using Real = typename Lanes::Real;
  using Modes = ModalState<Lanes, packs>;
  static constexpr int width = Lanes::width, row = packs * width;
  static constexpr int points = 1 + padded_points(width);  // of a cell's numbers
  static constexpr int most_sweeps = 24;

 public:
  /// Steps from `now` at `place` on. The moving forces' series are in units of `force_scale` [s].
  RA2D_FUNCTION SmoothStep(const Lanes& lanes, const ModeTables& modes, const SliderMotion& motion,
                           const FaceTables& faces, const SliderShapes& slider,
                           const SeriesTables& adaptive, const MovingForces& forces,
                           const ContactTables& contact, const CollocationTables& collocation,
                           const NodeContact<Lanes, packs>& node_contact,
                           const ExpandedCells<Lanes, packs>& expanded, ContactList& contact_list,
                           const double* force_series, double force_scale, const Modes& now,
                           const Place& place, PointBuffers& buffers)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        adaptive_{adaptive},
        forces_{forces},
        collocation_{collocation},
        node_contact_{node_contact},
        sweeps_{lanes,   modes,    motion,
                faces,   slider,   adaptive,
                contact, expanded, contact_list.cell_parts,
                buffers},
        contact_list_{contact_list},
        force_series_{force_series},
        force_scale_{force_scale},
        now_{now},
        start_{place},
        buffers_{buffers} {}

  /// Finds the forces at the beginning, in the listed cells (PointBuffers::cells).
  RA2D_FUNCTION void evaluate_start(int cells) {
    cells_ = cells;
    const ContactTotals<Real> totals = evaluate(0, start_, now_.u, now_.v, 0.0);
    energy_ = totals.energy;
    nodes_at_start_ = totals.nodes;
  }

  /// Takes the forces at the end of the step before, in `cells` cells, for those at the beginning:
  /// it is the same state in the same window, so they have the same bits.
  RA2D_FUNCTION void take_start(int cells, double energy) {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const int from = last_point * row + p * width, to = p * width;
      lanes_.store(buffers_.velocity + to, lanes_.load(buffers_.velocity + from));
      lanes_.store(buffers_.acceleration + to, lanes_.load(buffers_.acceleration + from));
    }
    int count = 0;
    for (int e = 0; e < cells; ++e) {
      const double force = buffers_.force[e * points + last_point];
      if (!(force > 0.0)) continue;
      if (lanes_.leader()) {
        contact_list_.nodes[count] = buffers_.cells[e];
        contact_list_.forces[count] = force;
        contact_list_.centres[count] = buffers_.centre[e * points + last_point];
      }
      ++count;
    }
    lanes_.sync();
    if (lanes_.leader()) {
      buffers_.power[0] = buffers_.power[last_point];
      buffers_.power[points] = buffers_.power[points + last_point];
    }
    energy_ = energy;
    nodes_at_start_ = count;
    lanes_.sync();
  }
  KOKKOS_FORCEINLINE_FUNCTION double energy_at_end() const { return energy_at_end_; }
  /// Accelerations of the modes at the beginning.
  RA2D_FUNCTION void acceleration(Real* a) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      a[p] = lanes_.load(buffers_.acceleration + p * width);
  }
  /// Keeps the forces at the beginning, the latest found, for another list of cells.
  RA2D_FUNCTION void keep_start(int cells) {
    lanes_.sync();
    cells_ = cells;
    keep_forces(0, nodes_at_start_);
  }

  /// Keeps the rate of the accelerations at the beginning.
  RA2D_FUNCTION void keep_jerk(const Real* jerk) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      lanes_.store(buffers_.jerk + p * width, jerk[p]);
  }

  /// Makes a step of so many ticks. `end_place`: of its end, to the bit.
  RA2D_FUNCTION void make(std::int64_t ticks, Pace pace, int cells, const Place& end_place) {
    ticks_ = static_cast<double>(ticks);
    time_ = ticks_ * motion_.time_step;
    pace_ = pace;
    table_ = collocation_.paces + static_cast<int>(pace) * pace_numbers;
    cells_ = cells;
    double *const u = buffers_.u, *const v = buffers_.v;
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(u + p * width, now_.u[p]);
      lanes_.store(v + p * width, now_.v[p]);
    }
    lanes_.sync();
    sweeps_.begin(table_, ticks_, start_, {u, v, buffers_.acceleration, buffers_.jerk});
    if (forces_.count > 0) sweeps_.add_moving_forces(force_series_, adaptive_.order, force_scale_);
    converges_ = sweep();
    sweeps_.finish(u + row);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      end_.u[p] = lanes_.load(u + row + p * width);
      end_.v[p] = lanes_.load(buffers_.velocity + last_point * row + p * width);
    }
    energy_at_end_ = evaluate(last_point, end_place, end_.u, end_.v, 1.0).energy;
  }
  /// Finds the motion over the step.
  RA2D_FUNCTION void find_motion() {
    for (int m = 0; m < motion_terms; ++m) {
      Real u[packs], v[packs];
      sum(motion_weights + m * collocation_points, u, v);
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        lanes_.store(buffers_.u + m * row + p * width,
                     multiply_add(time_, u[p], m == 0 ? now_.u[p] : Real(0.0)));
        lanes_.store(buffers_.v + m * row + p * width,
                     multiply_add(time_, v[p], m == 0 ? now_.v[p] : Real(0.0)));
      }
    }
    lanes_.sync();
  }

  /// Estimated local error over the tolerance: a step is good up to 1. In the energy norm, relative
  /// to the larger of both ends, the springs' energy included.
  ///
  /// Of a smooth motion, the Legendre coefficients of the rates at the points fall by some factor
  /// from degree to degree. Those of degrees 7 and 8 against 3 and 4 tell it. The rule's own error
  /// is that of degree 16 and higher; taken is what that of degree 12 would be, so the estimate is
  /// on the safe side, next to an onset or a release, too. Where a contact begins or ends elsewhere
  /// in the step, the coefficients fall as a power of the degree: degree 10 then.
  enum class Course { smooth, graded, kinked };
  struct Errors {
    double last, middle;  // of degrees 7 and 8, and 3 and 4, over the tolerance
    RA2D_FUNCTION double of(Course course) const {
      if (!(last > 0.0)) return last;
      const double falls = Kokkos::min(1.0, last / middle);
      return last * (course == Course::kinked ? Kokkos::sqrt(falls) : falls);
    }
    /// That of the motion within the step: of degree 9, integrated.
    RA2D_FUNCTION double inside() const {
      if (!(last > 0.0)) return last;
      return 0.1 * last * Kokkos::sqrt(Kokkos::sqrt(Kokkos::min(1.0, last / middle)));
    }
    /// How the step's length is to change from this error to 1.
    RA2D_FUNCTION static double factor(Course course, double error) {
      const double order = course == Course::smooth ? 12.0 : course == Course::graded ? 10.0 : 4.0;
      return 0.9 * Kokkos::exp2(-Kokkos::log2(error) / order);
    }
  };
  RA2D_FUNCTION Errors errors() const {
    Real last(0.0), middle(0.0), before(0.0), after(0.0);
    add_squares(legendre_8, last);
    add_squares(legendre_7, last);
    add_squares(legendre_4, middle);
    add_squares(legendre_3, middle);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      before = before + twice_energy(p, now_.u[p], now_.v[p]);
      after = after + twice_energy(p, end_.u[p], end_.v[p]);
    }
    double of_last, of_middle, start, end;
    lanes_.sum(last, middle, of_last, of_middle);
    lanes_.sum(before, after, start, end);
    const double size = Kokkos::max(start, end) + 2.0 * Kokkos::max(energy_, energy_at_end_);
    if (!(size < 1e300)) return {size - size + 1e300, 1e300};  // not a number, or too large
    if (!(size > 0.0)) return {0.0, 0.0};
    if (!converges_) return {1e30, 1e30};
    constexpr double share = 0.1;  // of the tolerance for a step, so that many keep it together
    const double per = time_ / (share * adaptive_.tolerance * Kokkos::sqrt(size));
    return {per * Kokkos::sqrt(of_last), per * Kokkos::sqrt(of_middle)};
  }

  KOKKOS_FORCEINLINE_FUNCTION const Modes& end() const { return end_; }
  KOKKOS_FORCEINLINE_FUNCTION Pace pace() const { return pace_; }
  KOKKOS_FORCEINLINE_FUNCTION double ticks() const { return ticks_; }
  KOKKOS_FORCEINLINE_FUNCTION int cells() const { return cells_; }
  /// The x of a point, and the share of the step's time at which it stands.
  KOKKOS_FORCEINLINE_FUNCTION double place(int point) const { return table_[point_places + point]; }
  KOKKOS_FORCEINLINE_FUNCTION double share(int point) const {
    return pace_share(pace_, place(point));
  }
  /// The polynomial through a value at each point, at x.
  RA2D_FUNCTION double between(const double* values, double x) const {
    const double* const weights = table_ + barycentric_weights;
    double sum = 0.0, of_weights = 0.0;
    for (int i = 0; i < collocation_points; ++i) {
      const double distance = x - place(i);
      if (distance == 0.0) return values[i];
      const double weight = weights[i] / distance;
      sum = Kokkos::fma(weight, values[i], sum);
      of_weights += weight;
    }
    return sum / of_weights;
  }
  /// The motion up to x, a polynomial.
  KOKKOS_FORCEINLINE_FUNCTION PolynomialMotion<Lanes, packs> motion(double x) const {
    return {buffers_.u, motion_terms - 1, pace_, motion_.advance * ticks_, x};
  }
  KOKKOS_FORCEINLINE_FUNCTION Place place_at_share(double share) const {
    Place place = start_;
    const double travelled = motion_.advance * ticks_ * share;
    place.position += travelled;
    place.theta += travelled;
    place.offset += travelled;
    return place;
  }
  RA2D_FUNCTION void state(double x, Real* u, Real* v) const {
    const Real at(x);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      u[p] = lanes_.load(buffers_.u + (motion_terms - 1) * row + p * width);
      v[p] = lanes_.load(buffers_.v + (motion_terms - 1) * row + p * width);
      for (int m = motion_terms - 2; m >= 0; --m) {
        u[p] = multiply_add(u[p], at, lanes_.load(buffers_.u + m * row + p * width));
        v[p] = multiply_add(v[p], at, lanes_.load(buffers_.v + m * row + p * width));
      }
    }
  }
  /// The contact at x, in the step's cells; lists those in contact (ContactList).
  RA2D_FUNCTION ContactTotals<Real> contact_at(double x) const {
    Real u[packs], v[packs], force[packs];
    state(x, u, v);
    for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = Real(0.0);
    lanes_.sync();
    return node_contact_(place_at_share(pace_share(pace_, x)), u, buffers_.cells, cells_, force);
  }

  /// Weights of the points in an integral over time from the beginning to x, in units of the step.
  struct Weights {
    double of[collocation_points];
  };
  RA2D_FUNCTION Weights weights(double x) const {
    Weights w;
    for (int i = 0; i < collocation_points; ++i) {
      if (x == 1.0) {
        w.of[i] = table_[end_weights + i];
        continue;
      }
      double sum = 0.0;
      for (int m = motion_terms - 1; m >= 0; --m)
        sum = Kokkos::fma(sum, x, table_[motion_weights + m * collocation_points + i]);
      w.of[i] = sum;
    }
    return w;
  }
  /// Integral of V^2, in ticks.
  RA2D_FUNCTION void squares(const Weights& w, Real* square) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) square[p] = Real(0.0);
    for (int i = 0; i < collocation_points; ++i)
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        const Real v = lanes_.load(buffers_.velocity + i * row + p * width);
        square[p] = multiply_add(w.of[i] * ticks_, v * v, square[p]);
      }
  }
  /// Works of the imposed motion and of the moving forces [J].
  RA2D_FUNCTION void works(const Weights& w, double& sliding, double& moving) const {
    sliding = moving = 0.0;
    for (int i = 0; i < collocation_points; ++i) {
      sliding = Kokkos::fma(w.of[i], buffers_.power[i], sliding);
      moving = Kokkos::fma(w.of[i], buffers_.power[points + i], moving);
    }
    sliding *= time_;
    moving *= time_;
  }

 private:
  Lanes lanes_;
  const ModeTables& modes_;
  const SliderMotion& motion_;
  const SeriesTables& adaptive_;
  const MovingForces& forces_;
  const CollocationTables& collocation_;
  NodeContact<Lanes, packs> node_contact_;
  CollocationSweeps<Lanes, packs> sweeps_;
  ContactList& contact_list_;
  const double* force_series_;
  double force_scale_;  // s, unit of that series
  const Modes& now_;
  Place start_;
  PointBuffers& buffers_;
  Modes end_;
  double energy_ = 0.0, energy_at_end_ = 0.0, ticks_ = 0.0, time_ = 0.0;
  Pace pace_ = Pace::even;
  const double* table_ = nullptr;
  int cells_ = 0, nodes_at_start_ = 0;
  bool converges_ = false;

  /// Sweeps until the error is small beside the tolerance. Whether it came to be.
  RA2D_FUNCTION bool sweep() {
    Real before(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      before = before + twice_energy(p, now_.u[p], now_.v[p]);
    const double size = lanes_.sum(before) + 2.0 * energy_;
    const double close = Kokkos::max(0.02 * adaptive_.tolerance, 8.0 * 0x1p-52);
    double change_before = 0.0;
    for (int k = 0; k < most_sweeps; ++k) {
      sweeps_.move();
      const auto found = sweeps_.accelerate(buffers_.cells, cells_, k > 0);
      const double change =
          Kokkos::sqrt(found.by / Kokkos::max(Kokkos::max(size, found.size), 1e-300));
      // the next one changes it by no larger a part of this change
      if (k > 0 && change * Kokkos::min(1.0, change / change_before) < close) {
        sweeps_.move();
        return true;
      }
      change_before = change;
    }
    return false;
  }

  /// Mass times V^2 + (omega U)^2.
  KOKKOS_FORCEINLINE_FUNCTION Real twice_energy(int p, const Real& u, const Real& v) const {
    const Real stretch = load_pack(lanes_, modes_.omega, p) * u;
    return load_pack(lanes_, modes_.mass, p) * multiply_add(v, v, stretch * stretch);
  }
  RA2D_FUNCTION void add_squares(int weights, Real& squares) const {
    Real u[packs], v[packs];
    sum(weights, u, v);
    for (int p = 0; p < filled<packs>(lanes_); ++p) squares = squares + twice_energy(p, u[p], v[p]);
  }

  /// Weighted sums of the velocities and accelerations of the points.
  KOKKOS_FORCEINLINE_FUNCTION void sum(int weights, Real* u, Real* v) const {
    const double* w = table_ + weights;
    for (int p = 0; p < filled<packs>(lanes_); ++p) u[p] = v[p] = Real(0.0);
    for (int j = 0; j < collocation_points; ++j) {
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        u[p] = multiply_add(w[j], lanes_.load(buffers_.velocity + j * row + p * width), u[p]);
        v[p] = multiply_add(w[j], lanes_.load(buffers_.acceleration + j * row + p * width), v[p]);
      }
    }
  }

  /// Forces and accelerations at a state, kept as those of a point.
  RA2D_FUNCTION ContactTotals<Real> evaluate(int point, const Place& place, const Real* u,
                                             const Real* v, double share) {
    Real force[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = load_pack(lanes_, modes_.load, p);
    double moving = 0.0;
    if (forces_.count > 0) moving = add_moving_forces(share * time_ / force_scale_, v, force);
    lanes_.sync();
    const ContactTotals<Real> totals = node_contact_(place, u, buffers_.cells, cells_, force);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real omega = load_pack(lanes_, modes_.omega, p);
      const Real held =
          multiply_add(load_pack(lanes_, adaptive_.decay, p), v[p], omega * omega * u[p]);
      lanes_.store(buffers_.velocity + point * row + p * width, v[p]);
      lanes_.store(buffers_.acceleration + point * row + p * width,
                   multiply_add(load_pack(lanes_, adaptive_.inverse_mass, p), force[p], -held));
    }
    const double work =
        totals.nodes > 0 ? totals.face_work + lanes_.sum(totals.deflection_work) : 0.0;
    if (lanes_.leader()) {
      buffers_.power[point] = motion_.advance / motion_.time_step * work;
      buffers_.power[points + point] = moving;
    }
    keep_forces(point, totals.nodes);
    return totals;
  }
  /// Keeps the forces of the `count` cells in contact (ContactList) as those of a point.
  RA2D_FUNCTION void keep_forces(int point, int count) {
    if (lanes_.leader())
      for (int e = 0, i = 0; e < cells_; ++e) {
        const bool in_contact = i < count && contact_list_.nodes[i] == buffers_.cells[e];
        buffers_.force[e * points + point] = in_contact ? contact_list_.forces[i] : 0.0;
        buffers_.centre[e * points + point] = in_contact ? contact_list_.centres[i] : 0.0;
        if (in_contact) ++i;
      }
    lanes_.sync();
  }

  /// Adds the modal forces of the moving forces at x of their series; returns their power [W].
  RA2D_FUNCTION double add_moving_forces(double x, const Real* v, Real* force) const {
    Real power(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real f = lanes_.load(force_series_ + adaptive_.order * row + p * width);
      for (int j = adaptive_.order - 1; j >= 0; --j)
        f = multiply_add(f, Real(x), lanes_.load(force_series_ + j * row + p * width));
      force[p] = force[p] + f;
      power = multiply_add(f, v[p], power);
    }
    return lanes_.sum(power);
  }
};

}  // namespace ra2d
