// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/crossing.hpp"
#include "kernels/adaptive/flight.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/push.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The record of the motion itself: samples at their own times, sums and shocks integrated over the
/// series. Nothing of it depends on where a launch ends: when the samples of a step do not fit into
/// their buffer, the step is done again in the next launch.
template <class Lanes, int K>
class AdaptiveRecorder {
  using Real = typename Lanes::Real;
  using Modes = ModalState<Lanes, K>;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION AdaptiveRecorder(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                                   const Flight<Lanes, K>& flight,
                                   const ModalSeries<Lanes, K>& series, const Push<Lanes, K>& push)
      : lanes_{lanes}, t_{tables}, s_{state}, flight_{flight}, series_{series}, push_{push} {}

  /// The samples within the `ticks` after `step`, of modes that fly from there. False when the
  /// buffer is full.
  KOKKOS_FUNCTION bool fly_samples(std::int64_t step, const Modes& now, std::int64_t ticks) const {
    if (is_complete() || sample_tick() >= step + ticks) return true;
    // each from the one before, those too that the launch before has written: what is flown in one
    // leap and in two has other roundings
    const auto apart = static_cast<std::int64_t>(t_.steps_per_sample);
    std::int64_t at = step;
    Modes there = now;
    for (std::int64_t sample = (step + apart - 1) / apart * apart; sample < step + ticks;
         sample += apart) {
      if (is_complete()) break;
      flight_(there.u, there.v, there.square, sample - at);
      at = sample;
      if (sample < sample_tick()) continue;
      if (!has_room_for_sample()) return false;
      write_sample(there, Contact{});
    }
    return true;
  }

  /// ... of modes that follow their series, whose squares are found here.
  KOKKOS_FUNCTION bool drive_samples(std::int64_t step, const Modes& now,
                                     std::int64_t ticks) const {
    series_.expand_squares();
    while (!is_complete() && sample_tick() < step + ticks) {
      if (!has_room_for_sample()) return false;
      const double x = series_.x_at(sample_tick() - step);
      Modes there;
      series_.state(x, there.u, there.v);
      series_.squares(x, there.square);
      for (int p = 0; p < K; ++p) there.square[p] = now.square[p] + there.square[p];
      write_sample(there, contact_at(x));
    }
    return true;
  }

  KOKKOS_FORCEINLINE_FUNCTION bool is_complete() const { return s_.next_sample >= t_.samples; }
  KOKKOS_FORCEINLINE_FUNCTION bool has_room_for_sample() const {
    return s_.sample_count < s_.sample_capacity;
  }
  /// The sample that falls on the end of the scene. If any node is in contact, the series are those
  /// from there on.
  KOKKOS_FUNCTION void write_last_sample(const Modes& now) const {
    Contact contact;
    if (s_.closed_count > 0) contact = contact_at(0.0);
    write_sample(now, contact);
  }

  /// Takes in a flight that ends at `step`.
  KOKKOS_FUNCTION void add_flight(std::int64_t step) const {
    if (lanes_.leader() && s_.open_count > 0) end_shocks(s_, step);
    lanes_.sync();
  }
  /// Takes in the `ticks` after `step`, up to `end` in units of the series, with the nodes in
  /// contact and their hulls.
  KOKKOS_FUNCTION void add_drive(const Place& place, std::int64_t step, std::int64_t ticks,
                                 double end) const {
    if (ticks == 0) return;
    sum_nodes(end);
    const double sliding = sliding_work(), moving = push_.work(series_, end);
    if (!lanes_.leader()) return;
    s_.sliding_work += sliding;
    s_.force_work += moving;
    const int count = s_.closed_count;
    if (count == 0) {
      if (s_.open_count > 0) end_shocks(s_, step);
      return;
    }
    s_.contact_steps += ticks;
    if (count > s_.most_nodes) s_.most_nodes = count;
    add_shocks(place, step, ticks, end);
  }

  /// Sums are kept in two parts, so that many small terms are not added to one large number.
  KOKKOS_FUNCTION void close_parts(Modes& now) const {
    for (int p = 0; p < K; ++p) {
      lanes_.store(s_.square + p * width, lanes_.load(s_.square + p * width) + now.square[p]);
      now.square[p] = Real(0.0);
    }
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  const Flight<Lanes, K>& flight_;
  const ModalSeries<Lanes, K>& series_;
  const Push<Lanes, K>& push_;

  // ---- samples

  KOKKOS_FORCEINLINE_FUNCTION std::int64_t sample_tick() const {
    return s_.next_sample * static_cast<std::int64_t>(t_.steps_per_sample);
  }

  /// A sample's contact, and the works since the step began.
  struct Contact {
    double force = 0, energy = 0, sliding_work = 0, force_work = 0;
    int nodes = 0;
  };
  KOKKOS_FUNCTION Contact contact_at(double x) const {
    Contact contact;
    for (int e = 0; e < s_.closed_count; ++e) {
      const double over = polynomial(series_.overlap(e), series_.degree(), x);
      contact.force += t_.node_stiffness * over;
      contact.energy += 0.5 * t_.node_stiffness * over * over;
    }
    contact.nodes = s_.closed_count;
    sum_nodes(x);
    contact.sliding_work = sliding_work();
    contact.force_work = push_.work(series_, x);
    return contact;
  }

  KOKKOS_FUNCTION void write_sample(const Modes& at, const Contact& contact) const {
    double* row = s_.sample_rows +
                  static_cast<std::int64_t>(s_.sample_count) * (2 * K * width + sample::columns);
    Real loss(0.0);
    for (int p = 0; p < K; ++p) {
      lanes_.store(row + p * width, at.u[p]);
      lanes_.store(row + (K + p) * width, at.v[p]);
      loss = multiply_add(lanes_.load(t_.damping + p * width),
                          lanes_.load(s_.square + p * width) + at.square[p], loss);
    }
    const double damping_loss = lanes_.sum(loss);
    lanes_.sync();
    if (lanes_.leader()) {
      double* column = row + 2 * K * width;
      column[sample::force] = contact.force;
      column[sample::nodes] = contact.nodes;
      column[sample::contact_energy] = contact.energy;
      column[sample::damping_loss] = damping_loss;
      column[sample::sliding_work] = s_.sliding_work + contact.sliding_work;
      column[sample::force_work] = s_.force_work + contact.force_work;
      ++s_.sample_count;
      ++s_.next_sample;
    }
    lanes_.sync();
  }

  // ---- sums over the nodes in contact

  /// Their integrals from the beginning of the step to x, by a Gauss rule.
  KOKKOS_FUNCTION void sum_nodes(double x) const {
    const int n = series_.degree();
    for (int e = 0; e < s_.closed_count; ++e) {
      const double *o = series_.overlap(e), *c = series_.climb(e);
      constexpr int packs = (gauss_points + width - 1) / width;
      Real at[packs], over[packs], climb[packs];
      for (int g = 0; g < packs; ++g) {
        at[g] = Real(x) * lanes_.load(t_.gauss + g * width);
        over[g] = Real(o[n]);
        climb[g] = Real(c[n]);
      }
      for (int j = n - 1; j >= 0; --j)
        for (int g = 0; g < packs; ++g) {
          over[g] = multiply_add(over[g], at[g], Real(o[j]));
          climb[g] = multiply_add(climb[g], at[g], Real(c[j]));
        }
      Real sum(0.0), moment(0.0), work(0.0);
      for (int g = 0; g < packs; ++g) {
        const Real weighted = lanes_.load(t_.gauss + gauss_room + g * width) * over[g];
        sum = sum + weighted;
        moment = multiply_add(weighted, at[g], moment);
        work = multiply_add(weighted, climb[g], work);
      }
      double of_sum, of_moment;
      lanes_.sum(sum, moment, of_sum, of_moment);
      const NodeSums sums{x * of_sum, x * of_moment, x * lanes_.sum(work)};
      if (lanes_.leader()) s_.closed_sums[e] = sums;
    }
    lanes_.sync();
  }
  /// Work of the imposed motion, sum_n f_n V (dh_2/dx + du_2/dx) [J].
  KOKKOS_FUNCTION double sliding_work() const {
    double work = 0.0;
    for (int e = 0; e < s_.closed_count; ++e) work += s_.closed_sums[e].work;
    return t_.node_stiffness * work;
  }

  // ---- shocks; on the leader alone

  KOKKOS_FUNCTION void add_shocks(const Place& place, std::int64_t step, std::int64_t ticks,
                                  double end) const {
    const int count = s_.closed_count;
    const double newton_ticks = t_.node_stiffness * series_.scale() / t_.step;
    const double way = t_.advance * (series_.scale() / t_.step);  // chi per x
    for (int e = 0; e < count; ++e) {
      s_.touched[e] = s_.closed[e];
      s_.touched_force[e] = newton_ticks * s_.closed_sums[e].overlap;
    }
    join_shocks(s_, step, step + ticks - 1, place.base + place.theta, count, [&](int e) {
      return Kokkos::fma(s_.touched_force[e], s_.touched[e],
                         newton_ticks * way * s_.closed_sums[e].moment);
    });
    for (int i = 0; i < s_.open_count; ++i) {
      const double peak = highest_force(i, end);
      if (peak > s_.open[i].peak) s_.open[i].peak = peak;
    }
  }

  /// The largest sum of the forces that belong to open shock i, over the step [N]; 0 where it
  /// cannot be more than the peak so far.
  KOKKOS_FUNCTION double highest_force(int i, double end) const {
    const int n = series_.degree();
    const double* sum = nullptr;
    double falling = 0.0, rising = 0.0, most = 0.0;
    int e = 0;
    for (int r = 0; r < s_.run_count; ++r)
      for (; e < s_.closed_count && s_.closed[e] <= s_.runs[r].last; ++e) {
        if (s_.runs[r].shock != i) continue;
        const double* o = series_.overlap(e);
        const Hull& hull = s_.closed_hull[e];
        falling += hull.falling;
        rising += hull.rising;
        most += hull.most;
        if (sum == nullptr) {
          sum = o;
        } else {
          for (int j = 0; j <= n; ++j) s_.scan[j] = sum[j] + o[j];
          sum = s_.scan;
        }
      }
    if (sum == nullptr || t_.node_stiffness * most <= s_.open[i].peak) return 0.0;
    double highest;
    if (rising <= 0.0)
      highest = sum[0];
    else if (falling >= 0.0)
      highest = polynomial(sum, n, end);
    else
      highest = highest_value(sum, n, end);
    return t_.node_stiffness * highest;
  }
};

}  // namespace ra2d
