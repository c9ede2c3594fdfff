// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/adaptive/group_bounds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <vector>

#include "tests/areal_scenes.hpp"
#include "tests/dice.hpp"
#include "tests/filled.hpp"
#include "tests/kernels_of.hpp"

/// The groups of nodes that areal scenes evaluate for a step of the adaptive scheme.
namespace ra2d::test {
namespace {

/// Packs for the modes of a plate (40) and a free block.
constexpr int many = (44 + width - 1) / width;
using State = ModalState<HostLanes, many>;

/// Lists of all groups of a scene.
struct Listed : Filled {
  SceneState s;
  std::vector<int> groups, selected;
  std::vector<std::int64_t> evaluated;
  std::vector<double> reference, highest, slope, own_shape, own_motion, sums;

  explicit Listed(const Model& model) : Filled(model, many * width) {
    const std::size_t padded = n.groups + width;
    for (std::vector<int>* list : {&groups, &selected}) list->assign(n.groups, 0);
    evaluated.assign(n.groups, 0);
    for (std::vector<double>* row : {&highest, &slope}) row->assign(padded, 0.0);
    own_shape.assign(n.slider_modes * padded, 0.0);
    own_motion.assign(4 * n.lanes, 0.0);
    sums.assign(4 * n.footprint_sums(), 0.0);
    reference.assign(n.lanes, 0.0);
    for (int e = 0; e < n.groups; ++e) groups[e] = e;
    s.work.candidates.groups = groups.data();
    s.work.candidates.highest = highest.data();
    s.work.candidates.slope = slope.data();
    s.work.candidates.reference_u = reference.data();
    s.work.groups = {selected.data(), evaluated.data(), own_shape.data(), own_motion.data(),
                     sums.data()};
  }
  Place place_at(double position) const {
    SliderMotion motion = t.motion;
    motion.position = position;
    return {motion, 0};
  }
  /// Of all nodes, group by group; nodes that do not exist lie low. Between smooth faces with the
  /// sag of the cells beside each.
  std::vector<double> overlaps_at(const std::vector<double>& u, double position) {
    std::vector<double> over = between_lines(u, position);
    if (!t.faces.smooth) return over;
    const std::vector<double> lines = between_lines(std::vector<double>(n.lanes, 0.0), position);
    const Place place = place_at(position);
    for (int e = 0; e < n.groups; ++e) {
      double splines[width];
      lanes.store(
          splines,
          StaticOverlap<HostLanes>(lanes, t.faces, place, e, nodes_beyond(t.faces, e)).height +
              cell_sag(lanes, t.faces, place, e));
      for (int l = 0; l < std::min(width, nodes_left(t.faces, e, width)); ++l)
        over[e * width + l] += splines[l] - lines[e * width + l];
    }
    return over;
  }
  /// As if the faces were straight from node to node.
  std::vector<double> between_lines(const std::vector<double>& u, double position) {
    model.position = position;
    const auto first = u.begin();
    const auto modes2 = static_cast<std::ptrdiff_t>(model.resonator.modes.size()),
               modes1 = static_cast<std::ptrdiff_t>(model.slider.modes.size());
    const std::vector<double> at =
        overlaps(model, {first, first + modes2}, {first + modes2, first + modes2 + modes1});
    std::vector<double> grouped(n.padded_nodes(), -1.0);
    for (int j = 0; j < n.rows; ++j)
      for (int i = 0; i < n.row_nodes; ++i)
        grouped[j * n.padded_row() + i] = at[j * n.row_nodes + i];
    return grouped;
  }
};

State state_of(const std::vector<double>& u, const std::vector<double>& v) {
  State state;
  for (int p = 0; p < many; ++p) {
    state.u[p] = lanes.load(u.data() + p * width);
    state.v[p] = lanes.load(v.data() + p * width);
  }
  return state;
}

/// In every step every group is selected in which a node, or a cell beside it, reaches a level,
/// along a motion that is a cubic in time. Groups that are not selected keep the bounds of earlier
/// steps.
void select_every_group_that_comes_near(Faces faces_are) {
  Dice dice(11);
  int near = 0, chosen = 0, all = 0;
  for (int scene = 0; scene < 12; ++scene) {
    ArealScene of = many_nodes();
    of.plate.modes = 40;
    of.faces = faces_are;
    Listed listed(areal_march(of, 1e-6, 1e-3).model);
    ASSERT_GT(listed.n.footprint_terms, 0);
    GroupBounds<HostLanes, many> bounds(lanes, listed.t.motion, listed.t.faces, listed.t.slider,
                                        listed.t.bounds, listed.s.work.candidates,
                                        listed.s.work.groups);
    ASSERT_TRUE(bounds.follows());
    const std::size_t modes = listed.model.resonator.modes.size() + 3;
    // one part of the motion leads, so that no other bound hides it: the faces, the slider, or the
    // resonator, one mode of which keeps its direction
    const int leads = scene % 3;
    const double slider = leads == 1   ? 1.5e-7
                          : leads == 0 ? 5e-9
                                       : 1e-10,
                 farthest = leads == 0 ? 0.045 : 1e-4;
    const auto random = [&](double share) {
      std::vector<double> x(listed.n.lanes, 0.0);
      for (std::size_t k = modes - 3; k < modes; ++k)
        x[k] = share * slider * dice.uniform(-1, 1) / listed.t.bounds.largest_shape[k];
      x[0] = (leads == 2 ? 2e-8 : 1e-11) / listed.t.bounds.largest_shape[0];
      return x;
    };
    std::vector<double> u = random(1), v = random(1);
    double position = std::floor(listed.model.position) + 1.01;
    const auto place_at = [&](double at) { return listed.place_at(at); };
    std::vector<double> over = listed.overlaps_at(u, position);
    const auto highest_of = [&](int e) {
      return *std::max_element(over.begin() + e * width, over.begin() + (e + 1) * width);
    };
    std::vector<double> ranked = over;
    constexpr int above = 300;  // nodes: so many that others are close below
    std::nth_element(ranked.begin(), ranked.begin() + above, ranked.end(), std::greater<>());
    const double level = ranked[above];
    const Place first = place_at(position);
    const double left = rest_of_spacing(first, listed.t.motion);
    for (int e = 0; e < listed.n.groups; ++e) {
      const FaceTables& faces = listed.t.faces;
      Real overlap = lanes.load(over.data() + e * width);
      if (faces.smooth) overlap = overlap - cell_sag(lanes, faces, first, e);
      const FacesCourse<HostLanes> course(
          lanes, faces, first, e, overlap,
          StaticOverlap<HostLanes>(lanes, faces, first, e, nodes_beyond(faces, e)).rise);
      listed.highest[e] = course.highest(lanes);
      listed.slope[e] = course.slope(lanes, left);
    }
    listed.reference = u;
    listed.s.work.candidates.reference_u = listed.reference.data();
    bounds.begin(place_at(position), listed.n.groups);
    for (int step = 0; step < 20; ++step) {
      const double distance = dice.uniform(0, farthest);
      const std::vector<double> move = random(1), fast = random(2);
      std::vector<double> end = u;
      for (std::size_t k = 0; k < modes; ++k) end[k] += move[k];
      const State before = state_of(u, v), after = state_of(end, fast);
      const Place place = place_at(position);
      const Rise rise = bounds.rise(place, before, after, 1.0, 1.0, 0.0, 1e300);
      const double path =
          distance * listed.model.scene.spacing *
              weighted_sum<HostLanes, many>(lanes, listed.t.bounds.largest_slope, before.u) +
          1e-15;
      bounds.select(place, listed.n.groups, distance, level - rise.rest - path);
      std::set<int> selected;
      for (int i = 0; i < bounds.selected(); ++i) selected.insert(bounds[i]);
      chosen += bounds.selected(), all += listed.n.groups;
      const auto displacement_at = [&](double t) {
        std::vector<double> at = u;
        for (std::size_t k = 0; k < modes; ++k)
          at[k] += t * v[k] + t * t * (3 * move[k] - 2 * v[k] - fast[k]) +
                   t * t * t * (v[k] + fast[k] - 2 * move[k]);
        return at;
      };
      for (const double t : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
        over = listed.overlaps_at(displacement_at(t), position + t * distance);
        for (int e = 0; e < listed.n.groups; ++e) {
          if (highest_of(e) < level) continue;
          ++near;
          EXPECT_EQ(selected.count(e), 1u) << "group " << e << ", step " << step << ", " << t;
        }
      }
      const double part = dice.one_in(3) ? 0.5 : 1.0;  // a step may be cut short
      const std::vector<double> there = displacement_at(part);
      for (std::size_t k = 0; k < modes; ++k)
        v[k] += 2 * part * (3 * move[k] - 2 * v[k] - fast[k]) +
                3 * part * part * (v[k] + fast[k] - 2 * move[k]);
      u = there, position += part * distance;
      over = listed.overlaps_at(u, position);
      const double moved =
          part < 1.0 ? bounds.rise_at_end(place, before, state_of(u, v)) : rise.end;
      EXPECT_LE(moved, rise.rest);
      bounds.end_step(moved + path);
      if (step % 3 == 2) continue;  // as where a contact begins: nothing is taken
      std::vector<double> rows(2 * listed.n.groups * width, -1.0);
      for (int e = 0; e < listed.n.groups; ++e) {
        Real at_nodes = lanes.load(over.data() + e * width);
        if (listed.t.faces.smooth)
          at_nodes = at_nodes - cell_sag(lanes, listed.t.faces, place_at(position), e);
        lanes.store(rows.data() + 2 * e * width, at_nodes);
      }
      bounds.take(place_at(position), state_of(u, v).u, rows.data());
    }
  }
  EXPECT_GT(near, 1000);
  EXPECT_LT(chosen, all / 3);
}
/// Sums kept from step to step change nothing, also where another set of polynomials serves.
TEST(GroupBounds, RiseIsThatOfBoundsThatKnowNothing) {
  Dice dice(12);
  ArealScene of = many_nodes();
  of.plate.modes = 40;
  Listed listed(areal_march(of, 1e-6, 1e-3).model);
  const auto bounds_with = [&](GroupBuffers& buffers) {
    return GroupBounds<HostLanes, many>(lanes, listed.t.motion, listed.t.faces, listed.t.slider,
                                        listed.t.bounds, listed.s.work.candidates, buffers);
  };
  GroupBounds<HostLanes, many> bounds = bounds_with(listed.s.work.groups);
  const std::size_t modes = listed.model.resonator.modes.size() + 3;
  const auto random = [&] {
    std::vector<double> x(listed.n.lanes, 0.0);
    for (std::size_t k = 0; k < modes; ++k)
      x[k] = 1e-7 * dice.uniform(-1, 1) / listed.t.bounds.largest_shape[k];
    return x;
  };
  const FootprintTables& tables = listed.t.bounds.footprint;
  ASSERT_GT(tables.places, 1);
  State now = state_of(random(), random());
  for (int step = 0; step < 40; ++step) {
    const Place place =
        listed.place_at(tables.first + dice.pick(tables.places) * tables.nodes + 0.5);
    State end = state_of(random(), random());
    const Rise rise = bounds.rise(place, now, end, 1.0, 0.5, 0.0, 1e300);
    std::vector<double> sums(4 * listed.n.footprint_sums(), 0.0), motion(4 * listed.n.lanes, 0.0);
    GroupBuffers apart = listed.s.work.groups;
    apart.sums = sums.data(), apart.own_motion = motion.data();
    GroupBounds<HostLanes, many> knows_nothing = bounds_with(apart);
    const Rise alone = knows_nothing.rise(place, now, end, 1.0, 0.5, 0.0, 1e300);
    EXPECT_EQ(rise.any, alone.any);
    EXPECT_EQ(rise.rest, alone.rest);
    EXPECT_EQ(rise.end, alone.end);
    if (dice.one_in(3)) {
      end = state_of(random(), random());
      const double at_end = bounds.rise_at_end(place, now, end);
      EXPECT_EQ(at_end, knows_nothing.rise_at_end(place, now, end));
      EXPECT_NEAR(at_end, knows_nothing.rise(place, now, end, 1.0, 0.5, 0.0, 1e300).end,
                  256 * 0x1p-53 * at_end)
          << "two sums of less than 128 terms, none of them negative";
    }
    bounds.end_step(0.0);
    now = end;
  }
}

/// Also where every group is evaluated, and none is selected.
TEST(GroupBounds, RiseIsThatOfTheStepWhereAllNodesAreSearched) {
  Dice dice(13);
  const Model model = areal_march(many_nodes(), 1e-6, 1e-3, 1, Nodes::all).model;
  Listed listed(model), other(model);
  std::vector<double> ends(4 * listed.n.groups * width, 0.0);
  listed.s.work.search.overlaps = other.s.work.search.overlaps = ends.data();
  Overlaps<HostLanes, many> overlaps = overlaps_of<many>(listed.t, listed.s);
  ASSERT_TRUE(overlaps.knows_footprint());
  const std::size_t modes = model.resonator.modes.size() + 3;
  const auto random = [&] {
    std::vector<double> x(listed.n.lanes, 0.0);
    for (std::size_t k = 0; k < modes; ++k)
      x[k] = 1e-7 * dice.uniform(-1, 1) / listed.t.bounds.largest_shape[k];
    return x;
  };
  const Place place = listed.place_at(std::floor(model.position) + 0.5);
  const MotionBounds bounds{1.0, 0.0, 0.0, 1e-5};
  State now = state_of(random(), random());
  for (int step = 0; step < 12; ++step) {
    const State end = state_of(random(), random()), elsewhere = state_of(random(), random());
    const Rise rise = overlaps.longest_rise(place, now, end, bounds, 1000);
    Overlaps<HostLanes, many> knows_nothing = overlaps_of<many>(other.t, other.s);
    EXPECT_EQ(rise.rest, knows_nothing.longest_rise(place, now, end, bounds, 1000).rest);
    const bool ends_elsewhere = step % 3 == 0;
    if (ends_elsewhere) overlaps.end_at(place, now, elsewhere, bounds, 500);
    now = ends_elsewhere ? elsewhere : end;
    if (step % 2 == 0)
      overlaps.discard_start();
    else
      overlaps.end_becomes_start(place, now.u);
  }
}

TEST(GroupBounds, SelectEveryGroupThatComesNear) {
  select_every_group_that_comes_near(Faces::linear);
}
TEST(GroupBounds, SelectEveryGroupWhoseCellsComeNear) {
  select_every_group_that_comes_near(Faces::smooth);
}

/// A smooth face is followed by a bound on its rise, which may be more than the rise itself. Lists
/// of groups, which know the face, have to hold for that, too.
TEST(GroupBounds, ListsHoldForMoreThanASmoothFaceRisesBy) {
  ArealScene of = many_nodes();
  of.faces = Faces::smooth;
  Listed listed(areal_march(of, 1e-6, 1e-3).model);
  std::vector<double> ends(4 * listed.n.groups * width, 0.0);
  listed.s.work.search.overlaps = ends.data();
  Overlaps<HostLanes, many> overlaps = overlaps_of<many>(listed.t, listed.s);
  ASSERT_TRUE(overlaps.knows_footprint());
  const FaceTables& faces = listed.t.faces;
  const std::vector<double> zero(listed.n.lanes, 0.0);
  const State still = state_of(zero, zero);
  const double position = std::floor(listed.model.position) + 1.4;
  const auto ticks = static_cast<std::int64_t>(0.02 / listed.t.motion.advance);
  const double distance = static_cast<double>(ticks) * listed.t.motion.advance;
  const Place place = listed.place_at(position), there = listed.place_at(position + distance);
  const Rise rise = overlaps.longest_rise(place, still, still, {0.0, 0.0, 0.0, 0.0}, ticks);
  double excess = 0;
  for (int e = 0; e < listed.n.groups; ++e) {
    const int beyond = nodes_beyond(faces, e);
    const StaticOverlap<HostLanes> now(lanes, faces, place, e, beyond);
    const Real followed =
        FacesCourse<HostLanes>(lanes, faces, place, e, now.height, now.rise).most_risen(distance);
    const Real risen = StaticOverlap<HostLanes>(lanes, faces, there, e, beyond).height - now.height;
    double more[width];
    lanes.store(more, followed - Kokkos::max(risen, Real(0.0)));
    for (int l = 0; l < std::min(width, nodes_left(faces, e, width)); ++l)
      excess = std::max(excess, more[l]);
  }
  EXPECT_GE(rise.any - rise.rest, excess);
  EXPECT_LT(rise.any - rise.rest, 4 * excess) << "and for little more";
}

}  // namespace
}  // namespace ra2d::test
