// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

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
/// is smooth all the same, but for the onset and the release: a Runge-Kutta formula of order 8,
///
///   U_i = U_0 + h sum_j a_ij V_j,   V_i = V_0 + h sum_j a_ij A_j,   A = force/m - 2 zeta omega V -
///   omega^2 U,
///
/// whose stages stand at even shares of the time or, next to an onset or a release, closer there
/// (Pace, kernels/tables.hpp). Its continuous output gives the motion over the whole step as a
/// polynomial of x; whatever is integrated over the step has the same weights.
template <class Lanes, int packs>
class SmoothStep {
  using Real = typename Lanes::Real;
  using Modes = ModalState<Lanes, packs>;
  static constexpr int width = Lanes::width, row = packs * width;

 public:
  /// Steps from `now` at `place` on. The moving forces' series are in units of `force_scale` [s].
  RA2D_FUNCTION SmoothStep(const Lanes& lanes, const ModeTables& modes, const SliderMotion& motion,
                           const SeriesTables& adaptive, const MovingForces& forces,
                           const StageTables& stages, const NodeContact<Lanes, packs>& node_contact,
                           ContactList& contact_list, const double* force_series,
                           double force_scale, const Modes& now, const Place& place,
                           StageBuffers& buffers)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        adaptive_{adaptive},
        forces_{forces},
        stages_{stages},
        node_contact_{node_contact},
        contact_list_{contact_list},
        force_series_{force_series},
        force_scale_{force_scale},
        now_{now},
        start_{place},
        buffers_{buffers} {}

  /// Finds the forces at the beginning, in the listed cells (StageBuffers::cells).
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
      const int from = last_stage * row + p * width, to = p * width;
      lanes_.store(buffers_.velocity + to, lanes_.load(buffers_.velocity + from));
      lanes_.store(buffers_.acceleration + to, lanes_.load(buffers_.acceleration + from));
    }
    int count = 0;
    for (int e = 0; e < cells; ++e) {
      const double force = buffers_.force[e * formula_stages + last_stage];
      if (!(force > 0.0)) continue;
      if (lanes_.leader()) {
        contact_list_.nodes[count] = buffers_.cells[e];
        contact_list_.forces[count] = force;
        contact_list_.centres[count] = buffers_.centre[e * formula_stages + last_stage];
      }
      ++count;
    }
    lanes_.sync();
    if (lanes_.leader()) {
      buffers_.power[0] = buffers_.power[last_stage];
      buffers_.power[formula_stages] = buffers_.power[formula_stages + last_stage];
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

  /// Makes a step of so many ticks. `end_place`: of its end, to the bit.
  RA2D_FUNCTION void make(std::int64_t ticks, Pace pace, int cells, const Place& end_place) {
    ticks_ = static_cast<double>(ticks);
    time_ = ticks_ * motion_.time_step;
    pace_ = pace;
    table_ = stages_.paces + static_cast<int>(pace) * pace_numbers;
    cells_ = cells;
    for (int i = 1; i <= last_stage; ++i) make_stage(i, end_place);
  }
  /// Finds the motion over the step.
  RA2D_FUNCTION void find_motion() {
    for (int i = last_stage + 1; i < formula_stages; ++i) make_stage(i, start_);
    for (int m = 0; m < motion_terms; ++m) {
      Real u[packs], v[packs];
      sum(stage_output + m, formula_stages, u, v);
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        lanes_.store(buffers_.u + m * row + p * width,
                     multiply_add(time_, u[p], m == 0 ? now_.u[p] : Real(0.0)));
        lanes_.store(buffers_.v + m * row + p * width,
                     multiply_add(time_, v[p], m == 0 ? now_.v[p] : Real(0.0)));
      }
    }
  }

  /// Estimated local error over the tolerance: a step is good up to 1. In the energy norm, relative
  /// to the larger of both ends, the springs' energy included.
  ///
  /// The formula's own estimate takes the errors of orders 5 and 3 and infers that of order 8. It
  /// holds for a smooth motion. Graded towards an onset or a release, the estimate is the geometric
  /// mean of the inferred error and that of order 5. (So chosen that the energy that such steps
  /// lose is no larger than that of the others.) Where a contact begins or ends elsewhere in the
  /// step, nothing may be inferred, and either error may vanish by chance: then the estimate
  /// combines both errors.
  enum class Course { smooth, graded, kinked };
  struct Errors {
    double fifth, third;  // over the tolerance
    RA2D_FUNCTION double of(Course course) const {
      if (!(fifth > 0.0)) return course == Course::kinked ? 0.1 * third : fifth;
      const double inferred = fifth * fifth / Kokkos::hypot(fifth, 0.1 * third);
      return course == Course::smooth   ? inferred
             : course == Course::graded ? Kokkos::sqrt(inferred * fifth)
                                        : Kokkos::hypot(fifth, 0.1 * third);
    }
    /// How the step's length is to change for an error of 1.
    RA2D_FUNCTION double factor(Course course) const {
      const double order = course == Course::smooth ? 8.0 : course == Course::graded ? 7.0 : 3.0;
      return 0.9 * Kokkos::exp2(-Kokkos::log2(of(course)) / order);
    }
  };
  RA2D_FUNCTION Errors errors() const {
    Real u5[packs], v5[packs], u3[packs], v3[packs];
    sum(stage_fifth_order_error, last_stage, u5, v5);
    sum(stage_third_order_error, last_stage, u3, v3);
    Real fifth(0.0), third(0.0), before(0.0), after(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real mass = load_pack(lanes_, modes_.mass, p),
                 omega = load_pack(lanes_, modes_.omega, p);
      const auto norm = [&](const Real& u, const Real& v) {
        const Real stretch = omega * u;
        return mass * multiply_add(v, v, stretch * stretch);
      };
      fifth = fifth + norm(u5[p], v5[p]);
      third = third + norm(u3[p], v3[p]);
      before = before + norm(now_.u[p], now_.v[p]);
      after = after + norm(end_.u[p], end_.v[p]);
    }
    double e5, e3, start, end;
    lanes_.sum(fifth, third, e5, e3);
    lanes_.sum(before, after, start, end);
    const double size = Kokkos::max(start, end) + 2.0 * Kokkos::max(energy_, energy_at_end_);
    if (!(size < 1e300)) return {size - size + 1e300, 1e300};  // not a number, or too large
    if (!(size > 0.0)) return {0.0, 0.0};
    constexpr double share = 0.1;  // of the tolerance for a step, so that many keep it together
    const double per = time_ / (share * adaptive_.tolerance * Kokkos::sqrt(size));
    return {per * Kokkos::sqrt(e5), per * Kokkos::sqrt(e3)};
  }

  KOKKOS_FORCEINLINE_FUNCTION const Modes& end() const { return end_; }
  KOKKOS_FORCEINLINE_FUNCTION Pace pace() const { return pace_; }
  KOKKOS_FORCEINLINE_FUNCTION double ticks() const { return ticks_; }
  KOKKOS_FORCEINLINE_FUNCTION int cells() const { return cells_; }
  /// Share of the step's time at which a stage stands.
  KOKKOS_FORCEINLINE_FUNCTION double share(int stage) const {
    return pace_share(pace_, table_[stage_places * formula_stages + stage]);
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

  /// Weights of the stages in an integral over time from the beginning to x, in units of the step.
  struct Weights {
    double of[formula_stages];
  };
  RA2D_FUNCTION Weights weights(double x) const {
    Weights w;
    for (int i = 0; i < formula_stages; ++i) {
      if (x == 1.0) {
        w.of[i] = i < last_stage ? table_[(stage_weights + last_stage) * formula_stages + i] : 0.0;
        continue;
      }
      double sum = 0.0;
      for (int m = motion_terms - 1; m >= 0; --m)
        sum = Kokkos::fma(sum, x, table_[(stage_output + m) * formula_stages + i]);
      w.of[i] = sum;
    }
    return w;
  }
  /// Integral of V^2, in ticks.
  RA2D_FUNCTION void squares(const Weights& w, Real* square) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) square[p] = Real(0.0);
    for (int i = 0; i < formula_stages; ++i)
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        const Real v = lanes_.load(buffers_.velocity + i * row + p * width);
        square[p] = multiply_add(w.of[i] * ticks_, v * v, square[p]);
      }
  }
  /// Works of the imposed motion and of the moving forces [J].
  RA2D_FUNCTION void works(const Weights& w, double& sliding, double& moving) const {
    sliding = moving = 0.0;
    for (int i = 0; i < formula_stages; ++i) {
      sliding = Kokkos::fma(w.of[i], buffers_.power[i], sliding);
      moving = Kokkos::fma(w.of[i], buffers_.power[formula_stages + i], moving);
    }
    sliding *= time_;
    moving *= time_;
  }

 private:
  RA2D_FUNCTION void make_stage(int i, const Place& end_place) {
    Real u[packs], v[packs];
    sum(stage_weights + i, i, u, v);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      u[p] = multiply_add(time_, u[p], now_.u[p]);
      v[p] = multiply_add(time_, v[p], now_.v[p]);
    }
    if (i == last_stage) {
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        end_.u[p] = u[p];
        end_.v[p] = v[p];
      }
      energy_at_end_ = evaluate(i, end_place, u, v, 1.0).energy;
    } else {
      evaluate(i, place_at_share(share(i)), u, v, share(i));
    }
  }

  Lanes lanes_;
  const ModeTables& modes_;
  const SliderMotion& motion_;
  const SeriesTables& adaptive_;
  const MovingForces& forces_;
  const StageTables& stages_;
  NodeContact<Lanes, packs> node_contact_;
  ContactList& contact_list_;
  const double* force_series_;
  double force_scale_;  // s, unit of that series
  const Modes& now_;
  Place start_;
  StageBuffers& buffers_;
  Modes end_;
  double energy_ = 0.0, energy_at_end_ = 0.0, ticks_ = 0.0, time_ = 0.0;
  Pace pace_ = Pace::even;
  const double* table_ = nullptr;
  int cells_ = 0, nodes_at_start_ = 0;

  /// Weighted sums of the velocities and accelerations of the first `count` stages.
  KOKKOS_FORCEINLINE_FUNCTION void sum(int weights, int count, Real* u, Real* v) const {
    const double* w = table_ + weights * formula_stages;
    for (int p = 0; p < filled<packs>(lanes_); ++p) u[p] = v[p] = Real(0.0);
    for (int j = 0; j < count; ++j) {
      if (w[j] == 0.0) continue;
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        u[p] = multiply_add(w[j], lanes_.load(buffers_.velocity + j * row + p * width), u[p]);
        v[p] = multiply_add(w[j], lanes_.load(buffers_.acceleration + j * row + p * width), v[p]);
      }
    }
  }

  /// Forces and accelerations at a state, kept as those of a stage.
  RA2D_FUNCTION ContactTotals<Real> evaluate(int stage, const Place& place, const Real* u,
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
      lanes_.store(buffers_.velocity + stage * row + p * width, v[p]);
      lanes_.store(buffers_.acceleration + stage * row + p * width,
                   multiply_add(load_pack(lanes_, adaptive_.inverse_mass, p), force[p], -held));
    }
    const double work =
        totals.nodes > 0 ? totals.face_work + lanes_.sum(totals.deflection_work) : 0.0;
    if (lanes_.leader()) {
      buffers_.power[stage] = motion_.advance / motion_.time_step * work;
      buffers_.power[formula_stages + stage] = moving;
    }
    keep_forces(stage, totals.nodes);
    return totals;
  }
  /// Keeps the forces of the `count` cells in contact (ContactList) as those of a stage.
  RA2D_FUNCTION void keep_forces(int stage, int count) {
    if (lanes_.leader())
      for (int e = 0, i = 0; e < cells_; ++e) {
        const bool in_contact = i < count && contact_list_.nodes[i] == buffers_.cells[e];
        buffers_.force[e * formula_stages + stage] = in_contact ? contact_list_.forces[i] : 0.0;
        buffers_.centre[e * formula_stages + stage] = in_contact ? contact_list_.centres[i] : 0.0;
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
