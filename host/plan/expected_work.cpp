// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/expected_work.hpp"

#include <algorithm>
#include <cmath>

#include "host/body/body.hpp"
#include "host/model/model.hpp"
#include "host/plan/step_costs.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

/// Steps of the adaptive scheme in a second. Between linear faces one ends where a node passes
/// another. Otherwise the fastest mode and the contacts set them.
double strides_a_second(const Scene& scene, double highest, double nodes_in_contact) {
  const double radians = 2 * M_PI * highest;
  if (scene.faces == Faces::smooth)  // a formula of order 8
    return step_costs::smooth_steps_a_radian * radians *
           std::pow(1e-6 / scene.time.tolerance.value_or(usual_tolerance), 1.0 / 9);
  const double a_crossing =
      nodes_in_contact > 1 ? step_costs::steps_a_wide_crossing : step_costs::steps_a_crossing;
  return a_crossing * scene.speed / scene.spacing + step_costs::steps_a_radian * radians;
}

}  // namespace

ExpectedWork expected_work(const Scene& scene, double contact_width) {
  constexpr int most_counted = 2000;  // modes
  constexpr double ns = 1e-9;
  const auto modes_of = [](const BodySpec& body) { return mode_count(body, most_counted); };
  const auto highest_of = [&](const BodySpec& body) {
    const int elastic = modes_of(body) - rigid_mode_count(body);
    return elastic > 0 ? elastic_frequency(body, elastic - 1) : 0.0;
  };
  const double modes = modes_of(scene.resonator) + modes_of(scene.slider);
  const double wide = std::max(1.0, modes / step_costs::counted_modes);
  const double rows = scene.kind == SceneKind::areal
                          ? scene.slider.width / scene.spacing_y.value_or(scene.spacing)
                          : 1;
  const double nodes = rows * scene.slider.length / scene.spacing;
  const auto forces = static_cast<double>(scene.resonator.moving_forces.size());
  const bool smooth = scene.faces == Faces::smooth;
  // nodes, or cells, that a contact is wide
  const double touching = std::max(1.0, contact_width / scene.spacing + (smooth ? 1.0 : 0.0));

  ExpectedWork work;
  work.readiness =
      ns * (step_costs::readiness +
            step_costs::surface_node * (rows * scene.resonator.length / scene.spacing + nodes));
  if (scene.initial == Initial::statics)
    work.readiness += ns * step_costs::balanced_node * nodes * std::max(8.0, modes);
  if (is_adaptive(scene)) {
    const double highest = std::max(highest_of(scene.resonator), highest_of(scene.slider));
    const int terms = series_order(scene.time.tolerance.value_or(usual_tolerance));
    work.strides = 1 + scene.duration * strides_a_second(scene, highest, touching);
    const double all_nodes = scene.time.nodes == Nodes::all ? 4 * step_costs::node * nodes : 0.0;
    const double step = (smooth ? step_costs::smooth_step : terms * step_costs::order) *
                        (1 + step_costs::usual_more_share * (touching - 1));
    work.march =
        ns * (work.strides *
                  (wide * (step + terms * forces * step_costs::travelling_force) + all_nodes) +
              scene.duration * scene.speed / scene.spacing * step_costs::leap);
    return work;
  }
  work.strides = scene.duration / scene.time.step;
  const bool held = holds_forces(scene);
  const int stages = scheme_table(scene.time.scheme).stages;
  const int evaluations = held ? 2 : stages;  // held: without and with the contact's force
  const double node = scene.kind == SceneKind::areal
                          ? step_costs::row_node + step_costs::row_node_mode * modes
                          : step_costs::node;
  const double all_nodes = scene.time.nodes == Nodes::all ? evaluations * node * nodes : 0.0;
  const bool new_force = held && scene.contact.law == ContactLaw::penalty;
  const double in_contact =
      smooth ? (new_force ? step_costs::new_cells : (held ? 1 : stages) * step_costs::cells)
      : held ? evaluations * step_costs::held
             : stages * step_costs::contact;
  // on average a contact is half as wide as at the peak of a shock
  const double more =
      0.5 * (touching - 1) * evaluations *
      (smooth ? step_costs::cell : step_costs::more_nodes * std::max(8.0, modes) / wide);
  const double solved =
      new_force && !smooth && touching > 1
          ? step_costs::pressed * std::pow(std::min(touching, step_costs::pressed_at_most), 3)
          : 0.0;
  // in contact half of the time
  work.march = ns * work.strides *
               (wide * (0.5 * (step_costs::flight + in_contact + more + solved) +
                        stages * forces * step_costs::travelling_force) +
                all_nodes);
  return work;
}

}  // namespace ra2d
