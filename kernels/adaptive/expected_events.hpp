// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/contact/moving_cell.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// When contacts between smooth faces will begin and end, foretold from the motion's first three
/// derivatives at one state. A step that is planned by it seldom has to be rejected; whether it is
/// good does not rest on it.
template <class Lanes, int packs>
class ExpectedEvents {
  using Real = typename Lanes::Real;

 public:
  /// Times from now [s]; infinite where none is expected.
  struct Times {
    double onset = 1e300, release = 1e300;
  };

  RA2D_FUNCTION ExpectedEvents(const Lanes& lanes, const ModeTables& modes,
                               const SliderMotion& motion, const SeriesTables& adaptive,
                               const NodeContact<Lanes, packs>& node_contact, const Place& place)
      : lanes_{lanes},
        modes_{modes},
        adaptive_{adaptive},
        node_contact_{node_contact},
        place_{place},
        speed_{motion.advance / motion.time_step} {}

  /// The first of each within `horizon` [s], in the listed cells. `force`: at the beginning, of
  /// each listed cell, one every `apart` numbers. Runs of cells are taken as one contact.
  /// `stays_open` becomes 1 for each listed cell that is open and will be for a quarter longer,
  /// else 0. `third` becomes the third derivative of the modes' displacement.
  RA2D_FUNCTION Times operator()(const Real* u, const Real* v, const Real* acceleration,
                                 const int* cells, int count, const double* force, int apart,
                                 double horizon, int* stays_open, Real* third) const {
    third_derivative(u, v, acceleration, cells, count, force, apart, third);
    Times times;
    for (int e = 0; e < count;) {
      bool closed = false, ends = true;  // contact at the beginning; all are free at the end
      double onset = 1e300, release = 0.0;
      int last = cells[e];
      for (; e < count && cells[e] <= last + 1; ++e) {
        last = cells[e];
        ForeseenCell path;
        path.now = node_contact_.moving_cell(cells[e], place_, u, v, speed_);
        const double now = path.highest_after(0.0);
        // far from contact its second derivative tells enough
        foresee_second(cells[e], acceleration, path);
        if (force[e * apart] == 0.0 && now + path.most_rise(1.25 * horizon) < 0.0) {
          if (lanes_.leader()) stays_open[e] = 1;
          continue;
        }
        path.third[0] = path.third[1] = node_contact_.along(cells[e], place_, third);
        const double then = path.highest_after(horizon);
        const bool open = force[e * apart] == 0.0 && now < 0.0 && then < 0.0 &&
                          path.highest_after(0.5 * horizon) < 0.0 &&
                          path.highest_after(1.25 * horizon) < 0.0;
        if (lanes_.leader()) stays_open[e] = open ? 1 : 0;
        closed = closed || force[e * apart] > 0.0;
        ends = ends && then < 0.0;
        if (now > 0.0 && then < 0.0)
          release = Kokkos::max(release, path.crossing(horizon, now, then));
        if (now < 0.0 && then > 0.0) onset = Kokkos::min(onset, path.crossing(horizon, now, then));
      }
      if (closed && ends && release > 0.0) times.release = Kokkos::min(times.release, release);
      if (!closed) times.onset = Kokkos::min(times.onset, onset);
    }
    return times;
  }

 private:
  Lanes lanes_;
  const ModeTables& modes_;
  const SeriesTables& adaptive_;
  NodeContact<Lanes, packs> node_contact_;
  Place place_;
  double speed_;  // chi/s

  RA2D_FUNCTION void foresee_second(int cell, const Real* acceleration, ForeseenCell& path) const {
    const Cubic of_modes = node_contact_.along(cell, place_, acceleration);
    for (int side = 0; side < 2; ++side) {
      const Cubic face = node_contact_.passing(cell, place_, side);
      path.second[side] = of_modes;
      path.second[side].c[0] = Kokkos::fma(speed_ * speed_, 2.0 * face.c[2], of_modes.c[0]);
      path.second[side].c[1] = Kokkos::fma(speed_ * speed_, 6.0 * face.c[3], of_modes.c[1]);
    }
  }

  /// u''' = F'/m - 2 zeta omega u'' - omega^2 u'
  RA2D_FUNCTION void third_derivative(const Real* u, const Real* v, const Real* acceleration,
                                      const int* cells, int count, const double* force, int apart,
                                      Real* third) const {
    Real rate[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) rate[p] = Real(0.0);
    for (int e = 0; e < count; ++e)
      if (force[e * apart] > 0.0)
        node_contact_.add_force_rate(cells[e], place_, u, v, speed_, rate);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real omega = load_pack(lanes_, modes_.omega, p);
      third[p] = multiply_add(load_pack(lanes_, adaptive_.inverse_mass, p), rate[p],
                              -multiply_add(load_pack(lanes_, adaptive_.decay, p), acceleration[p],
                                            omega * omega * v[p]));
    }
  }
};

}  // namespace ra2d
