// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/adaptive/crossing.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/check.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The nodes in contact, in ascending order (CarriedState::contacts): the same from the beginning
/// of a step to its end. At its end some contacts end, and others begin: at nodes that were flagged
/// and searched (kernels/adaptive/overlaps.hpp).
template <class Lanes, int packs>
class Contacts {
 public:
  /// `listed_nodes`: the nodes that Overlaps flags; `onsets`: where their contacts begin;
  /// `bernstein`: work space.
  RA2D_FUNCTION Contacts(const Lanes& lanes, ContactSet& contacts, ContactSpans& spans,
                         const int* listed_nodes, const double* onsets, double* bernstein)
      : lanes_{lanes},
        contacts_{contacts},
        spans_{spans},
        listed_nodes_{listed_nodes},
        onsets_{onsets},
        bernstein_{bernstein} {}

  /// Where the first of these contacts ends, in units of the series; beyond `end` if none does. A
  /// contact ends where its overlap comes to -tolerance. Leaves the hulls of the overlaps up to
  /// `end`.
  RA2D_FUNCTION double first_end(const ModalSeries<Lanes, packs>& series, double end,
                                 double tolerance) const {
    double first = 2.0 * end + 1.0;
    for (int e = 0; e < contacts_.count; ++e) {
      const double* o = series.overlap(e);
      const int n = series.degree();
      const Hull hull = hull_of(lanes_, series.hull_table(), o, n, end, bernstein_);
      double x = 2.0 * end + 1.0;
      if (hull.least <= -0.75 * tolerance)
        x = first_crossing(o, n, -1.0, tolerance, 0.25 * tolerance, end, hull.curvature);
      if (lanes_.leader()) {
        spans_.hulls[e] = hull;
        spans_.ends[e] = x;
      }
      if (x < first) first = x;
    }
    lanes_.sync();
    return first;
  }
  /// Takes out the nodes whose contact has ended by x.
  RA2D_FUNCTION void end(double x) const {
    lanes_.sync();
    if (lanes_.leader()) {
      int kept = 0;
      for (int e = 0; e < contacts_.count; ++e)
        if (!(spans_.ends[e] <= x)) contacts_.nodes[kept++] = contacts_.nodes[e];
      contacts_.count = kept;
    }
    lanes_.sync();
  }

  /// Whether there is memory for the flagged nodes whose contact begins by x. To be called before
  /// anything of the step is kept, so that the step can be repeated with more memory.
  RA2D_FUNCTION bool can_take(int flagged, double x) const {
    int count = contacts_.count;
    for (int e = 0; e < flagged; ++e) count += onsets_[e] <= x ? 1 : 0;
    return count <= spans_.capacity;
  }
  /// Takes in the flagged nodes whose contact begins by x, if they are not in contact already.
  RA2D_FUNCTION void begin(int flagged, double x) const {
    lanes_.sync();
    if (lanes_.leader())
      for (int e = 0; e < flagged; ++e) {
        if (!(onsets_[e] <= x)) continue;
        int i = contacts_.count;
        while (i > 0 && contacts_.nodes[i - 1] > listed_nodes_[e]) --i;
        if (i > 0 && contacts_.nodes[i - 1] == listed_nodes_[e]) continue;
        RA2D_CHECK(contacts_.count < spans_.capacity);
        for (int j = contacts_.count++; j > i; --j) contacts_.nodes[j] = contacts_.nodes[j - 1];
        contacts_.nodes[i] = listed_nodes_[e];
      }
    lanes_.sync();
  }

 private:
  Lanes lanes_;
  ContactSet& contacts_;
  ContactSpans& spans_;
  const int* listed_nodes_;
  const double* onsets_;
  double* bernstein_;
};

}  // namespace ra2d
