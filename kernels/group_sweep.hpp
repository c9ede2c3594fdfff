// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/displacement.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Overlaps at groups of nodes, one group after the other: -g_n (kernels/gap.hpp, equation 10) is
/// the faces' h_1 - delta + h_2 (StaticOverlap), u_1 from the slider's modes, and u_2 from the
/// cubic of the resonator's displacement on the patch where the group stands. Groups on one patch
/// share the sums over the modes.
template <class Lanes, int packs>
class GroupSweep {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
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
    for (int p = 0; p < packs; ++p) {
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
    const StaticOverlap<Lanes> faces(lanes_, faces_, place_, group);
    return {
        add_slider_displacement(lanes_, slider_, amplitudes_, group, faces.height) + cubic(q_, eta),
        faces.rise};
  }

  struct OverlapAndRates {
    Real overlap;  // m
    Real modes;    // m/s, the modes' rate
    Real slope;    // m per chi of the slider's path
  };
  KOKKOS_FORCEINLINE_FUNCTION OverlapAndRates overlap_and_rates(int group) {
    const Real eta = stand_on_patch(group, true);
    const StaticOverlap<Lanes> faces(lanes_, faces_, place_, group);
    return {
        add_slider_displacement(lanes_, slider_, amplitudes_, group, faces.height) + cubic(q_, eta),
        add_slider_displacement(lanes_, slider_, amplitudes_ + packs * width, group,
                                cubic(rate_q_, eta)),
        faces.rise + Real(patches_.inverse_radius) * cubic_slope(q_, eta)};
  }

 private:
  Lanes lanes_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  const Place& place_;
  const double* amplitudes_;
  const Real *u_, *v_;
  Real lane_eta_;
  int patch_ = -1;
  double q_[4], rate_q_[4];

  /// Finds the cubics of the group's patch, if it is not that of the group before; returns eta.
  KOKKOS_FORCEINLINE_FUNCTION Real stand_on_patch(int group, bool rates) {
    const GroupPlace<Lanes> at(patches_, place_, group);
    if (at.patch != patch_) {
      patch_ = at.patch;
      RA2D_CHECK(patch_ >= 0 && patch_ < patches_.count);
      const double* const rows =
          patches_.derivatives + static_cast<std::int64_t>(patch_) * 4 * packs * width;
      series_coefficients<Lanes, packs>(lanes_, rows, u_, q_);
      if (rates) series_coefficients<Lanes, packs>(lanes_, rows, v_, rate_q_);
    }
    return lane_eta_ + Real(at.eta);
  }
};

}  // namespace ra2d
