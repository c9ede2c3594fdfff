// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/displacement.hpp"
#include "kernels/footprint.hpp"
#include "kernels/function.hpp"
#include "kernels/group_sweep.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Smooth faces: bound on what the overlap in a cell exceeds that at its ends by [m], for both
/// cells beside each node of a group and as long as no node passes another. The faces' part; the
/// modes' is modes_sag, and both add up.
///
/// Let C >= 0 be a bound on -o'' over a cell, o the overlap and eta in units of chi. Then o + C
/// eta^2/2 is convex (o' is continuous at the resonator's node, too), so it lies below its chord:
///
///   o(eta) <= chord(eta) + C/2 (1/4 - eta^2) <= max(o(-1/2), o(1/2)) + C/8.
///
/// A parabola whose ends are equal reaches that. Here -o'' is at most the largest -h_1'' of the
/// cell plus the largest -h_2'' of the pieces that pass it. Between nodes a spline's second
/// derivative is a straight line, so both are largest at nodes. Either may be negative: where one
/// face is hollow the sum is less, and where it is negative the overlap is largest at an end.
template <class Lanes>
KOKKOS_FORCEINLINE_FUNCTION typename Lanes::Real cell_sag(const Lanes& lanes,
                                                          const FaceTables& faces,
                                                          const Place& place, int group) {
  using Real = typename Lanes::Real;
  const int passed = place.base + nodes_beyond(faces, group) + group * Lanes::width;
  return Kokkos::max(
      lanes.load(faces.sag1 + group * Lanes::width) + lanes.load(faces.sag2 + passed), Real(0.0));
}
/// Smooth faces: bound on the faces' overlap in the cells that begin at the nodes of a group, but
/// for the last one's. `ends`: bounds on the overlaps at the nodes, `sag`: cell_sag. On a flank the
/// overlap hardly exceeds the higher end. With d = o(1/2) - o(-1/2), what cell_sag is derived from
/// is largest at eta = d/C, if that is in the cell:
///
///   max(o(-1/2), o(1/2)) + C/8 (1 - 2 |d|/C)^2,   and without the second term if |d| > C/2.
///
/// It grows with each end and with C, so bounds on the three will do.
template <class Lanes>
KOKKOS_FORCEINLINE_FUNCTION typename Lanes::Real most_in_cells(const Lanes& lanes,
                                                               const typename Lanes::Real& ends,
                                                               const typename Lanes::Real& sag) {
  using Real = typename Lanes::Real;
  const Real other = lanes.next(ends), least = Kokkos::min(sag, lanes.next(sag));
  const Real hidden = Kokkos::max(multiply_add(4.0, least, -Kokkos::abs(ends - other)), Real(0.0));
  return Kokkos::max(ends, other) + hidden * hidden / multiply_add(16.0, least, Real(1e-300));
}

/// Smooth faces: calls list(cell) for cells beside the nodes of a group, in ascending order: those
/// between two of its nodes whose bits are set in `inside`, and those at its borders whose node has
/// its bit set in `ends`. Some do not exist (is_cell), and one at the border of two groups may come
/// twice.
template <int width, class List>
KOKKOS_FORCEINLINE_FUNCTION void list_cells_of(const FaceTables& faces, int group,
                                               std::uint32_t inside, std::uint32_t ends,
                                               const List& list) {
  constexpr std::uint32_t last = 1u << (width - 1);
  const int first = group * width, left = nodes_left(faces, group, width) - 1;
  std::uint32_t bits = (inside & (last - 1)) | (ends & last);
  if (left < width) bits &= left > 0 ? (1u << left) - 1u : 0u;
  // from the cell before the first node on
  for (std::uint64_t cells = std::uint64_t{bits} << 1 | (ends & 1u); cells != 0; cells &= cells - 1)
    list(first - 1 + Kokkos::Experimental::countr_zero_builtin(cells));
}

/// The modes' part of cell_sag, at displacements that are at most `travel` [m] away from u.
template <class Lanes, int packs>
KOKKOS_FORCEINLINE_FUNCTION double modes_sag(const Lanes& lanes, const FaceTables& faces,
                                             const MotionLimits& bounds,
                                             const typename Lanes::Real* u, double travel) {
  return weighted_sum<Lanes, packs>(lanes, bounds.cell_sag, u) + faces.sag_per_travel * travel;
}

/// Smooth faces: the resonator's piece under the nodes of a group.
template <class Lanes>
struct PiecePassed {
  using Real = typename Lanes::Real;
  Real left, right;  // h_2'' chi^2 at its ends, between which it is a straight line

  KOKKOS_FORCEINLINE_FUNCTION PiecePassed(const Lanes& lanes, const FaceTables& faces,
                                          const Place& place, int group) {
    const double* curvature =
        faces.curvature2 + place.base + nodes_beyond(faces, group) + group * Lanes::width;
    left = lanes.load(curvature);
    right = lanes.load(curvature + 1);
  }
  /// Bound on what the face rises by up to the piece's end, `distance` [chi] from where the slope
  /// is `slope`: to its end, or up to distance^2/8 C more in between (cell_sag).
  KOKKOS_FORCEINLINE_FUNCTION Real rise(double distance, const Real& slope) const {
    const Real here = multiply_add(distance, left - right, right), zero(0.0);
    const Real to_end = Real(distance) * multiply_add(distance / 6.0, here + here + right, slope);
    return multiply_add(0.125 * distance * distance, Kokkos::max(Kokkos::max(-left, -right), zero),
                        Kokkos::max(to_end, zero));
  }
  /// Bound on the curvature that lifts a node off its straight path.
  KOKKOS_FORCEINLINE_FUNCTION Real upward() const {
    return Kokkos::max(Kokkos::max(left, right), Real(0.0));
  }
};

/// Bounds on the overlaps at the nodes of a group and in the cells beside these, as the nodes go on
/// over the faces up to the end of a spacing.
template <class Lanes>
class FacesCourse {
  using Real = typename Lanes::Real;

 public:
  /// `overlap` at the nodes, `rise`: the slope of the resonator's face there (StaticOverlap).
  KOKKOS_FORCEINLINE_FUNCTION FacesCourse(const Lanes& lanes, const FaceTables& faces,
                                          const Place& place, int group, const Real& overlap,
                                          const Real& rise)
      : overlap_{overlap}, rise_{rise}, upward_{Real(0.0)} {
    if (!faces.smooth) [[likely]]
      return;
    overlap_ = overlap_ + cell_sag(lanes, faces, place, group);
    upward_ = PiecePassed<Lanes>(lanes, faces, place, group).upward();
  }
  /// The most that they are now.
  KOKKOS_FORCEINLINE_FUNCTION double highest(const Lanes& lanes) const {
    return lanes.max(overlap_);
  }
  /// The most that this rises by, per chi, on the next `distance` [chi]. Each node's course lies
  /// below a straight line, or a parabola that is open upward. The largest of them is convex, so it
  /// lies below its chord.
  KOKKOS_FORCEINLINE_FUNCTION double slope(const Lanes& lanes, double distance) const {
    const Real there = multiply_add(distance, risen(distance), overlap_);
    return (lanes.max(there) - highest(lanes)) / distance;
  }
  /// The most that each rises by within the next `distance` [chi].
  KOKKOS_FORCEINLINE_FUNCTION Real most_risen(double distance) const {
    return Kokkos::max(Real(distance) * risen(distance), Real(0.0));
  }

 private:
  Real overlap_, rise_, upward_;

  /// Over a distance, per chi.
  KOKKOS_FORCEINLINE_FUNCTION Real risen(double distance) const {
    return multiply_add(0.5 * distance, upward_, rise_);
  }
};

/// The groups of nodes that can come into contact while no node passes another and U - U^ref raises
/// no overlap by more than `range` (kernels/footprint.hpp): all that a search for contact has to
/// evaluate. U^ref are the modal displacements at which the list was made.
///
/// Found in two passes. The first, coarse, takes for each node the highest point of the resonator's
/// face over the next `width` spacings of the slider's path, and holds for as long. The second
/// evaluates those of its groups that the modes can have brought close since, and holds until a
/// node passes another. Neither leaves out a node that could come into contact, so the lists set
/// the cost, never the answer.
///
/// Areal scenes have millions of nodes, too many to look at one by one: there the coarse pass
/// begins with tiles (TileTables). The highest points of both faces in a tile, and what the modes
/// move its middle by and differ by across it, bound the overlaps of all its nodes. It takes long,
/// so it is to hold for long. The fine pass needs no sums over the modes at each group: it takes
/// the polynomials of the footprint (FootprintSweep). Without them it leaves out before those sums
/// the groups that the faces as they stand, the tile's displacement when the list was made, and
/// bounds on what has moved since keep from contact.
template <class Lanes, int packs>
class CandidateGroups {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  /// `amplitudes`: work space; `evaluated` counts the nodes whose gap was evaluated.
  RA2D_FUNCTION CandidateGroups(const Lanes& lanes, const SliderMotion& motion,
                                const FaceTables& faces, const SliderShapes& slider,
                                const PatchTables& patches, const MotionLimits& bounds,
                                CandidateLists& lists, double* amplitudes, std::int64_t& evaluated)
      : lanes_{lanes},
        motion_{motion},
        faces_{faces},
        slider_{slider},
        patches_{patches},
        bounds_{bounds},
        lists_{lists},
        amplitudes_{amplitudes},
        evaluated_{evaluated} {}

  KOKKOS_FORCEINLINE_FUNCTION int count() const { return count_; }
  KOKKOS_FORCEINLINE_FUNCTION int operator[](int e) const { return lists_.groups[e]; }
  /// How far the modes have travelled since the list was made (moved) [m]; 1e300 in another
  /// spacing.
  RA2D_FUNCTION double travelled(const Real* u, const Place& place) const {
    return place.base == base_ ? moved(lists_.reference_u, u, place) : 1e300;
  }
  /// How far they may [m].
  KOKKOS_FORCEINLINE_FUNCTION double range() const { return range_; }
  /// Whether the list holds for all states within `travel` [m] of one that has travelled so far.
  KOKKOS_FORCEINLINE_FUNCTION bool holds(const Place& place, double travelled,
                                         double travel) const {
    return place.base == base_ && travelled + travel <= range_;
  }
  RA2D_FUNCTION bool holds(const Real* u, const Place& place, double travel) const {
    return holds(place, travelled(u, place), travel);
  }
  /// As above, of displacements u whose sums of the footprint's terms are given.
  RA2D_FUNCTION bool holds(const Real* u, const double* sums, const Place& place,
                           double travel) const {
    if (place.base != base_) return false;
    Real away[packs];
    away_from(lists_.reference_u, u, away);
    const double gone = faces_.smooth ? footprint().most(sums, lists_.footprint, away)
                                      : footprint().most_raised(sums, lists_.footprint, away);
    return holds(place, gone, travel);
  }
  /// Finds them anew about u, to hold for a travel of `range` [m]. `rounding` bounds the rounding
  /// of a displacement; `back` [chi] is how far back on the slider's path the list must hold.
  RA2D_FUNCTION void find(const Real* u, const Place& place, double range, double rounding,
                          double back) {
    base_ = place.base;
    range_ = range < 1e300 ? range : 1e300;  // not a number, too: then all groups are listed
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      lanes_.store(lists_.reference_u + p * width, u[p]);
      lanes_.store(amplitudes_ + p * width, u[p]);
    }
    lanes_.sync();
    const double to_end = place.base + 1 - place.position;  // until a node passes another, chi
    const double distance = Kokkos::max(to_end, back);
    const double slope = weighted_sum<Lanes, packs>(lanes_, bounds_.largest_slope, u);
    double error = faces_.rounding + rounding +
                   weighted_sum<Lanes, packs>(lanes_, bounds_.cubic_remainder, u) +
                   distance * motion_.spacing * slope +
                   position_rounding(place) * faces_.steepest_rise;
    if (faces_.smooth) [[unlikely]]
      error += modes_sag<Lanes, packs>(lanes_, faces_, bounds_, u, range_) +
               0.5 * back * back * faces_.largest_face_curvature;
    const double below = range_ + error;
    const bool by_footprint = footprint().exists();
    const Real* const one[] = {u};
    if (by_footprint) footprint().expand(place, one, lists_.footprint);
    // with the motion since then, raised by the roundings of both displacements
    const double gone = moved(lists_.coarse_reference_u, u, place);
    double coarse_below = gone + 0x1p-43 * Kokkos::abs(gone) + below + error;
    // On maps a list that still holds is made anew once going through it in vain has cost more than
    // making it.
    if (!(place.base >= coarse_base_ && place.base < coarse_base_ + width &&
          coarse_below <= coarse_below_ && in_vain_ <= coarse_work_)) {
      coarse_base_ = place.base;
      // On maps a longer list costs more than it saves: to look at a group is to wait for memory.
      coarse_below_ = (faces_.rows.across == nullptr ? 4.0 : 3.0) * below;
      coarse_work_ = in_vain_ = 0;
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        lanes_.store(lists_.coarse_reference_u + p * width, u[p]);
      if (faces_.rows.across == nullptr) [[likely]]
        find_coarse(u, place, slope);
      else
        find_coarse_on_rows(u, place);
      coarse_below = below + error;
    }
    using Polynomials = FootprintSweep<Lanes, packs>;
    using Sums = GroupSweep<Lanes, packs>;
    if (!faces_.smooth) [[likely]] {
      if (by_footprint)
        find_fine<false, Polynomials>(u, place, below, coarse_below, to_end, back);
      else
        find_fine<false, Sums>(u, place, below, coarse_below, to_end, back);
    } else if (by_footprint) {
      find_fine<true, Polynomials>(u, place, below, coarse_below, to_end, back);
    } else {
      find_fine<true, Sums>(u, place, below, coarse_below, to_end, back);
    }
  }

 private:
  Lanes lanes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  const MotionLimits& bounds_;
  CandidateLists& lists_;
  double* amplitudes_;
  std::int64_t& evaluated_;
  int count_ = 0, base_ = -1;
  double range_ = -1.0;
  // of the coarse pass
  int coarse_count_ = 0, coarse_base_ = -2 * width;
  double coarse_below_ = -1.0;
  // areal scenes, as numbers of groups: what it took to make the list, and what it has since taken
  // to look at those of its groups that were left out
  std::int64_t coarse_work_ = 0, in_vain_ = 0;

  KOKKOS_FORCEINLINE_FUNCTION const double* rows(int patch) const {
    return patches_.derivatives + static_cast<std::int64_t>(patch) * 4 * packs * width;
  }
  /// How far the modes have moved any node towards contact since a list was made at the
  /// displacements `from` [m]. Between smooth faces how far at all: what they add to the overlap
  /// in a cell (modes_sag) counts, too.
  KOKKOS_FORCEINLINE_FUNCTION double moved(const double* from, const Real* u,
                                           const Place& place) const {
    Real away[packs];
    away_from(from, u, away);
    return faces_.smooth ? footprint().most(place, away) : footprint().most_raised(place, away);
  }
  KOKKOS_FORCEINLINE_FUNCTION void away_from(const double* from, const Real* u, Real* away) const {
    for (int p = 0; p < filled<packs>(lanes_); ++p) away[p] = u[p] - lanes_.load(from + p * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION Footprint<Lanes, packs> footprint() const {
    return {lanes_, bounds_};
  }
  /// Of the overlaps at the displacements u, by sums over the modes or by the footprint.
  template <class Sweep>
  KOKKOS_FORCEINLINE_FUNCTION Sweep sweep_at(const Real* u, const Place& place) const {
    if constexpr (Sweep::sums_modes)
      return {lanes_, faces_, slider_, patches_, place, amplitudes_, u};
    else
      return {lanes_, faces_, slider_, bounds_, place, lists_.footprint, lists_.reference_u};
  }
  /// The groups of the coarse list that come within `below` of contact on the rest of this spacing.
  /// `coarse_below`: that, and all that the modes can have added since the coarse list was made.
  /// `Sweep` finds the overlaps.
  template <bool smooth, class Sweep>
  KOKKOS_FORCEINLINE_FUNCTION void find_fine(const Real* u, const Place& place, double below,
                                             double coarse_below, double to_end, double back) {
    Sweep sweep = sweep_at<Sweep>(u, place);
    // bound on what its overlaps are off by
    const double left_out = Sweep::sums_modes ? 0.0 : footprint().left_out(u, slider_.first_lane);
    const double left_of_spacing = rest_of_spacing(place, motion_);
    int count = 0, evaluated = 0, looked_at = 0;
    for (int first = 0; first < coarse_count_; first += width) {
      const int left = coarse_count_ - first;
      std::uint32_t close =
          lanes_.at_least(lanes_.load(lists_.coarse_highest + first), -coarse_below);
      if (left < width) close &= (1u << left) - 1u;
      for (; close != 0; close &= close - 1) {
        const int e = first + Kokkos::Experimental::countr_zero_builtin(close);
        const int group = lists_.coarse_groups[e];
        if (Sweep::sums_modes && lists_.coarse_displacement != nullptr) [[unlikely]] {
          ++looked_at;
          const StaticOverlap<Lanes> faces(lanes_, faces_, place, group,
                                           nodes_beyond(faces_, group));
          const Real most =
              most_on_way<smooth>(place, group, faces.height, faces.rise, to_end, back);
          if (lanes_.at_least(most, -coarse_below - lists_.coarse_displacement[e]) == 0) continue;
        }
        ++evaluated;
        const auto now = sweep.overlap(group);
        const Real most = most_on_way<smooth>(place, group, now.overlap, now.rise, to_end, back);
        if (lanes_.at_least(most, -below - left_out) == 0) continue;
        RA2D_CHECK(count < faces_.groups);
        if (lists_.highest != nullptr) [[unlikely]] {
          const FacesCourse<Lanes> course(lanes_, faces_, place, group, now.overlap, now.rise);
          const double highest = course.highest(lanes_),
                       slope = course.slope(lanes_, left_of_spacing);
          if (lanes_.leader()) {
            lists_.highest[count] = highest + left_out;
            lists_.slope[count] = slope;
          }
        }
        if (lanes_.leader()) lists_.groups[count] = group;
        ++count;
      }
    }
    count_ = count;
    if (lists_.coarse_displacement != nullptr) [[unlikely]]
      in_vain_ += looked_at + Sweep::cost * (evaluated - count);
    // those by polynomials are bounds, as a tile's are
    if (Sweep::sums_modes && lanes_.leader())
      evaluated_ += static_cast<std::int64_t>(evaluated) * width;
    lanes_.sync();
  }

  /// The most that an overlap, `now` at the nodes of a group, becomes there and in the cells
  /// between them by the way over the faces: on the rest of this spacing, and `back` [chi] before.
  /// `rise`: of the resonator's face to its next node.
  template <bool smooth>
  KOKKOS_FORCEINLINE_FUNCTION Real most_on_way(const Place& place, int group, const Real& now,
                                               const Real& rise, double to_end, double back) const {
    Real ahead;
    if constexpr (smooth)
      ahead = PiecePassed<Lanes>(lanes_, faces_, place, group).rise(to_end, rise);
    else
      ahead = Kokkos::max(Real(to_end) * rise, Real(0.0));
    Real most = now + Kokkos::max(ahead, Real(-back) * rise);
    if constexpr (smooth) most = most + cell_sag(lanes_, faces_, place, group);
    return most;
  }

  /// sum_k U_k psi_k(x) of the resonator in the middle of a patch.
  KOKKOS_FORCEINLINE_FUNCTION double at_centre(int patch, const Real* u) const {
    Real sum = lanes_.load(rows(patch)) * u[0];
    for (int p = 1; p < filled<packs>(lanes_); ++p)
      sum = multiply_add(lanes_.load(rows(patch) + p * width), u[p], sum);
    return lanes_.sum(sum);
  }

  /// The groups that come within coarse_below_ of contact somewhere on the next `width` spacings of
  /// the path.
  RA2D_FUNCTION void find_coarse(const Real* u, const Place& place, double slope) {
    // bound on the rise of the deflected beam from a patch's centre to any place of a group on it
    const double rise =
        (motion_.spacing / patches_.inverse_radius + width * motion_.spacing) * slope;
    int patch = -1, count = 0;
    double highest = 0.0;
    for (int group = 0; group < faces_.groups; ++group) {
      const GroupPlace<Lanes> at(patches_, place, group);
      if (at.patch != patch) {
        patch = at.patch;
        highest = at_centre(patch, u) + rise;
      }
      const Real face = lanes_.load(faces_.height1 + group * width) +
                        lanes_.load(faces_.highest2 + place.base + group * width);
      Real top = add_slider_displacement(lanes_, slider_, amplitudes_, group, face) + Real(highest);
      if (faces_.smooth) [[unlikely]]
        top = top + Kokkos::max(lanes_.load(faces_.sag1 + group * width) +
                                    lanes_.load(faces_.highest_sag2 + place.base + group * width),
                                Real(0.0));
      list_coarse(group, top, count);
    }
    coarse_count_ = count;
    lanes_.sync();
  }
  /// Lists a group whose nodes have the overlap `top` at the most, if that is near contact.
  KOKKOS_FORCEINLINE_FUNCTION void list_coarse(int group, const Real& top, int& count) {
    // a CPU cannot predict the branch, and a GPU is slow to find the highest
    if (Lanes::on_gpu && lanes_.at_least(top, -coarse_below_) == 0) return;
    const double most = lanes_.max(top);
    if (lanes_.leader()) {
      RA2D_CHECK(count < faces_.groups);
      lists_.coarse_groups[count] = group;
      lists_.coarse_highest[count] = most;
    }
    count += most >= -coarse_below_;
  }

  // ---- areal scenes

  RA2D_FUNCTION void find_coarse_on_rows(const Real* u, const Place& place) {
    const double variation = weighted_sum<Lanes, packs>(lanes_, bounds_.tile_variation, u);
    const bool by_footprint = footprint().exists();
    const int first = by_footprint ? slider_.first_lane / width : 0;  // pack whose modes are needed
    int count = 0;
    for (int band = 0; band < faces_.tiles.bands; ++band) {
      const double* const across =
          faces_.tiles.across + static_cast<std::int64_t>(band) * packs * width;
      Real x[packs];
      lanes_.sync();
      for (int p = first; p < filled<packs>(lanes_); ++p) {
        x[p] = lanes_.load(across + p * width) * u[p];
        lanes_.store(amplitudes_ + p * width, x[p]);
      }
      lanes_.sync();
      const int tiles = find_tiles(band, x, place, variation);
      const int columns = tiles > 0 ? find_columns(band, tiles, place) : 0;
      coarse_work_ += faces_.tiles.count + columns * tile_rows;
      if (columns > 0) list_groups_of_columns(band, columns, place, count);
    }
    coarse_count_ = count;
    lanes_.sync();
  }
  KOKKOS_FORCEINLINE_FUNCTION int patch_of_tile(int tile, const Place& place) const {
    const int nodes = faces_.tiles.groups * width, middle = tile * nodes + nodes / 2,
              last = faces_.rows.nodes - 1;
    const int at = place.base + (middle < last ? middle : last);
    return static_cast<int>((at + 0.5) * patches_.inverse_nodes);
  }
  /// Lists the tiles of a band that come near contact, in CandidateLists::tiles, and finds the
  /// most that the modes move the nodes of each by. `x`: the modes' displacements there.
  RA2D_FUNCTION int find_tiles(int band, const Real* x, const Place& place, double variation) {
    const TileTables& tiles = faces_.tiles;
    const int group = (place.base - faces_.rows.behind) / width;  // of the resonator
    const double* const own = tiles.highest1 + static_cast<std::int64_t>(band) * tiles.row;
    const double* const opposite =
        tiles.highest2 +
        (static_cast<std::int64_t>(band) * tiles.groups + group % tiles.groups) * tiles.strip +
        group / tiles.groups;
    int found = 0;
    const auto faces = [&](int tile) {
      return lanes_.load(own + tile) + lanes_.load(opposite + tile);
    };
    const auto add_slider = [&](int tile, Real displacement) {
      for (int k = 0; k < slider_.modes; ++k)
        displacement = multiply_add(amplitudes_[slider_.first_lane + k],
                                    lanes_.load(tiles.shape + k * tiles.row + tile), displacement);
      return displacement;
    };
    // those from `tile` to before `end`, a vector of them at the most
    const auto look_at = [&](int tile, int end, const Real& displacement) {
      lanes_.store(lists_.tile_displacement + tile, displacement);
      std::uint32_t bits = lanes_.at_least(faces(tile) + displacement, -coarse_below_);
      if (end - tile < width) bits &= (1u << (end - tile)) - 1u;
      for (; bits != 0; bits &= bits - 1, ++found)
        if (lanes_.leader())
          lists_.tiles[found] = tile + Kokkos::Experimental::countr_zero_builtin(bits);
    };
    if (footprint().exists()) {
      const int rows = faces_.groups / faces_.rows.groups, first = band * tile_rows,
                last = first + tile_rows < rows ? first + tile_rows : rows;
      double along[highest_footprint_degree + 1];
      footprint().take_row(lists_.footprint, 0.5 * (first + last - 1), rows, along);
      double highest = along[0] + variation;  // anywhere on the band: |T_a| <= 1
      for (int a = 1; a <= bounds_.footprint.degree; ++a) highest += Kokkos::abs(along[a]);
      const double nodes = tiles.groups * width;
      for (int tile = 0; tile < tiles.count; tile += width) {
        // left out at once: tiles that would not touch with the resonator as high as that
        const Real slider = add_slider(tile, Real(0.0));
        if (lanes_.at_least(faces(tile) + slider, -coarse_below_ - highest) == 0) continue;
        const Real middle =
            Kokkos::min((Real(tile) + lanes_.index()) * Real(nodes) + Real(0.5 * nodes),
                        Real(faces_.rows.nodes - 1.0));
        look_at(tile, tiles.count,
                slider + Real(variation) +
                    footprint().displacement(place, along, middle, faces_.rows.nodes));
      }
    } else {
      for (int tile = 0; tile < tiles.count;) {
        const int patch = patch_of_tile(tile, place);
        RA2D_CHECK(patch >= 0 && patch < patches_.count);
        int end = tile + 1;
        while (end < tiles.count && patch_of_tile(end, place) == patch) ++end;
        const Real level(at_centre(patch, x) + variation);
        lanes_.sync();
        for (; tile < end; tile += width) look_at(tile, end, add_slider(tile, level));
        tile = end;
      }
    }
    lanes_.sync();
    return found;
  }
  /// Smooth faces: what the overlaps in the cells beside the nodes of a group exceed those of the
  /// nodes alone by, on the next `width` spacings of the path: in a piece of the resonator's face a
  /// node may be higher than at its ends, and in a cell the overlap. `passed`: node of the
  /// resonator under the group's first.
  RA2D_FUNCTION Real sag_on_path(int group, int passed) const {
    const double* const sag2 = faces_.sag2 + passed;
    Real most = lanes_.load(sag2);
    for (int n = 1; n <= width; ++n) most = Kokkos::max(most, lanes_.load(sag2 + n));
    return Kokkos::max(most, Real(0.0)) +
           Kokkos::max(lanes_.load(faces_.sag1 + group * width) + most, Real(0.0));
  }
  /// Lists the columns of `found` tiles that come near contact, in CandidateLists::columns.
  RA2D_FUNCTION int find_columns(int band, int found, const Place& place) {
    const TileTables& tiles = faces_.tiles;
    const std::int64_t at = band;
    const double* const own = tiles.column1 + at * tiles.column_row;
    const double* const opposite =
        tiles.column2 + at * tiles.column_strip + (place.base - faces_.rows.behind) / width;
    int columns = 0;
    for (int e = 0; e < found; ++e) {
      const int tile = lists_.tiles[e], begin = tile * tiles.groups;
      const int end =
          begin + tiles.groups < faces_.rows.groups ? begin + tiles.groups : faces_.rows.groups;
      const Real displacement(lists_.tile_displacement[tile]);
      for (int g = begin; g < end; g += width) {
        const Real top = lanes_.load(own + g) + lanes_.load(opposite + g) + displacement;
        std::uint32_t bits = lanes_.at_least(top, -coarse_below_);
        if (end - g < width) bits &= (1u << (end - g)) - 1u;
        for (; bits != 0; bits &= bits - 1, ++columns)
          if (lanes_.leader())
            lists_.columns[columns] = g + Kokkos::Experimental::countr_zero_builtin(bits);
      }
    }
    lanes_.sync();
    return columns;
  }
  /// Lists the groups of `columns` columns that come near contact, row by row.
  RA2D_FUNCTION void list_groups_of_columns(int band, int columns, const Place& place, int& count) {
    const RowTables& rows = faces_.rows;
    const int first = band * tile_rows, all = faces_.groups / rows.groups,
              last = first + tile_rows < all ? first + tile_rows : all;
    for (int row = first; row < last; ++row)
      for (int e = 0; e < columns; ++e) {
        const int column = lists_.columns[e], group = row * rows.groups + column,
                  next = group + rows.groups;
        const int passed = place.base - rows.behind + row * rows.excess + group * width;
        const double displacement = lists_.tile_displacement[column / faces_.tiles.groups];
        const double* const h2 = faces_.height2 + passed;
        if (row + 1 < last) {
          lanes_.prefetch(h2 + rows.excess + rows.groups * width);
          lanes_.prefetch(h2 + rows.excess + rows.groups * width + width);
          lanes_.prefetch(faces_.height1 + next * width);
        }
        Real face = lanes_.load(h2);
        for (int ahead = 1; ahead <= width; ++ahead)
          face = Kokkos::max(face, lanes_.load(h2 + ahead));
        Real top = lanes_.load(faces_.height1 + group * width) + face + Real(displacement);
        if (faces_.smooth) [[unlikely]]
          top = top + sag_on_path(group, passed);
        if (lanes_.leader()) lists_.coarse_displacement[count] = displacement;
        list_coarse(group, top, count);
      }
  }
};

}  // namespace ra2d
