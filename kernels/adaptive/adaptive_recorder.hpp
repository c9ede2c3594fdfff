// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/crossing.hpp"
#include "kernels/adaptive/flight.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/moving_force_series.hpp"
#include "kernels/adaptive/pace.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/adaptive/smooth_step.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The record of the motion itself: samples at their own times, sums and shocks integrated over the
/// series. Nothing of it depends on where a launch ends: when the samples of a step do not fit into
/// their buffer, the step is done again in the next launch.
///
/// From a contact force to the energies of the file: the overlaps' series give the forces of a
/// step. add_drive and add_contact integrate their works and impulses into RunningSums and the
/// shocks, write_sample puts the sums and the springs' energy into the columns of a sample; the
/// rest is as with fixed steps (kernels/fixed/fixed_recorder.hpp).
template <class Lanes, int packs>
class AdaptiveRecorder {
  using Real = typename Lanes::Real;
  using Modes = ModalState<Lanes, packs>;
  using Series = ModalSeries<Lanes, packs>;
  static constexpr int width = Lanes::width;

 public:
  RA2D_FUNCTION AdaptiveRecorder(const Lanes& lanes, const ModeTables& modes,
                                 const SliderMotion& motion, const ContactTables& contact,
                                 const SeriesTables& adaptive, const RecordTables& output,
                                 const Flight<Lanes, packs>& flight,
                                 const MovingForceSeries<Lanes, packs>& moving_forces,
                                 CarriedState& carried, ContactList& contact_list, RunBuffer& runs,
                                 ContactSpans& spans, double* polynomial, RecordBuffers& out)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        contact_{contact},
        adaptive_{adaptive},
        output_{output},
        flight_{flight},
        moving_forces_{moving_forces},
        modal_{carried.modal},
        sums_{carried.sums},
        sampling_{carried.sampling},
        shocks_{carried.shocks},
        contacts_{carried.contacts},
        contact_list_{contact_list},
        runs_{runs},
        spans_{spans},
        polynomial_{polynomial},
        samples_{out.samples},
        ended_{out.ended_shocks} {}

  /// The samples within the `ticks` after `tick`, of modes that fly from there. False when the
  /// buffer is full.
  RA2D_FUNCTION bool fly_samples(std::int64_t tick, const Modes& now, std::int64_t ticks) const {
    if (is_complete() || sample_tick() >= tick + ticks) return true;
    // each from the one before, those too that the launch before has written: a flight in one
    // piece and in two has other roundings
    const auto apart = static_cast<std::int64_t>(output_.steps_per_sample);
    std::int64_t at = tick;
    Modes there;
    there.take(lanes_, now);
    for (std::int64_t sample = (tick + apart - 1) / apart * apart; sample < tick + ticks;
         sample += apart) {
      if (is_complete()) break;
      flight_(there.u, there.v, there.square, sample - at);
      at = sample;
      if (sample < sample_tick()) continue;
      if (!can_take_sample()) return false;
      write_sample(there, Contact{});
    }
    return true;
  }

  /// The samples within a step between smooth faces. False when the buffer is full.
  RA2D_FUNCTION bool contact_samples(const SmoothStep<Lanes, packs>& step, std::int64_t tick,
                                     const Modes& now, std::int64_t ticks) const {
    while (is_within(tick, ticks)) {
      if (!can_take_sample()) return false;
      const double x =
          pace_x(step.pace(), static_cast<double>(sample_tick() - tick) / step.ticks());
      const auto weights = step.weights(x);
      Modes there;
      step.state(x, there.u, there.v);
      step.squares(weights, there.square);
      Contact contact = contact_of(step.contact_at(x));
      step.works(weights, contact.sliding_work, contact.force_work);
      add_squares(now, there);
      write_sample(there, contact);
    }
    return true;
  }

  KOKKOS_FORCEINLINE_FUNCTION bool is_complete() const { return sampling_.next >= output_.samples; }
  KOKKOS_FORCEINLINE_FUNCTION bool can_take_sample() const {
    return samples_.count < samples_.capacity;
  }
  /// The sample that falls on the end of the scene, between smooth faces.
  RA2D_FUNCTION void write_last_sample(const ContactTotals<Real>& totals, const Modes& now) const {
    write_sample(now, contact_of(totals));
  }
  /// The sample that falls on the end of the scene, from where no work is done any more. If any
  /// node is in contact, the series are those from there on.
  RA2D_FUNCTION void write_last_sample(const Series& series, const Modes& now) const {
    write_sample(now, springs_at(series, 0.0));
  }

  /// Takes in a flight that begins at `tick`.
  RA2D_FUNCTION void add_flight(std::int64_t tick) const {
    if (lanes_.leader() && shocks_.open_count > 0) end_shocks(shocks_, ended_, tick);
    lanes_.sync();
  }
  /// Takes in the `ticks` after `tick`, up to `end` in units of the series, with their samples; the
  /// nodes in contact are those of the hulls. `there` gets the squares at the end. False when the
  /// buffer of the samples is full.
  RA2D_FUNCTION bool add_drive(const Series& series, const Place& place, std::int64_t tick,
                               const Modes& now, std::int64_t ticks, double end,
                               Modes& there) const {
    if (series.has_series_of_squares()) series.expand_squares();
    const auto apart = static_cast<std::int64_t>(output_.steps_per_sample);
    // those too that the launch before has written: in other pieces squares have other roundings
    std::int64_t sample =
        is_within(tick, ticks) ? (tick + apart - 1) / apart * apart : tick + ticks;
    double last_x = 0.0;
    Modes last;  // at last_x
    last.take(lanes_, now);
    for (;; sample += apart) {
      const bool is_sample = sample < tick + ticks && sample < output_.samples * apart;
      const double x = is_sample ? series.x_at(sample - tick) : end;
      Modes at;
      if (is_sample) [[unlikely]]
        series.state(x, at.u, at.v);
      else
        at.take(lanes_, there);
      if (series.has_series_of_squares()) {
        series.squares(x, at.square);
        add_squares(now, at);
      } else {
        for (int p = 0; p < filled<packs>(lanes_); ++p) at.square[p] = last.square[p];
        series.add_squares(last_x, last.v, x, at.v, at.square);
        last_x = x;
        last.take(lanes_, at);
      }
      if (is_sample && sample < sample_tick()) continue;
      if (is_sample && !can_take_sample()) return false;
      sum_nodes(series, x);
      const double sliding = sliding_work(), moving = moving_forces_.work(series, x);
      if (is_sample) [[unlikely]] {
        Contact contact = springs_at(series, x);
        contact.sliding_work = sliding;
        contact.force_work = moving;
        write_sample(at, contact);
        continue;
      }
      for (int p = 0; p < filled<packs>(lanes_); ++p) there.square[p] = at.square[p];
      if (ticks > 0 && lanes_.leader()) {
        sums_.sliding_work += sliding;
        sums_.force_work += moving;
        add_contacts(series, place, tick, ticks, end);
      }
      return true;
    }
  }

  /// Takes in the works of a step between smooth faces [J], and its time in contact.
  RA2D_FUNCTION void add_contact(double sliding_work, double force_work,
                                 std::int64_t ticks_in_contact, int cells) const {
    if (!lanes_.leader()) return;
    sums_.sliding_work += sliding_work;
    sums_.force_work += force_work;
    sums_.contact_steps += ticks_in_contact;
    if (cells > sums_.most_nodes) sums_.most_nodes = cells;
  }

  /// Sums are kept in two parts, so that many small terms are not added to one large number.
  RA2D_FUNCTION void close_parts(Modes& now) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(modal_.square + p * width,
                   lanes_.load(modal_.square + p * width) + now.square[p]);
      now.square[p] = Real(0.0);
    }
  }

 private:
  Lanes lanes_;
  const ModeTables& modes_;
  const SliderMotion& motion_;
  const ContactTables& contact_;
  const SeriesTables& adaptive_;
  const RecordTables& output_;
  Flight<Lanes, packs> flight_;
  MovingForceSeries<Lanes, packs> moving_forces_;
  CarriedModes& modal_;
  RunningSums& sums_;
  Sampling& sampling_;
  ShockTracking& shocks_;
  const ContactSet& contacts_;
  ContactList& contact_list_;
  RunBuffer& runs_;
  ContactSpans& spans_;
  double* polynomial_;
  SampleBuffer& samples_;
  ShockBuffer& ended_;

  // ---- samples

  KOKKOS_FORCEINLINE_FUNCTION std::int64_t sample_tick() const {
    return sampling_.next * static_cast<std::int64_t>(output_.steps_per_sample);
  }

  /// A sample's contact, and the works since the step began.
  struct Contact {
    double force = 0, energy = 0, sliding_work = 0, force_work = 0;
    int nodes = 0;
  };
  RA2D_FUNCTION static Contact contact_of(const ContactTotals<Real>& totals) {
    Contact contact;
    contact.force = totals.force;
    contact.energy = totals.energy;
    contact.nodes = totals.nodes;
    return contact;
  }

  /// Whether the next sample is within the `ticks` after `tick`.
  KOKKOS_FORCEINLINE_FUNCTION bool is_within(std::int64_t tick, std::int64_t ticks) const {
    return !is_complete() && sample_tick() < tick + ticks;
  }
  /// Adds the squares before a step to those since it began.
  KOKKOS_FORCEINLINE_FUNCTION void add_squares(const Modes& before, Modes& since) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      since.square[p] = before.square[p] + since.square[p];
  }

  /// The contact at x, without the works.
  RA2D_FUNCTION Contact springs_at(const Series& series, double x) const {
    Contact contact;
    for (int e = 0; e < contacts_.count; ++e) {
      const double over = polynomial(series.overlap(e), series.degree(), x);
      contact.force += contact_.node_stiffness * over;
      contact.energy += 0.5 * contact_.node_stiffness * over * over;
    }
    contact.nodes = contacts_.count;
    return contact;
  }

  RA2D_FUNCTION void write_sample(const Modes& at, const Contact& contact) const {
    constexpr int pitch = 2 * packs * width + sample::padded_columns;
    double* const row = samples_.rows + static_cast<std::int64_t>(samples_.count) * pitch;
    Real loss(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(row + p * width, at.u[p]);
      lanes_.store(row + (packs + p) * width, at.v[p]);
      loss = multiply_add(lanes_.load(modes_.damping + p * width),
                          lanes_.load(modal_.square + p * width) + at.square[p], loss);
    }
    const double damping_loss = lanes_.sum(loss);
    lanes_.sync();
    if (lanes_.leader()) {
      double* column = row + 2 * packs * width;
      column[sample::force] = contact.force;
      column[sample::nodes] = contact.nodes;
      column[sample::contact_energy] = contact.energy;
      column[sample::damping_loss] = damping_loss;
      column[sample::sliding_work] = sums_.sliding_work + contact.sliding_work;
      column[sample::force_work] = sums_.force_work + contact.force_work;
      ++samples_.count;
      ++sampling_.next;
    }
    lanes_.sync();
  }

  // ---- sums over the nodes in contact

  /// Their integrals from the beginning of the step to x, by a Gauss rule.
  RA2D_FUNCTION void sum_nodes(const Series& series, double x) const {
    const int n = series.degree();
    for (int e = 0; e < contacts_.count; ++e) {
      const double *o = series.overlap(e), *c = series.sliding_rate(e);
      constexpr int points = (gauss_points + width - 1) / width;  // packs of them
      Real at[points], over[points], rate[points];
      for (int g = 0; g < points; ++g) {
        at[g] = Real(x) * lanes_.load(adaptive_.gauss + g * width);
        over[g] = Real(o[n]);
        rate[g] = Real(c[n]);
      }
      for (int j = n - 1; j >= 0; --j)
        for (int g = 0; g < points; ++g) {
          over[g] = multiply_add(over[g], at[g], Real(o[j]));
          rate[g] = multiply_add(rate[g], at[g], Real(c[j]));
        }
      Real sum(0.0), moment(0.0), work(0.0);
      for (int g = 0; g < points; ++g) {
        const Real weighted = lanes_.load(adaptive_.gauss + gauss_row + g * width) * over[g];
        sum = sum + weighted;
        moment = multiply_add(weighted, at[g], moment);
        work = multiply_add(weighted, rate[g], work);
      }
      double of_sum, of_moment;
      lanes_.sum(sum, moment, of_sum, of_moment);
      const NodeSums sums{x * of_sum, x * of_moment, x * lanes_.sum(work)};
      if (lanes_.leader()) spans_.sums[e] = sums;
    }
    lanes_.sync();
  }
  /// Work of the imposed motion, sum_n f_n V (dh_2/dx + du_2/dx) [J].
  RA2D_FUNCTION double sliding_work() const {
    double work = 0.0;
    RA2D_KEEP_LOOP
    for (int e = 0; e < contacts_.count; ++e) work += spans_.sums[e].work;
    return contact_.node_stiffness * work;
  }

  // ---- shocks; on the leader alone

  /// Takes in the nodes in contact over a step.
  RA2D_FUNCTION void add_contacts(const Series& series, const Place& place, std::int64_t tick,
                                  std::int64_t ticks, double end) const {
    const int count = contacts_.count;
    if (count == 0) {
      if (shocks_.open_count > 0) end_shocks(shocks_, ended_, tick);
      return;
    }
    sums_.contact_steps += ticks;
    if (count > sums_.most_nodes) sums_.most_nodes = count;
    const double newton_ticks = contact_.node_stiffness * series.scale() / motion_.time_step;
    const double advance = motion_.advance * (series.scale() / motion_.time_step);  // chi per x
    RA2D_KEEP_LOOP
    for (int e = 0; e < count; ++e) {
      contact_list_.nodes[e] = contacts_.nodes[e];
      contact_list_.forces[e] = newton_ticks * spans_.sums[e].overlap;
    }
    join_shocks(shocks_, runs_, ended_, contact_list_, count, tick, tick + ticks - 1,
                place.base + place.theta, [&](int e) {
                  return Kokkos::fma(contact_list_.forces[e], along(contact_list_.nodes[e]),
                                     newton_ticks * advance * spans_.sums[e].moment);
                });
    for (int i = 0; i < shocks_.open_count; ++i) {
      const double peak = highest_force(series, i, end);
      if (peak > shocks_.open[i].peak) shocks_.open[i].peak = peak;
    }
  }

  /// A node's number along x.
  KOKKOS_FORCEINLINE_FUNCTION int along(int node) const {
    return runs_.row == 0 ? node : node % runs_.row;
  }

  /// The largest sum of the forces that belong to open shock i, over the step [N]; 0 where it
  /// cannot be more than the peak so far.
  RA2D_FUNCTION double highest_force(const Series& series, int i, double end) const {
    const int n = series.degree();
    const double* sum = nullptr;
    double falling = 0.0, rising = 0.0, most = 0.0;
    int e = 0;
    for (int r = 0; r < shocks_.run_count; ++r)
      for (; e < contacts_.count && contacts_.nodes[e] <= shocks_.runs[r].last; ++e) {
        if (shocks_.runs[r].shock != i) continue;
        const double* o = series.overlap(e);
        const Hull& hull = spans_.hulls[e];
        falling += hull.falling;
        rising += hull.rising;
        most += hull.most;
        if (sum == nullptr) {
          sum = o;
        } else {
          for (int j = 0; j <= n; ++j) polynomial_[j] = sum[j] + o[j];
          sum = polynomial_;
        }
      }
    if (sum == nullptr || contact_.node_stiffness * most <= shocks_.open[i].peak) return 0.0;
    double highest;
    if (rising <= 0.0)
      highest = sum[0];
    else if (falling >= 0.0)
      highest = polynomial(sum, n, end);
    else
      highest = highest_value(sum, n, end);
    return contact_.node_stiffness * highest;
  }
};

}  // namespace ra2d
