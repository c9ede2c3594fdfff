// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "host/base/shared_numbers.hpp"
#include "host/body/body.hpp"
#include "host/scene/scene.hpp"

/// A scene made ready to march: bodies, faces, and where everything starts. Host data, for any
/// number of lanes.
namespace ra2d {

/// Time is counted in ticks. With fixed steps a tick is a step. The adaptive scheme counts on a
/// clock so fine that rounding to it changes nothing; every sample falls on one of its ticks.
struct Model {
  Scene scene;
  Body resonator, slider;
  SharedNumbers resonator_height, slider_height;  // m, at the nodes: (row, node along x)
  // m, of smooth faces, along x (spline_curvatures)
  SharedNumbers resonator_curvature, slider_curvature;
  double delta = 0;                 // m, imposed distance of the mean lines
  double node_stiffness = 0;        // N/m, kappa chi w; areal: kappa chi chi_y
  double position = 0;              // of slider node 0 at t = 0, in chi
  double tick = 0;                  // s
  double advance = 0;               // per tick, in chi
  std::int64_t steps = 0;           // ticks of the whole run
  double steps_per_sample = 0;      // ticks; a power of two when adaptive
  std::int64_t end = 0;             // tick that it ends at: `steps`, or the end of output.window
  std::int64_t samples = 0;         // until then, from t = 0 on
  std::int64_t first_sample = 0;    // the first that is kept (output.window)
  std::vector<std::string> doubts;  // values that look wrong but may be intended

  bool is_areal = false;  // a plate and a block; else beams, and one row
  int rows = 1;
  double spacing_y = 0;  // m, chi_y, of an areal scene
  double side = 0;       // m, y0: where the slider's side stands on the resonator

  int nodes() const { return static_cast<int>(slider_height.size()); }
  int row_nodes() const { return nodes() / rows; }
  /// Nodes of the resonator in a row.
  int row_heights() const { return static_cast<int>(resonator_height.size()) / rows; }
  /// From the slider's side to a row [m]: rows stand in the middle of their strips.
  double eta(int row) const { return (row + 0.5) * spacing_y; }
  bool has_smooth_faces() const { return scene.faces == Faces::smooth; }
  std::int64_t kept_samples() const { return samples - first_sample; }
};

/// Builds bodies and surfaces and places the slider. Throws RequestError where they do not fit.
Model make_model(const Scene& scene);

/// The faces of an areal scene, on rows of constant y.
struct HeightMaps {
  int rows = 0;
  double spacing_y = 0;                   // m, chi_y
  double side = 0;                        // m, y0
  std::vector<double> resonator, slider;  // m, (row, node along x): under the slider's rows alone
  // smooth faces: the resonator's node from which on its splines are laid, and how many nodes at
  // the end of a row they alone feel
  int first = 0, beyond = 0;
};

/// As of a plane scene, of a plate and a block with these faces; the scene's own surfaces do not
/// count. Throws RequestError as for a scene.
Model make_model(const Scene& scene, const HeightMaps& maps);

/// A model of the bodies and faces of `made`, which both share, with `time`, `output`,
/// `contact.law` and `duration` of a scene, which ends no later. Doubts stay those of `made`.
/// Throws RequestError as for a scene.
Model with_settings(const Model& made, const Scene& scene);

/// Tick at which level and shock statistics begin: the first at or after `output.from`.
std::int64_t first_counted(const Model& model);

/// The largest of the lengths that an overlap is the difference of [m].
double largest_height(const Model& model);

/// Largest overlap of the undeformed faces at t = 0 [m]; 0 where it is no more than roundings.
double rest_overlap(const Model& model);

/// Order of the power series of an adaptive step to a relative error of `tolerance`. Measured on
/// the paper's scenes at 1e-6: one less costs up to 3 % more, one or two more cost the same.
int series_order(double tolerance);

/// Modal displacements and rates of both bodies at one instant, and the energy of the contact
/// springs.
struct ModalStart {
  std::vector<double> resonator_u, resonator_v, slider_u, slider_v;
  double energy = 0;              // J, kinetic + elastic + contact
  double contact_force = 0;       // N
  std::vector<int> loaded_nodes;  // nodes in contact, in ascending order
  double contact_energy = 0;      // J, of the contact springs, part of `energy`
};

/// State at t = 0: at rest, or in static equilibrium under load and contact (scene.initial). Throws
/// RequestError when no equilibrium can be found.
ModalStart make_start(const Model& model);

/// Overlap -g_n [m] of every slider node at t = 0 for given modal displacements, by direct
/// evaluation.
std::vector<double> overlaps(const Model& model, const std::vector<double>& resonator_u,
                             const std::vector<double>& slider_u);

}  // namespace ra2d
