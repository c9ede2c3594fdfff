// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

#include "kernels/displacement.hpp"
#include "kernels/lanes.hpp"
#include "kernels/tables.hpp"

/// Where the slider stands, and the parts of the gap (kernels/gap.hpp) as the kernels evaluate
/// them: for groups of nodes, one a lane. They work with the overlap -g_n. Single nodes are in
/// kernels/contact/node_contact.hpp.
namespace ra2d {

/// Where the slider stands at a step, in chi.
struct Place {
  double position;  // of slider node 0 on the resonator
  int base;         // whole nodes
  double theta;     // the rest: every slider node stands theta behind resonator node base + n
  int part;         // the window: part of the node's width, of SliderMotion::windows
  double middle;    // of that part, in chi from the resonator node
  double offset;    // from there

  /// At a step, or a share of a step later.
  KOKKOS_FORCEINLINE_FUNCTION Place(const SliderMotion& motion, std::int64_t step,
                                    double share = 0.0) {
    position = Kokkos::fma(static_cast<double>(step) + share, motion.advance, motion.position);
    base = static_cast<int>(position);
    theta = position - base;
    part = static_cast<int>(theta * motion.windows);
    middle = (part + 0.5) * motion.window_width;
    offset = theta - middle;
  }
  /// The number of the window: a part of the slider's path in which no node passes another and the
  /// modes' shapes at a node are cubic polynomials of the offset.
  KOKKOS_FORCEINLINE_FUNCTION std::int64_t window(const SliderMotion& motion) const {
    return static_cast<std::int64_t>(base) * motion.windows + part;
  }
  /// On to another step of the same window.
  KOKKOS_FORCEINLINE_FUNCTION void move_to(const SliderMotion& motion, std::int64_t step,
                                           double share = 0.0) {
    position = Kokkos::fma(static_cast<double>(step) + share, motion.advance, motion.position);
    theta = position - base;
    offset = theta - middle;
  }
};

/// Bound on the roundings of two positions [chi]. Shorter distances are not resolved by the
/// computed position. Twice the roundings themselves, for numbers computed from them.
KOKKOS_FORCEINLINE_FUNCTION double position_rounding(const Place& place) {
  return 2 * 0x1p-52 * (place.position + 1.0);
}

/// The rest of this spacing [chi], as far as a step within it may go: it ends by a tick or less
/// behind the crossing.
KOKKOS_FORCEINLINE_FUNCTION double rest_of_spacing(const Place& place, const SliderMotion& motion) {
  return place.base + 1 - place.position + 2.0 * (position_rounding(place) + motion.advance);
}

/// Nodes of a group and of those after it in its row, without what pads the row's end.
KOKKOS_INLINE_FUNCTION int nodes_left(const FaceTables& faces, int group, int width) {
  if (faces.rows.across == nullptr) [[likely]]
    return faces.nodes - group * width;
  return faces.rows.nodes - group % faces.rows.groups * width;
}

/// Whether there is a cell between slider node `left` and the next one in its row.
KOKKOS_FORCEINLINE_FUNCTION bool is_cell(const FaceTables& faces, int left) {
  if (left < 0 || left > faces.nodes - 2) return false;
  return faces.rows.across == nullptr || left % faces.rows.length < faces.rows.nodes - 1;
}
/// A node's number along its row.
KOKKOS_FORCEINLINE_FUNCTION int along_row(const FaceTables& faces, int node) {
  return faces.rows.across == nullptr ? node : node % faces.rows.length;
}

/// By how many nodes the row of height2 that a group meets begins later than that of height1.
KOKKOS_FORCEINLINE_FUNCTION int nodes_beyond(const FaceTables& faces, int group) {
  if (faces.rows.across == nullptr) [[likely]]
    return 0;
  return group / faces.rows.groups * faces.rows.excess - faces.rows.behind;
}

/// The patch on which a group of slider nodes is evaluated, and eta of the group's first node.
/// `group`: counted from the beginning of its row.
template <class Lanes>
struct GroupPlace {
  int patch;
  double eta;

  KOKKOS_FORCEINLINE_FUNCTION GroupPlace(const PatchTables& patches, const Place& place,
                                         int group) {
    const int middle = place.base + group * Lanes::width + Lanes::width / 2;
    patch = static_cast<int>((middle + 0.5) * patches.inverse_nodes);
    eta = (place.position + (group * Lanes::width - (patch + 0.5) * patches.nodes)) *
          patches.inverse_radius;
  }
};

/// The rough faces alone: h_1 - delta + h_2 at the nodes of a group, and the resonator's slope
/// there [m per chi], which between straight lines is its rise to the next node.
template <class Lanes>
struct StaticOverlap {
  using Real = typename Lanes::Real;
  Real height, rise;

  /// `beyond`: nodes_beyond.
  KOKKOS_FORCEINLINE_FUNCTION StaticOverlap(const Lanes& lanes, const FaceTables& faces,
                                            const Place& place, int group, int beyond = 0) {
    const double* h2 = faces.height2 + place.base + beyond + group * Lanes::width;
    const Real left = lanes.load(h2);
    rise = lanes.load(h2 + 1) - left;
    const Real own = lanes.load(faces.height1 + group * Lanes::width);
    if (!faces.smooth) [[likely]] {
      height = own + multiply_add(place.theta, rise, left);
      return;
    }
    const double* curvature = faces.curvature2 + place.base + beyond + group * Lanes::width;
    const Real b0 = lanes.load(curvature), b1 = lanes.load(curvature + 1), theta(place.theta);
    // of the cubic between two nodes: slope at the left one, half its curvature there, a sixth of
    // the curvature's change
    const Real slope = multiply_add(-1.0 / 6.0, b0 + b0 + b1, rise);
    const Real half = Real(0.5) * b0, sixth = Real(1.0 / 6.0) * (b1 - b0);
    height = own + multiply_add(theta, multiply_add(theta, multiply_add(theta, sixth, half), slope),
                                left);
    rise = multiply_add(theta, multiply_add(Real(3.0) * theta, sixth, b0), slope);
  }
};

/// Adds u_1 (or its rate) at the nodes of a group to `value`; `amplitude` holds all modes'
/// amplitudes one by one. `group`: as of GroupPlace.
template <class Lanes>
KOKKOS_FORCEINLINE_FUNCTION typename Lanes::Real add_slider_displacement(
    const Lanes& lanes, const SliderShapes& slider, const double* amplitude, int group,
    typename Lanes::Real value) {
  const std::int64_t row = slider.row;
  for (int k = 0; k < slider.modes; ++k)
    value = multiply_add(amplitude[slider.first_lane + k],
                         lanes.load(slider.shape + k * row + group * Lanes::width), value);
  return value;
}

}  // namespace ra2d
