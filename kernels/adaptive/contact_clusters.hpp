// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/contact/cluster_places.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Nodes in contact that stand close together share their sums over the modes.
///
/// A contact of an areal scene has tens of nodes within a fraction of the modes' shortest wave
/// length. About a place in their midst the shapes of the modes are polynomials in xi and eta, with
/// coefficients Phi_kab (kernels/contact/cluster_places.hpp). The resonator's modes pass a node, xi
/// = xi_0 + advance x; the slope of the slider's goes with xi_0. With the sums over the modes M_ab
/// = sum_k Phi_kab U_k a cluster's nodes have the overlaps
///
///   o_n = face_n + sum_ab P_ab xi_0^a eta^b,
///   P_ab = M_ab + sum_(i>=1) C(a+i, i) (advance x)^i M_(a+i)b
///
/// and their springs drive mode k with -kappa chi w sum_ab Phi_kab R_ab, where
///
///   Q_ab = sum_n xi_0^a eta^b o_n,   R_ab = Q_ab + sum_(i>=1) C(a, i) (advance x)^i Q_(a-i)b.
///
/// All of these are power series in x (kernels/adaptive/series.hpp); a factor x^i is a shift by i
/// orders. So the modes are gone through for each place, not for each node: 6 or 10 terms, and one
/// for the slider. What the polynomials leave out is ClusterTables::remainder.
///
/// Places stand on a lattice of even nodes and even rows. Each is expanded once a window.
template <class Lanes, int packs>
class ContactClusters {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;
  static constexpr int row = packs * width;
  static constexpr int column = cluster_rows * row;

 public:
  RA2D_FUNCTION ContactClusters(const Lanes& lanes, const SliderMotion& motion,
                                const FaceTables& faces, const SliderShapes& slider,
                                const PatchTables& patches, const ContactTables& contact,
                                const ClusterTables& tables, const ContactSet& contacts,
                                Marks& marks, Caches& caches, ClusterBuffers& buffers)
      : lanes_{lanes},
        motion_{motion},
        faces_{faces},
        slider_{slider},
        patches_{patches},
        stiffness_{contact.node_stiffness},
        tables_{tables},
        contacts_{contacts},
        marks_{marks},
        caches_{caches},
        buffers_{buffers} {}

  /// Gathers the nodes in contact, which are not none, into clusters. False where they are better
  /// taken one by one: too few to a cluster, or too many clusters.
  RA2D_FUNCTION bool gather(const Place& place) {
    count_ = 0;
    if (tables_.degree == 0 || !assign()) return false;
    // operations for each pack of modes: a node by itself has 5, with two terms of its shapes
    if (5 * contacts_.count < 2 * (cluster_sums(tables_.degree) + 1) * count_) {
      count_ = 0;
      return false;
    }
    expand_places(place);
    list_members(place);
    return true;
  }
  /// Forgets the clusters.
  KOKKOS_FORCEINLINE_FUNCTION void clear() { count_ = 0; }
  /// Whether the nodes in contact stand in clusters now.
  KOKKOS_FORCEINLINE_FUNCTION bool exist() const { return count_ > 0; }

  /// The overlaps' terms of the orders j and j + 1, from the modes' terms of these, c(0, pack) and
  /// c(-1, pack) (zero beyond the series' last), and with `drives` the forces on the modes, added
  /// to `force`. `advance` [chi per x]. Orders follow one another from 0 on.
  template <int degree, class Terms>
  KOKKOS_FORCEINLINE_FUNCTION void expand(int j, const Terms& c, bool drives, double advance,
                                          Real (&force)[2][packs]) const {
    for (int s = 0; s < count_; ++s) sum_modes<degree>(s, j, c);
    lanes_.sync();
    for (int s = 0; s < count_; ++s)
      for (int q = 0; q < 2; ++q) shift<degree>(s, j + q, advance);
    lanes_.sync();
    for (int s = 0; s < count_; ++s)
      for (int q = 0; q < 2; ++q) overlaps<degree>(s, j + q, drives, advance);
    lanes_.sync();
    if (!drives) return;
    for (int s = 0; s < count_; ++s) add_force<degree>(s, j, advance, force);
  }

  /// Overlaps and sliding rates of the nodes in contact, order by order, to rows of each node: `to`
  /// [node][overlap_terms], then [overlap_terms] of its sliding rate.
  RA2D_FUNCTION void hand_out(int terms, double* to) const {
    if (lanes_.leader())
      for (int g = 0; g < member_packs(); ++g)
        for (int i = 0; i < width; ++i) {
          const int e = buffers_.members[g * width + i];
          if (e < 0) continue;
          double* const over = to + static_cast<std::int64_t>(e) * (2 * overlap_terms);
          const double* const from = term(g, 0) + i;
          for (int j = 0; j < terms; ++j) {
            over[j] = from[2 * j * width];
            over[overlap_terms + j] = from[(2 * j + 1) * width];
          }
        }
    lanes_.sync();
  }

  /// Number of a cluster whose polynomials hold at a node; -1 if none does.
  KOKKOS_FORCEINLINE_FUNCTION int cluster_of(int node) const {
    if (!exist()) return -1;
    const int j = node / slider_.row, i = node - j * slider_.row;
    for (int s = 0; s < count_; ++s)
      if (holds(s, i, j)) return s;
    return -1;
  }
  /// The series of the overlap at a node for which cluster s holds, to `over` [overlap_terms].
  RA2D_FUNCTION void overlap_of(int s, int node, const Place& place, double advance,
                                double* over) const {
    const Member member(*this, s, node, place);
    double power[cluster_rows];
    monomials(member, power);
    constexpr int order_packs = overlap_terms / width;
    const double* const p = polynomial(s);
    for (int g = 0; g < order_packs; ++g) {
      Real sum =
          Real(power[cluster_own]) * lanes_.load(p + cluster_own * overlap_terms + g * width);
      for (int t = cluster_sums(tables_.degree) - 1; t >= 0; --t)
        sum = multiply_add(power[t], lanes_.load(p + t * overlap_terms + g * width), sum);
      lanes_.store(over + g * width, sum);
    }
    lanes_.sync();
    if (lanes_.leader()) {
      over[0] += Kokkos::fma(place.theta, member.rise, member.face);
      over[1] += member.rise * advance;
    }
    lanes_.sync();
  }

  /// Adds to `force` bounds on the second derivative of the modal forces, per x^2, where the
  /// overlaps of the nodes in contact stay within `hulls`.
  RA2D_FUNCTION void add_force_bounds(const Hull* hulls, double advance, Real* force) const {
    for (int s = 0; s < count_; ++s) {
      double size = 0.0, slope = 0.0, curvature = 0.0;
      for (int i = buffers_.first[s] * width; i < buffers_.first[s + 1] * width; ++i) {
        const int e = buffers_.members[i];
        if (e < 0) continue;
        size += Kokkos::max(hulls[e].most, -hulls[e].least);
        slope += Kokkos::max(hulls[e].rising, -hulls[e].falling);
        curvature += hulls[e].curvature;
      }
      const double* const phi = columns(s);
      for (int t = 0; t < cluster_rows; ++t) {
        if (t >= cluster_sums(tables_.degree) && t != cluster_own) continue;
        const int a = t == cluster_own ? 1 : power_along(t), b = power_across(t);
        const auto of = [&](int derivative) {  // of xi^a eta^b, where xi moves by `advance`
          double most = 1.0;
          for (int i = 0; i < derivative; ++i) most *= advance * (a - i);
          for (int i = derivative; i < a; ++i) most *= cluster_reach + 0.5;
          for (int i = 0; i < b; ++i) most *= cluster_reach;
          return a < derivative ? 0.0 : most;
        };
        double share = curvature * of(0);
        if (t != cluster_own) share += 2.0 * slope * of(1) + size * of(2);
        share *= stiffness_;
        for (int p = first_pack(t); p < filled<packs>(lanes_); ++p)
          force[p] = multiply_add(share, Kokkos::abs(lanes_.load(cluster_term<width>(phi, t, p))),
                                  force[p]);
      }
    }
  }

  /// Bound on what the polynomials leave out of a displacement where the modes' sizes are at most
  /// `amplitude` [m].
  RA2D_FUNCTION double left_out(const Real* amplitude) const {
    Real sum(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      sum = multiply_add(load_pack(lanes_, tables_.remainder, p), amplitude[p], sum);
    return lanes_.sum(sum);
  }
  KOKKOS_FORCEINLINE_FUNCTION int degree() const { return tables_.degree; }

 private:
  Lanes lanes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  double stiffness_;
  const ClusterTables& tables_;
  const ContactSet& contacts_;
  Marks& marks_;
  Caches& caches_;
  ClusterBuffers& buffers_;
  int count_ = 0;

  /// The packs of modes that a term has values in begin here: the slider's own come last.
  KOKKOS_FORCEINLINE_FUNCTION int first_pack(int t) const {
    return t == cluster_own ? slider_.first_lane / width : 0;
  }

  // what the buffers hold of cluster s, and of the g-th pack of members
  KOKKOS_FORCEINLINE_FUNCTION const double* columns(int s) const {
    return caches_.columns + static_cast<std::int64_t>(buffers_.column[s]) * column;
  }
  KOKKOS_FORCEINLINE_FUNCTION double* moments(int s, int j) const {
    return buffers_.moments + (s * overlap_terms + j) * cluster_rows;
  }
  KOKKOS_FORCEINLINE_FUNCTION double* forces(int s, int j) const {
    return buffers_.forces + (s * overlap_terms + j) * cluster_rows;
  }
  KOKKOS_FORCEINLINE_FUNCTION double* polynomial(int s) const {
    return buffers_.polynomials + s * (cluster_rows * overlap_terms);
  }
  KOKKOS_FORCEINLINE_FUNCTION double* powers(int g) const {
    return buffers_.powers + static_cast<std::int64_t>(g) * (cluster_rows * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION double* term(int g, int j) const {
    return buffers_.terms + (static_cast<std::int64_t>(g) * overlap_terms + j) * (2 * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION int member_packs() const { return buffers_.first[count_]; }

  KOKKOS_FORCEINLINE_FUNCTION bool holds(int s, int i, int j) const {
    const int along = i - buffers_.node[s], across = j - buffers_.row[s];
    return along >= -cluster_reach && along <= cluster_reach && across >= -cluster_reach &&
           across <= cluster_reach;
  }

  /// A node seen from the place of a cluster.
  struct Member {
    double xi, own, eta;  // `own`: along x, of the slider, which does not pass it
    double face, rise;    // of the rough faces, as NodeContact's

    RA2D_FUNCTION Member(const ContactClusters& of, int s, int node, const Place& place) {
      const int j = node / of.slider_.row, i = node - j * of.slider_.row;
      own = i - of.buffers_.node[s];
      xi = own + place.offset;
      eta = j - of.buffers_.row[s];
      const FaceTables& faces = of.faces_;
      const double* const h2 =
          faces.height2 + (place.base - faces.rows.behind + node + j * faces.rows.excess);
      face = faces.height1[node] + h2[0];
      rise = h2[1] - h2[0];
    }
  };
  KOKKOS_FORCEINLINE_FUNCTION static void monomials(const Member& m, double* power) {
    power[0] = 1.0;
    for (int n = 1; n <= 3; ++n) {
      power[term_of(n, 0)] = power[term_of(n - 1, 0)] * m.xi;
      for (int b = 1; b <= n; ++b) power[term_of(n - b, b)] = power[term_of(n - b, b - 1)] * m.eta;
    }
    power[cluster_own] = m.own;
  }

  /// Each node in contact goes to the first cluster that it is in reach of; where there is none it
  /// begins one, about a place that has the nodes that follow in reach. False: too many clusters.
  RA2D_FUNCTION bool assign() {
    lanes_.sync();
    int count = 0;
    for (int e = 0; e < contacts_.count; ++e) {
      const int node = contacts_.nodes[e], j = node / slider_.row, i = node - j * slider_.row;
      int s = 0;
      while (s < count && !holds(s, i, j)) ++s;
      if (s == most_clusters) return false;
      lanes_.sync();
      if (lanes_.leader()) {
        if (s == count) {
          // the node is the first of its contact's lowest row, of which it may be the middle
          buffers_.node[s] = (i + 1) & ~1;
          buffers_.row[s] = (j + 2) & ~1;
        }
        buffers_.cluster[e] = s;
      }
      if (s == count) ++count;
      lanes_.sync();
    }
    count_ = count;
    return true;
  }

  /// Finds the columns of all clusters' places. They are of one window.
  RA2D_FUNCTION void expand_places(const Place& place) {
    const std::int64_t window = place.window(motion_);
    int used = marks_.places_window == window ? marks_.places_used : 0;
    for (int s = 0; s < count_; ++s) {
      const int id = buffers_.row[s] / 2 * (slider_.row / 2 + 2) + buffers_.node[s] / 2;
      int at = 0;
      while (at < used && marks_.place_id[at] != id) ++at;
      if (at == most_places) {  // full: of this step's clusters alone
        used = 0;
        s = -1;
        lanes_.sync();
        continue;
      }
      if (at == used) {
        lanes_.sync();
        expand_cluster_place<Lanes, packs>(
            lanes_, faces_, slider_, patches_, tables_, place, buffers_.node[s], buffers_.row[s],
            caches_.columns + static_cast<std::int64_t>(at) * column);
        if (lanes_.leader()) marks_.place_id[at] = id;
        ++used;
      }
      if (lanes_.leader()) buffers_.column[s] = at;
      lanes_.sync();
    }
    if (lanes_.leader()) {
      marks_.places_used = used;
      marks_.places_window = window;
    }
    lanes_.sync();
  }
  /// The members of each cluster in packs of their own, and their powers of xi_0 and eta.
  RA2D_FUNCTION void list_members(const Place& place) {
    lanes_.sync();
    if (lanes_.leader()) {
      int g = 0;
      for (int s = 0; s < count_; ++s) {
        buffers_.first[s] = g;
        int filled_lanes = 0;
        for (int e = 0; e < contacts_.count; ++e) {
          if (buffers_.cluster[e] != s) continue;
          if (filled_lanes == width) {
            filled_lanes = 0;
            ++g;
          }
          if (filled_lanes == 0) clear_pack(g);
          const Member member(*this, s, contacts_.nodes[e], place);
          double power[cluster_rows];
          monomials(member, power);
          double* const to = powers(g) + filled_lanes;
          for (int t = 0; t < cluster_rows; ++t) to[t * width] = power[t];
          buffers_.faces[2 * g * width + filled_lanes] =
              Kokkos::fma(place.theta, member.rise, member.face);
          buffers_.faces[(2 * g + 1) * width + filled_lanes] = member.rise;
          buffers_.members[g * width + filled_lanes] = e;
          ++filled_lanes;
        }
        ++g;
      }
      buffers_.first[count_] = g;
      RA2D_CHECK(g <= contacts_.count / width + most_clusters);
    }
    lanes_.sync();
  }
  RA2D_FUNCTION void clear_pack(int g) const {
    for (int i = 0; i < width; ++i) {
      buffers_.members[g * width + i] = -1;
      buffers_.faces[2 * g * width + i] = buffers_.faces[(2 * g + 1) * width + i] = 0.0;
      for (int t = 0; t < cluster_rows; ++t) powers(g)[t * width + i] = 0.0;
    }
  }

  /// M_ab of the orders j and j + 1.
  template <int degree, class Terms>
  KOKKOS_FORCEINLINE_FUNCTION void sum_modes(int s, int j, const Terms& c) const {
    sum_at_cluster_place<degree, 2, Lanes, packs>(
        lanes_, slider_, columns(s), [&](int q, int p) { return c(-q, p); }, moments(s, j));
  }

  /// P_ab of order j.
  template <int degree>
  KOKKOS_FORCEINLINE_FUNCTION void shift(int s, int j, double advance) const {
    if (!lanes_.leader()) return;
    double* const to = polynomial(s) + j;
    for (int b = 0; b <= degree; ++b)
      for (int a = degree - b; a >= 0; --a) {
        double sum = moments(s, j)[term_of(a, b)], factor = 1.0;
        for (int i = 1; a + i + b <= degree && i <= j; ++i) {
          factor *= advance * (a + i) / i;
          sum = Kokkos::fma(factor, moments(s, j - i)[term_of(a + i, b)], sum);
        }
        to[term_of(a, b) * overlap_terms] = sum;
      }
    to[cluster_own * overlap_terms] = moments(s, j)[cluster_own];
  }

  /// Overlaps and sliding rates of order j, and Q_ab.
  template <int degree>
  KOKKOS_FORCEINLINE_FUNCTION void overlaps(int s, int j, bool drives, double advance) const {
    constexpr int sums = cluster_sums(degree);
    const double* const p = polynomial(s) + j;
    Real part[sums + 1];
    for (int t = 0; t <= sums; ++t) part[t] = Real(0.0);
    for (int g = buffers_.first[s]; g < buffers_.first[s + 1]; ++g) {
      const double* const power = powers(g);
      Real over = Real(p[cluster_own * overlap_terms]) * lanes_.load(power + cluster_own * width);
      Real slope(0.0);
      for (int t = sums - 1; t >= 0; --t)
        over = multiply_add(p[t * overlap_terms], lanes_.load(power + t * width), over);
      for (int b = 0; b < degree; ++b)
        for (int a = degree - b; a > 0; --a)
          slope = multiply_add(a * p[term_of(a, b) * overlap_terms],
                               lanes_.load(power + term_of(a - 1, b) * width), slope);
      slope = Real(advance) * slope;
      if (j <= 1) {
        const Real rise = Real(advance) * lanes_.load(buffers_.faces + (2 * g + 1) * width);
        if (j == 0) {
          over = over + lanes_.load(buffers_.faces + 2 * g * width);
          slope = slope + rise;
        } else {
          over = over + rise;
        }
      }
      lanes_.store(term(g, j), over);
      lanes_.store(term(g, j) + width, slope);
      if (!drives) continue;
      for (int t = 0; t < sums; ++t)
        part[t] = multiply_add(lanes_.load(power + t * width), over, part[t]);
      part[sums] = multiply_add(lanes_.load(power + cluster_own * width), over, part[sums]);
    }
    if (!drives) return;
    double q[sums + 2];
    for (int t = 0; t <= sums; t += 2)
      lanes_.sum(part[t], t < sums ? part[t + 1] : Real(0.0), q[t], q[t + 1]);
    if (!lanes_.leader()) return;
    double* const to = forces(s, j);
    for (int t = 0; t < sums; ++t) to[t] = q[t];
    to[cluster_own] = q[sums];
  }

  /// Adds the forces on the modes of the orders j and j + 1.
  template <int degree>
  KOKKOS_FORCEINLINE_FUNCTION void add_force(int s, int first, double advance,
                                             Real (&force)[2][packs]) const {
    double r[2][cluster_sums(degree)], own[2];
    for (int q = 0; q < 2; ++q) {
      const int j = first + q;
      for (int b = 0; b <= degree; ++b)
        for (int a = degree - b; a >= 0; --a) {
          double sum = forces(s, j)[term_of(a, b)], factor = 1.0;
          for (int i = 1; i <= a && i <= j; ++i) {
            factor *= advance * (a - i + 1) / i;
            sum = Kokkos::fma(factor, forces(s, j - i)[term_of(a - i, b)], sum);
          }
          r[q][term_of(a, b)] = -stiffness_ * sum;
        }
      own[q] = -stiffness_ * forces(s, j)[cluster_own];
    }
    add_force_at_cluster_place<degree, 2, Lanes, packs>(lanes_, slider_, columns(s), r, own,
                                                        {force[0], force[1]});
  }
};

}  // namespace ra2d
