// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/device/fill.hpp"
#include "host/device/layout.hpp"
#include "kernels/adaptive/contact_clusters.hpp"
#include "kernels/adaptive/contacts.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/adaptive/slider_path.hpp"
#include "kernels/contact/clustered_contact.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/dice.hpp"
#include "tests/eight_modes.hpp"
#include "tests/kernels_of.hpp"
#include "tests/schemes.hpp"

/// Sums over the modes that the nodes of a cluster or of a square share, against those of each node
/// by itself.
namespace {

using namespace ra2d;
using test::Dice, test::eps, test::width;

constexpr int clustered_modes = 43;  // of fine_maps(): 40 of the plate, 3 of the block
constexpr int P = (clustered_modes + width - 1) / width;
static_assert(P > 3);
using Series = ModalSeries<HostLanes, P>;
using Packs = std::array<HostLanes::Real, P>;

const HostLanes lanes{clustered_modes};

/// A scene with more room than one makes in a march.
struct Scene {
  Model model;
  PatchSeries series;
  Extents n;
  SceneTables t;
  SceneState s;
  std::vector<std::vector<double>> arrays;
  Packs u, v;

  explicit Scene(double tolerance, int rows = 24, int nodes = 40)
      : Scene(test::areal_march(of(rows, nodes), tolerance, 1e-4).model) {}
  explicit Scene(Model marched)
      : model{std::move(marched)},
        series{choose_series(model, width)},
        n{extents_of(model, series, P * width, width, {.nodes = 4096})} {
    const auto provide = [&](const char*, auto*& array, std::size_t count) {
      using Value = std::remove_const_t<std::remove_reference_t<decltype(*array)>>;
      arrays.emplace_back(count * sizeof(Value) / sizeof(double) + 1, 0.0);
      array = reinterpret_cast<Value*>(arrays.back().data());
    };
    visit_arrays(t, n, provide);
    visit_arrays(s.carried, n, provide);
    visit_arrays(s.marks, n, provide);
    visit_arrays(s.caches, n, provide);
    visit_arrays(s.work, n, provide);
    fill(t, model, series, n, HostCopy());
    s.marks.slots = static_cast<int>(n.slots());
    s.work.spans.capacity = n.contacts;
  }
  Scene(const Scene&) = delete;
  static test::ArealScene of(int rows, int nodes) {
    test::ArealScene scene = test::fine_maps();
    scene.block.length = (nodes - 1) * scene.spacing, scene.block.width = rows * scene.spacing_y;
    scene.plate_heights = test::rough_map(rows, 3420 + nodes, 1e-7, 5);
    scene.block_heights = test::rough_map(rows, nodes, 1e-7, 6);
    return scene;
  }

  int number(int row, int along) const { return row * static_cast<int>(n.padded_row()) + along; }
  void touch(std::vector<int> nodes) {
    std::sort(nodes.begin(), nodes.end());
    std::copy(nodes.begin(), nodes.end(), s.carried.contacts.nodes);
    s.carried.contacts.count = static_cast<int>(nodes.size());
  }
  void draw_motion(Dice& dice) {
    std::array<double, P * width> at{}, rate{};
    for (int k = 0; k < clustered_modes; ++k) {
      rate[k] = dice.uniform(-1, 1) * 1e-4;
      at[k] = dice.uniform(-1, 1) * 1e-4 / std::max(t.modes.omega[k], 1e4);
    }
    for (int p = 0; p < P; ++p) {
      u[p] = lanes.load(at.data() + p * width);
      v[p] = lanes.load(rate.data() + p * width);
    }
  }
  ContactClusters<HostLanes, P> clusters() { return test::clusters_of<P>(t, s, lanes); }
  Series modal_series() { return test::series_of<P>(t, s, lanes); }
  double of_lanes(const double* weights, const Packs& x) const {
    double sum = 0;
    for (int k = 0; k < clustered_modes; ++k)
      sum += weights[k] * std::abs(x[k / width][static_cast<std::size_t>(k % width)]);
    return sum;
  }
};

/// The nodes of some rectangles of the block's face, in ascending order.
std::vector<int> patches_of(const Scene& m, Dice& dice, int rows, int nodes) {
  std::vector<int> list;
  for (int i = 0; i < 3; ++i) {
    const int row = dice.pick(rows - 8), along = dice.pick(nodes - 8), high = 5 + dice.pick(4),
              wide = 5 + dice.pick(4);
    for (int j = row; j < row + high; ++j)
      for (int k = along; k < along + wide; ++k) list.push_back(m.number(j, k));
  }
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

/// The result of a series: the modes, and of each node in contact overlap and sliding rate.
struct Made {
  std::vector<double> modes, nodes;
  Made(const Scene& m, int contacts)
      : modes(m.s.work.series.modes, m.s.work.series.modes + (most_order + 1) * P * width),
        nodes(m.s.work.series.nodes,
              m.s.work.series.nodes + static_cast<std::ptrdiff_t>(contacts) * 2 * overlap_terms) {}
};

class Clusters : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Degrees, Clusters, testing::Values(1e-6, 1e-8));

TEST_P(Clusters, MoveTheModesAsSingleNodesDo) {
  const double tolerance = GetParam();
  Dice dice(3);
  Scene m(tolerance);
  ASSERT_EQ(m.t.clusters.degree, tolerance == 1e-6 ? 2 : 3);
  for (int trial = 0; trial < 30; ++trial) {
    m.touch(patches_of(m, dice, 24, 40));
    m.draw_motion(dice);
    const int contacts = m.s.carried.contacts.count;
    const Place place = SliderPath(m.t.motion).at(dice.pick(1'000'000) * std::int64_t{1000});
    const double scale = dice.ratio(2e-6, 6e-6);
    Series shared = m.modal_series();
    ASSERT_TRUE(shared.expand(m.u.data(), m.v.data(), place, scale));
    ASSERT_GE(shared.cluster_of(m.s.carried.contacts.nodes[0]), 0);
    ASSERT_GT(shared.neglected(), 0);
    const Made in_clusters(m, contacts);
    const double end = std::min(1.0, shared.usable_length(tolerance));
    const int degree = m.t.clusters.degree;
    m.t.clusters.degree = 0;
    Series apart = m.modal_series();
    ASSERT_TRUE(apart.expand(m.u.data(), m.v.data(), place, scale));
    ASSERT_LT(apart.cluster_of(m.s.carried.contacts.nodes[0]), 0);
    const Made single(m, contacts);
    m.t.clusters.degree = degree;

    const double rounding = 64 * eps * (m.of_lanes(m.t.bounds.largest_shape, m.u) + 1e-6);
    for (int e = 0; e < contacts; ++e) {
      const double *a = in_clusters.nodes.data() + e * 2 * overlap_terms,
                   *b = single.nodes.data() + e * 2 * overlap_terms;
      // both leave out a part of their own
      EXPECT_NEAR(a[0], b[0], shared.neglected() + apart.neglected() + rounding);
      double over[2]{}, rate[2]{};
      for (int i = 0; i < 2; ++i) {
        over[i] = polynomial(i == 0 ? a : b, shared.degree(), end);
        rate[i] = polynomial((i == 0 ? a : b) + overlap_terms, shared.degree(), end);
      }
      const double moved = m.of_lanes(m.t.bounds.largest_shape, m.v) * scale;
      EXPECT_NEAR(over[0], over[1], tolerance * moved + rounding);
      EXPECT_NEAR(rate[0], rate[1], tolerance * moved + rounding);
    }
    // in the energy norm, at the end of the step
    double difference = 0, size = 0;
    for (int k = 0; k < clustered_modes; ++k) {
      const auto speed_of = [&](const Made& made) {
        double sum = 0;
        for (int j = m.t.adaptive.order; j > 0; --j)
          sum = sum * end + j * made.modes[j * P * width + k];
        return sum / scale;
      };
      difference += m.t.modes.mass[k] * std::pow(speed_of(in_clusters) - speed_of(single), 2);
      size += m.t.modes.mass[k] * std::pow(speed_of(single), 2);
    }
    EXPECT_LT(std::sqrt(difference / size), tolerance);
  }
}

/// Nodes too few for clusters have sums of their own, from which overlaps and sliding rates follow
/// in another order than of plane scenes. One or two have a loop of their own.
TEST_P(Clusters, LeaveSingleNodesTheirOwnSums) {
  const double tolerance = GetParam();
  Dice dice(9);
  Scene m(tolerance, 60, 120);
  std::array<int, 5> terms{};
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<int> nodes;
    for (int i = 0; i < 1 + trial % 4; ++i)
      nodes.push_back(m.number(2 + 16 * i + dice.pick(8), dice.pick(120)));
    m.touch(nodes);
    m.draw_motion(dice);
    const int contacts = m.s.carried.contacts.count;
    const Place place = SliderPath(m.t.motion).at(dice.pick(1'000'000) * std::int64_t{1000});
    const double scale = dice.ratio(3e-7, 6e-5);
    Series moments = m.modal_series();
    ASSERT_TRUE(moments.expand(m.u.data(), m.v.data(), place, scale));
    ASSERT_LT(moments.cluster_of(m.s.carried.contacts.nodes[0]), 0);
    const Made by_moments(m, contacts);
    const double end = std::min(1.0, moments.usable_length(tolerance));
    const int free = m.number(1, dice.pick(120));
    std::array<double, overlap_terms> side_by_side, in_turn;
    ASSERT_TRUE(moments.expand_nodes(place, &free, 1));
    moments.overlap_of(free, place, side_by_side.data());
    double* const buffer = std::exchange(m.s.work.series.moments, nullptr);
    Series plain = m.modal_series();
    ASSERT_TRUE(plain.expand(m.u.data(), m.v.data(), place, scale));
    const Made single(m, contacts);
    ASSERT_TRUE(plain.expand_nodes(place, &free, 1));
    plain.overlap_of(free, place, in_turn.data());
    m.s.work.series.moments = buffer;
    ASSERT_EQ(moments.wanted_terms(), plain.wanted_terms());
    ++terms[moments.wanted_terms()];
    const double moved = m.of_lanes(m.t.bounds.largest_shape, m.v) * scale,
                 rounding = 256 * eps * (m.of_lanes(m.t.bounds.largest_shape, m.u) + moved + 1e-6);
    EXPECT_NEAR(polynomial(side_by_side.data(), moments.degree(), end),
                polynomial(in_turn.data(), plain.degree(), end), rounding)
        << "trial " << trial;
    for (int e = 0; e < contacts; ++e)
      for (int rate = 0; rate < 2; ++rate) {
        const int at = (2 * e + rate) * overlap_terms;
        EXPECT_NEAR(polynomial(by_moments.nodes.data() + at, moments.degree(), end),
                    polynomial(single.nodes.data() + at, plain.degree(), end), rounding)
            << "trial " << trial << ", node " << e;
      }
  }
  EXPECT_GE(std::count_if(terms.begin(), terms.end(), [](int n) { return n > 0; }), 2);
}

/// The part of a shape that polynomials leave out, at the corners of what a place has in reach.
TEST(ContactClusters, LeaveOutNoMoreThanTheirBound) {
  const Model model = test::areal_march(test::fine_maps(), 1e-6, 1e-4).model;
  const double along = (cluster_reach + 0.5) * model.scene.spacing,
               across = cluster_reach * model.spacing_y;
  Dice dice(2);
  double nearest = 0;
  for (const int degree : {2, 3})
    for (int trial = 0; trial < 2000; ++trial) {
      const BodyMode& mode = model.resonator.modes[static_cast<std::size_t>(dice.pick(40))];
      const double x = dice.uniform(along, model.scene.resonator.length - along),
                   y = dice.uniform(across, model.scene.resonator.width - across);
      double of_x[4], of_y[4], along_there, across_there;
      mode.shape->evaluate(x, 4, of_x);
      mode.shape->evaluate_across(y, 4, of_y);
      for (const double dx : {-along, along})
        for (const double dy : {-across, across}) {
          mode.shape->evaluate(x + dx, 1, &along_there);
          mode.shape->evaluate_across(y + dy, 1, &across_there);
          double polynomial = 0;
          for (int a = 0; a <= degree; ++a)
            for (int b = 0; a + b <= degree; ++b)
              polynomial += of_x[a] * std::pow(dx, a) / std::tgamma(a + 1) * of_y[b] *
                            std::pow(dy, b) / std::tgamma(b + 1);
          const double bound = cluster_remainder(model, mode, degree),
                       rounding = 8 * eps * mode.shape->size();
          ASSERT_LE(std::abs(along_there * across_there - polynomial), bound + rounding);
          if (bound > 100 * rounding)
            nearest = std::max(nearest, std::abs(along_there * across_there - polynomial) / bound);
        }
    }
  EXPECT_GT(nearest, 0.45);
}

/// Forces of fixed steps at nodes and on modes.
struct Pressed {
  std::map<int, double> forces;  // of the nodes in contact
  double sum;
  std::array<double, P * width> modal{};

  template <class Contact>
  Pressed(const Scene& m, const Contact& contact, const Place& place,
          const std::vector<int>& list) {
    const int count = static_cast<int>(list.size());
    EXPECT_TRUE(contact.expand(place, list.data(), count));
    Packs force;
    force.fill(HostLanes::Real(0.0));
    const auto totals = contact(place, m.u.data(), list.data(), count, force.data());
    sum = totals.force;
    for (int i = 0; i < totals.nodes; ++i)
      forces[m.s.work.contact_list.nodes[i]] = m.s.work.contact_list.forces[i];
    for (int p = 0; p < P; ++p) lanes.store(modal.data() + p * width, force[p]);
  }
  double of(int node) const { return forces.contains(node) ? forces.at(node) : 0.0; }
};

/// In squares a mode's shape is off by what polynomials leave out, and nothing else.
TEST(ContactSquares, PressAsSingleNodesDo) {
  if (width > square_nodes) GTEST_SKIP() << "a group is wider than a square";
  Dice dice(6);
  Scene m(test::areal_march(Scene::of(24, 40), test::scheme_of(SchemeKind::midpoint), 1e-8, 10'000)
              .model);
  ASSERT_GT(m.t.clusters.degree, 0);
  int pressed = 0;
  double nearest = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const int degree = m.t.clusters.degree = trial < 30 ? 2 : 3;
    if (trial == 30) m.s.marks.places_used = 0;  // those of the other degree
    const std::vector<int> list = patches_of(m, dice, 24, 40);
    m.draw_motion(dice);
    const Place place(m.t.motion, dice.pick(10'000));
    const Pressed single(m, test::node_contact_of<P>(m.t, m.s), place, list);
    const ClusteredContact<HostLanes, P> clustered(lanes, m.t, m.s,
                                                   test::node_contact_of<P>(m.t, m.s));
    const Pressed squares(m, clustered, place, list);

    // of each shape; single nodes' cubics over a window, far shorter than a square, leave out less
    std::array<double, P * width> left_out{};
    for (std::size_t k = 0; k < m.model.resonator.modes.size(); ++k)
      left_out[k] = 2 * cluster_remainder(m.model, m.model.resonator.modes[k], degree);
    const double off = m.of_lanes(left_out.data(), m.u),
                 rounding = 64 * eps * (m.of_lanes(m.t.bounds.largest_shape, m.u) + 1e-6);
    const double of_force = m.t.contact.node_stiffness * (off + rounding);
    double largest = 0;
    for (const int node : list)
      largest = std::max(largest, std::abs(squares.of(node) - single.of(node)));
    EXPECT_LE(largest, of_force);
    nearest = std::max(nearest, largest / of_force);
    const auto nodes = static_cast<double>(std::max(single.forces.size(), squares.forces.size()));
    EXPECT_NEAR(squares.sum, single.sum, nodes * of_force);
    for (int k = 0; k < clustered_modes; ++k)
      EXPECT_NEAR(squares.modal[k], single.modal[k],
                  nodes * of_force * m.t.bounds.largest_shape[k] +
                      single.sum * (left_out[k] + 64 * eps * m.t.bounds.largest_shape[k]));
    pressed += single.forces.size() > 10 ? 1 : 0;
  }
  EXPECT_GT(pressed, 15);
  EXPECT_GT(nearest, 0.01);
}

/// The polynomials of a cluster hold for the free nodes about it, too.
TEST_P(Clusters, ServeFreeNodes) {
  Dice dice(4);
  Scene m(GetParam());
  int served = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const int row = 6 + dice.pick(10), along = 6 + dice.pick(20);
    std::vector<int> nodes;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) nodes.push_back(m.number(row + j, along + i));
    m.touch(nodes);
    m.draw_motion(dice);
    const Place place = SliderPath(m.t.motion).at(dice.pick(1'000'000) * std::int64_t{1000});
    Series shared = m.modal_series();
    ASSERT_TRUE(shared.expand(m.u.data(), m.v.data(), place, 3e-6));
    for (const int node : {m.number(row - 1, along), m.number(row + 4, along + 1),
                           m.number(row + 1, along - 1), m.number(0, 0)}) {
      ASSERT_TRUE(shared.expand_nodes(place, &node, 1));
      std::array<double, overlap_terms> by_cluster, by_itself;
      shared.overlap_of(node, place, by_cluster.data());
      served += shared.cluster_of(node) >= 0 ? 1 : 0;
      Series other = shared;
      other.forget_clusters();
      ASSERT_TRUE(other.expand_nodes(place, &node, 1));
      other.overlap_of(node, place, by_itself.data());
      const double moved = m.of_lanes(m.t.bounds.largest_shape, m.v) * 3e-6;
      for (int j = 0; j <= shared.degree(); ++j)
        EXPECT_NEAR(by_cluster[j], by_itself[j], GetParam() * moved + 1e-20);
    }
  }
  EXPECT_GE(served, 10);
}

/// Bounds on a step hold for what its series do.
TEST_P(Clusters, BoundsHold) {
  Dice dice(5);
  Scene m(GetParam());
  for (int trial = 0; trial < 20; ++trial) {
    m.touch(patches_of(m, dice, 24, 40));
    m.draw_motion(dice);
    const Place place = SliderPath(m.t.motion).at(dice.pick(1'000'000) * std::int64_t{1000});
    const double scale = dice.ratio(2e-6, 6e-6);
    Series shared = m.modal_series();
    ASSERT_TRUE(shared.expand(m.u.data(), m.v.data(), place, scale));
    const Contacts<HostLanes, P> contacts(lanes, m.s.carried.contacts, m.s.work.spans,
                                          m.s.work.listed_nodes, m.s.work.search.onsets,
                                          m.s.work.search.bernstein);
    const double end = std::min(1.0, shared.usable_length(GetParam()));
    contacts.first_end(shared, end, 1e-15);
    const MotionBounds bounds = shared.bounds(end);
    const double* const rows = m.s.work.series.modes;
    double travel = 0;
    for (int k = 0; k < clustered_modes; ++k) {
      double moved = 0;
      for (int j = m.t.adaptive.order; j > 0; --j) moved = (moved + rows[j * P * width + k]) * end;
      travel += m.t.bounds.largest_shape[k] * std::abs(moved);
    }
    EXPECT_LE(travel, bounds.travel);
    for (int e = 0; e < m.s.carried.contacts.count; ++e) {
      const double* o = shared.overlap(e);
      double derivative = 0;
      for (int j = shared.degree(); j >= 4; --j)
        derivative = 0.5 * end * derivative + j * (j - 1.0) * (j - 2) * (j - 3) * o[j];
      EXPECT_LE(std::abs(derivative) / std::pow(scale, 4), bounds.fourth_derivative);
    }
  }
}

TEST(ContactClusters, LeaveSingleNodesAlone) {
  Dice dice(6);
  Scene m(1e-6, 60, 120);
  m.draw_motion(dice);
  m.u.fill(HostLanes::Real(0.0));
  m.t.contact.node_stiffness = 1;  // it is only asked which nodes share their sums
  const Place place = SliderPath(m.t.motion).at(1'000'000);
  const auto shares_sums = [&](std::vector<int> nodes) {
    m.touch(std::move(nodes));
    Series series = m.modal_series();
    EXPECT_TRUE(series.expand(m.u.data(), m.v.data(), place, 3e-6));
    return series.cluster_of(m.s.carried.contacts.nodes[0]) >= 0;
  };
  const auto block = [&](int row, int along, int size) {
    std::vector<int> nodes;
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) nodes.push_back(m.number(row + j, along + i));
    return nodes;
  };
  EXPECT_TRUE(shares_sums(block(10, 10, 4)));
  EXPECT_FALSE(shares_sums(block(10, 10, 1)));
  EXPECT_FALSE(shares_sums({m.number(3, 5), m.number(30, 50), m.number(50, 110)}));
  EXPECT_TRUE(shares_sums(block(1, 1, 20)));   // 35 clusters at the most
  EXPECT_FALSE(shares_sums(block(1, 1, 50)));  // more than 48
}

/// Places are kept for a window; when there is no room for more, all begin anew.
TEST(ContactClusters, ComeToTheSameBitsWhateverPlacesAreKept) {
  Scene m(1e-6, 60, 120), fresh(1e-6, 60, 120);
  const auto to_next_node = static_cast<std::int64_t>(1 / m.t.motion.advance);
  Dice dice(7);
  int places = 0;
  for (int trial = 0; trial < 60; ++trial) {
    m.touch(patches_of(m, dice, 60, 120));
    m.draw_motion(dice);
    fresh.touch(
        {m.s.carried.contacts.nodes, m.s.carried.contacts.nodes + m.s.carried.contacts.count});
    fresh.u = m.u, fresh.v = m.v;
    fresh.s.marks.places_window = -1;
    const Place place = SliderPath(m.t.motion).at(1'000'000 + trial / 20 * to_next_node);
    ASSERT_TRUE(m.modal_series().expand(m.u.data(), m.v.data(), place, 3e-6));
    ASSERT_TRUE(fresh.modal_series().expand(m.u.data(), m.v.data(), place, 3e-6));
    places += fresh.s.marks.places_used;
    const Made a(m, m.s.carried.contacts.count), b(fresh, m.s.carried.contacts.count);
    ASSERT_EQ(std::memcmp(a.modes.data(), b.modes.data(), a.modes.size() * sizeof(double)), 0);
    ASSERT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(double)), 0);
  }
  EXPECT_GT(places, 2 * most_places);
}

}  // namespace
