// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/displacement.hpp"
#include "kernels/footprint.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Overlaps at groups of nodes, one group after the other: -g_n (kernels/gap.hpp, equation 10) is
/// the faces' h_1 - delta + h_2 (StaticOverlap), u_1 from the slider's modes, and u_2 from the
/// cubic of the resonator's displacement on the patch where the group stands. Groups on one patch
/// of one row share the sums over the modes.
template <class Lanes, int packs>
class GroupSweep {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;
  /// Whether the modes' displacements on a row are read from memory: in a loop that is not unrolled
  /// u and v would leave a GPU's registers.
  static constexpr bool in_memory = Lanes::on_gpu;

 public:
  /// Whether a group's overlaps take sums over the modes, and as many times what it takes to look
  /// at its faces.
  static constexpr bool sums_modes = true;
  static constexpr std::int64_t cost = 4;

  /// At the displacements u and, for their rates, the velocities v. `amplitudes` (two
  /// rows of lanes) holds them one by one, for the slider's modes.
  KOKKOS_FORCEINLINE_FUNCTION GroupSweep(const Lanes& lanes, const FaceTables& faces,
                                         const SliderShapes& slider, const PatchTables& patches,
                                         const Place& place, double* amplitudes, const Real* u,
                                         const Real* v = nullptr)
      : lanes_{lanes},
        faces_{faces},
        slider_{slider},
        patches_{patches},
        place_{place},
        amplitudes_{amplitudes},
        u_{u},
        v_{v},
        lane_eta_{Real(patches.inverse_radius) * lanes.index()} {
    if (faces.rows.across != nullptr) [[unlikely]] {
      stand_on_row(0);
      return;
    }
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      lanes_.store(amplitudes + p * width, u[p]);
      if (v != nullptr) lanes_.store(amplitudes + (packs + p) * width, v[p]);
    }
    lanes_.sync();
  }

  struct Overlap {
    Real overlap;  // m
    Real rise;     // m, of the resonator's face to its next node
  };
  KOKKOS_FORCEINLINE_FUNCTION Overlap overlap(int group) {
    const Real eta = stand_on_patch(group, false);
    const StaticOverlap<Lanes> faces(lanes_, faces_, place_, group, beyond_);
    return {
        add_slider_displacement(lanes_, slider_, amplitudes_, group - first_group_, faces.height) +
            cubic(q_, eta),
        faces.rise};
  }

  struct OverlapAndRates {
    Real overlap;  // m
    Real modes;    // m/s, the modes' rate
    Real slope;    // m per chi of the slider's path
  };
  KOKKOS_FORCEINLINE_FUNCTION OverlapAndRates overlap_and_rates(int group) {
    const Real eta = stand_on_patch(group, true);
    const StaticOverlap<Lanes> faces(lanes_, faces_, place_, group, beyond_);
    const int in_row = group - first_group_;
    return {add_slider_displacement(lanes_, slider_, amplitudes_, in_row, faces.height) +
                cubic(q_, eta),
            add_slider_displacement(lanes_, slider_, amplitudes_ + packs * width, in_row,
                                    cubic(rate_q_, eta)),
            faces.rise + Real(patches_.inverse_radius) * cubic_slope(q_, eta)};
  }

 private:
  Lanes lanes_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  const Place& place_;
  double* amplitudes_;
  const Real *u_, *v_;
  Real lane_eta_;
  int patch_ = -1;
  int first_group_ = 0, beyond_ = 0;  // of the row
  const double* across_ = nullptr;    // the modes' shares on the row
  double q_[4], rate_q_[4];

  /// Finds the cubics of the group's patch, if it is not that of the group before; returns eta.
  KOKKOS_FORCEINLINE_FUNCTION Real stand_on_patch(int group, bool rates) {
    if (static_cast<unsigned>(group - first_group_) >= static_cast<unsigned>(faces_.rows.groups))
        [[unlikely]]
      stand_on_row(group / faces_.rows.groups);
    const GroupPlace<Lanes> at(patches_, place_, group - first_group_);
    if (at.patch != patch_) {
      patch_ = at.patch;
      RA2D_CHECK(patch_ >= 0 && patch_ < patches_.count);
      const double* const rows =
          patches_.derivatives + static_cast<std::int64_t>(patch_) * 4 * packs * width;
      if (faces_.rows.across == nullptr) [[likely]] {
        series_coefficients<Lanes, packs>(lanes_, rows, u_, q_);
        if (rates) series_coefficients<Lanes, packs>(lanes_, rows, v_, rate_q_);
      } else {
        if (rates)
          on_row<true>(rows);
        else
          on_row<false>(rows);
      }
    }
    return lane_eta_ + Real(at.eta);
  }
  /// As series_coefficients, of the displacement and, if asked for, of its rate.
  template <bool rates>
  RA2D_FUNCTION void on_row(const double* rows) {
    Real part[4], rate[4];
    for (int j = 0; j < 4; ++j) part[j] = rate[j] = Real(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real u, v(0.0);
      if constexpr (in_memory) {
        u = lanes_.load(amplitudes_ + p * width);
        if constexpr (rates) v = lanes_.load(amplitudes_ + (packs + p) * width);
      } else {
        const Real share = lanes_.load(across_ + p * width);
        u = share * u_[p];
        if constexpr (rates) v = share * v_[p];
      }
      for (int j = 0; j < 4; ++j) {
        const Real derivative = lanes_.load(rows + (j * packs + p) * width);
        part[j] = multiply_add(derivative, u, part[j]);
        if constexpr (rates) rate[j] = multiply_add(derivative, v, rate[j]);
      }
    }
    add_up(part, q_);
    if constexpr (rates) add_up(rate, rate_q_);
  }
  KOKKOS_FORCEINLINE_FUNCTION void add_up(const Real (&part)[4], double (&q)[4]) const {
    four_sums_in_pairs(lanes_, part, q);
    for (int j = 2; j < 4; ++j) q[j] *= inverse_factorial(j);
  }

  /// Areal scenes: goes on to a row, where every mode has the share `across` of its displacement.
  RA2D_FUNCTION void stand_on_row(int row) {
    first_group_ = row * faces_.rows.groups;
    beyond_ = nodes_beyond(faces_, first_group_);
    patch_ = -1;
    across_ = faces_.rows.across + static_cast<std::int64_t>(row) * packs * width;
    lanes_.sync();
    // else the packs that hold modes of the slider
    const int first = in_memory ? 0 : slider_.first_lane / width;
    for (int p = first; p < filled<packs>(lanes_); ++p) {
      const Real share = lanes_.load(across_ + p * width);
      lanes_.store(amplitudes_ + p * width, share * u_[p]);
      if (v_ != nullptr) lanes_.store(amplitudes_ + (packs + p) * width, share * v_[p]);
    }
    lanes_.sync();
  }
};

/// As GroupSweep::overlap, in areal scenes, by the polynomials of the footprint: off by no more
/// than they leave out (Footprint::left_out), and without sums over the modes.
template <class Lanes, int packs>
class FootprintSweep {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  static constexpr bool sums_modes = false;
  static constexpr std::int64_t cost = 2;

  /// At the displacements u, one by one, with the `terms` of Footprint::expand.
  RA2D_FUNCTION FootprintSweep(const Lanes& lanes, const FaceTables& faces,
                               const SliderShapes& slider, const MotionLimits& limits,
                               const Place& place, const double* terms, const double* u)
      : lanes_{lanes},
        faces_{faces},
        slider_{slider},
        footprint_{lanes, limits},
        place_{place},
        terms_{terms},
        own_{u + slider.first_lane} {
    stand_on_row(0);
  }

  KOKKOS_FORCEINLINE_FUNCTION typename GroupSweep<Lanes, packs>::Overlap overlap(int group) {
    if (static_cast<unsigned>(group - first_group_) >= static_cast<unsigned>(faces_.rows.groups))
      stand_on_row(group / faces_.rows.groups);
    const int first = (group - first_group_) * width;
    const StaticOverlap<Lanes> faces(lanes_, faces_, place_, group, beyond_);
    Real overlap = faces.height + footprint_.displacement(
                                      place_, along_, Real(first + place_.theta) + lanes_.index(),
                                      faces_.rows.nodes);
    const std::int64_t row = slider_.row;
    for (int k = 0; k < slider_.modes; ++k)
      overlap =
          multiply_add(across_[k] * own_[k], lanes_.load(slider_.shape + k * row + first), overlap);
    return {overlap, faces.rise};
  }

 private:
  Lanes lanes_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  Footprint<Lanes, packs> footprint_;
  const Place& place_;
  const double *terms_, *own_;        // own_: displacements of the slider's modes
  int first_group_ = 0, beyond_ = 0;  // of the row
  const double* across_ = nullptr;    // shares of the slider's modes on the row
  double along_[highest_footprint_degree + 1];

  RA2D_FUNCTION void stand_on_row(int row) {
    first_group_ = row * faces_.rows.groups;
    beyond_ = nodes_beyond(faces_, first_group_);
    across_ =
        faces_.rows.across + static_cast<std::int64_t>(row) * packs * width + slider_.first_lane;
    footprint_.take_row(terms_, row, faces_.groups / faces_.rows.groups, along_);
  }
};

}  // namespace ra2d
