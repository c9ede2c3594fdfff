// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/expected_work.hpp"

#include <algorithm>
#include <cmath>

#include "host/body/body.hpp"
#include "host/model/model.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

// Wall time on one core of a server processor of 2023, measured on the paper's scene and its
// variants.
constexpr double usual_readiness = 2e-3;                       // s: tables, files
constexpr double surface_node = 6e-8, balanced_node = 7e-8;    // s a node; s a node and mode
constexpr double flight = 5e-9, contact = 45e-9, held = 2e-7;  // s: a fixed step, by its form
constexpr double cells_contact = 500e-9;                       // s: the same between smooth faces
constexpr double new_cells_contact = 2500e-9;    // s: with the penalty force of the new time
constexpr double evaluation = 1e-9;              // s, of a node, where all are evaluated
constexpr double leap = 600e-9, order = 180e-9;  // s: a flight; a step, each order
constexpr double of_smooth_faces = 4.0;       // an order of a step: its stages between smooth faces
constexpr double travelling_seconds = 20e-9;  // s: a force that travels, at one time
constexpr double counted_modes = 24;          // that these times are of

/// Steps of the adaptive scheme in a second: where a node passes another, and as often as the
/// fastest mode turns, of which the contact of rough faces takes about 0.45 steps a radian.
double strides_a_second(const Scene& scene, double highest) {
  constexpr double of_crossings = 1.2, of_turns = 0.45;
  return of_crossings * scene.speed / scene.spacing + of_turns * 2 * M_PI * highest;
}

}  // namespace

ExpectedWork expected_work(const Scene& scene) {
  constexpr int most_counted = 2000;  // modes
  const auto modes_of = [](const BodySpec& body) { return mode_count(body, most_counted); };
  const auto highest_of = [&](const BodySpec& body) {
    const int elastic = modes_of(body) - (body.support == Support::free ? 2 : 0);
    return elastic > 0 ? elastic_frequency(body, elastic - 1) : 0.0;
  };
  const double modes = modes_of(scene.resonator) + modes_of(scene.slider);
  const double wide = std::max(1.0, modes / counted_modes);
  const double nodes = scene.slider.length / scene.spacing;
  const auto forces = static_cast<double>(scene.resonator.moving_forces.size());

  ExpectedWork work;
  work.readiness =
      usual_readiness + surface_node * (scene.resonator.length / scene.spacing + nodes);
  if (scene.initial == Initial::statics)
    work.readiness += balanced_node * nodes * std::max(8.0, modes);
  if (is_adaptive(scene)) {
    const double highest = std::max(highest_of(scene.resonator), highest_of(scene.slider));
    const int terms = series_order(scene.time.tolerance.value_or(usual_tolerance));
    work.strides = 1 + scene.duration * strides_a_second(scene, highest);
    const double all_nodes = scene.time.nodes == Nodes::all ? 4 * evaluation * nodes : 0.0;
    const double faces = scene.faces == Faces::smooth ? of_smooth_faces : 1.0;
    work.march = work.strides *
                     (wide * (terms * (faces * order + forces * travelling_seconds)) + all_nodes) +
                 scene.duration * scene.speed / scene.spacing * leap;
    return work;
  }
  work.strides = scene.duration / scene.time.step;
  const int stages = scheme_table(scene.time.scheme).stages;
  const double all_nodes = scene.time.nodes == Nodes::all ? stages * evaluation * nodes : 0.0;
  const bool new_force = holds_forces(scene) && scene.contact.law == ContactLaw::penalty;
  const double touching =
      scene.faces == Faces::smooth
          ? (new_force ? new_cells_contact : (holds_forces(scene) ? 1 : stages) * cells_contact)
      : holds_forces(scene) ? held
                            : stages * contact;
  work.march =
      work.strides *
      (wide * (0.5 * (flight + touching) + stages * forces * travelling_seconds) + all_nodes);
  return work;
}

}  // namespace ra2d
