// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "tests/areal_scenes.hpp"
#include "tests/dice.hpp"
#include "tests/filled.hpp"
#include "tests/kernels_of.hpp"
#include "tests/schemes.hpp"

/// Candidate groups of areal scenes, found by tiles of nodes, against every node.
namespace ra2d::test {
namespace {

/// The lists of a scene, and where the slider stands.
struct Searched : Filled {
  SceneState s;
  std::vector<int> groups, coarse_groups, tiles, columns;
  std::vector<double> reference, coarse_reference, coarse_highest, coarse_displacement,
      displacement, amplitudes, footprint;

  Searched(const Model& model, int all_packs) : Filled(model, all_packs * width) {
    for (std::vector<int>* list : {&groups, &coarse_groups}) list->assign(n.groups, 0);
    tiles.assign(n.padded_tiles(), 0);
    columns.assign(n.row_groups, 0);
    for (std::vector<double>* row : {&reference, &coarse_reference}) row->assign(n.lanes, 0.0);
    for (std::vector<double>* row : {&coarse_highest, &coarse_displacement})
      row->assign(n.groups + n.width, 0.0);
    displacement.assign(n.padded_tiles() + n.width, 0.0);
    amplitudes.assign(2 * n.lanes, 0.0);
    footprint.assign(n.footprint_sums(), 0.0);
    CandidateLists& lists = s.work.candidates;
    lists.groups = groups.data(), lists.coarse_groups = coarse_groups.data();
    lists.tiles = tiles.data(), lists.columns = columns.data();
    lists.tile_displacement = displacement.data();
    lists.reference_u = reference.data(), lists.coarse_reference_u = coarse_reference.data();
    lists.coarse_highest = coarse_highest.data();
    lists.coarse_displacement = coarse_displacement.data();
    lists.footprint = footprint.data();
    s.work.amplitudes = amplitudes.data();
  }
  /// Of all nodes, by their number along a row and the row; displacements lane by lane.
  std::vector<double> overlaps_at(const std::vector<double>& u, double position) {
    model.position = position;
    const auto first = u.begin();
    const auto modes2 = static_cast<std::ptrdiff_t>(model.resonator.modes.size()),
               modes1 = static_cast<std::ptrdiff_t>(model.slider.modes.size());
    return overlaps(model, {first, first + modes2}, {first + modes2, first + modes2 + modes1});
  }
};

/// Displacements of some `size` [m] at the nodes.
std::vector<double> random_motion(const Searched& of, Dice& dice, double size) {
  std::vector<double> u(of.n.lanes, 0.0);
  const std::size_t modes = of.model.resonator.modes.size() + of.model.slider.modes.size();
  for (std::size_t k = 0; k < modes; ++k)
    u[k] = size / static_cast<double>(modes) * dice.uniform(-1, 1) / of.t.bounds.largest_shape[k];
  return u;
}

template <int all>
struct RealPacks {
  Real u[all];
  explicit RealPacks(const std::vector<double>& of) {
    for (int p = 0; p < all; ++p) u[p] = lanes.load(of.data() + p * width);
  }
};

/// While a list holds no other node comes into contact: wherever the slider stands within the
/// spacing, and the modes within the range. Lists that follow one another share a coarse pass.
template <int packs>
void list_every_node_that_can_touch(int modes, bool fine = false) {
  Dice dice(7);
  int touching = 0;
  std::size_t listed = 0, all = 0;
  for (int scene = 0; scene < (fine ? 2 : 12); ++scene) {
    ArealScene of = many_nodes();
    of.plate_heights = rough_map(37, 1201, 2e-6, 10 + scene);
    if (fine) {  // many tiles: modes differ far more across the block than across one
      of.spacing = of.spacing_y = 2e-5;
      of.block.length = 599 * of.spacing, of.block.width = 37 * of.spacing_y;
      of.plate_heights = rough_map(37, 3001, 2e-6, 10 + scene);
      of.block_heights = rough_map(37, 600, 2e-6, 4);
    }
    for (std::vector<double>& row : of.plate_heights)  // an asperity of one node here and there
      for (double& h : row) h += dice.one_in(100) ? dice.uniform(3e-6, 5e-6) : 0.0;
    of.plate.modes = modes;
    of.side = dice.uniform(0, of.plate.width - of.block.width);
    Searched searched(areal_march(of, schemes[0], 1e-8, 100).model, packs);
    ASSERT_EQ(searched.n.footprint_terms > 0, packs > 3);
    CandidateGroups<HostLanes, packs> groups = candidate_groups_of<packs>(searched.t, searched.s);
    // with far bends what the modes differ by within a tile counts
    const double far = std::pow(10, dice.uniform(-6.5, -3.5));
    std::vector<double> u = random_motion(searched, dice, far);
    if (fine || scene % 2 == 1) {  // one mode comes nearer to the bound than many
      u.assign(u.size(), 0.0);
      const int k = static_cast<int>(dice.uniform(0, searched.modes()));
      u[k] = far / searched.t.bounds.largest_shape[k];
    }
    const double begin = of.start / of.spacing;  // chi
    const std::vector<double> flat = searched.overlaps_at(u, begin);
    const double level = *std::max_element(flat.begin(), flat.end());
    const double range = scene % 4 < 2 ? 1e-7 : std::pow(10, dice.uniform(-9.5, -7));
    for (double& h : searched.model.slider_height.edit()) h -= level + 2 * range;
    fill(searched.t, searched.model, searched.series, searched.n, HostCopy());
    SliderMotion motion = searched.t.motion;
    for (int step = 0; step < (fine ? 24 : 30); ++step) {
      motion.position = begin + 0.61 * step;
      Place place(motion, 0);
      groups.find(RealPacks<packs>(u).u, place, range, 1e-14, 0.0);
      std::set<int> nodes;
      for (int e = 0; e < groups.count(); ++e)
        for (int i = 0; i < width; ++i) nodes.insert(groups[e] * width + i);
      listed += groups.count(), all += searched.n.groups;
      for (int e = 1; e < groups.count(); ++e) EXPECT_LT(groups[e - 1], groups[e]);
      for (const double share : {0.0, 0.5, 0.999}) {
        std::vector<double> moved = random_motion(searched, dice, range);
        for (std::size_t k = 0; k < moved.size(); ++k) moved[k] += u[k];
        const double position = motion.position + share * (place.base + 1 - motion.position);
        const std::vector<double> over = searched.overlaps_at(moved, position);
        for (int node = 0; node < static_cast<int>(over.size()); ++node) {
          if (over[node] < 0) continue;
          ++touching;
          const int row = node / searched.n.row_nodes, along = node % searched.n.row_nodes;
          EXPECT_EQ(nodes.count(row * static_cast<int>(searched.n.padded_row()) + along), 1u)
              << "node " << along << " of row " << row << ", step " << step;
        }
      }
      const std::vector<double> drift = random_motion(searched, dice, 0.5 * range);
      for (std::size_t k = 0; k < u.size(); ++k) u[k] += drift[k];
    }
  }
  EXPECT_GT(touching, fine ? 20 : 200);
  EXPECT_LT(listed, all / 4);
}
TEST(Tiles, ListEveryNodeThatCanTouch) { list_every_node_that_can_touch<packs>(12); }
/// The resonator's displacement comes from the footprint's polynomials.
TEST(Tiles, OfManyModesListEveryNodeThatCanTouch) {
  list_every_node_that_can_touch<(64 + width - 1) / width>(60);
}
TEST(Tiles, OfLongBlocksListEveryNodeThatCanTouch) {
  list_every_node_that_can_touch<(64 + width - 1) / width>(60, true);
}

}  // namespace
}  // namespace ra2d::test
