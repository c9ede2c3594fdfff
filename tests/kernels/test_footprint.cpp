// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/footprint.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <vector>

#include "kernels/adaptive/modal_state.hpp"
#include "kernels/group_sweep.hpp"
#include "tests/areal_scenes.hpp"
#include "tests/dice.hpp"
#include "tests/filled.hpp"

/// Bounds on what the modes of an areal scene move the slider's nodes by.
namespace ra2d::test {
namespace {

/// Packs for the modes of these scenes: a plate's 60 and a free block's.
constexpr int many = (64 + width - 1) / width;

/// Tables of a slider that passes some hundred nodes of a plate with 60 modes.
struct Sliding : Filled {
  explicit Sliding(double length, double block_width)
      : Filled(areal_march(scene(length, block_width), 1e-6, 0.01).model, many * width) {}

  static ArealScene scene(double length, double block_width) {
    ArealScene s = small_areal_scene(Support::free, 60);
    s.block.length = length, s.block.width = block_width;
    const int nodes = static_cast<int>(std::lround(length / s.spacing)) + 1,
              rows = static_cast<int>(std::lround(block_width / s.spacing_y));
    s.plate_heights = rough_map(rows, 301, 2e-6, 1);
    s.block_heights = rough_map(rows, nodes, 2e-6, 2);
    return s;
  }
  Place place(double position) const {
    SliderMotion motion = t.motion;
    motion.position = position;
    return {motion, 0};
  }
  /// Of every node, row by row; `x`: lane by lane.
  std::vector<double> displacements(const std::vector<double>& x, double position) const {
    std::vector<double> all;
    for (int j = 0; j < model.rows; ++j)
      for (int i = 0; i < n.row_nodes; ++i)
        all.push_back(of_resonator(x, position, i, j) + of_slider(x, i, j));
    return all;
  }
  double of_slider(const std::vector<double>& x, int i, int j) const {
    double sum = 0;
    for (std::size_t k = 0; k < model.slider.modes.size(); ++k)
      sum +=
          x[modes() + k] * shape_at(model.slider.modes[k], i * model.scene.spacing, model.eta(j));
    return sum;
  }
  double of_resonator(const std::vector<double>& x, double position, int i, int j) const {
    double sum = 0;
    for (int k = 0; k < modes(); ++k)
      sum +=
          x[k] * shape_at(mode(k), (position + i) * model.scene.spacing, model.side + model.eta(j));
    return sum;
  }
};

struct ManyPacks {
  Real x[many];
  explicit ManyPacks(const std::vector<double>& of) {
    for (int p = 0; p < many; ++p) x[p] = lanes.load(of.data() + p * width);
  }
};

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}

TEST(Footprint, BoundsWhatAnyNodeIsMovedBy) {
  Dice dice(5);
  for (const auto& [size, degree, samples] :
       {std::tuple{2e-3, 2, 200}, std::tuple{5.8e-3, 4, 200}, std::tuple{15e-3, 8, 40}}) {
    const Sliding scene(size, size / 2);
    ASSERT_EQ(scene.t.bounds.footprint.degree, degree);
    const Footprint<HostLanes, many> footprint(lanes, scene.t.bounds);
    ASSERT_TRUE(footprint.exists());
    const int all = scene.modes() + static_cast<int>(scene.model.slider.modes.size());
    const double path = scene.model.advance * static_cast<double>(scene.model.steps);
    double tightest = 0, by_sizes = 0;
    for (int sample = 0; sample < samples; ++sample) {
      // all modes, or one alone, which comes nearest to the remainder
      std::vector<double> x(many * width, 0.0);
      const int one = sample % 2 == 0 ? -1 : sample / 2 % all;
      for (int k = 0; k < all; ++k)
        if (one < 0 || k == one) x[k] = dice.uniform(-1, 1) / scene.t.bounds.largest_shape[k];
      const double position = scene.model.position + dice.uniform(0, 1) * path;
      const double moved = largest(scene.displacements(x, position)),
                   bound = footprint.most(scene.place(position), ManyPacks(x).x);
      EXPECT_LE(moved, bound);
      if (one >= 0) continue;
      tightest = std::max(tightest, moved / bound);
      by_sizes =
          std::max(by_sizes, moved / weighted_sum<HostLanes, many>(
                                         lanes, scene.t.bounds.largest_shape, ManyPacks(x).x));
    }
    // of use: nearer to the truth than the sum of the modes' sizes
    EXPECT_GT(tightest, 0.4);
    EXPECT_GT(tightest, 1.3 * by_sizes);
  }
}

/// A motion of all nodes away from contact lowers the bound.
TEST(Footprint, BoundsWhatAnyNodeIsRaisedBy) {
  Dice dice(8);
  const Sliding scene(2e-3, 1e-3);
  const Footprint<HostLanes, many> footprint(lanes, scene.t.bounds);
  const int all = scene.modes() + static_cast<int>(scene.model.slider.modes.size());
  int away = 0;
  for (int sample = 0; sample < 300; ++sample) {
    // all modes, or one alone, or one of the slider's and the resonator's lowest
    std::vector<double> x(many * width, 0.0);
    const int one = sample % 3 == 0 ? -1 : dice.pick(all), own = scene.modes() + dice.pick(3);
    for (int k = 0; k < all; ++k)
      if (one < 0 || (sample % 3 == 1 ? k == one : k == own || k == 0))
        x[k] = dice.uniform(-1, 1) / scene.t.bounds.largest_shape[k];
    const double position = scene.model.position + dice.uniform(0, 40);
    const Place place = scene.place(position);
    const std::vector<double> moved = scene.displacements(x, position);
    const double highest = *std::max_element(moved.begin(), moved.end()),
                 bound = footprint.most_raised(place, ManyPacks(x).x);
    EXPECT_LE(highest, bound);
    EXPECT_LE(bound, (1 + 0x1p-42) * footprint.most(place, ManyPacks(x).x));
    away += bound < 0;
  }
  EXPECT_GT(away, 30);
  std::vector<double> x(many * width, 0.0);
  x[scene.modes()] = -1.0 / scene.t.bounds.largest_shape[scene.modes()];  // the slider's heave
  // but for the allowances for roundings
  EXPECT_NEAR(footprint.most_raised(scene.place(scene.model.position), ManyPacks(x).x), -1,
              0x1p-39);
}

/// The bound on the roundings of the sums rests on that (Overlaps::sums_error).
TEST(Footprint, PolynomialsOfAModeAddUpToLittle) {
  double most = 0;
  for (const double size : {2e-3, 5.8e-3, 15e-3}) {
    const Sliding scene(size, size / 2);
    const FootprintTables& tables = scene.t.bounds.footprint;
    for (int place = 0; place < tables.places; ++place)
      for (int k = 0; k < scene.modes(); ++k) {
        double sum = 0;
        for (int t = 0; t < tables.terms; ++t)
          sum += std::abs(
              tables
                  .rows[(static_cast<std::size_t>(place) * tables.terms + t) * scene.n.lanes + k]);
        most = std::max(most, sum / scene.t.bounds.largest_shape[k]);
      }
  }
  EXPECT_LT(most, 25);
  EXPECT_GT(most, 2);
}

/// The polynomial itself, at every node: off by no more than what it leaves out.
TEST(Footprint, IsWhatTheResonatorMovesTheNodesBy) {
  Dice dice(7);
  const Sliding small(5.8e-3, 2.5e-3), large(15e-3, 2.5e-3);
  double farthest = 0, moved = 0;
  for (int sample = 0; sample < 40; ++sample) {
    const Sliding& scene = sample % 2 == 0 ? small : large;
    const Footprint<HostLanes, many> footprint(lanes, scene.t.bounds);
    std::vector<double> terms(scene.n.footprint_sums());
    std::vector<double> x(many * width, 0.0);
    double left_out = 0;
    for (int k = 0; k < scene.modes(); ++k) {
      x[k] = dice.uniform(-1, 1) / scene.t.bounds.largest_shape[k];
      left_out += scene.t.bounds.footprint.remainder[k] * std::abs(x[k]);
    }
    const Place place = scene.place(std::floor(scene.model.position + dice.uniform(0, 40)));
    const ManyPacks at(x);
    const Real* const one[] = {at.x};
    footprint.expand(place, one, terms.data());
    for (int j = 0; j < scene.model.rows; ++j) {
      double along[highest_footprint_degree + 1];
      footprint.take_row(terms.data(), j, scene.model.rows, along);
      for (int i = 0; i < scene.n.row_nodes; i += width) {
        double found[width];
        lanes.store(found, footprint.displacement(place, along, Real(i) + lanes.index(),
                                                  scene.n.row_nodes));
        for (int l = 0; l < width && i + l < scene.n.row_nodes; ++l) {
          const double truly = scene.of_resonator(x, place.position, i + l, j);
          moved = std::max(moved, std::abs(truly));
          farthest = std::max(farthest, std::abs(found[l] - truly) / left_out);
        }
      }
    }
  }
  EXPECT_LE(farthest, 1);
  EXPECT_GT(farthest, 0.02) << "the remainder is of use";
  EXPECT_GT(moved, 1);
}

/// Overlaps by the polynomials, at every node: of the slider's motion nothing is left out.
TEST(Footprint, GivesTheOverlapsOfAllNodes) {
  Dice dice(8);
  const Sliding scene(5.8e-3, 2.5e-3);
  const Footprint<HostLanes, many> footprint(lanes, scene.t.bounds);
  std::vector<double> terms(scene.n.footprint_sums());
  double farthest = 0;
  for (int sample = 0; sample < 40; ++sample) {
    std::vector<double> x(many * width, 0.0);
    const auto all = scene.modes() + static_cast<int>(scene.model.slider.modes.size());
    const double by_resonator = sample % 2 == 0 ? 1e-6 : 0.0;
    for (int k = 0; k < all; ++k)
      x[k] = (k < scene.modes() ? by_resonator : 1e-6) * dice.uniform(-1, 1) /
             scene.t.bounds.largest_shape[k];
    Model there = scene.model;
    there.position += dice.uniform(0, 40);
    const Place place = scene.place(there.position);
    const ManyPacks at(x);
    const Real* const one[] = {at.x};
    footprint.expand(place, one, terms.data());
    const double left_out = footprint.left_out(ManyPacks(x).x, scene.modes());
    double truly_left_out = 0;
    for (int k = 0; k < scene.modes(); ++k)
      truly_left_out += scene.t.bounds.footprint.remainder[k] * std::abs(x[k]);
    EXPECT_NEAR(left_out, truly_left_out, 1e-12 * truly_left_out);
    const auto slider = x.begin() + scene.modes();
    const std::vector<double> over =
        overlaps(there, {x.begin(), slider}, {slider, x.begin() + all});
    FootprintSweep<HostLanes, many> sweep(lanes, scene.t.faces, scene.t.slider, scene.t.bounds,
                                          place, terms.data(), x.data());
    for (const int group : dice.order(scene.n.groups)) {
      double found[width];
      lanes.store(found, sweep.overlap(group).overlap);
      const int row = group / scene.n.row_groups, first = group % scene.n.row_groups * width;
      for (int l = 0; l < width && first + l < scene.n.row_nodes; ++l) {
        const double off = std::abs(found[l] - over[row * scene.n.row_nodes + first + l]);
        EXPECT_LE(off, left_out + 1e-18) << "group " << group;
        if (left_out > 0) farthest = std::max(farthest, off / left_out);
      }
    }
  }
  EXPECT_GT(farthest, 0.02) << "the remainder is of use";
}

/// With the slider's part in the middle of each group taken off.
TEST(Footprint, BoundsWhatIsNotFollowedInGroups) {
  Dice dice(6);
  const Sliding scene(5.8e-3, 2.5e-3);
  const Footprint<HostLanes, many> footprint(lanes, scene.t.bounds);
  const int all = scene.modes() + static_cast<int>(scene.model.slider.modes.size());
  for (int sample = 0; sample < 100; ++sample) {
    std::vector<double> x(many * width, 0.0);
    // most by the slider, then by the slider alone
    for (int k = sample % 2 == 0 ? 0 : scene.modes(); k < all; ++k)
      x[k] = dice.uniform(-1, 1) / scene.t.bounds.largest_shape[k];
    const double position = scene.model.position + dice.uniform(0, 40);
    const ManyPacks one(x), none(std::vector<double>(many * width, 0.0));
    const Place place = scene.place(position);
    std::vector<double> sums(2 * scene.n.footprint_sums(), 1e300);
    const Real* const both[] = {one.x, none.x};
    footprint.expand(place, both, sums.data());
    const double* const from = sums.data() + scene.n.footprint_sums();
    const double bound = footprint.most_in_group(sums.data(), from, one.x);
    const double roundings = 2 * 13 * MotionBounds{0, 0, 0, 1.0 * all}.rounding();  // sums_error
    EXPECT_NEAR(footprint.most(sums.data(), from, one.x), footprint.most(place, one.x), roundings);
    EXPECT_NEAR(footprint.most_raised(sums.data(), from, one.x),
                footprint.most_raised(place, one.x), roundings);
    double left = 0;
    for (int j = 0; j < scene.model.rows; ++j)
      for (int i = 0; i < scene.n.row_nodes; ++i) {
        const int group = j * scene.n.row_groups + i / width;
        double displacement = scene.of_resonator(x, position, i, j) + scene.of_slider(x, i, j);
        for (int k = 0; k < scene.t.slider.modes; ++k)
          displacement -= shape_in_group<HostLanes, many>(scene.t.faces, scene.t.slider, group, k) *
                          x[scene.modes() + k];
        left = std::max(left, std::abs(displacement));
      }
    EXPECT_LE(left, bound);
    if (sample % 2 == 1) {
      EXPECT_LT(bound, 0.5 * footprint.most(scene.place(position), one.x));
      if constexpr (width > 1) {  // groups of one node are followed whole
        EXPECT_GT(left, 0.05 * bound);
      }
    }
  }
}

}  // namespace
}  // namespace ra2d::test
