// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "host/model/bounds.hpp"
#include "host/surface/spline.hpp"
#include "kernels/candidate_groups.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/gap.hpp"
#include "tests/bodies_by_hand.hpp"
#include "tests/dice.hpp"
#include "tests/eight_modes.hpp"
#include "tests/kernels_of.hpp"

/// Candidate groups against a search of every node, over a wavy beam with rough faces.
namespace {

using namespace ra2d;
using test::Dice, test::Amplitudes, test::Real, test::lanes;
using test::K, test::eps, test::modes, test::width;

/// A resonator with the modes sin(beta_k x + k) and a slider that tilts; or, `stiff`, bodies that
/// hardly bend under a slider that moves as a whole, so that the bounds on what modes do are tight.
/// Lengths in chi, here 1 m.
struct Bodies {
  static constexpr int waves = modes - 1, patch_nodes = 24;
  static constexpr int resonator_nodes = 480, slider_nodes = 157;
  static constexpr int groups = (slider_nodes + width - 1) / width;
  static constexpr double radius = 0.5 * (patch_nodes + width) + 1;
  std::vector<double> beta, largest_shape, slope, tail, patch, tilt, height1, height2, highest2;
  // of smooth faces
  std::vector<double> curvature1, curvature2, sag1, sag2, highest_sag2, modes_sag;
  SceneTables t;

  enum class Faces { linear, corners, wavy };  // the last two: splines, of noise or of its means

  explicit Bodies(Dice& dice, bool stiff = false, Faces faces = Faces::linear) {
    for (int k = 0; k < waves; ++k) {
      beta.push_back(dice.uniform(0.05, 0.6) / radius * (stiff ? 1e-3 : 1));
      largest_shape.push_back(1);
      slope.push_back(beta[k]);
      tail.push_back(std::pow(beta[k] * radius, 4) / 24);
    }
    largest_shape.push_back(1), slope.push_back(0), tail.push_back(0);  // of the slider
    const int patches = resonator_nodes / patch_nodes + 1;
    patch.assign(static_cast<std::size_t>(patches) * 4 * modes, 0.0);
    for (int p = 0; p < patches; ++p)
      for (int k = 0; k < waves; ++k)
        for (int j = 0; j < 4; ++j)
          patch[(p * 4 + j) * modes + k] =
              std::pow(beta[k] * radius, j) *
              std::sin(beta[k] * (p + 0.5) * patch_nodes + k + j * M_PI_2);
    for (int n = 0; n < groups * width; ++n) {
      const bool real = n < slider_nodes;
      tilt.push_back(!real ? 0.0 : stiff ? 1.0 : 2.0 * n / slider_nodes - 1);
      height1.push_back(real ? dice.uniform(-1, 0) - 2 : -1e30);
    }
    for (int n = 0; n < resonator_nodes; ++n)  // with an asperity here and there
      height2.push_back(dice.uniform(-1, 0) + (dice.one_in(40) ? 2 : 0));
    highest2.resize(resonator_nodes);
    fill_highest(height2.data(), resonator_nodes, width, highest2.data());
    t.faces.steepest_rise = steepest_rise(height2.data(), resonator_nodes);
    t.slider.first_lane = waves, t.slider.modes = 1, t.slider.row = groups * width;
    t.faces.nodes = slider_nodes, t.faces.groups = groups;
    t.patches.count = patches, t.patches.nodes = patch_nodes,
    t.patches.inverse_nodes = 1.0 / patch_nodes;
    t.patches.inverse_radius = 1 / radius, t.motion.spacing = 1;
    t.faces.rounding = 16 * eps * 5;
    t.bounds.largest_shape = largest_shape.data(), t.bounds.largest_slope = slope.data(),
    t.bounds.cubic_remainder = tail.data();
    t.patches.derivatives = patch.data(), t.slider.shape = tilt.data();
    t.faces.height1 = height1.data(), t.faces.height2 = height2.data(),
    t.faces.highest2 = highest2.data();
    if (faces != Faces::linear) make_smooth(faces == Faces::wavy ? 6 : 0);
  }
  Bodies(const Bodies&) = delete;

  /// Splines through the nodes, averaged so many times, as the host fills their tables.
  void make_smooth(int averages) {
    for (int i = 0; i < averages; ++i)
      for (std::vector<double>* height : {&height1, &height2}) {
        const int last = height == &height1 ? slider_nodes - 1 : resonator_nodes - 1;
        for (int n = 1; n < last; ++n)
          (*height)[n] = 0.25 * ((*height)[n - 1] + (*height)[n + 1]) + 0.5 * (*height)[n];
      }
    curvature1 = spline_curvatures({height1.begin(), height1.begin() + slider_nodes});
    curvature2 = spline_curvatures(height2);
    for (std::vector<double>* row : {&sag2, &highest_sag2}) row->resize(resonator_nodes);
    sag1.assign(height1.size(), 0.0);
    fill_sag(curvature1.data(), slider_nodes, 1, 1, sag1.data());
    fill_sag(curvature2.data(), resonator_nodes, 1, 2, sag2.data());
    fill_highest(sag2.data(), resonator_nodes, width, highest_sag2.data());
    std::vector<double> raised(resonator_nodes);
    fill_raised(height2.data(), curvature2.data(), resonator_nodes, raised.data());
    fill_highest(raised.data(), resonator_nodes, width, highest2.data());
    t.faces.smooth = true;
    t.faces.curvature1 = curvature1.data(), t.faces.curvature2 = curvature2.data();
    t.faces.sag1 = sag1.data(), t.faces.sag2 = sag2.data();
    t.faces.highest_sag2 = highest_sag2.data();
    t.faces.largest_face_curvature = largest_face_curvature(curvature2.data(), resonator_nodes);
    t.faces.steepest_rise = steepest_rise(height2.data(), curvature2.data(), resonator_nodes);
    t.faces.rounding = face_rounding(10, true);
    modes_sag.assign(modes, 0.0);
    for (int k = 0; k < waves; ++k) {
      modes_sag[k] = 0.125 * beta[k] * beta[k];
      t.faces.sag_per_travel = std::max(t.faces.sag_per_travel, modes_sag[k]);
    }
    t.bounds.cell_sag = modes_sag.data();
  }
  static double on_spline(const std::vector<double>& h, const std::vector<double>& curvature,
                          double x) {
    const int left = std::min(static_cast<int>(x), static_cast<int>(curvature.size()) - 2);
    return spline_piece(h[left], h[left + 1], curvature[left], curvature[left + 1])(x - left);
  }
  /// Between smooth faces, `share` of the way along a cell.
  double overlap_in_cell(const Amplitudes& u, double position, int cell, double share) const {
    const double x = position + cell + share;
    double sum = on_spline(height1, curvature1, cell + share) + on_spline(height2, curvature2, x) +
                 u[waves] * ((1 - share) * tilt[cell] + share * tilt[cell + 1]);
    for (int k = 0; k < waves; ++k) sum += u[k] * std::sin(beta[k] * x + k);
    return sum;
  }

  Place place(double position) const {
    SceneTables at = t;
    at.motion.position = position;
    return {at.motion, 0};
  }
  double overlap(const Amplitudes& u, double position, int node) const {
    const double x = position + node;
    const int left = static_cast<int>(x);
    double u2 = 0;
    for (int k = 0; k < waves; ++k) u2 += u[k] * std::sin(beta[k] * x + k);
    return -gap(0.0, height1[node], u[waves] * tilt[node],
                {height2[left], height2[left + 1], x - left}, u2);
  }
  /// sum weight_k |u_k|
  static double weigh(const std::vector<double>& weight, const Amplitudes& u) {
    double sum = 0;
    for (int k = 0; k < modes; ++k) sum += weight[k] * std::abs(u[k]);
    return sum;
  }
};

/// Candidate groups with their work space.
struct Lists {
  std::vector<int> fine_groups, coarse_groups;
  std::vector<double> reference_u, coarse_reference_u, coarse_highest, amplitudes;
  SceneState s;
  CandidateGroups<HostLanes, K> groups;

  explicit Lists(const SceneTables& t)
      : fine_groups(t.faces.groups),
        coarse_groups(t.faces.groups),
        reference_u(modes),
        coarse_reference_u(modes),
        coarse_highest(t.faces.groups + width),
        amplitudes(modes),
        groups{lanes,
               t.motion,
               t.faces,
               t.slider,
               t.patches,
               t.bounds,
               s.work.candidates,
               amplitudes.data(),
               s.carried.sums.evaluated} {
    s.work.candidates.groups = fine_groups.data(),
    s.work.candidates.coarse_groups = coarse_groups.data(),
    s.work.candidates.coarse_highest = coarse_highest.data();
    s.work.candidates.reference_u = reference_u.data(),
    s.work.candidates.coarse_reference_u = coarse_reference_u.data(),
    s.work.amplitudes = amplitudes.data();
  }
  Lists(const Lists&) = delete;

  struct Packs {
    Real u[K];
    explicit Packs(const Amplitudes& of) {
      for (int p = 0; p < K; ++p) u[p] = lanes.load(of.data() + p * width);
    }
  };
  void find(const Amplitudes& u, const Place& place, double range) {
    groups.find(Packs(u).u, place, range,
                256 * eps * Bodies::weigh(std::vector<double>(modes, 1), u), 0.0);
  }
  bool holds(const Amplitudes& u, const Place& place, double travel) const {
    return groups.holds(Packs(u).u, place, travel);
  }
  double remaining_travel(const Amplitudes& u, const Place& place) const {
    return groups.range() - groups.travelled(Packs(u).u, place);
  }
  std::vector<int> listed() const {
    std::vector<int> out;
    for (int e = 0; e < groups.count(); ++e) out.push_back(groups[e]);
    return out;
  }
};

Amplitudes some(Dice& dice, double size) {
  Amplitudes u;
  for (double& x : u) x = dice.uniform(-size, size);
  return u;
}
/// No farther off than `way`, in sum |U - U'|.
Amplitudes elsewhere(Dice& dice, Amplitudes u, double travel_left) {
  double left = travel_left * (1 - 1e-12);  // roundings
  for (const int k : dice.order(modes)) {
    const double part = dice.one_in(3) ? left : dice.uniform(0, left);
    u[k] += dice.one_in(2) ? part : -part;
    left -= part;
  }
  return u;
}

TEST(CandidateGroups, LeaveOutNothingThatTouchesWhileTheyHold) {
  Dice dice(1);
  int touched = 0, listed = 0, searches = 0;
  for (int scene = 0; scene < 20; ++scene) {
    const Bodies bodies(dice, scene % 2 == 1);
    Lists lists(bodies.t);
    Amplitudes u = some(dice, 0.2);
    double position = dice.uniform(0, 10);
    for (int trial = 0; trial < 60; ++trial) {
      const double range = dice.ratio(1e-3, 0.5);
      lists.find(u, bodies.place(position), range);
      const std::vector<int> candidates = lists.listed();
      ASSERT_TRUE(std::is_sorted(candidates.begin(), candidates.end()));
      listed += static_cast<int>(candidates.size()), ++searches;
      const double end = std::floor(position) + 1;
      for (int i = 0; i < 20; ++i) {
        Amplitudes there = elsewhere(dice, u, range);
        if (i % 2 == 1) (there = u)[modes - 1] += range * (1 - 1e-12);  // the slider comes nearer
        const double at = i == 0 ? position : std::nextafter(dice.uniform(position, end), 0);
        ASSERT_TRUE(lists.holds(there, bodies.place(at), 0));
        for (int node = 0; node < Bodies::slider_nodes; ++node)
          if (bodies.overlap(there, at, node) >= 0) {
            ++touched;
            ASSERT_TRUE(std::binary_search(candidates.begin(), candidates.end(), node / width))
                << "scene " << scene << ", trial " << trial << ", node " << node;
          }
      }
      u = elsewhere(dice, u, dice.ratio(1e-3, 1));
      position += dice.one_in(8) ? dice.uniform(0, 3 * width) / 10 : dice.uniform(0, 1);
    }
  }
  EXPECT_GT(touched, 1000);
  // and they leave out many groups
  EXPECT_LT(listed, 0.7 * searches * Bodies::groups);
}

TEST(CandidateGroups, LeaveOutNoCellThatTouchesWhileTheyHold) {
  Dice dice(7);
  int touched = 0, between_nodes = 0, listed = 0, searches = 0;
  for (int scene = 0; scene < 20; ++scene) {
    const Bodies bodies(dice, scene % 2 == 1,
                        scene % 4 < 2 ? Bodies::Faces::corners : Bodies::Faces::wavy);
    Lists lists(bodies.t);
    Amplitudes u = some(dice, 0.2);
    double position = dice.uniform(0, 10);
    for (int trial = 0; trial < 40; ++trial) {
      const double range = dice.ratio(1e-3, 0.5);
      lists.find(u, bodies.place(position), range);
      const std::vector<int> candidates = lists.listed();
      listed += static_cast<int>(candidates.size()), ++searches;
      const double end = std::floor(position) + 1;
      for (int i = 0; i < 8; ++i) {
        Amplitudes there = elsewhere(dice, u, range);
        if (i % 2 == 1) (there = u)[modes - 1] += range * (1 - 1e-12);  // the slider comes nearer
        const double at = i == 0 ? position : std::nextafter(dice.uniform(position, end), 0);
        for (int cell = 0; cell + 1 < Bodies::slider_nodes; ++cell) {
          double most = -1e300;
          for (int part = 0; part <= 8; ++part)
            most = std::max(most, bodies.overlap_in_cell(there, at, cell, part / 8.0));
          if (most < 0) continue;
          ++touched;
          between_nodes += bodies.overlap_in_cell(there, at, cell, 0) < 0 &&
                           bodies.overlap_in_cell(there, at, cell, 1) < 0;
          ASSERT_TRUE(std::binary_search(candidates.begin(), candidates.end(), cell / width) ||
                      std::binary_search(candidates.begin(), candidates.end(), (cell + 1) / width))
              << "scene " << scene << ", trial " << trial << ", cell " << cell;
        }
      }
      u = elsewhere(dice, u, dice.ratio(1e-3, 1));
      position += dice.one_in(8) ? dice.uniform(0, 3 * width) / 10 : dice.uniform(0, 1);
    }
  }
  EXPECT_GT(touched, 1000);
  EXPECT_GT(between_nodes, 50);
  EXPECT_LT(listed, 0.9 * searches * Bodies::groups);
}

TEST(CandidateGroups, NoCellExceedsItsEndsByMoreThanItsSag) {
  Dice dice(8);
  double closest = 0;
  std::vector<double> slack;  // of the bound that knows both ends
  int hollow = 0, cells = 0;
  for (int scene = 0; scene < 40; ++scene) {
    const Bodies bodies(dice, true, scene % 2 ? Bodies::Faces::corners : Bodies::Faces::wavy);
    const double position = dice.uniform(0, 100);
    const Place place = bodies.place(position);
    for (int group = 0; group < Bodies::groups; ++group) {
      std::array<double, width> sag;
      lanes.store(sag.data(), cell_sag(lanes, bodies.t.faces, place, group));
      for (int lane = 0; lane < width; ++lane)
        for (const int cell : {group * width + lane - 1, group * width + lane}) {
          if (cell < 0 || cell + 1 >= Bodies::slider_nodes) continue;
          const Amplitudes still{};
          const auto overlap = [&](double share) {
            return bodies.overlap_in_cell(still, position, cell, share);
          };
          const double ends = std::max(overlap(0), overlap(1));
          ++cells, hollow += sag[lane] == 0;
          std::array<double, width> inside;
          if (cell % width + 1 < width && cell / width == group) {
            std::array<double, width> at;
            for (int i = 0; i < width; ++i) {
              const int node = std::min(group * width + i, Bodies::slider_nodes - 1);
              at[i] = node + 1 < Bodies::slider_nodes
                          ? bodies.overlap_in_cell(still, position, node, 0)
                          : bodies.overlap_in_cell(still, position, node - 1, 1);
            }
            lanes.store(inside.data(),
                        most_in_cells(lanes, lanes.load(at.data()),
                                      cell_sag(lanes, bodies.t.faces, place, group)));
            double most = -1e300;
            for (int part = 0; part <= 16; ++part) most = std::max(most, overlap(part / 16.0));
            ASSERT_LE(most, inside[cell % width] + 64 * eps) << "cell " << cell;
            slack.push_back(inside[cell % width] - most);
          }
          for (int part = 1; part < 16; ++part) {
            const double excess = overlap(part / 16.0) - ends;
            ASSERT_LE(excess, sag[lane] + 64 * eps) << "cell " << cell;
            if (sag[lane] > 0) closest = std::max(closest, excess / sag[lane]);
          }
        }
    }
  }
  EXPECT_GT(closest, 0.7);
  EXPECT_GT(hollow, cells / 40);
  if constexpr (width > 1) {  // else no cell has both ends in a group
    std::sort(slack.begin(), slack.end());
    EXPECT_LT(slack[slack.size() / 2], 0.1);
  }
}

/// With the cells' sag, along the way over the faces to the end of a spacing.
TEST(FacesCourse, BoundsTheOverlapsOfAGroupToTheEndOfTheSpacing) {
  Dice dice(12);
  constexpr double shy = 1e-12;  // of the next spacing
  for (const Bodies::Faces kind :
       {Bodies::Faces::linear, Bodies::Faces::corners, Bodies::Faces::wavy}) {
    double nearest = 0, nearest_node = 0;
    for (int scene = 0; scene < 20; ++scene) {
      const Bodies bodies(dice, true, kind);
      const FaceTables& faces = bodies.t.faces;
      const double position = dice.uniform(0, 100), left = std::floor(position) + 1 - position;
      const auto overlaps_at = [&](int group, double share) {
        const Place place = bodies.place(position + share * left * (1 - shy));
        const StaticOverlap<HostLanes> now(lanes, faces, place, group);
        return std::pair{now.height, now.rise};
      };
      for (int group = 0; group < Bodies::groups; ++group) {
        if (nodes_left(faces, group, width) < width) continue;  // its last nodes do not exist
        const Place place = bodies.place(position);
        const double roundings =
            64 * eps + (2 * position_rounding(place) + shy) * faces.steepest_rise;
        const Real sag = faces.smooth ? cell_sag(lanes, faces, place, group) : Real(0.0);
        const auto [height, rise] = overlaps_at(group, 0);
        const FacesCourse<HostLanes> course(lanes, faces, place, group, height, rise);
        const double highest = course.highest(lanes), slope = course.slope(lanes, left);
        EXPECT_EQ(highest, lanes.max(height + sag));
        Real farthest(0.0);  // that each node has risen
        for (const double share : {0.01, 0.1, 0.3, 0.5, 0.8, 1.0}) {
          const double distance = share * left, bound = highest + slope * distance;
          const Real there = overlaps_at(group, share).first, risen = there - height;
          const double most = lanes.max(there + sag);
          ASSERT_LE(most, bound + roundings) << "group " << group << ", " << share;
          if (slope > 0) nearest = std::max(nearest, (most - highest) / (slope * distance));
          farthest = Kokkos::max(farthest, risen);
          const Real followed = course.most_risen(distance);
          ASSERT_EQ(lanes.at_least(farthest - followed, roundings), 0u) << share;
          // a list of groups counts on no more than this being added to the truth
          const double excess = distance * distance * faces.largest_face_curvature;
          ASSERT_EQ(lanes.at_least(followed - farthest, excess + roundings), 0u) << share;
          if (lanes.max(followed) > 0.01)
            nearest_node = std::max(nearest_node, lanes.max(farthest) / lanes.max(followed));
        }
      }
    }
    EXPECT_GT(nearest, 0.9);
    EXPECT_GT(nearest_node, 0.9);
  }
}

TEST(CandidateGroups, LeaveOutNothingThatTheCubicsMiss) {
  // one node just touches; the list is to hold for no travel
  Dice dice(6);
  for (int trial = 0; trial < 300; ++trial) {
    Bodies bodies(dice);
    const Amplitudes u = some(dice, 0.2);
    const double position = std::nextafter(dice.order(100)[0] + 1.0, 0);  // no way is left
    const int node = dice.order(Bodies::slider_nodes)[0];
    for (int n = 0; n < Bodies::slider_nodes; ++n)
      bodies.height1[n] -= bodies.overlap(u, position, n) + (n == node ? -1e-12 : 5);
    Lists lists(bodies.t);
    lists.find(u, bodies.place(position), 0);
    EXPECT_EQ(lists.listed(), std::vector<int>{node / width}) << "trial " << trial;
  }
}

TEST(CandidateGroups, AreThoseThatASearchOfEveryGroupFinds) {
  // The coarse pass is made once in many spacings. The groups that the second pass then finds must
  // not depend on when that was.
  Dice dice(2);
  for (int scene = 0; scene < 20; ++scene) {
    const Bodies bodies(dice, scene % 2 == 1,
                        scene % 3 == 1 ? Bodies::Faces::wavy : Bodies::Faces::linear);
    Lists kept(bodies.t);
    Amplitudes u = some(dice, 0.2);
    double position = dice.uniform(0, 10);
    for (int trial = 0; trial < 60; ++trial) {
      const double range = dice.ratio(1e-3, 0.2);
      Lists anew(bodies.t);
      kept.find(u, bodies.place(position), range);
      anew.find(u, bodies.place(position), range);
      ASSERT_EQ(kept.listed(), anew.listed()) << "scene " << scene << ", trial " << trial;
      const double travel_left = dice.ratio(1e-3, 0.1);
      if (trial % 2 == 0)
        u = elsewhere(dice, u, travel_left);
      else
        u[modes - 1] += dice.one_in(2) ? travel_left : -travel_left;
      position += dice.uniform(0, 1);
    }
    EXPECT_LT(kept.s.carried.sums.evaluated, 0.5 * 60 * Bodies::groups * width)
        << "the work that the coarse pass saves";
  }
}

TEST(CandidateGroups, ListNoGroupThatCannotComeIntoContact) {
  Dice dice(3);
  for (int trial = 0; trial < 300; ++trial) {
    const Bodies bodies(dice);
    Lists lists(bodies.t);
    const Amplitudes u = some(dice, 0.2);
    const double position = dice.uniform(0, 100), range = dice.ratio(1e-3, 1);
    const Place place = bodies.place(position);
    lists.find(u, place, range);
    // the error of the cubics, and the rise of the deflected beam over the rest of the spacing
    const double error = Bodies::weigh(bodies.tail, u) +
                         (place.base + 1 - position) * Bodies::weigh(bodies.slope, u) + 1e-12;
    for (const int group : lists.listed()) {
      double highest = -1e300;
      for (int n = group * width; n < std::min((group + 1) * width, Bodies::slider_nodes); ++n)
        for (const double x : {position, std::nextafter(place.base + 1, 0)}) {
          const int left = place.base + n;
          const double face = (x - place.base) * (bodies.height2[left + 1] - bodies.height2[left]);
          const double now =
              (position - place.base) * (bodies.height2[left + 1] - bodies.height2[left]);
          highest = std::max(highest, bodies.overlap(u, position, n) + face - now);
        }
      EXPECT_GE(highest, -(range + 2 * error)) << "trial " << trial << ", group " << group;
    }
  }
}

TEST(CandidateGroups, HoldUntilANodeIsPassedOrTheModesHaveGoneTooFar) {
  Dice dice(4);
  const Bodies bodies(dice);
  Lists lists(bodies.t);
  const Amplitudes u = some(dice, 0.2);
  EXPECT_FALSE(lists.holds(u, bodies.place(7.25), 0)) << "nothing has been found yet";
  lists.find(u, bodies.place(7.25), 0.125);
  EXPECT_TRUE(lists.holds(u, bodies.place(7.25), 0.125));
  EXPECT_TRUE(lists.holds(u, bodies.place(7.99), 0.125));
  EXPECT_FALSE(lists.holds(u, bodies.place(8), 0));
  EXPECT_FALSE(lists.holds(u, bodies.place(6.99), 0));
  EXPECT_EQ(lists.remaining_travel(u, bodies.place(7.25)), 0.125);
  Amplitudes there = u;
  there[0] = u[0] + 0.0625;
  EXPECT_NEAR(lists.remaining_travel(there, bodies.place(7.25)), 0.0625, 4 * eps);
  EXPECT_TRUE(lists.holds(there, bodies.place(7.25), 0.0624));
  EXPECT_FALSE(lists.holds(there, bodies.place(7.25), 0.0626));
}

TEST(CandidateGroups, AreAllOfThemWhereNothingIsKnown) {
  Dice dice(5);
  const Bodies bodies(dice);
  for (const double range :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    Lists lists(bodies.t);
    lists.find(some(dice, 0.2), bodies.place(3.5), range);
    EXPECT_EQ(lists.groups.count(), Bodies::groups);
  }
}

// ---- the constants of the proof, each where it is reached (proofs.md)

using test::BodiesByHand;

/// A search for candidate groups, over bodies made by hand.
struct Search {
  double range = 0, rounding = 0, back = 0;

  bool lists(const BodiesByHand& bodies, const Amplitudes& u) const {
    SceneState s = bodies.s;
    auto groups = test::candidate_groups_of<K>(bodies.t, s);
    groups.find(test::Packs(u).u, Place(bodies.t.motion, 0), range, rounding, back);
    return groups.count() > 0;
  }
  /// How far open the first node, which touches, may be and still be listed.
  double widest(BodiesByHand& bodies, const Amplitudes& u) const {
    double listed = 0, not_listed = 10;
    const double touching = bodies.height1[0];
    for (int i = 0; i < 60; ++i) {
      const double open = 0.5 * (listed + not_listed);
      bodies.height1[0] = touching - open;
      (lists(bodies, u) ? listed : not_listed) = open;
    }
    bodies.height1[0] = touching;
    return listed;
  }
};

const std::vector<double> up(1, 1.0);  // shape of a slider of one node that moves as a whole

TEST(CandidateGroupsProof, RangeRoundingsAndSlackCountInFull) {
  const Amplitudes still{};
  BodiesByHand bodies({}, {up}, 1);
  bodies.t.motion.position = 9;
  EXPECT_NEAR((Search{.range = 0.5}.widest(bodies, still)), 0.5, 1e-12);
  EXPECT_NEAR((Search{.rounding = 0.25}.widest(bodies, still)), 0.25, 1e-12);
  bodies.t.faces.rounding = 0.125;
  EXPECT_NEAR(Search{}.widest(bodies, still), 0.125, 1e-12);
}

TEST(CandidateGroupsProof, TheRestOfTheSpacingCountsOnADeflectedBeamsFlank) {
  // a node a quarter of the way on, and the flank of a wave that rises under it
  constexpr double beta = 1e-3, size = 100;
  BodiesByHand bodies({{beta, 9.625 + M_PI_2 / beta}}, {}, 1);
  bodies.t.motion.position = 9.25;
  Amplitudes u{};
  u[0] = size;
  bodies.set_overlap(0, 0, u, 9.25);
  const double risen = bodies.overlap(u, 10, 0) - bodies.overlap(u, 9.25, 0);
  const double widest = Search{}.widest(bodies, u);
  EXPECT_GE(widest, risen * (1 - 1e-9));
  EXPECT_LE(widest, risen * (1 + 1e-6));
  // and back to where an earlier stage stood, if that is farther
  const double before = bodies.overlap(u, 9.25, 0) - bodies.overlap(u, 8.35, 0);
  const double back = (Search{.back = 0.9}.widest(bodies, u));
  EXPECT_GE(back, before * (1 - 1e-9));
  EXPECT_LE(back, before * (1 + 1e-6));
}

/// Smooth faces of no curvature, but for the bounds that a test sets.
struct SmoothByHand : BodiesByHand {
  std::vector<double> curvature2, sag1, sag2, highest_sag2, modes_sag;

  SmoothByHand() : BodiesByHand({}, {up}, 1) {
    curvature2.assign(height2.size(), 0.0), sag1.assign(width, 0.0);
    sag2 = highest_sag2 = curvature2;
    modes_sag.assign(modes, 0.0);
    t.faces.smooth = true;
    t.faces.curvature2 = curvature2.data(), t.faces.sag1 = sag1.data();
    t.faces.sag2 = sag2.data(), t.faces.highest_sag2 = highest_sag2.data();
    t.bounds.cell_sag = modes_sag.data();
    t.motion.position = 9;
  }
};

TEST(CandidateGroupsProof, TheSagOfACellCountsInFull) {
  Amplitudes u{};
  SmoothByHand bodies;
  EXPECT_NEAR(Search{}.widest(bodies, u), 0, 1e-12);
  bodies.sag2[9] = bodies.highest_sag2[9] = 0.375;
  EXPECT_NEAR(Search{}.widest(bodies, u), 0.375, 1e-12);
  bodies.sag1[0] = -0.125;  // a hollow of one face counts against the other's summit
  EXPECT_NEAR(Search{}.widest(bodies, u), 0.25, 1e-12);
  bodies.sag1[0] = -0.5;
  EXPECT_NEAR(Search{}.widest(bodies, u), 0, 1e-12);
  // the modes', where they are and where they get to
  bodies.modes_sag[0] = 0.25, u[0] = -0.5;
  bodies.set_overlap(0, 0, u, 9);
  EXPECT_NEAR(Search{}.widest(bodies, u), 0.125, 1e-12);
  bodies.t.faces.sag_per_travel = 0.5;
  EXPECT_NEAR((Search{.range = 1}.widest(bodies, u)), 1.625, 1e-12);
}

TEST(CandidateGroupsProof, TheRiseOfAPieceIsReached) {
  Dice dice(9);
  SmoothByHand bodies;
  for (int trial = 0; trial < 2000; ++trial) {
    const double left = dice.uniform(-1, 1), right = dice.uniform(-1, 1);
    const Cubic piece = spline_piece(0, dice.uniform(-0.3, 0.3), left, right);
    const double theta = trial % 3 == 0 ? 0 : dice.uniform(0, 1);
    bodies.curvature2[9] = left, bodies.curvature2[10] = right;
    const PiecePassed<HostLanes> passed(lanes, bodies.t.faces, Place(bodies.t.motion, 0), 0);
    std::array<double, width> bound, upward;
    lanes.store(bound.data(), passed.rise(1 - theta, Real(piece.slope(theta))));
    lanes.store(upward.data(), passed.upward());
    EXPECT_EQ(upward[0], std::max({left, right, 0.0}));
    double rise = 0;
    for (int part = 0; part <= 64; ++part)
      rise = std::max(rise, piece(theta + (1 - theta) * part / 64.0) - piece(theta));
    ASSERT_GE(bound[0], rise - 4 * eps);
    if (left >= 0 && right >= 0) {
      ASSERT_NEAR(bound[0], rise, 4 * eps) << "largest at an end";
    }
  }
  // a parabola that ends as high as it begins
  bodies.curvature2[9] = bodies.curvature2[10] = -1;
  const PiecePassed<HostLanes> passed(lanes, bodies.t.faces, Place(bodies.t.motion, 0), 0);
  std::array<double, width> bound;
  lanes.store(bound.data(), passed.rise(1, Real(0.5)));
  EXPECT_NEAR(bound[0], 0.125, eps);
}

TEST(CandidateGroupsProof, TheRestOfTheSpacingCountsOnTheFaces) {
  const Amplitudes still{};
  constexpr double on = 0.25;  // of the way to the next node
  for (const double rise : {2.0, -2.0}) {
    BodiesByHand bodies({}, {up}, 1);
    bodies.height2[10] = rise;
    fill_highest(bodies.height2.data(), static_cast<int>(bodies.height2.size()), width,
                 bodies.highest2.data());
    bodies.t.motion.position = 9 + on;
    bodies.height1[0] = -on * rise;  // touches where it stands
    // ahead to the next node where the face rises, back to the last one where it falls
    const double comes = rise > 0 ? (1 - on) * rise : -on * rise;
    EXPECT_NEAR((Search{.back = on}.widest(bodies, still)), comes, 1e-12) << "rise " << rise;
  }
}

TEST(CandidateGroupsProof, WhatACubicOverAPatchLeavesOutIsReachedAtItsEdge) {
  // as in OverlapsProof: a node that touches, and is seen to be open by nearly all of the bound
  constexpr int wide = 256;
  const double radius = BodiesByHand::radius_of(wide), beta = 0.25 / radius;
  BodiesByHand bodies({{beta, 1.5 * wide}}, {}, 1, wide);
  bodies.t.motion.position = std::nextafter(wide - width / 2 + 1.0, 0);  // no way is left
  Amplitudes u{};
  u[0] = 1;
  bodies.slope[0] = 0;  // nor is any rise allowed for it
  bodies.set_overlap(0, 0, u, bodies.t.motion.position);
  const double z = beta * (0.5 * wide + width / 2 - 1), left_out = std::cos(z) - (1 - z * z / 2);
  EXPECT_GT(left_out, 0.9 * bodies.tail[0]);
  EXPECT_TRUE(Search{}.lists(bodies, u));
  EXPECT_NEAR(Search{}.widest(bodies, u), bodies.tail[0] - left_out, 1e-12);
}

TEST(CandidateGroupsProof, RoundingsOfAPositionReachHalfTheirBound) {
  // A place is rounded once, by half an ulp, and so is the next: 2^-52 of the larger in all. Twice
  // that is taken, for what is computed of them.
  for (const double position : {1.0, 4096.0}) {
    SceneTables t;
    t.motion.position = std::nextafter(position, 2 * position);
    const Place place(t.motion, 0);
    const double ulp = std::nextafter(position, 2 * position) - position;
    EXPECT_GE(position_rounding(place), 2 * ulp);
    EXPECT_NEAR(position_rounding(place), 2 * 0x1p-52 * (position + 1), 1e-3 * ulp);
  }
  // the steepest face, under a place that is off by that
  const Amplitudes still{};
  BodiesByHand bodies({}, {up}, 1);
  bodies.t.motion.position = 9, bodies.t.faces.steepest_rise = 0x1p49;
  EXPECT_NEAR(Search{}.widest(bodies, still), 2 * 10 * 0x1p-3, 1e-9);
}

TEST(CandidateGroupsProof, ACoarseListCoversAllPlacesOfAGroup) {
  // The list is made where the slider stands first, from the middle of each patch, and still holds
  // when it has come on by a group. By then the last node of the group stands on the flank of a
  // wave.
  constexpr int wide = 256, first = wide - width / 2 + wide - 1;  // its last place on patch 1
  constexpr double beta = 1e-6;
  BodiesByHand bodies({{beta, 1.5 * wide + M_PI_2 / beta}}, {}, width, wide);
  for (int n = 0; n + 1 < width; ++n) bodies.height1[n] = -1e9;
  Amplitudes u{};
  u[0] = 1 / beta;  // rises by 1 per chi
  SceneTables& t = bodies.t;
  t.motion.position = std::nextafter(first + width, 0);
  bodies.set_overlap(width - 1, 0, u, t.motion.position);  // it touches there
  auto groups = test::candidate_groups_of<K>(t, bodies.s);
  t.motion.position = first;
  ASSERT_EQ(GroupPlace<HostLanes>(t.patches, Place(t.motion, 0), 0).patch, 1);
  groups.find(test::Packs(u).u, Place(t.motion, 0), 0, 0, 0);
  t.motion.position = std::nextafter(first + width, 0);
  groups.find(test::Packs(u).u, Place(t.motion, 0), 1e-6, 0, 0);
  EXPECT_EQ(groups.count(), 1);
  // three chi less than where it stands would have done
  const double stands = 0.5 * wide + 2 * width - width / 2 - 2;
  const double bound = BodiesByHand::radius_of(wide) + width;
  EXPECT_NEAR(bodies.s.work.candidates.coarse_highest[0], bound - stands, 1e-3);
  EXPECT_GT(stands, 0.9 * bound);
}

TEST(CandidateGroupsProof, ACoarseListCountsTheMotionSinceItWasMade) {
  // The slider has come down by 0.5 since the coarse list was made, and the groups are to hold for
  // 0.25 more.
  BodiesByHand bodies({}, {up}, 1);
  bodies.t.motion.position = 9;
  Amplitudes u{}, there{};
  there[0] = 0.5;
  bodies.set_overlap(0, -0.25 * (1 - 1e-9), there, 9);
  auto groups = test::candidate_groups_of<K>(bodies.t, bodies.s);
  groups.find(test::Packs(u).u, Place(bodies.t.motion, 0), 0.25, 0, 0);
  EXPECT_EQ(groups.count(), 0);
  groups.find(test::Packs(there).u, Place(bodies.t.motion, 0), 0.25, 0, 0);
  EXPECT_EQ(groups.count(), 1);
  EXPECT_NEAR(bodies.s.work.candidates.coarse_highest[0], -0.75, 1e-8) << "still the first list";
}

}  // namespace
