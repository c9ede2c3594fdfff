// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/modal_state.hpp"
#include "kernels/candidate_groups.hpp"
#include "kernels/footprint.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Bounds on what an overlap may rise by within a step [m].
struct Rise {
  double any;   // of any node: by all modes and, where they are not followed, by the faces
  double rest;  // the part of it that is not followed for each group
  double end;   // that at the end of the step
};

/// Areal scenes, adaptive scheme: bounds on the overlaps of the candidate groups from one
/// evaluation to the next, and the groups that have to be evaluated for a step.
///
/// Where there is a footprint (kernels/footprint.hpp) most of what changes an overlap is followed
/// for each group: its way over the faces, and the motion of the slider, which is stiff. What the
/// resonator does is small, and one bound for all groups:
///
///   o <= highest + slope theta + sum_k own_shape_k U_k + risen.
///
/// `slope` holds from where the group was evaluated to the end of the spacing (FacesCourse).
/// Without a footprint nothing is followed: slope and own_shape are 0, and a step's rise is all
/// that there can be. Between smooth faces o is the overlap in the cells, but for the modes' part
/// of it (modes_sag).
template <class Lanes, int packs>
class GroupBounds {
  using Real = typename Lanes::Real;
  using Modes = ModalState<Lanes, packs>;
  static constexpr int width = Lanes::width;
  static constexpr int row = packs * width;

 public:
  RA2D_FUNCTION GroupBounds(const Lanes& lanes, const SliderMotion& motion, const FaceTables& faces,
                            const SliderShapes& slider, const MotionLimits& limits,
                            CandidateLists& lists, GroupBuffers& buffers)
      : lanes_{lanes},
        motion_{motion},
        faces_{faces},
        slider_{slider},
        footprint_{lanes, limits},
        lists_{lists},
        buffers_{buffers},
        start_{buffers.sums},
        end_{buffers.sums + 2 * footprint_.sums()} {}

  KOKKOS_FORCEINLINE_FUNCTION const Footprint<Lanes, packs>& footprint() const {
    return footprint_;
  }
  /// Whether the faces and the slider are followed.
  KOKKOS_FORCEINLINE_FUNCTION bool follows() const { return footprint_.exists(); }

  /// Bounds on what the modes raise an overlap by within a step between two states. There must be a
  /// footprint.
  ///
  /// At a place of the resonator the cubic through the displacement and its rate at both ends is
  /// off by `error` at the most, and lies between its Bernstein coefficients. Less that at the
  /// beginning these are 0, h V_0/3, U_1 - U_0 - h V_1/3 and U_1 - U_0. `before` and `after`: the
  /// h of both ends [s], of an even pace the step's length. `travel` is another bound, on all that
  /// the modes do; less what the slider does in the middle of a group it is at most twice that.
  RA2D_FUNCTION Rise rise(const Place& place, const Modes& now, const Modes& end, double before,
                          double after, double error, double travel) {
    find_sums(place, now, end);
    const Real of_now(before / 3.0), of_end(-after / 3.0);
    Real rest[3], own[3];
    for (int i = 0; i < 3; ++i) rest[i] = own[i] = Real(0.0);
    const int terms = footprint_.sums();
    for (int t = 0; t < terms; t += width) {
      const Real first = of_now * lanes_.load(start_ + terms + t),
                 last = lanes_.load(end_ + t) - lanes_.load(start_ + t),
                 second = multiply_add(of_end, lanes_.load(end_ + terms + t), last);
      rest[0] = rest[0] + Kokkos::abs(first);
      rest[1] = rest[1] + Kokkos::abs(second);
      rest[2] = rest[2] + Kokkos::abs(last);
    }
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real first = of_now * now.v[p], last = end.u[p] - now.u[p],
                 second = multiply_add(of_end, end.v[p], last);
      const Real left = footprint_.remainder_in_group(p);
      rest[0] = multiply_add(left, Kokkos::abs(first), rest[0]);
      rest[1] = multiply_add(left, Kokkos::abs(second), rest[1]);
      rest[2] = multiply_add(left, Kokkos::abs(last), rest[2]);
      if (p < first_own_pack()) continue;
      const Real largest = footprint_.remainder(p);
      own[0] = multiply_add(largest, Kokkos::abs(first), own[0]);
      own[1] = multiply_add(largest, Kokkos::abs(second), own[1]);
      own[2] = multiply_add(largest, Kokkos::abs(last), own[2]);
      double* const to = buffers_.own_motion + p * width;
      lanes_.store(to, now.u[p]);
      lanes_.store(to + row, now.u[p] + first);
      lanes_.store(to + 2 * row, now.u[p] + second);
      lanes_.store(to + 3 * row, end.u[p]);
    }
    lanes_.sync();
    double of_rest[3], of_own[3];
    for (int i = 0; i < 3; ++i) lanes_.sum(rest[i], own[i], of_rest[i], of_own[i]);
    const double most_rest = Kokkos::min(2.0 * travel, largest_of(of_rest) + error);
    return {largest_of(of_own) + most_rest, most_rest, Kokkos::min(2.0 * travel, of_rest[2])};
  }
  /// Rise::end of a step between two states. There must be a footprint.
  RA2D_FUNCTION double rise_at_end(const Place& place, const Modes& now, const Modes& end) {
    find_sums(place, now, end);
    Real last[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) last[p] = end.u[p] - now.u[p];
    return footprint_.most_in_group(end_, start_, last);
  }
  /// The sums of the footprint's terms at the beginning of the step.
  KOKKOS_FORCEINLINE_FUNCTION const double* start_sums() const { return start_; }

  /// The most that the followed motion raises the overlaps of a group by within a step of
  /// `distance` [chi], at each of its nodes.
  RA2D_FUNCTION Real followed_rise(const Place& place, int group, double distance) const {
    const StaticOverlap<Lanes> faces(lanes_, faces_, place, group, nodes_beyond(faces_, group));
    double most = 0.0;
    for (int i = 1; i < 4; ++i) {
      double moved = 0.0;
      for (int k = 0; k < slider_.modes; ++k)
        moved += own_shape(group, k) * (own_motion(i, k) - own_motion(0, k));
      most = Kokkos::max(most, moved);
    }
    return FacesCourse<Lanes>(lanes_, faces_, place, group, faces.height, faces.rise)
               .most_risen(distance) +
           Real(most);
  }

  /// For new candidate groups, so many, with CandidateLists::highest and slope at the place and the
  /// displacements at which they were found.
  RA2D_FUNCTION void begin(const Place& place, int count) {
    risen_ = 0.0;
    lanes_.sync();
    if (lanes_.leader())
      for (int e = 0; e < count; ++e) {
        const int group = lists_.groups[e];
        double own = 0.0;
        for (int k = 0; k < slider_.modes; ++k) {
          const double shape = follows() ? own_shape(group, k) : 0.0;
          buffers_.own_shape[k * stride() + e] = shape;
          own += shape * lists_.reference_u[slider_.first_lane + k];
        }
        buffers_.evaluated[e] = -1;
        if (!follows()) lists_.slope[e] = 0.0;
        lists_.highest[e] -= lists_.slope[e] * place.theta + own;
      }
    lanes_.sync();
  }
  /// Forgets all bounds.
  RA2D_FUNCTION void forget(int count) {
    risen_ = 0.0;
    lanes_.sync();
    if (lanes_.leader())
      for (int e = 0; e < count; ++e) {
        buffers_.evaluated[e] = -1;
        lists_.highest[e] = 1e300;
      }
    lanes_.sync();
  }

  /// Selects, of so many groups, those whose overlaps may come to `least` within a step of
  /// `distance` [chi], but for what is not followed.
  RA2D_FUNCTION void select(const Place& place, int groups, double distance, double least) {
    const Real begin(place.theta), end(place.theta + distance);
    int count = 0;
    for (int e = 0; e < groups; e += width) {
      Real own[4] = {Real(0.0), Real(0.0), Real(0.0), Real(0.0)};
      if (follows())
        for (int k = 0; k < slider_.modes; ++k) {
          const Real shape = lanes_.load(buffers_.own_shape + k * stride() + e);
          for (int i = 0; i < 4; ++i) own[i] = multiply_add(own_motion(i, k), shape, own[i]);
        }
      const Real slope = lanes_.load(lists_.slope + e);
      const Real most = lanes_.load(lists_.highest + e) + Kokkos::max(slope * begin, slope * end) +
                        Kokkos::max(Kokkos::max(own[0], own[1]), Kokkos::max(own[2], own[3]));
      std::uint32_t bits = lanes_.at_least(most, least - risen_);
      if (groups - e < width) bits &= (1u << (groups - e)) - 1u;
      for (; bits != 0; bits &= bits - 1, ++count)
        if (lanes_.leader())
          buffers_.selected[count] = e + Kokkos::Experimental::countr_zero_builtin(bits);
    }
    selected_ = count;
    lanes_.sync();
  }
  KOKKOS_FORCEINLINE_FUNCTION int selected() const { return selected_; }
  /// Number of the i-th of them among the candidate groups.
  KOKKOS_FORCEINLINE_FUNCTION int operator[](int i) const { return buffers_.selected[i]; }

  /// Whether a group's overlaps at the beginning of the step are known.
  KOKKOS_FORCEINLINE_FUNCTION bool knows(int e) const { return buffers_.evaluated[e] == steps_; }
  /// Those of the selected ones are known now.
  RA2D_FUNCTION void know_selected() {
    lanes_.sync();
    if (lanes_.leader())
      for (int i = 0; i < selected_; ++i) buffers_.evaluated[buffers_.selected[i]] = steps_;
    lanes_.sync();
  }

  /// On to the next step, after one of so much that is not followed (Rise::end).
  KOKKOS_FORCEINLINE_FUNCTION void end_step(double rise) {
    double* const swap = start_;
    start_ = end_;
    end_ = swap;
    start_place_ = end_place_;
    end_place_ = -1;
    ++steps_;
    risen_ += rise * (1.0 + 0x1p-40);
  }
  /// After end_step(), at the place where the step has ended, and the displacements u: the overlaps
  /// of the selected groups there, of group e from `overlaps` + 2 e packs on.
  RA2D_FUNCTION void take(const Place& end, const Real* u, const double* overlaps) {
    lanes_.sync();
    if (follows())
      for (int p = first_own_pack(); p < filled<packs>(lanes_); ++p)
        lanes_.store(buffers_.own_motion + 3 * row + p * width, u[p]);
    lanes_.sync();
    const double left = rest_of_spacing(end, motion_);
    for (int i = 0; i < selected_; ++i) {
      const int e = buffers_.selected[i];
      const int group = lists_.groups[e];
      Real rise(0.0);
      if (follows())
        rise = StaticOverlap<Lanes>(lanes_, faces_, end, group, nodes_beyond(faces_, group)).rise;
      const FacesCourse<Lanes> course(lanes_, faces_, end, group,
                                      lanes_.load(overlaps + 2 * e * width), rise);
      const double highest = course.highest(lanes_);
      double own = 0.0, slope = 0.0;
      if (follows()) {
        slope = course.slope(lanes_, left);
        for (int k = 0; k < slider_.modes; ++k)
          own += buffers_.own_shape[k * stride() + e] * own_motion(3, k);
      }
      if (!lanes_.leader()) continue;
      lists_.slope[e] = slope;
      lists_.highest[e] = highest - risen_ - (slope * end.theta + own);
      buffers_.evaluated[e] = steps_;
    }
    lanes_.sync();
  }

 private:
  Lanes lanes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  Footprint<Lanes, packs> footprint_;
  CandidateLists& lists_;
  GroupBuffers& buffers_;
  int selected_ = 0;
  double risen_ = 0.0;  // m
  // of the footprint's terms at the beginning and the end of the step: sums of U, then of V
  double *start_, *end_;
  int start_place_ = -1, end_place_ = -1;  // Footprint::place_of; -1: they are not known
  std::int64_t steps_ = 0;

  KOKKOS_FORCEINLINE_FUNCTION static double largest_of(const double (&x)[3]) {
    return Kokkos::max(Kokkos::max(x[0], x[1]), x[2]);
  }
  /// Finds the sums at both ends of a step; those at the beginning, unless they are known.
  RA2D_FUNCTION void find_sums(const Place& place, const Modes& now, const Modes& end) {
    end_place_ = footprint_.place_of(place);
    if (start_place_ != end_place_) {
      const Real* const at[] = {now.u, now.v};
      footprint_.expand(place, at, start_);
      start_place_ = end_place_;
    }
    const Real* const at[] = {end.u, end.v};
    footprint_.expand(place, at, end_);
  }
  KOKKOS_FORCEINLINE_FUNCTION int stride() const { return faces_.groups + width; }
  KOKKOS_FORCEINLINE_FUNCTION int first_own_pack() const { return slider_.first_lane / width; }
  KOKKOS_FORCEINLINE_FUNCTION double own_motion(int i, int k) const {
    return buffers_.own_motion[i * row + slider_.first_lane + k];
  }
  KOKKOS_FORCEINLINE_FUNCTION double own_shape(int group, int k) const {
    return shape_in_group<Lanes, packs>(faces_, slider_, group, k);
  }
};

}  // namespace ra2d
