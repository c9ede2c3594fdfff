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
  using Motion = PolynomialMotion<Lanes, packs>;
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
                           StepStart& begin, const Place& place, PointBuffers& buffers)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        adaptive_{adaptive},
        forces_{forces},
        collocation_{collocation},
        node_contact_{node_contact},
        sweeps_{lanes,    modes,   motion,      faces,    slider,
                adaptive, contact, collocation, expanded, contact_list.cell_parts,
                buffers},
        contact_list_{contact_list},
        force_series_{force_series},
        force_scale_{force_scale},
        now_{now},
        begin_{begin},
        start_{place},
        buffers_{buffers} {}

  /// Finds the forces at the beginning, in so many listed cells (PointBuffers::cells): those at the
  /// end of the step before, if that told.
  RA2D_FUNCTION void find_start(int cells) {
    cells_ = cells;
    if (begin_.knows_forces)
      take_start();
    else
      evaluate_start();
    if (!begin_.knows_rates) find_rates();
    Real before(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      before = before + twice_energy(p, now_.u[p], now_.v[p]);
    energy_norm_ = lanes_.sum(before) + 2.0 * energy_;
    change_ = 1e300;
    lanes_.sync();
  }

  /// Begins a step of so many ticks: the first sweep, whose forces tell of contacts that end.
  RA2D_FUNCTION void begin(std::int64_t ticks, Pace pace) {
    const double share = static_cast<double>(ticks) / ticks_;
    const bool tells = change_ < 0.1 && share <= 1.0;  // the try before does
    const typename CollocationSweeps<Lanes, packs>::Earlier earlier{tells ? table_ : nullptr, pace_,
                                                                    share};
    ticks_ = static_cast<double>(ticks);
    time_ = ticks_ * motion_.time_step;
    pace_ = pace;
    table_ = collocation_.paces + static_cast<int>(pace) * pace_numbers;
    double *const u = buffers_.u, *const v = buffers_.v;
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(u + p * width, now_.u[p]);
      lanes_.store(v + p * width, now_.v[p]);
    }
    lanes_.sync();
    sweeps_.begin(table_, ticks_, start_, {u, v, buffers_.acceleration, begin_.jerk}, earlier);
    if (forces_.count > 0) sweeps_.add_moving_forces(force_series_, adaptive_.order, force_scale_);
    change_ = 1e300;
    sweep(false);
  }
  /// The next sweep.
  KOKKOS_FORCEINLINE_FUNCTION void sweep_on() { sweep(true); }
  /// Takes those cells out of the step in which no sweep has found contact yet.
  RA2D_FUNCTION int leave_out_open() {
    cells_ = sweeps_.leave_out_open(cells_);
    return cells_;
  }
  /// Sweeps on until the motion is found.
  RA2D_FUNCTION void finish() {
    converges_ = sweep_to_end();
    double* const u = buffers_.u;
    sweeps_.finish(u + row);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      end_.u[p] = lanes_.load(u + row + p * width);
      end_.v[p] = lanes_.load(buffers_.velocity + last_point * row + p * width);
    }
    energy_at_end_ = buffers_.spring_energy[last_point - 1];
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
  /// `rounding`: of an overlap [m].
  RA2D_FUNCTION Errors errors(double rounding) const {
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
    // Works count to a tenth of the tolerance, since of those in and out little is left; and but
    // for roundings. Between rigid bodies the work of the imposed motion is all that there is.
    const double most = 0.1 * Kokkos::max(size, 2.0 * begin_.most_energy);
    if (!(most > 0.0)) return {0.0, 0.0};
    if (!converges_) return {1e30, 1e30};
    if (is_within(rounding, size)) return {0.0, 0.0};
    constexpr double share = 0.1;  // of the tolerance for a step, so that many keep it together
    const double per = time_ / (share * adaptive_.tolerance),
                 noise = rounding * most_force() / time_;
    const auto error = [&](double square, int first, int second) {
      const double work = Kokkos::max(size_of_power(first, second) - noise, 0.0) / most;
      return per * Kokkos::sqrt(Kokkos::fma(work, work, size > 0.0 ? square / size : 0.0));
    };
    return {error(of_last, legendre_8, legendre_7), error(of_middle, legendre_4, legendre_3)};
  }

  KOKKOS_FORCEINLINE_FUNCTION const Modes& end() const { return end_; }
  KOKKOS_FORCEINLINE_FUNCTION Pace pace() const { return pace_; }
  KOKKOS_FORCEINLINE_FUNCTION double ticks() const { return ticks_; }
  KOKKOS_FORCEINLINE_FUNCTION double early_release() const { return collocation_.early_release; }
  KOKKOS_FORCEINLINE_FUNCTION int cells() const { return cells_; }
  /// The x of a point, and the share of the step's time at which it stands.
  KOKKOS_FORCEINLINE_FUNCTION double place(int point) const { return table_[point_places + point]; }
  KOKKOS_FORCEINLINE_FUNCTION double share(int point) const {
    return pace_share(pace_, place(point));
  }
  /// Keeps what the step after one that is kept up to x starts with, as far as this one tells.
  RA2D_FUNCTION void keep_for_next(double x) const {
    lanes_.sync();
    const bool knows_rates = keep_rates(x), whole = x == 1.0;
    if (whole)
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        lanes_.store(begin_.acceleration + p * width,
                     lanes_.load(buffers_.acceleration + last_point * row + p * width));
    if (lanes_.leader()) {
      begin_.knows_rates = knows_rates;
      begin_.knows_forces = whole;
      begin_.energy = energy_at_end_;
      begin_.most_energy = Kokkos::max(begin_.most_energy, energy_at_end_);
      begin_.power = buffers_.power[last_point];
      begin_.moving_power = buffers_.power[points + last_point];
      begin_.count = 0;
      for (int e = 0; e < cells_; ++e) {
        const double force = buffers_.force[e * points + last_point];
        if (!(force > 0.0)) continue;
        begin_.cells[begin_.count] = buffers_.cells[e];
        begin_.forces[begin_.count] = force;
        begin_.centres[begin_.count] = buffers_.moment[e * points + last_point] / force;
        ++begin_.count;
      }
    }
    lanes_.sync();
  }
  /// Where the contact of a run of cells ends, as a share of the step's time, as far as its forces
  /// at the points tell: they fall as depth^1.5, and the depth is smooth. Beyond 1 where they have
  /// not come to an end; how far beyond is told at the pace towards a release alone.
  RA2D_FUNCTION double expected_end(const CellRun& run) const {
    double force[collocation_points];
    int last = -1;
    for (int i = 0; i <= last_point; ++i) {
      force[i] = 0.0;
      for (int e = 0; e < cells_; ++e)
        if (buffers_.cells[e] >= run.first && buffers_.cells[e] <= run.last)
          force[i] += buffers_.force[e * points + i];
      if (force[i] > 0.0)
        last = i;
      else if (last >= 0)
        break;
    }
    if (last < 0) return 0.0;
    if (last == last_point && pace_ != Pace::to_release) return 4.0;
    const double low = share(last), high = last < last_point ? share(last + 1) : 4.0;
    if (last == 0 || !(force[last - 1] > force[last])) return high;
    // the share as a function of the depth, at none: a parabola where the three fall, else a chord
    const double q0 = depth_of(force[last]), q1 = depth_of(force[last - 1]), s1 = share(last - 1);
    if (!(q1 > q0)) return high;
    double end = low + (low - s1) * (q0 / (q1 - q0));
    const double q2 = last >= 2 ? depth_of(force[last - 2]) : 0.0;
    if (q2 > q1) {
      const double s2 = share(last - 2);
      end = low * (q1 * q2 / ((q0 - q1) * (q0 - q2))) + s1 * (q0 * q2 / ((q1 - q0) * (q1 - q2))) +
            s2 * (q0 * q1 / ((q2 - q0) * (q2 - q1)));
    }
    return Kokkos::max(low, Kokkos::min(high, end));
  }
  /// The part of the step within which alone the overlap anywhere in an expanded cell may come
  /// to `level` [m]; one that begins beyond 1 where there is none. `curvature`: of the motion
  /// (PolynomialMotion::bounds).
  RA2D_FUNCTION OnsetInterval near(int cell, double curvature, double level) const {
    const Motion moving = motion(1.0);
    const double rate = moving.most_slide_rate(), interval = place(1);
    const auto faces = sweeps_.faces(cell).steepness();
    const double second =
        Kokkos::fma(rate * rate, faces.curvature,
                    Kokkos::fma(moving.change_of_slide_rate(), faces.slope, curvature));
    const auto [first, last] = sweeps_.points_near(cell, second, level);
    const bool at_once =
        first == 1 || Kokkos::fma(0.125 * interval * interval, second,
                                  node_contact_.highest(cell, start_, now_.u)) >= level;
    if (last < first) return at_once ? OnsetInterval{0.0, interval} : OnsetInterval{2.0, 2.0};
    return {at_once ? 0.0 : place(first - 1), last == last_point ? 1.0 : place(last + 1)};
  }
  /// When, after the step, the cell that near() was asked for last is expected to come into contact
  /// [s]; 1e300 where nothing tells that it does.
  RA2D_FUNCTION double expected_onset() const {
    lanes_.sync();
    const double* const o = buffers_.highest;
    const double time = zero_after(o[4], o[6], o[8]);
    lanes_.sync();
    return time;
  }
  /// When, after the step, the contact of a run of cells that is in contact at its end is expected
  /// to end [s]; 1e300 where nothing tells that it does.
  RA2D_FUNCTION double expected_release(const CellRun& run) const {
    double force[3] = {0.0, 0.0, 0.0};
    for (int e = 0; e < cells_; ++e)
      if (buffers_.cells[e] >= run.first && buffers_.cells[e] <= run.last)
        for (int i = 0; i < 3; ++i) force[i] += buffers_.force[e * points + 4 + 2 * i];
    // where it falls slowly, the parabola tells nothing
    if (!(force[2] < 0.75 * force[1]) || !(force[0] > 0.0)) return 1e300;
    return zero_after(-depth_of(force[0]), -depth_of(force[1]), -depth_of(force[2]));
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
  KOKKOS_FORCEINLINE_FUNCTION Motion motion(double x) const {
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
  StepStart& begin_;
  Place start_;
  PointBuffers& buffers_;
  Modes end_;
  double energy_norm_ = 0.0;  // J, twice the energy at the beginning
  double energy_ = 0.0, energy_at_end_ = 0.0, ticks_ = 0.0, time_ = 0.0;
  Pace pace_ = Pace::even;
  const double* table_ = nullptr;
  int cells_ = 0;
  int sweeps_made_ = 0;
  double change_ = 0.0, change_before_ = 0.0;  // by the latest sweeps, relative
  bool converges_ = false;

  /// `again`: it is not the first sweep.
  RA2D_FUNCTION void sweep(bool again) {
    if (again) sweep_on_springs();
    sweeps_.move();
    const auto change = sweeps_.accelerate(buffers_.cells, cells_, again);
    change_before_ = change_;
    change_ = Kokkos::sqrt(change.by / Kokkos::max(Kokkos::max(energy_norm_, change.size), 1e-300));
    sweeps_made_ = again ? sweeps_made_ + 1 : 1;
  }
  RA2D_FUNCTION void sweep_on_springs() {
    sweeps_.move();
    sweeps_.accelerate_on_springs();
  }
  /// Sweeps until the error is small beside the tolerance. Whether it came to be.
  RA2D_FUNCTION bool sweep_to_end() {
    // these errors add up over the steps of a lasting contact
    const double close = Kokkos::max(1e-3 * adaptive_.tolerance, 8.0 * 0x1p-52);
    while (true) {
      if (sweeps_made_ > 1) {
        // a sweep on springs and a full one leave no larger a part of this change than the two
        // before; one alone leaves the root of that part
        const double falls = Kokkos::min(1.0, change_ / change_before_);
        if (change_ * falls < close) {
          if (!(change_ * Kokkos::sqrt(falls) < close)) sweep_on_springs();
          sweeps_.move();
          return true;
        }
      }
      if (!(sweeps_made_ < most_sweeps)) return false;
      sweep(true);
    }
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

  /// Of the imposed motion's power [W], two of its coefficients together.
  KOKKOS_FORCEINLINE_FUNCTION double size_of_power(int first, int second) const {
    double a = 0.0, b = 0.0;
    for (int j = 0; j < collocation_points; ++j) {
      a = Kokkos::fma(table_[first + j], buffers_.power[j], a);
      b = Kokkos::fma(table_[second + j], buffers_.power[j], b);
    }
    return Kokkos::sqrt(Kokkos::fma(a, a, b * b));
  }
  /// The largest force at the beginning, the middle and the end [N].
  KOKKOS_FORCEINLINE_FUNCTION double most_force() const {
    double most = 0.0;
    for (int i = 0; i <= last_point; i += last_point / 2) {
      double force = 0.0;
      for (int e = 0; e < cells_; ++e) force += buffers_.force[e * points + i];
      most = Kokkos::max(most, force);
    }
    return most;
  }

  /// Whether contacts are in the mean less deep than a rounding of the overlap, at all points, and
  /// nothing else moves by more than they make it: no step can tell their forces any better. (Of a
  /// contact as deep as d the energy is 0.4 d times the force.) `size` [J]: twice the energy.
  RA2D_FUNCTION bool is_within(double rounding, double size) const {
    double most = 0.0;
    for (int i = last_point; i >= 0; --i) {
      double force = 0.0;
      for (int e = 0; e < cells_; ++e) force += buffers_.force[e * points + i];
      if (!((i > 0 ? buffers_.spring_energy[i - 1] : energy_) <= 0.4 * rounding * force))
        return false;
      most = Kokkos::max(most, force);
    }
    return size <= 0.8 * rounding * most;
  }

  /// The depth of a contact that carries this force, to a factor.
  KOKKOS_FORCEINLINE_FUNCTION static double depth_of(double force) {
    return Kokkos::exp2(2.0 / 3.0 * Kokkos::log2(force));
  }
  /// How long after the step a number that is negative at its end comes to zero [s], as the
  /// parabola through its values at points 4, 6 and 8 goes on; 1e300 where it does not.
  RA2D_FUNCTION double zero_after(double at_4, double at_6, double at_8) const {
    const double s4 = share(4), s6 = share(6);
    const double before = (at_6 - at_4) / (s6 - s4), rise = (at_8 - at_6) / (1.0 - s6),
                 curvature = (rise - before) / (1.0 - s4),
                 rate = Kokkos::fma(curvature, 1.0 - s6, rise),
                 inside = Kokkos::fma(rate, rate, -4.0 * curvature * at_8);
    if (!(inside >= 0.0)) return 1e300;
    const double root = rate + Kokkos::sqrt(inside);
    return root > 0.0 && at_8 < 0.0 ? -2.0 * at_8 / root * time_ : 1e300;
  }

  /// Finds the rate of the accelerations at the beginning, but for what contact forces change by.
  RA2D_FUNCTION void find_rates() const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real omega = load_pack(lanes_, modes_.omega, p);
      lanes_.store(
          begin_.jerk + p * width,
          -multiply_add(load_pack(lanes_, adaptive_.decay, p),
                        lanes_.load(buffers_.acceleration + p * width), omega * omega * now_.v[p]));
      lanes_.store(begin_.jerk + row + p * width, Real(0.0));
      lanes_.store(begin_.jerk + 2 * row + p * width, Real(0.0));
    }
  }
  /// Keeps the first three derivatives of the accelerations at x for the next step. False where
  /// the motion does not tell them.
  RA2D_FUNCTION bool keep_rates(double x) const {
    const double rate = pace_rate(pace_, x), per_time = 1.0 / (rate * time_);
    if (!(rate >= 0.5)) return false;
    // by the chain rule: x changes by 1/rate over the step's time
    const double slowing = pace_change(pace_) / rate;
    const Real at(x), once(-slowing), thrice(-3.0 * slowing), six_times(-6.0 * slowing),
        squared(15.0 * slowing * slowing);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real d1(0.0), d2(0.0), d3(0.0), d4(0.0);  // of the velocity, in x
      for (int m = motion_terms - 1; m >= 1; --m) {
        const Real c = Real(static_cast<double>(m)) * lanes_.load(buffers_.v + m * row + p * width);
        d1 = multiply_add(d1, at, c);
        if (m >= 2) d2 = multiply_add(d2, at, Real(m - 1.0) * c);
        if (m >= 3) d3 = multiply_add(d3, at, Real((m - 1.0) * (m - 2.0)) * c);
        if (m >= 4) d4 = multiply_add(d4, at, Real((m - 1.0) * (m - 2.0) * (m - 3.0)) * c);
      }
      const Real bent = multiply_add(once, d1, d2);
      const Real in_time[] = {bent, multiply_add(thrice, bent, d3),
                              multiply_add(six_times, d3, multiply_add(squared, bent, d4))};
      double power = per_time;
      for (int j = 0; j < 3; ++j) {
        power *= per_time;
        lanes_.store(begin_.jerk + j * row + p * width, power * in_time[j]);
      }
    }
    return true;
  }
  /// Finds forces and accelerations at the beginning from its state.
  RA2D_FUNCTION void evaluate_start() {
    Real force[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = load_pack(lanes_, modes_.load, p);
    double moving = 0.0;
    if (forces_.count > 0) moving = add_moving_forces(force);
    lanes_.sync();
    const ContactTotals<Real> totals = node_contact_(start_, now_.u, buffers_.cells, cells_, force);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real omega = load_pack(lanes_, modes_.omega, p);
      const Real held =
          multiply_add(load_pack(lanes_, adaptive_.decay, p), now_.v[p], omega * omega * now_.u[p]);
      lanes_.store(buffers_.velocity + p * width, now_.v[p]);
      lanes_.store(buffers_.acceleration + p * width,
                   multiply_add(load_pack(lanes_, adaptive_.inverse_mass, p), force[p], -held));
    }
    const double work =
        totals.nodes > 0 ? totals.face_work + lanes_.sum(totals.deflection_work) : 0.0;
    if (lanes_.leader()) {
      buffers_.power[0] = motion_.advance / motion_.time_step * work;
      buffers_.power[points] = moving;
    }
    energy_ = totals.energy;
    keep_start_forces(contact_list_.nodes, contact_list_.forces, contact_list_.centres,
                      totals.nodes);
  }
  RA2D_FUNCTION void take_start() {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(buffers_.velocity + p * width, now_.v[p]);
      lanes_.store(buffers_.acceleration + p * width, lanes_.load(begin_.acceleration + p * width));
    }
    if (lanes_.leader()) {
      buffers_.power[0] = begin_.power;
      buffers_.power[points] = begin_.moving_power;
    }
    energy_ = begin_.energy;
    keep_start_forces(begin_.cells, begin_.forces, begin_.centres, begin_.count);
  }
  /// Keeps the forces of `count` cells in contact at the beginning.
  RA2D_FUNCTION void keep_start_forces(const int* cells, const double* forces,
                                       const double* centres, int count) const {
    if (lanes_.leader())
      for (int e = 0, i = 0; e < cells_; ++e) {
        while (i < count && cells[i] < buffers_.cells[e]) ++i;
        const bool in_contact = i < count && cells[i] == buffers_.cells[e];
        buffers_.force[e * points] = in_contact ? forces[i] : 0.0;
        buffers_.moment[e * points] = in_contact ? forces[i] * centres[i] : 0.0;
      }
    lanes_.sync();
  }

  /// Adds the modal forces of the moving forces at the beginning; returns their power [W].
  RA2D_FUNCTION double add_moving_forces(Real* force) const {
    Real power(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real f = lanes_.load(force_series_ + p * width);
      force[p] = force[p] + f;
      power = multiply_add(f, now_.v[p], power);
    }
    return lanes_.sum(power);
  }
};

}  // namespace ra2d
