// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "host/model/bounds.hpp"
#include "kernels/gap.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"
#include "tests/eight_modes.hpp"

namespace ra2d::test {

/// A resonator whose modes are waves cos(beta (x - crest)), a slider whose modes are given at its
/// nodes, and flat faces whose heights a test sets node by node. All masses are 1; lengths are in
/// chi, here 1 m. Every bound in the tables is as tight as it can be.
struct BodiesByHand {
  /// Of a patch [chi].
  static constexpr double radius_of(int patch_nodes) { return 0.5 * (patch_nodes + width) + 1; }
  static constexpr double radius = 0.5 * (1 + width) + 1;  // radius_of(1)
  struct Wave {
    double beta, crest;
  };
  using Shape = std::vector<double>;  // at the slider's nodes

  /// Patches of one node keep close to what a test is about. Of wide ones the outermost nodes stand
  /// where a bound on all of the patch is reached.
  BodiesByHand(std::vector<Wave> waves, std::vector<Shape> shapes, int nodes, int patch_nodes = 1)
      : waves_{std::move(waves)}, shapes_{std::move(shapes)} {
    const int resonator_nodes = 64 + 3 * patch_nodes;
    const int groups = (nodes + width - 1) / width, patches = resonator_nodes / patch_nodes + 1;
    const double radius = radius_of(patch_nodes);
    const auto waving = static_cast<int>(waves_.size()), sliding = static_cast<int>(shapes_.size());
    for (std::vector<double>* row :
         {&largest_shape, &slope, &curvature, &tail, &slope_tail, &zero, &outer_acceleration})
      row->assign(modes, 0.0);
    patch.assign(static_cast<std::size_t>(patches) * 4 * modes, 0.0);
    for (int k = 0; k < waving; ++k) {
      const double b = waves_[k].beta, turn = b * radius;
      largest_shape[k] = 1, slope[k] = b, curvature[k] = b * b;
      tail[k] = std::pow(turn, 4) / 24, slope_tail[k] = b * std::pow(turn, 3) / 6;
      for (int p = 0; p < patches; ++p)
        for (int j = 0; j < 4; ++j)
          patch[(p * 4 + j) * modes + k] =
              std::pow(turn, j) *
              std::cos(b * ((p + 0.5) * patch_nodes - waves_[k].crest) + j * M_PI_2);
    }
    shape.assign(static_cast<std::size_t>(std::max(1, sliding)) * groups * width, 0.0);
    for (int k = 0; k < sliding; ++k)
      for (int n = 0; n < nodes; ++n) {
        shape[k * groups * width + n] = shapes_[k][n];
        largest_shape[waving + k] = std::max(largest_shape[waving + k], std::abs(shapes_[k][n]));
      }
    height1.assign(groups * width, -1e30);
    std::fill_n(height1.begin(), nodes, 0.0);
    height2.assign(resonator_nodes + groups * width + 2 * width, 0.0);
    highest2 = height2;
    t.slider.first_lane = waving, t.slider.modes = sliding, t.slider.row = groups * width;
    t.faces.nodes = nodes, t.faces.groups = groups;
    t.patches.count = patches, t.patches.nodes = patch_nodes,
    t.patches.inverse_nodes = 1.0 / patch_nodes;
    t.patches.inverse_radius = 1 / radius, t.motion.spacing = 1, t.motion.time_step = 1;
    t.bounds.largest_shape = largest_shape.data(), t.bounds.largest_slope = slope.data();
    t.bounds.largest_curvature = curvature.data();
    t.bounds.cubic_remainder = tail.data(), t.bounds.cubic_slope_remainder = slope_tail.data();
    t.modes.omega = t.bounds.acceleration_per_energy_norm = zero.data(),
    t.bounds.outer_acceleration = outer_acceleration.data();
    for (const double largest : largest_shape)
      t.bounds.acceleration_per_newton += largest * largest;
    t.patches.derivatives = patch.data(), t.slider.shape = shape.data();
    t.faces.height1 = height1.data(), t.faces.height2 = height2.data(),
    t.faces.highest2 = highest2.data();
    for (std::vector<int>* list : {&groups_, &coarse_groups_, &listed_nodes_, &contacts_})
      list->assign(nodes, 0);
    reference_u_.assign(modes, 0.0), coarse_reference_u_ = reference_u_;
    amplitudes_.assign(2 * modes, 0.0), coarse_highest_.assign(groups + width, 0.0);
    overlaps_.assign(4 * groups * width, 0.0);
    s.work.candidates.groups = groups_.data(),
    s.work.candidates.coarse_groups = coarse_groups_.data(),
    s.work.candidates.coarse_highest = coarse_highest_.data();
    s.work.candidates.reference_u = reference_u_.data(),
    s.work.candidates.coarse_reference_u = coarse_reference_u_.data(),
    s.work.amplitudes = amplitudes_.data();
    s.work.candidates.most_listed = nodes;
    s.work.listed_nodes = listed_nodes_.data(), s.carried.contacts.nodes = contacts_.data(),
    s.work.search.overlaps = overlaps_.data();
  }
  BodiesByHand(const BodiesByHand&) = delete;

  /// The overlap itself [m], at a position of the slider [chi].
  double overlap(const Amplitudes& u, double position, int node) const {
    double u1 = 0, u2 = 0;
    for (std::size_t k = 0; k < waves_.size(); ++k)
      u2 += u[k] * std::cos(waves_[k].beta * (position + node - waves_[k].crest));
    for (std::size_t k = 0; k < shapes_.size(); ++k) u1 += u[waves_.size() + k] * shapes_[k][node];
    return -gap(0.0, height1[node], u1, {0.0, 0.0, 0.0}, u2);
  }
  /// Lets a node overlap by so much there.
  void set_overlap(int node, double by, const Amplitudes& u, double position) {
    height1[node] += by - overlap(u, position, node);
  }
  bool lists(int node, int count) const {
    return std::find(listed_nodes_.begin(), listed_nodes_.begin() + count, node) !=
           listed_nodes_.begin() + count;
  }

  std::vector<double> largest_shape, slope, curvature, tail, slope_tail, zero, outer_acceleration;
  std::vector<double> patch, shape, height1, height2, highest2;
  SceneTables t;
  SceneState s;

 private:
  std::vector<Wave> waves_;
  std::vector<Shape> shapes_;
  std::vector<int> groups_, coarse_groups_, listed_nodes_, contacts_;
  std::vector<double> reference_u_, coarse_reference_u_, coarse_highest_, amplitudes_, overlaps_;
};

/// Amplitudes as kernels take them.
struct Packs {
  Real u[K];
  explicit Packs(const Amplitudes& of) {
    for (int p = 0; p < K; ++p) u[p] = lanes.load(of.data() + p * width);
  }
};

}  // namespace ra2d::test
