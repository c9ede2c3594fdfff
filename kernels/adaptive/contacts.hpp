// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/adaptive/crossing.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/check.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The nodes in contact, in ascending order (CarriedState::closed): the same from the beginning of
/// a step to its end. At its end some let go, and others come in: those that were flagged and
/// searched (kernels/adaptive/overlaps.hpp).
template <class Lanes, int K>
class Contacts {
 public:
  KOKKOS_FUNCTION Contacts(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                           const ModalSeries<Lanes, K>& series)
      : lanes_{lanes}, t_{tables}, s_{state}, series_{series} {}

  /// Where the first of them lets go, in units of the series; beyond `end` if none. To let go, an
  /// overlap must come to -touch. Leaves the hulls of their overlaps up to `end`.
  KOKKOS_FUNCTION double first_to_let_go(double end, double touch) const {
    double first = 2.0 * end + 1.0;
    for (int e = 0; e < s_.closed_count; ++e) {
      const double* o = series_.overlap(e);
      const int n = series_.degree();
      const Hull hull = hull_of(lanes_, t_, o, n, end, s_.hull_room);
      double x = 2.0 * end + 1.0;
      if (hull.least <= -0.75 * touch)
        x = first_crossing(o, n, -1.0, touch, 0.25 * touch, end, hull.curve);
      if (lanes_.leader()) {
        s_.closed_hull[e] = hull;
        s_.closed_roots[e] = x;
      }
      if (x < first) first = x;
    }
    lanes_.sync();
    return first;
  }
  /// Takes out those that have let go by x.
  KOKKOS_FUNCTION void open(double x) const {
    lanes_.sync();
    if (lanes_.leader()) {
      int kept = 0;
      for (int e = 0; e < s_.closed_count; ++e)
        if (!(s_.closed_roots[e] <= x)) s_.closed[kept++] = s_.closed[e];
      s_.closed_count = kept;
    }
    lanes_.sync();
  }

  /// Whether there is room for the flagged nodes that touch by x. Asked before anything of the step
  /// is kept, so that it can be done again once there is.
  KOKKOS_FUNCTION bool have_room(int flagged, double x) const {
    int count = s_.closed_count;
    for (int e = 0; e < flagged; ++e) count += s_.roots[e] <= x ? 1 : 0;
    return count <= s_.closed_capacity;
  }
  /// Takes in the flagged nodes that touch by x.
  KOKKOS_FUNCTION void close(int flagged, double x) const {
    lanes_.sync();
    if (lanes_.leader())
      for (int e = 0; e < flagged; ++e) {
        if (!(s_.roots[e] <= x)) continue;
        RA2D_CHECK(s_.closed_count < s_.closed_capacity);
        int i = s_.closed_count++;
        for (; i > 0 && s_.closed[i - 1] > s_.watch[e]; --i) s_.closed[i] = s_.closed[i - 1];
        s_.closed[i] = s_.watch[e];
      }
    lanes_.sync();
  }

 private:
  const Lanes& lanes_;
  const SceneTables& t_;
  SceneState& s_;
  const ModalSeries<Lanes, K>& series_;
};

}  // namespace ra2d
