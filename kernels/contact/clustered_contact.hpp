// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/contact/cluster_places.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/contact/penalty.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Contact detection and penalty force at listed nodes, as NodeContact; where nodes are fine,
/// squares of `square_nodes` by `square_nodes` of them share their sums over the modes.
///
/// About the middle of a square the modes' shapes are polynomials
/// (kernels/contact/cluster_places.hpp). With M_ab = sum_k Phi_kab U_k the overlap of a node is
///
///   o = face + sum_ab M_ab xi^a eta^b + M_own xi_own,   xi = xi_own + offset of the window,
///
/// and the nodes' forces f drive mode k with -sum_ab Phi_kab R_ab, R_ab = sum f xi^a eta^b (and
/// -Phi_own sum f xi_own). So the modes are gone through twice a square, not twice a node.
///
/// Squares stand where they stand, whatever is in contact, and open nodes add nothing to a sum: a
/// result does not depend on which nodes are listed beside those in contact.
template <class Lanes, int packs>
class ClusteredContact {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;
  static constexpr int row = packs * width, column = cluster_rows * row;
  /// Whether there can be squares: each has room for a group, and modes are many enough for them to
  /// save anything (cluster_degree(), host/device/layout.hpp).
  static constexpr bool fits = width <= square_nodes && packs > 3;

 public:
  RA2D_FUNCTION ClusteredContact(const Lanes& lanes, const SceneTables& tables, SceneState& state,
                                 const NodeContact<Lanes, packs>& single)
      : lanes_{lanes},
        motion_{tables.motion},
        faces_{tables.faces},
        slider_{tables.slider},
        patches_{tables.patches},
        stiffness_{tables.contact.node_stiffness},
        tables_{tables.clusters},
        marks_{state.marks},
        columns_{state.caches.columns},
        contact_list_{state.work.contact_list},
        squares_{state.work.squares},
        single_{single} {}

  /// Prepares the listed nodes (in ascending order) for this window. False where there is no room.
  RA2D_FUNCTION bool expand(const Place& place, const int* nodes, int count) const {
    if constexpr (fits)
      if (tables_.degree > 0) {
        gather(nodes, count);
        expand_places(place);
        return true;
      }
    return single_.expand(place, nodes, count);
  }

  /// Whether what was prepared last serves at this place, too. Squares do at every one up to the
  /// next spacing.
  KOKKOS_FORCEINLINE_FUNCTION bool is_expanded(const Place& place) const {
    return (fits && tables_.degree > 0) || single_.is_expanded(place);
  }

  /// As NodeContact. The listed nodes are those of the latest expand().
  KOKKOS_FORCEINLINE_FUNCTION ContactTotals<Real> operator()(const Place& place, const Real* u,
                                                             const int* nodes, int count,
                                                             Real* force,
                                                             bool recorded = true) const {
    if constexpr (fits) {
      if (tables_.degree == 2) return in_squares<2>(place, u, force, recorded);
      if (tables_.degree == 3) return in_squares<3>(place, u, force, recorded);
    }
    return single_(place, u, nodes, count, force, recorded);
  }
  /// As NodeContact, of a list of single nodes.
  KOKKOS_FORCEINLINE_FUNCTION ContactTotals<Real> unlisted(const Place& place, const Real* u,
                                                           const int* nodes, int count, Real* force,
                                                           std::uint32_t second) const {
    return single_.unlisted(place, u, nodes, count, force, second);
  }

 private:
  Lanes lanes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  double stiffness_;
  const ClusterTables& tables_;
  Marks& marks_;
  double* columns_;
  const ContactList& contact_list_;
  SquareBuffers& squares_;
  NodeContact<Lanes, packs> single_;

  KOKKOS_FORCEINLINE_FUNCTION int squares_in_row() const {
    return (slider_.row + square_nodes - 1) / square_nodes;
  }
  /// Of the place in the middle of a square.
  KOKKOS_FORCEINLINE_FUNCTION int middle_node(int square) const {
    return square % squares_in_row() * square_nodes + square_reach;
  }
  KOKKOS_FORCEINLINE_FUNCTION int middle_row(int square) const {
    return square / squares_in_row() * square_nodes + square_reach;
  }

  /// Lists the groups of the nodes, and their squares.
  RA2D_FUNCTION void gather(const int* nodes, int count) const {
    lanes_.sync();
    if (lanes_.leader()) {
      SquareBuffers& s = squares_;
      s.count = s.groups = 0;
      for (int e = 0; e < count; ++e) {
        const int group = nodes[e] / width, bit = 1 << (nodes[e] - group * width);
        if (s.groups > 0 && s.group[s.groups - 1] == group) {
          s.listed[s.groups - 1] |= bit;
          continue;
        }
        const int first = group * width, j = first / slider_.row, i = first - j * slider_.row;
        const int square = j / square_nodes * squares_in_row() + i / square_nodes;
        // the latest ones first: neighbours stand close together
        int at = s.count - 1;
        while (at >= 0 && s.square[at] != square) --at;
        if (at < 0) {
          at = s.count++;
          s.square[at] = square;
        }
        s.group[s.groups] = group;
        s.listed[s.groups] = bit;
        s.of_group[s.groups] = square;
        ++s.groups;
      }
      sort(s);
    }
    lanes_.sync();
  }
  /// Squares in ascending order: so their forces are added up in one order, whatever is listed.
  RA2D_FUNCTION static void sort(SquareBuffers& s) {
    for (int i = 1; i < s.count; ++i) {
      const int square = s.square[i];
      int at = i;
      for (; at > 0 && s.square[at - 1] > square; --at) s.square[at] = s.square[at - 1];
      s.square[at] = square;
    }
    for (int e = 0; e < s.groups; ++e) {
      int low = 0, high = s.count;  // the square stands from `low` on, before `high`
      while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (s.square[middle] <= s.of_group[e])
          low = middle;
        else
          high = middle;
      }
      s.of_group[e] = low;
    }
  }

  /// Finds the columns of all squares. Those without a place of their own share the last one.
  RA2D_FUNCTION void expand_places(const Place& place) const {
    const std::int64_t window = place.window(motion_);
    int used = marks_.places_window == window ? marks_.places_used : 0;
    if (used + squares_.count >= most_places) used = 0;
    for (int s = 0; s < squares_.count; ++s) {
      const int square = squares_.square[s];
      int at = 0;
      while (at < used && marks_.place_id[at] != square) ++at;
      if (at == used && used < most_places - 1) {
        lanes_.sync();
        expand_in(at, place, square);
        if (lanes_.leader()) marks_.place_id[at] = square;
        ++used;
      }
      if (lanes_.leader()) squares_.column[s] = at;
      lanes_.sync();
    }
    if (lanes_.leader()) {
      marks_.places_used = used;
      marks_.places_window = window;
    }
    lanes_.sync();
  }
  RA2D_FUNCTION void expand_in(int at, const Place& place, int square) const {
    expand_cluster_place<Lanes, packs>(lanes_, faces_, slider_, patches_, tables_, place,
                                       middle_node(square), middle_row(square),
                                       columns_ + static_cast<std::int64_t>(at) * column);
  }
  /// Phi_kab of a square.
  KOKKOS_FORCEINLINE_FUNCTION const double* column_of(int s, const Place& place) const {
    const int at = squares_.column[s];
    if (at == most_places - 1) [[unlikely]] {
      lanes_.sync();
      expand_in(at, place, squares_.square[s]);
      lanes_.sync();
    }
    return columns_ + static_cast<std::int64_t>(at) * column;
  }

  template <int degree>
  RA2D_FUNCTION ContactTotals<Real> in_squares(const Place& place, const Real* u, Real* force,
                                               bool recorded) const {
    for (int s = 0; s < squares_.count; ++s) sum_modes<degree>(s, column_of(s, place), u);
    ContactTotals<Real> totals;
    double deflection_work = 0.0;
    for (int e = 0; e < squares_.groups; ++e)
      take_group<degree>(e, place, recorded, totals, deflection_work);
    if (totals.nodes == 0) return totals;
    totals.deflection_work =
        if_positive(Real(1.0) - lanes_.index(), Real(deflection_work), Real(0.0));
    lanes_.sync();
    for (int s = 0; s < squares_.count; ++s)
      if (squares_.forces[s * cluster_rows] > 0.0) add_force<degree>(s, column_of(s, place), force);
    return totals;
  }

  /// M_ab of a square; its R_ab begin at zero.
  template <int degree>
  KOKKOS_FORCEINLINE_FUNCTION void sum_modes(int s, const double* phi, const Real* u) const {
    sum_at_cluster_place<degree, 1, Lanes, packs>(
        lanes_, slider_, phi, [&](int, int p) { return u[p]; },
        squares_.moments + s * cluster_rows);
    if (!lanes_.leader()) return;
    for (int t = 0; t < cluster_rows; ++t) squares_.forces[s * cluster_rows + t] = 0.0;
  }

  /// The overlaps of a group's nodes, and what those in contact add to totals and R_ab.
  template <int degree>
  KOKKOS_FORCEINLINE_FUNCTION void take_group(int e, const Place& place, bool recorded,
                                              ContactTotals<Real>& totals,
                                              double& deflection_work) const {
    const int group = squares_.group[e], s = squares_.of_group[e];
    const int first = group * width, j = first / slider_.row, i = first - j * slider_.row;
    const int square = squares_.square[s];
    const double eta = j - middle_row(square);
    const double* const m = squares_.moments + s * cluster_rows;
    double c[4] = {};  // of xi^a
    for (int a = 0; a <= degree; ++a) {
      c[a] = m[term_of(a, degree - a)];
      for (int b = degree - a - 1; b >= 0; --b) c[a] = Kokkos::fma(c[a], eta, m[term_of(a, b)]);
    }
    const StaticOverlap<Lanes> faces(lanes_, faces_, place, group, nodes_beyond(faces_, group));
    const Real own = Real(static_cast<double>(i - middle_node(square))) + lanes_.index();
    const Real xi = own + Real(place.offset);
    const Real over = faces.height + multiply_add(m[cluster_own], own, cubic(c, xi));
    std::uint32_t closed =
        lanes_.at_least(over, 0.0) & static_cast<std::uint32_t>(squares_.listed[e]);
    if (closed == 0) return;

    const Penalty penalty{stiffness_};
    double overlap[width], forces[width] = {};
    lanes_.store(overlap, over);
    for (; closed != 0; closed &= closed - 1) {
      const int lane = Kokkos::Experimental::countr_zero_builtin(closed);
      forces[lane] = penalty.force(overlap[lane]);
      RA2D_CHECK(totals.nodes < faces_.nodes);
      if (recorded && lanes_.leader()) {
        contact_list_.nodes[totals.nodes] = first + lane;
        contact_list_.forces[totals.nodes] = forces[lane];
      }
      ++totals.nodes;
    }
    const Real f = lanes_.load(forces);
    double along[4], face_work, none;  // sums of f xi^a
    lanes_.sum(f, f * xi, along[0], along[1]);
    lanes_.sum(f * (xi * xi), f * (xi * (xi * xi)), along[2], along[3]);
    lanes_.sum(f * faces.rise, Real(0.0), face_work, none);
    totals.force += along[0];
    totals.face_work += face_work;
    deflection_work +=
        Kokkos::fma(c[1], along[0], Kokkos::fma(2.0 * c[2], along[1], 3.0 * c[3] * along[2]));
    if (!lanes_.leader()) return;
    double* const to = squares_.forces + s * cluster_rows;
    double across = 1.0;
    for (int b = 0; b <= degree; ++b) {
      for (int a = 0; a + b <= degree; ++a)
        to[term_of(a, b)] = Kokkos::fma(across, along[a], to[term_of(a, b)]);
      across *= eta;
    }
    to[cluster_own] += Kokkos::fma(-place.offset, along[0], along[1]);
  }

  /// Adds the force of a square on the modes.
  template <int degree>
  KOKKOS_FORCEINLINE_FUNCTION void add_force(int s, const double* phi, Real* force) const {
    constexpr int sums = cluster_sums(degree);
    const double* const pressing = squares_.forces + s * cluster_rows;
    double r[1][sums];
    for (int t = 0; t < sums; ++t) r[0][t] = -pressing[t];
    add_force_at_cluster_place<degree, 1, Lanes, packs>(lanes_, slider_, phi, r,
                                                        {-pressing[cluster_own]}, {force});
  }
};

}  // namespace ra2d
