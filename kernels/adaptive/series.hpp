// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>
#include <type_traits>

#include "kernels/adaptive/contact_clusters.hpp"
#include "kernels/adaptive/crossing.hpp"
#include "kernels/adaptive/modal_state.hpp"
#include "kernels/adaptive/onsets.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/displacement.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The motion of the modes as a power series in time, while the same nodes are in contact.
///
/// Within a window (kernels/tables.hpp) the faces are linear in time and the modes' shapes at a
/// node cubic, and the penalty force is linear in the overlap. So the coefficients of U_k(x) =
/// sum_j c_kj x^j, x = (t - t_0)/scale, follow from one another without any approximation:
///
///   o_nj = face_nj + sum_{i<=3} sum_k phi_nki c_k(j-i)                        overlap of node n
///   F_kj = load_kj - kappa chi w sum_n sum_{i<=3} phi_nki o_n(j-i)
///   (j + 1)(j + 2) c_k(j+2) = scale^2 (F_kj/m - omega^2 c_kj) - scale 2 zeta omega (j + 1)
///   c_k(j+1)
///
/// The series of every overlap comes with them: where contact begins or ends is a root of a
/// polynomial. All series converge at every x; the last terms kept show how far they may be used.
template <class Lanes, int packs>
class ModalSeries {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;
  static constexpr int row = packs * width;

 public:
  /// Nodes in contact in clusters, where there can be any: areal scenes have many modes.
  static constexpr bool has_clusters = packs > 3;
  struct NoClusters {};
  using Clusters = std::conditional_t<has_clusters, ContactClusters<Lanes, packs>, NoClusters>;

  /// `hulls`: ContactSpans', read by bounds().
  RA2D_FUNCTION ModalSeries(const Lanes& lanes, const ModeTables& modes, const SliderMotion& motion,
                            const ContactTables& contact, const MotionLimits& bounds,
                            const SeriesTables& adaptive, const MovingForces& forces,
                            const NodeContact<Lanes, packs>& node_contact, const Clusters& clusters,
                            const ContactSet& contacts, const StepControl& control,
                            SeriesBuffers& buffers, const Hull* hulls)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        contact_{contact},
        bounds_{bounds},
        adaptive_{adaptive},
        forces_{forces},
        node_contact_{node_contact},
        clusters_{clusters},
        contacts_{contacts},
        control_{control},
        buffers_{buffers},
        hulls_{hulls},
        order_{adaptive.order} {}

  KOKKOS_FORCEINLINE_FUNCTION double scale() const { return scale_; }  // s
  /// Ticks in units of the series.
  KOKKOS_FORCEINLINE_FUNCTION double x_at(std::int64_t ticks) const {
    return static_cast<double>(ticks) * motion_.time_step / scale_;
  }
  /// The first tick that is not before x, but no more than `most`.
  KOKKOS_FORCEINLINE_FUNCTION std::int64_t ticks_to(double x, std::int64_t most) const {
    const auto ticks = static_cast<std::int64_t>(Kokkos::ceil(x * (scale_ / motion_.time_step)));
    return ticks < most ? ticks : most;
  }
  /// Series of the overlap of contact e over x [m], and of its rate per x that is due to the
  /// sliding alone.
  KOKKOS_FORCEINLINE_FUNCTION double* overlap(int e) const {
    return buffers_.nodes + static_cast<std::int64_t>(e) * (2 * overlap_terms);
  }
  KOKKOS_FORCEINLINE_FUNCTION double* sliding_rate(int e) const {
    return overlap(e) + overlap_terms;
  }
  /// Degree of an overlap: that of the modes and three more, from the shapes along the path.
  KOKKOS_FORCEINLINE_FUNCTION int degree() const { return order_ + 3; }
  /// For hulls of overlaps.
  KOKKOS_FORCEINLINE_FUNCTION const double* hull_table() const {
    return adaptive_.hull + (order_ - adaptive_.order) / 2 * hull_length;
  }

  /// The series from (u, v) on, with the same nodes in contact, in units of `scale` [s].
  ///
  /// Of the shapes at a node as many terms are taken as the tolerance asks for: what the others add
  /// to an overlap over the step is `neglected`, a small part of the tolerance times the distance
  /// that the modes make in the same time.
  /// False where areal scenes have no room for the nodes in contact.
  RA2D_FUNCTION bool expand(const Real* u, const Real* v, const Place& place, double scale) {
    scale_ = scale;
    neglected_ = 0.0;
    order_ = adaptive_.order + 2 * control_.raised;
    const int contacts = contacts_.count;
    forget_clusters();
    if constexpr (has_clusters)
      if (contacts > 0 && expand_in_clusters(u, v, place)) return true;
    const double advance = motion_.advance * (scale / motion_.time_step);  // chi per x
    if (contacts > 0 && !node_contact_.expand(place, contacts_.nodes, contacts)) [[unlikely]]
      return false;
    for (int e = 0; e < contacts; ++e)
      place_shape(contacts_.nodes[e], place.offset, advance, buffers_.shapes + e * (4 * row));
    // The modes at the beginning of the step suggest the number of terms. What contact makes of
    // them within the step (of bodies at rest, everything) only the series shows.
    Real amplitude[packs], travel[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      amplitude[p] = Kokkos::abs(u[p]);
      travel[p] = Real(scale) * Kokkos::abs(v[p]);
    }
    int terms = 0;
    while (true) {
      if (contacts > 0) {
        wanted_terms_ = enough_terms(amplitude, travel);
        if (wanted_terms_ <= terms) break;
        // most steps need as many as the one before
        terms = wanted_terms_ < control_.shape_terms ? control_.shape_terms : wanted_terms_;
      }
      if (terms == 4)
        expand_terms<4>(u, v, place);
      else if (terms == 3)
        expand_terms<3>(u, v, place);
      else
        expand_terms<2>(u, v, place);
      if (contacts == 0) return true;
      bound_motion(u, amplitude, travel);
    }
    if (terms == 4) neglected_ = 0.0;
    return true;
  }
  /// Terms of the shapes that would have done.
  KOKKOS_FORCEINLINE_FUNCTION int wanted_terms() const { return wanted_terms_; }
  /// m, of an overlap.
  KOKKOS_FORCEINLINE_FUNCTION double neglected() const { return neglected_; }

  /// How far the series may be used for a local error of `tolerance`, relative, in x: the smaller
  /// of (tolerance |state|/|c_j|)^(1/(j - 1)) for the last two orders j. Their terms stand for the
  /// error: those that follow are smaller by the ratio of neighbours, so the step is on the safe
  /// side. Errors and state are measured in the energy norm, whose square is sum m (V^2 +
  /// omega^2 U^2) and the energy of the springs.
  RA2D_FUNCTION double usable_length(double tolerance) {
    const int order = order_;
    Real state(0.0), acceleration(0.0), before(0.0), last(0.0);
    const double per = 1.0 / scale_;
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real mass = load_pack(lanes_, modes_.mass, p),
                 omega = load_pack(lanes_, modes_.omega, p);
      const auto norm = [&](int j) {
        const Real x = coefficient(j, p), w = omega * x, rate = Real(j * per) * x;
        return mass * multiply_add(rate, rate, w * w);
      };
      state = state + norm(0) + norm(1);
      acceleration = acceleration + norm(2);
      before = before + norm(order - 1);
      last = last + norm(order);
    }
    double sums[4];
    four_sums(lanes_, {state, acceleration, before, last}, sums);
    double size = sums[0];
    for (int e = 0; e < contacts_.count; ++e)
      size += contact_.node_stiffness * overlap(e)[0] * overlap(e)[0];
    if (sums[1] > size) size = sums[1];
    if (size < 1e-300) size = 1e-300;  // motion whose squares underflow is none
    // terms of the shapes were left out for steps of up to two
    const double longest = neglected_ > 0.0 ? 2.0 : longest_usable;
    if (!(size < 1e300)) return -1.0;  // not a number
    double usable = longest;
    RA2D_KEEP_LOOP
    for (int j = order - 1; j <= order; ++j) {
      // squares throughout; a term of V goes with x^(j - 1)
      const double term = j < order ? sums[2] : sums[3];
      if (!(term > 1e-300 * size)) continue;
      const double x =
          Kokkos::exp2(0.5 * Kokkos::log2(tolerance * tolerance * (size / term)) / (j - 1.0));
      if (x < usable) usable = x;
    }
    usable_ = usable;
    return usable;
  }
  /// A step grows by no more than this: terms that happen to vanish say nothing about the next.
  static constexpr double longest_usable = 4.0;

  RA2D_FUNCTION void state(double x, Real* u, Real* v) const {
    const int order = order_;
    const Real at(x), per(1.0 / scale_);
    constexpr int block = has_many_packs<Lanes, packs> ? 4 : packs;
    for_packs<packs, block>(lanes_, [&]<int count>(int first) {
      Real sum[count], rate[count];
      for (int i = 0; i < count; ++i) sum[i] = rate[i] = coefficient(order, first + i);
      for (int i = 0; i < count; ++i) rate[i] = Real(static_cast<double>(order)) * rate[i];
      RA2D_KEEP_LOOP
      for (int j = order - 1; j >= 1; --j)
        for (int i = 0; i < count; ++i) {
          const Real c = coefficient(j, first + i);
          sum[i] = multiply_add(sum[i], at, c);
          rate[i] = multiply_add(rate[i], at, Real(static_cast<double>(j)) * c);
        }
      for (int i = 0; i < count; ++i) {
        u[first + i] = multiply_add(sum[i], at, coefficient(0, first + i));
        v[first + i] = rate[i] * per;
      }
    });
  }

  /// The motion up to x = `most`, as a polynomial.
  KOKKOS_FORCEINLINE_FUNCTION PolynomialMotion<Lanes, packs> motion(double most) const {
    return {buffers_.modes, order_, Pace::even, motion_.advance * (scale_ / motion_.time_step),
            most};
  }

  /// Velocity alone.
  RA2D_FUNCTION void velocity(double x, Real* v) const {
    const Real at(x), per(1.0 / scale_);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      v[p] = Real(static_cast<double>(order_)) * coefficient(order_, p);
      for (int j = order_ - 1; j >= 1; --j)
        v[p] = multiply_add(v[p], at, Real(static_cast<double>(j)) * coefficient(j, p));
      v[p] = v[p] * per;
    }
  }

  /// Bounds on the motion up to x. The norm of y = (omega U, U') does not grow by itself, so that
  /// of y'' is at most what it is at 0 and what the second derivative of the force adds to it:
  ///   |U''''| <= turn (|y''(0)| + x g) + g,  g >= |F''|/m,  turn = omega (zeta + sqrt(1 +
  ///   zeta^2)),
  /// and the lower derivatives follow. (All in units of x.) Needs the hulls of the nodes in contact
  /// over a stretch that reaches at least as far.
  RA2D_FUNCTION MotionBounds bounds(double x) const {
    const Real at(x);
    Real force[packs];  // bound on |F''|
    for (int p = 0; p < filled<packs>(lanes_); ++p) force[p] = Real(0.0);
    add_force_bounds(at, force);
    Real travel(0.0), fourth_derivative(0.0), tail(0.0), size(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real g =
          Real(scale_ * scale_) * load_pack(lanes_, adaptive_.inverse_mass, p) * force[p];
      const Real c0 = Kokkos::abs(coefficient(0, p)), c1 = Kokkos::abs(coefficient(1, p)),
                 c2 = Kokkos::abs(coefficient(2, p)), c3 = coefficient(3, p);
      const Real twist = Real(2.0 * scale_) * load_pack(lanes_, modes_.omega, p) * c2,
                 jerk = Real(6.0) * c3;
      const Real d3 = multiply_add(g, at, Kokkos::sqrt(multiply_add(twist, twist, jerk * jerk)));
      const Real d4 =
          multiply_add(Real(scale_) * load_pack(lanes_, adaptive_.fastest_rate, p), d3, g);
      const Real d2 = multiply_add(d3, at, Real(2.0) * c2);
      const Real d1 = multiply_add(d2, at, c1);
      const Real displacement = at * d1;
      const Real amplitude = c0 + displacement;
      const Real b = Real(scale_) * load_pack(lanes_, adaptive_.passing_rate, p),
                 largest = load_pack(lanes_, bounds_.largest_shape, p);
      // a mode at a node that moves: (d/dx + b)^4
      Real all = multiply_add(b, amplitude, Real(4.0) * d1);
      all = multiply_add(b, all, Real(6.0) * d2);
      all = multiply_add(b, all, Real(4.0) * d3);
      all = multiply_add(b, all, d4);
      travel = multiply_add(largest, displacement, travel);
      fourth_derivative = multiply_add(largest, all, fourth_derivative);
      tail = multiply_add(load_pack(lanes_, bounds_.cubic_remainder, p), amplitude, tail);
      size = multiply_add(largest, amplitude, size);
    }
    const double per2 = 1.0 / (scale_ * scale_);
    double sums[4];
    four_sums(lanes_, {travel, fourth_derivative, tail, size}, sums);
    return {sums[0], per2 * per2 * sums[1], sums[2], sums[3]};
  }

  /// The cluster that finds a node's overlap (kernels/adaptive/contact_clusters.hpp), or -1.
  KOKKOS_FORCEINLINE_FUNCTION int cluster_of([[maybe_unused]] int node) const {
    if constexpr (has_clusters)
      return clusters_.cluster_of(node);
    else
      return -1;
  }
  /// From here on overlaps are found at each node by itself.
  KOKKOS_FORCEINLINE_FUNCTION void forget_clusters() {
    if constexpr (has_clusters) clusters_.clear();
  }
  /// Expands those of the nodes whose overlaps are found by themselves. False where there is no
  /// room for them.
  RA2D_FUNCTION bool expand_nodes(const Place& place, const int* nodes, int count) const {
    if constexpr (has_clusters)
      if (clusters_.exist()) {
        for (int e = 0; e < count; ++e)
          if (cluster_of(nodes[e]) < 0 && !node_contact_.expand(place, nodes + e, 1)) [[unlikely]]
            return false;
        return true;
      }
    return node_contact_.expand(place, nodes, count);
  }
  /// The series of the overlap of any node that has been expanded here, to `c` [overlap_terms].
  RA2D_FUNCTION void overlap_of(int node, const Place& place, double* c) const {
    const double advance = motion_.advance * (scale_ / motion_.time_step);
    if constexpr (has_clusters)
      if (const int s = cluster_of(node); s >= 0) {
        clusters_.overlap_of(s, node, place, advance, c);
        return;
      }
    double* shape = buffers_.one_shape;
    place_shape(node, place.offset, advance, shape);
    const int n = degree();
    for (int j = 0; j <= n; j += 4) {  // by four: each shape that is read serves all
      Real product[4] = {Real(0.0), Real(0.0), Real(0.0), Real(0.0)};
      if (sums_moments()) {
        add_side_by_side(shape, j, product);
      } else {
        for (int i = 0; i <= 3; ++i) {
          const double* terms[4];
          for (int q = 0; q < 4; ++q) terms[q] = row_of(j + q - i);
          for (int p = 0; p < filled<packs>(lanes_); ++p) {
            const Real phi = load_pack(lanes_, shape + i * row, p);
            for (int q = 0; q < 4; ++q)
              product[q] = multiply_add(phi, load_pack(lanes_, terms[q], p), product[q]);
          }
        }
      }
      double sums[4];
      four_sums_in_pairs(lanes_, product, sums);
      if (j == 0) {
        sums[0] += node_contact_.face(node, place.theta);
        sums[1] += node_contact_.rise(node) * advance;
      }
      if (!lanes_.leader()) continue;
      for (int q = 0; q < 4; ++q) c[j + q] = sums[q];
    }
    lanes_.sync();
  }

  /// Whether the integral of V^2 has a series of its own. Steps of raised order turn the fastest
  /// modes by so much that one of as many terms would leave out a part of it, to be seen in the
  /// energy balance: there it is added up piece by piece (add_squares).
  KOKKOS_FORCEINLINE_FUNCTION bool has_series_of_squares() const {
    return order_ == adaptive_.order;
  }
  /// The series of the integral of V^2, in ticks: buffers_.squares, without its factor x.
  RA2D_FUNCTION void expand_squares() const {
    const double ticks =
        1.0 / (scale_ * motion_.time_step);  // of V^2 = (dU/dx)^2/scale^2, scale/tick
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real v[most_order + 1];
      for (int i = 0; i < order_; ++i) v[i] = Real(i + 1.0) * coefficient(i + 1, p);
      v[order_] = Real(0.0);
      for (int n = 0; n < order_; n += 2) {  // by two: each value that is read serves both
        Real even(0.0), odd(0.0);
        for (int i = 0; 2 * i < n; ++i) {
          even = multiply_add(v[i], v[n - i], even);
          odd = multiply_add(v[i], v[n + 1 - i], odd);
        }
        const Real middle = v[n / 2];
        odd = multiply_add(middle, v[n / 2 + 1], odd);
        even = multiply_add(middle, middle, even + even);
        double* to = buffers_.squares + n * row + p * width;
        lanes_.store(to, Real(ticks / (n + 1.0)) * even);
        if (n + 1 < order_) lanes_.store(to + row, Real(ticks / (n + 2.0)) * (odd + odd));
      }
    }
  }
  /// That integral from the beginning of the step to x.
  RA2D_FUNCTION void squares(double x, Real* square) const {
    const Real at(x);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real sum = load_pack(lanes_, buffers_.squares + (order_ - 1) * row, p);
      for (int n = order_ - 2; n >= 0; --n)
        sum = multiply_add(sum, at, load_pack(lanes_, buffers_.squares + n * row, p));
      square[p] = sum * at;
    }
  }
  /// Adds the integral of V^2, in ticks, from x0 to x1, where the velocities are v0 and v1.
  RA2D_FUNCTION void add_squares(double x0, const Real* v0, double x1, const Real* v1,
                                 Real* square) const {
    const double share = (x1 - x0) / usable_;
    if (share <= most_by_five)
      add_squares_by<0>(x0, v0, x1, v1, square);
    else if (share <= most_by_seven)
      add_squares_by<1>(x0, v0, x1, v1, square);
    else
      add_squares_by<2>(x0, v0, x1, v1, square);
  }

 private:
  Lanes lanes_;
  const ModeTables& modes_;
  const SliderMotion& motion_;
  const ContactTables& contact_;
  const MotionLimits& bounds_;
  const SeriesTables& adaptive_;
  const MovingForces& forces_;
  NodeContact<Lanes, packs> node_contact_;
  Clusters clusters_;
  const ContactSet& contacts_;
  const StepControl& control_;
  SeriesBuffers& buffers_;
  const Hull* hulls_;
  int order_;
  double scale_ = 1.0, usable_ = 1.0, neglected_ = 0.0;
  int wanted_terms_ = 2;

  KOKKOS_FORCEINLINE_FUNCTION Real coefficient(int j, int p) const {
    return lanes_.load(buffers_.modes + j * row + p * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION void put(int j, int p, const Real& x) const {
    lanes_.store(buffers_.modes + j * row + p * width, x);
  }

  template <int rule>
  RA2D_FUNCTION void add_squares_by(double x0, const Real* v0, double x1, const Real* v1,
                                    Real* square) const {
    constexpr int inner = lobatto_inner[rule];
    const double* const at = adaptive_.lobatto + rule * lobatto_numbers;
    const double* const weight = at + lobatto_row;
    const double ticks = (x1 - x0) * scale_ / motion_.time_step;
    const double per2 = 1.0 / (scale_ * scale_);  // V^2 = (dU/dx)^2/scale^2
    double x[inner];
    for (int g = 0; g < inner; ++g) x[g] = Kokkos::fma(x1 - x0, at[g], x0);
    constexpr int block = has_many_packs<Lanes, packs> ? 2 : 1;
    for_packs<packs, block>(lanes_, [&]<int count>(int first) {
      Real rate[count][inner];  // dU/dx
      for (int i = 0; i < count; ++i)
        for (int g = 0; g < inner; ++g) rate[i][g] = Real(0.0);
      for (int j = order_; j >= 1; --j)
        for (int i = 0; i < count; ++i) {
          const Real term = Real(static_cast<double>(j)) * coefficient(j, first + i);
          for (int g = 0; g < inner; ++g) rate[i][g] = multiply_add(Real(x[g]), rate[i][g], term);
        }
      for (int i = 0; i < count; ++i) {
        const int p = first + i;
        Real sum = Real(weight[inner]) * multiply_add(v0[p], v0[p], v1[p] * v1[p]);
        for (int g = 0; g < inner; ++g)
          sum = multiply_add(Real(per2 * weight[g]) * rate[i][g], rate[i][g], sum);
        square[p] = multiply_add(Real(ticks), sum, square[p]);
      }
    });
  }

  /// Terms of the shapes that will do for modes that get so far and move so much; sets `neglected`.
  RA2D_FUNCTION int enough_terms(const Real* amplitude, const Real* travel) {
    // (2 b)^2/2 and (2 b)^3/6 of a mode, b its turning over a unit of x, for steps of up to two
    Real second(0.0), third(0.0), displacement(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real b = Real(2.0 * scale_) * load_pack(lanes_, adaptive_.passing_rate, p);
      const Real part = load_pack(lanes_, bounds_.largest_shape, p) * amplitude[p] * (b * b);
      second = multiply_add(Real(0.5), part, second);
      third = multiply_add(Real(1.0 / 6.0), part * b, third);
      displacement =
          multiply_add(load_pack(lanes_, bounds_.largest_shape, p), travel[p], displacement);
    }
    double of_second, of_third;
    lanes_.sum(second, third, of_second, of_third);
    const double bearable = bearable_share * adaptive_.tolerance * lanes_.sum(displacement);
    neglected_ = of_second <= bearable ? of_second : of_third;
    return of_second <= bearable ? 2 : of_third <= bearable ? 3 : 4;
  }

  /// Adds to `force` bounds on |F''| up to x = `at`, of the nodes in contact and the moving forces.
  RA2D_FUNCTION void add_force_bounds(const Real& at, Real* force) const {
    int single_nodes = contacts_.count;
    if constexpr (has_clusters)
      if (clusters_.exist()) {
        clusters_.add_force_bounds(hulls_, motion_.advance * (scale_ / motion_.time_step), force);
        single_nodes = 0;
      }
    for (int e = 0; e < single_nodes; ++e) {
      const Hull& h = hulls_[e];
      const double o0 = Kokkos::max(h.most, -h.least), o1 = Kokkos::max(h.rising, -h.falling);
      const double* phi = buffers_.shapes + e * (4 * row);
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        const Real q1 = Kokkos::abs(load_pack(lanes_, phi + row, p)),
                   q2 = Kokkos::abs(load_pack(lanes_, phi + 2 * row, p)),
                   q3 = Kokkos::abs(load_pack(lanes_, phi + 3 * row, p));
        const Real p2 = multiply_add(Real(6.0) * q3, at, Real(2.0) * q2);
        const Real p1 = multiply_add(p2, at, q1);
        const Real p0 = multiply_add(p1, at, Kokkos::abs(load_pack(lanes_, phi, p)));
        force[p] = multiply_add(contact_.node_stiffness * h.curvature, p0, force[p]);
        force[p] = multiply_add(2.0 * contact_.node_stiffness * o1, p1, force[p]);
        force[p] = multiply_add(contact_.node_stiffness * o0, p2, force[p]);
      }
    }
    if (forces_.count > 0)
      for (int p = 0; p < filled<packs>(lanes_); ++p) {
        Real sum(0.0);
        for (int j = order_; j >= 2; --j)
          sum = multiply_add(
              sum, at,
              Real(j * (j - 1.0)) * Kokkos::abs(load_pack(lanes_, buffers_.forces + j * row, p)));
        force[p] = force[p] + sum;
      }
  }

  /// Contacts whose sums over many packs of modes are found at once: one by itself waits for each
  /// addition.
  static constexpr int at_once = has_many_packs<Lanes, packs> ? 2 : 1;

  /// The modes' terms of the orders j + 1 to j - 3, for the orders j and j + 1 of what follows from
  /// them: of few packs in registers, of many where the series stands.
  class LatestTerms {
   public:
    RA2D_FUNCTION explicit LatestTerms(const ModalSeries& series) : series_{series} { go_to(0); }
    /// Of order j - `before`, from -1 to 3; zero outside the series.
    KOKKOS_FORCEINLINE_FUNCTION Real operator()(int before, int p) const {
      if constexpr (in_registers)
        return kept_[before + 1][p];
      else
        return load_pack(series_.lanes_, rows_[before + 1], p);
    }
    /// Those of the orders j + 2 and j + 3 are known.
    KOKKOS_FORCEINLINE_FUNCTION void take(int p, const Real& even, const Real& odd) {
      if constexpr (in_registers) {
        kept_[4][p] = kept_[2][p];
        kept_[3][p] = kept_[1][p];
        kept_[2][p] = kept_[0][p];
        kept_[1][p] = even;
        kept_[0][p] = odd;
      }
    }
    KOKKOS_FORCEINLINE_FUNCTION void go_to(int j) {
      if constexpr (in_registers) {
        if (j > 0) return;
        for (int p = 0; p < filled<packs>(series_.lanes_); ++p) {
          kept_[0][p] = series_.coefficient(1, p);
          kept_[1][p] = series_.coefficient(0, p);
          kept_[2][p] = kept_[3][p] = kept_[4][p] = Real(0.0);
        }
      } else {
        for (int i = 0; i < 5; ++i) rows_[i] = series_.row_of(j + 1 - i);
      }
    }

   private:
    static constexpr bool in_registers = packs <= 3;
    const ModalSeries& series_;
    Real kept_[5][in_registers ? packs : 1];
    const double* rows_[5];
  };
  /// Areal scenes have so many modes that a sum over them waits for each of its additions, unless
  /// others are found beside it. There the sums of a node's shapes stand side by side. Plane scenes
  /// keep the order of additions, and so the bits, that they have always had.
  KOKKOS_FORCEINLINE_FUNCTION bool sums_moments() const {
    if constexpr (has_clusters)
      return buffers_.moments != nullptr;
    else
      return false;
  }
  /// Adds to product[q] the lanes' parts of the overlap's term of order j + q, from a node's
  /// shapes: one sum for each of these.
  RA2D_FUNCTION void add_side_by_side(const double* shape, int j, Real (&product)[4]) const {
    const double* terms[7];
    for (int i = 0; i < 7; ++i) terms[i] = row_of(j + 3 - i);
    Real part[4][4];
    for (int t = 0; t < 4; ++t)
      for (int q = 0; q < 4; ++q) part[t][q] = Real(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      for (int t = 0; t < 4; ++t) {
        const Real phi = load_pack(lanes_, shape + t * row, p);
        for (int q = 0; q < 4; ++q)
          part[t][q] = multiply_add(phi, load_pack(lanes_, terms[3 - q + t], p), part[t][q]);
      }
    for (int q = 0; q < 4; ++q) product[q] = (part[0][q] + part[1][q]) + (part[2][q] + part[3][q]);
  }
  /// The modes' terms of an order; zeros outside the series.
  KOKKOS_FORCEINLINE_FUNCTION const double* row_of(int order) const {
    return buffers_.modes + (order < 0 || order > order_ ? most_order + 1 : order) * row;
  }

  /// The shapes at `count` contacts from e on, of pack p of the modes.
  template <int terms, int count>
  struct ContactShapes {
    Real phi[count][terms];
    KOKKOS_FORCEINLINE_FUNCTION ContactShapes(const ModalSeries& series, int e, int p) {
      const double* const shapes = series.buffers_.shapes + e * (4 * row);
      for (int i = 0; i < count; ++i)
        for (int t = 0; t < terms; ++t)
          phi[i][t] = load_pack(series.lanes_, shapes + i * (4 * row) + t * row, p);
    }
  };
  /// The lanes' parts of M_t(j) and M_t(j + 1) of contacts.
  template <int terms, int count>
  struct Moments {
    Real of[count][terms][2];
    KOKKOS_FORCEINLINE_FUNCTION Moments() {
      for (int i = 0; i < count; ++i)
        for (int t = 0; t < terms; ++t) of[i][t][0] = of[i][t][1] = Real(0.0);
    }
    KOKKOS_FORCEINLINE_FUNCTION void add(const ContactShapes<terms, count>& at, const Real& even,
                                         const Real& odd) {
      for (int i = 0; i < count; ++i)
        for (int t = 0; t < terms; ++t) {
          of[i][t][0] = multiply_add(at.phi[i][t], even, of[i][t][0]);
          of[i][t][1] = multiply_add(at.phi[i][t], odd, of[i][t][1]);
        }
    }
  };
  /// The springs' terms of contacts that act on the modes' orders j and j + 1.
  template <int terms, int count>
  struct Springs {
    double f[count][terms + 1];  // of the orders j + 1 to j + 1 - terms
    KOKKOS_FORCEINLINE_FUNCTION Springs(const ModalSeries& series, int e, int j,
                                        const double (&sums)[count][4]) {
      const double stiffness = series.contact_.node_stiffness;
      for (int i = 0; i < count; ++i) {
        const double* const o = series.overlap(e + i);
        f[i][0] = -stiffness * sums[i][2];
        f[i][1] = -stiffness * sums[i][0];
        for (int before = 1; before < terms; ++before)
          f[i][before + 1] = j >= before ? -stiffness * o[j - before] : 0.0;
      }
    }
    KOKKOS_FORCEINLINE_FUNCTION void add(const ContactShapes<terms, count>& at, Real& even,
                                         Real& odd) const {
      for (int i = 0; i < count; ++i)
        for (int t = terms - 1; t >= 0; --t) {
          even = multiply_add(f[i][t + 1], at.phi[i][t], even);
          odd = multiply_add(f[i][t], at.phi[i][t], odd);
        }
    }
  };

  /// Terms of the orders j and j + 1 of the overlaps of `count` contacts from e on, and of their
  /// sliding rates. Adds their springs' force on the modes, of these orders.
  template <int terms, int count>
  KOKKOS_FORCEINLINE_FUNCTION void expand_contacts(int e, int j, const Place& place, double advance,
                                                   const LatestTerms& c, Real (&force)[2][packs]) {
    const double* const shapes = buffers_.shapes + e * (4 * row);
    const auto phi = [&](int i, int term, int p) {
      return load_pack(lanes_, shapes + i * (4 * row) + term * row, p);
    };
    const int modal_packs = filled<packs>(lanes_);
    Real product[count][2], second[count][2], third[count][2], rising[count][2];
    for (int i = 0; i < count; ++i)
      for (int q = 0; q < 2; ++q) product[i][q] = second[i][q] = third[i][q] = Real(0.0);
    // the latest orders last: they are those to wait for
    for (int p = 0; p < modal_packs; ++p)
      for (int i = 0; i < count; ++i)
        for (int q = 0; q < 2; ++q) {
          if constexpr (terms > 3) {
            product[i][q] = multiply_add(phi(i, 3, p), c(3 - q, p), product[i][q]);
            third[i][q] = multiply_add(phi(i, 3, p), c(2 - q, p), third[i][q]);
          }
          if constexpr (terms > 2) {
            product[i][q] = multiply_add(phi(i, 2, p), c(2 - q, p), product[i][q]);
            second[i][q] = multiply_add(phi(i, 2, p), c(1 - q, p), second[i][q]);
          }
          product[i][q] = multiply_add(phi(i, 1, p), c(1 - q, p), product[i][q]);
        }
    for (int i = 0; i < count; ++i)
      for (int q = 0; q < 2; ++q) {
        rising[i][q] = Real(2.0) * second[i][q];
        if constexpr (terms > 3) rising[i][q] = multiply_add(Real(3.0), third[i][q], rising[i][q]);
      }
    for (int p = 0; p < modal_packs; ++p)
      for (int i = 0; i < count; ++i)
        for (int q = 0; q < 2; ++q) {
          product[i][q] = multiply_add(phi(i, 0, p), c(-q, p), product[i][q]);
          rising[i][q] = multiply_add(phi(i, 1, p), c(-q, p), rising[i][q]);
        }
    double sums[count][4];
    for (int i = 0; i < count; ++i)
      four_sums_in_pairs(lanes_, {product[i][0], rising[i][0], product[i][1], rising[i][1]},
                         sums[i]);
    keep_overlaps(e, j, place, advance, sums);
    if (j + 2 <= order_) add_contact_forces<terms, count>(e, j, sums, force);
  }
  /// As expand_contacts(), from M_t(j): the sum of the t-th terms of the shapes with the modes'
  /// terms of order j. Each serves four orders: o_j = M_0(j) + M_1(j - 1) + ..., and the sliding
  /// rate is M_1(j) + 2 M_2(j - 1) + ...
  template <int terms, int count>
  KOKKOS_FORCEINLINE_FUNCTION void expand_by_moments(int e, int j, const Place& place,
                                                     double advance, const LatestTerms& c,
                                                     Real (&force)[2][packs]) {
    Moments<terms, count> part;
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      part.add(ContactShapes<terms, count>(*this, e, p), c(0, p), c(-1, p));
    double sums[count][4];
    take_moments<terms, count>(e, j, part, sums);
    keep_overlaps(e, j, place, advance, sums);
    if (j + 2 <= order_) add_contact_forces<terms, count>(e, j, sums, force);
  }
  /// The sums of `count` contacts from e on, of orders j and j + 1, from their moments.
  template <int terms, int count>
  KOKKOS_FORCEINLINE_FUNCTION void take_moments(int e, int j, const Moments<terms, count>& part,
                                                double (&sums)[count][4]) const {
    for (int i = 0; i < count; ++i) {
      double m[terms][5];  // of the orders j + 1 to j - 3
      double* const before = buffers_.moments + (e + i) * moment_numbers;
      for (int t = 0; t < terms; ++t) {
        lanes_.sum(part.of[i][t][0], part.of[i][t][1], m[t][1], m[t][0]);
        for (int b = 0; b < 3; ++b) m[t][2 + b] = j > 0 ? before[3 * t + b] : 0.0;
      }
      for (int q = 0; q < 2; ++q) {
        double over = m[0][1 - q], sliding = 0.0;
        for (int t = 1; t < terms; ++t) {
          over += m[t][1 - q + t];
          sliding = Kokkos::fma(static_cast<double>(t), m[t][t - q], sliding);
        }
        sums[i][2 * q] = over;
        sums[i][2 * q + 1] = sliding;
      }
      lanes_.sync();
      if (lanes_.leader())
        for (int t = 1; t < terms; ++t)
          for (int b = 0; b < 3; ++b) before[3 * t + b] = m[t][b];
    }
  }
  /// Keeps the sums of `count` contacts from e on, with the faces' terms: overlap and sliding rate
  /// of order j, then of j + 1.
  template <int count>
  KOKKOS_FORCEINLINE_FUNCTION void keep_overlaps(int e, int j, const Place& place, double advance,
                                                 double (&sums)[count][4]) const {
    for (int i = 0; i < count; ++i) {
      if (j == 0) {
        const int node = contacts_.nodes[e + i];
        const double rise = node_contact_.rise(node) * advance;
        sums[i][0] += node_contact_.face(node, place.theta);
        sums[i][1] += rise;
        sums[i][2] += rise;
      }
      if (lanes_.leader())
        for (int q = 0; q < 2; ++q) {
          overlap(e + i)[j + q] = sums[i][2 * q];
          sliding_rate(e + i)[j + q] = sums[i][2 * q + 1];
        }
    }
    lanes_.sync();
  }
  /// Adds the springs' force of these contacts, of the orders j and j + 1; `sums` as they were
  /// kept.
  template <int terms, int count>
  KOKKOS_FORCEINLINE_FUNCTION void add_contact_forces(int e, int j, const double (&sums)[count][4],
                                                      Real (&force)[2][packs]) const {
    const Springs<terms, count> springs(*this, e, j, sums);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      springs.add(ContactShapes<terms, count>(*this, e, p), force[0][p], force[1][p]);
  }

  /// As expand(), with the nodes in contact in clusters. False where these would not save anything,
  /// or leave out more than a small part of what the tolerance allows.
  RA2D_FUNCTION bool expand_in_clusters(const Real* u, const Real* v, const Place& place) {
    if (!clusters_.gather(place)) return false;
    Real amplitude[packs], travel[packs];
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      amplitude[p] = Kokkos::abs(u[p]);
      travel[p] = Real(scale_) * Kokkos::abs(v[p]);
    }
    bool is_accurate = leaves_out_little(amplitude, travel);
    if (is_accurate) {
      if (clusters_.degree() == 2)
        expand_terms<2, true>(u, v, place);
      else
        expand_terms<3, true>(u, v, place);
      bound_motion(u, amplitude, travel);
      is_accurate = leaves_out_little(amplitude, travel);
    }
    if (!is_accurate) {
      forget_clusters();
      neglected_ = 0.0;
      return false;
    }
    clusters_.hand_out(degree() + 1, buffers_.nodes);
    wanted_terms_ = control_.shape_terms;
    return true;
  }
  RA2D_FUNCTION bool leaves_out_little(const Real* amplitude, const Real* travel) {
    Real displacement(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      displacement =
          multiply_add(load_pack(lanes_, bounds_.largest_shape, p), travel[p], displacement);
    neglected_ = clusters_.left_out(amplitude);
    return neglected_ <= bearable_share * adaptive_.tolerance * lanes_.sum(displacement);
  }
  /// Of a series: how far the modes get, and how much they move, over steps of up to two. A body at
  /// rest has no lower term than the third where contact begins: its force rises from zero.
  RA2D_FUNCTION void bound_motion(const Real* u, Real* amplitude, Real* travel) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real c1 = Kokkos::abs(coefficient(1, p)), c2 = Kokkos::abs(coefficient(2, p)),
                 c3 = Kokkos::abs(coefficient(3, p));
      amplitude[p] = multiply_add(Real(4.0), c2, multiply_add(Real(2.0), c1, Kokkos::abs(u[p])));
      amplitude[p] = multiply_add(Real(8.0), c3, amplitude[p]);
      travel[p] = c1 + c2;
    }
  }
  /// Bound on what is left out of an overlap, as a share of the tolerance times the modes' way.
  static constexpr double bearable_share = 0.03;

  /// The term of order i + 2 of a mode from those of the orders i, `term`, and i + 1, `next`, and
  /// the force's, f.
  struct Recursion {
    double share, rank;
    KOKKOS_FORCEINLINE_FUNCTION explicit Recursion(int i)
        : share{1.0 / ((i + 1.0) * (i + 2.0))}, rank{i + 1.0} {}
    KOKKOS_FORCEINLINE_FUNCTION Real operator()(const Real& stiff, const Real& decay,
                                                const Real& inverse_mass, const Real& term,
                                                const Real& next, const Real& f) const {
      const Real pulled = multiply_add(stiff, term, Real(rank) * decay * next);
      return Real(share) * multiply_add(inverse_mass, f, Real(-1.0) * pulled);
    }
  };

  /// `terms` of the shapes at a node; of clusters, the degree of their polynomials. By two orders:
  /// the second of them needs nothing of the first but its terms of the modes.
  template <int terms, bool in_clusters = false>
  RA2D_FUNCTION void expand_terms(const Real* u, const Real* v, const Place& place) {
    if constexpr (has_clusters && !in_clusters) {
      if (contacts_.count == 0) return expand_free(u, v);
      if (sums_moments()) {
        if (contacts_.count == 1) return expand_few<terms, 1>(u, v, place);
        if constexpr (at_once == 2)
          if (contacts_.count == 2) return expand_few<terms, 2>(u, v, place);
      }
    }
    const double scale = scale_;
    const int order = order_, contacts = contacts_.count, modal_packs = filled<packs>(lanes_);
    const double advance = motion_.advance * (scale / motion_.time_step);  // chi per x
    Real stiff[packs], decay[packs], inverse_mass[packs];
    for (int p = 0; p < modal_packs; ++p)
      begin_terms(p, u[p], v[p], stiff[p], decay[p], inverse_mass[p]);
    LatestTerms c(*this);
    const int last = contacts > 0 ? degree() : order - 2;
    for (int j = 0; j <= last; j += 2) {
      Real force[2][packs];
      for (int q = 0; q < 2; ++q)
        for (int p = 0; p < filled<packs>(lanes_); ++p) force[q][p] = outer_force(j + q, p);
      if constexpr (in_clusters) {
        clusters_.template expand<terms>(j, c, j + 2 <= order, advance, force);
      } else {
        int e = 0;
        if constexpr (has_clusters)
          if (sums_moments()) {
            for (; e + at_once <= contacts; e += at_once)
              expand_by_moments<terms, at_once>(e, j, place, advance, c, force);
            for (; e < contacts; ++e) expand_by_moments<terms, 1>(e, j, place, advance, c, force);
          }
        if constexpr (at_once > 1)
          for (; e + at_once <= contacts; e += at_once)
            expand_contacts<terms, at_once>(e, j, place, advance, c, force);
        for (; e < contacts; ++e) expand_contacts<terms, 1>(e, j, place, advance, c, force);
      }
      // of order j + 2 and j + 3; what is beyond the last is zero
      const bool has_even = j + 2 <= order, has_odd = j + 3 <= order;
      const Recursion even_of(has_even ? j : 0), odd_of(has_odd ? j + 1 : 0);
      double* const evens = buffers_.modes + (j + 2) * row;
      for (int p = 0; p < modal_packs; ++p) {
        Real even(0.0), odd(0.0);
        if (has_even) {
          even = even_of(stiff[p], decay[p], inverse_mass[p], c(0, p), c(-1, p), force[0][p]);
          lanes_.store(evens + p * width, even);
        }
        if (has_odd) {
          odd = odd_of(stiff[p], decay[p], inverse_mass[p], c(-1, p), even, force[1][p]);
          lanes_.store(evens + row + p * width, odd);
        }
        c.take(p, even, odd);
      }
      c.go_to(j + 2);
    }
  }

  /// As expand_terms(), without contact: each pack goes through all orders by itself.
  RA2D_FUNCTION void expand_free(const Real* u, const Real* v) {
    constexpr int block = has_many_packs<Lanes, packs> ? 4 : packs;
    for_packs<packs, block>(lanes_, [&]<int count>(int first) {
      Real stiff[count], decay[count], inverse_mass[count], now[count], next[count];
      for (int i = 0; i < count; ++i) {
        begin_terms(first + i, u[first + i], v[first + i], stiff[i], decay[i], inverse_mass[i]);
        now[i] = u[first + i];
        next[i] = Real(scale_) * v[first + i];
      }
      for (int j = 0; j + 2 <= order_; ++j) {
        const Recursion term_of(j);
        for (int i = 0; i < count; ++i) {
          const Real term = term_of(stiff[i], decay[i], inverse_mass[i], now[i], next[i],
                                    outer_force(j, first + i));
          put(j + 2, first + i, term);
          now[i] = next[i];
          next[i] = term;
        }
      }
    });
  }
  /// As expand_terms(), of so few contacts that all their moments are in registers: for two orders
  /// one loop over the modes. It gives each pack its force and its next terms, and adds these to
  /// the moments that the following orders begin with.
  template <int terms, int count>
  RA2D_FUNCTION void expand_few(const Real* u, const Real* v, const Place& place) {
    const double scale = scale_;
    const int order = order_, last = degree(), modal_packs = filled<packs>(lanes_);
    const double advance = motion_.advance * (scale / motion_.time_step);  // chi per x
    Real stiff[packs], decay[packs], inverse_mass[packs];
    Moments<terms, count> part;
    for (int p = 0; p < modal_packs; ++p) {
      begin_terms(p, u[p], v[p], stiff[p], decay[p], inverse_mass[p]);
      part.add(ContactShapes<terms, count>(*this, 0, p), u[p], Real(scale) * v[p]);
    }
    for (int j = 0; j <= last; j += 2) {
      double sums[count][4];
      take_moments<terms, count>(0, j, part, sums);
      keep_overlaps(0, j, place, advance, sums);
      part = Moments<terms, count>();
      if (j + 2 > order) continue;
      const bool has_odd = j + 3 <= order;
      const Springs<terms, count> springs(*this, 0, j, sums);
      const Recursion even_of(j), odd_of(has_odd ? j + 1 : 0);
      double* const rows = buffers_.modes + j * row;
      for (int p = 0; p < modal_packs; ++p) {
        const ContactShapes<terms, count> at(*this, 0, p);
        double* const of_pack = rows + p * width;
        Real force[2];
        for (int q = 0; q < 2; ++q) force[q] = outer_force(j + q, p);
        springs.add(at, force[0], force[1]);
        const Real now = lanes_.load(of_pack), next = lanes_.load(of_pack + row);
        const Real even = even_of(stiff[p], decay[p], inverse_mass[p], now, next, force[0]);
        lanes_.store(of_pack + 2 * row, even);
        Real odd(0.0);
        if (has_odd) {
          odd = odd_of(stiff[p], decay[p], inverse_mass[p], next, even, force[1]);
          lanes_.store(of_pack + 3 * row, odd);
        }
        part.add(at, even, odd);
      }
    }
  }
  /// Keeps the first two terms of pack p of the modes, and finds what the others take of it.
  KOKKOS_FORCEINLINE_FUNCTION void begin_terms(int p, const Real& u, const Real& v, Real& stiff,
                                               Real& decay, Real& inverse_mass) const {
    const Real turn = Real(scale_) * load_pack(lanes_, modes_.omega, p);
    put(0, p, u);
    put(1, p, Real(scale_) * v);
    stiff = turn * turn;
    decay = Real(scale_) * load_pack(lanes_, adaptive_.decay, p);
    inverse_mass = Real(scale_ * scale_) * load_pack(lanes_, adaptive_.inverse_mass, p);
  }
  /// The j-th term of load and moving forces.
  KOKKOS_FORCEINLINE_FUNCTION Real outer_force(int j, int p) const {
    Real force = j == 0 ? load_pack(lanes_, modes_.load, p) : Real(0.0);
    if (forces_.count > 0 && j <= order_)
      force = force + load_pack(lanes_, buffers_.forces + j * row, p);
    return force;
  }

  /// An expanded node's shapes about where it stands, the i-th times advance^i.
  KOKKOS_FORCEINLINE_FUNCTION void place_shape(int node, double offset, double advance,
                                               double* shape) const {
    const double* c = node_contact_.expanded(node);
    const Real x(offset);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real c3 = load_pack(lanes_, c + 3 * row, p), c2 = load_pack(lanes_, c + 2 * row, p),
                 c1 = load_pack(lanes_, c + row, p);
      const Real b2 = multiply_add(Real(3.0) * c3, x, c2);
      const Real b1 = multiply_add(multiply_add(Real(3.0) * c3, x, Real(2.0) * c2), x, c1);
      const Real b0 =
          multiply_add(multiply_add(multiply_add(c3, x, c2), x, c1), x, load_pack(lanes_, c, p));
      lanes_.store(shape + p * width, b0);
      lanes_.store(shape + row + p * width, Real(advance) * b1);
      lanes_.store(shape + 2 * row + p * width, Real(advance * advance) * b2);
      lanes_.store(shape + 3 * row + p * width, Real(advance * advance * advance) * c3);
    }
  }
};

}  // namespace ra2d
