// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/scene/scene.hpp"

/// A reference for areal scenes, in long double and over all nodes: two height maps, a plate pinned
/// along its edges, and a block that is rigid or free. Modes, shapes, contact and time integration
/// are its own.
///
/// While no node opens or closes and none passes a node of the plate, the equations are linear with
/// coefficients that are entire functions of time: sines of the slider's place. A step is a Taylor
/// series of them, and so is the overlap of every node over the step. The step ends at the first
/// root of an overlap, which is found by bounds on the parts of the polynomial.
namespace ra2d::test {

/// Heights [m] on rows of constant y: (row, node along x).
using HeightMap = std::vector<std::vector<double>>;

struct ArealForce {
  double force = 0;  // N, on the plate, positive upwards
  double speed = 0;  // m/s
  double start = 0;  // m, x at t = 0
  double y = 0;      // m
};

/// Slider node (i, j) stands at start + speed t + i spacing, side + (j + 1/2) spacing_y on the
/// plate.
struct ArealScene {
  BodySpec plate, block;  // `length` along x, `width` along y, kept `modes` of the plate
  double spacing = 0, spacing_y = 0;  // m
  double start = 0, side = 0;         // m, the block's corner at t = 0
  double speed = 0;                   // m/s
  double gap = 0;                     // m, of the mean planes
  double stiffness = 0;               // Pa/m, kappa
  HeightMap plate_heights;            // under the block's rows, at x = 0, spacing, ...
  HeightMap block_heights;
  Faces faces = Faces::linear;  // of the march; the reference's are linear
  std::vector<ArealForce> forces;
  /// The bodies are beams, and every shape is constant in y: the equations of a plane scene.
  bool is_plane = false;
  /// At t = 0; empty: at rest. Plate's modes by frequency, then by m; the block's heave, pitch and,
  /// unless plane, roll.
  std::vector<double> plate_u, plate_v, block_u, block_v;
};

struct ArealOptions {
  int order = 28;      // of the Taylor series
  double longest = 1;  // the longest step, over the inverse of the highest rate of the motion
};

struct ArealState {
  double time = 0;
  std::vector<double> plate_u, plate_v, block_u, block_v;
  double force = 0;                              // N
  int contacts = 0;                              // nodes
  double kinetic = 0, elastic = 0, contact = 0;  // J
  // J, since t = 0; load_work: of the block's load and of the moving forces
  double damping_loss = 0, sliding_work = 0, load_work = 0;

  double energy() const { return kinetic + elastic + contact; }
  /// Energy that was put in and not lost.
  double supplied() const { return sliding_work + load_work - damping_loss; }
};

/// A connected piece of contact in space and time; neighbours are the eight around a node. Of two
/// pieces that meet, the peak is the larger of the two until then, as in the program.
struct ArealShock {
  double start = 0, end = 0;  // s; end: of the run, where it goes on
  double impulse = 0;         // N s
  double peak = 0;            // N
  double x = 0, y = 0;        // m, on the plate, mean weighted by force
  int nodes = 0;              // that were in contact
  bool is_open = false;       // at the end of the run
};

struct ArealReference {
  std::vector<ArealState> states;
  std::vector<ArealShock> shocks;  // by start
  long steps = 0, closings = 0, openings = 0;
};

/// States at `times` [s], in ascending order. The run ends at the last. Throws
/// std::invalid_argument where maps and bodies do not fit.
ArealReference areal_reference(const ArealScene& scene, const std::vector<double>& times,
                               const ArealOptions& options = {});

}  // namespace ra2d::test
